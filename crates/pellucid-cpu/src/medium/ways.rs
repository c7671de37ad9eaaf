//! Rays through several layers, on one lattice.
//!
//! The lattice begins where a ray enters the first layer, as it does in a single one. Its pieces end at its nodes and at
//! the borders of layers, so that every layer is covered exactly, whatever else begins or ends in a step.

use pellucid_scene::Overlap;

use super::merge::merged;
use super::{Beam, Layer, Piece};
use crate::element::Element;
use crate::integrator::Counter;
use crate::lanes::*;
use crate::packet::{Packet, Rays};
use crate::samples::{RUN, Sample};

/// Nodes and borders that are less apart are one, in steps: positions are rounded by about as much.
const CLOSE: f32 = 1e-4;

/// Where a layer lies on the rays of a packet.
pub struct Span<S: Lanes> {
    /// The rays in its index space, from where they enter it.
    pub rays: Rays<S>,
    /// Distances of that entry and of the exit, in steps; infinity and its negative where they miss it.
    pub ends: [F32<S>; 2],
    /// What light needs of the eye's rays, if samples are lit.
    pub beam: Option<Beam<S>>,
}

/// The rays of a packet, and where the layers lie on them.
pub struct Ways<S: Lanes> {
    spans: Vec<Span<S>>,
    /// Where in a piece its sample lies.
    jitter: F32<S>,
    /// Distance of the end of the last layer.
    length: F32<S>,
}

/// How far the rays of a packet have been followed.
pub struct Progress<S: Lanes> {
    distance: F32<S>,
    open: Mask<S>,
}

impl<S: Lanes> Ways<S> {
    /// Rays that lie so in layers.
    #[inline(always)]
    pub fn new(s: S, spans: Vec<Span<S>>, jitter: F32<S>) -> Self {
        let mut length = splat(s, 0.0);
        for span in &spans {
            length = length.max(span.ends[1]);
        }
        Self { spans, jitter, length }
    }

    /// The eye's rays: a packet for each layer, and before them one for all of them that says where the lattice
    /// begins; `step` is that of the lattice, in world units.
    #[inline(never)]
    pub fn of_eye(s: S, packets: &[Packet], layers: &[Box<dyn Layer<S> + '_>], step: f64) -> Self {
        s.vectorize(
            #[inline(always)]
            || {
                let (whole, own) = (&packets[0], &packets[1..]);
                let mut spans = Vec::with_capacity(own.len());
                for (packet, layer) in own.iter().zip(layers) {
                    let rays = Rays::new(s, packet);
                    let mut start = [f32::INFINITY; MOST_LANES];
                    for lane in (0..width::<S>()).filter(|&lane| packet.count[lane] > 0.0) {
                        start[lane] = ((packet.entry[lane] - whole.entry[lane]) / step) as f32;
                    }
                    let start = load(s, &start);
                    let met = start.is_finite();
                    let end = met.select(start + rays.length(), splat(s, f32::NEG_INFINITY));
                    let beam = layer.aim(packet, &rays);
                    spans.push(Span { rays, ends: [start, end], beam });
                }
                Self::new(s, spans, load(s, &whole.jitter))
            },
        )
    }

    /// At the beginning.
    #[inline(always)]
    pub fn start(&self, s: S) -> Progress<S> {
        let distance = splat(s, 0.0);
        Progress { distance, open: self.goes_on(distance) }
    }

    /// Looks at the next [`RUN`] pieces, nearest first: `see` is given the distance of their samples and the merged
    /// element, and returns the lanes whose ray is done. Returns whether any ray goes on.
    #[inline(always)]
    pub fn run(
        &self,
        s: S,
        progress: &mut Progress<S>,
        (layers, overlap): (&[Box<dyn Layer<S> + '_>], Overlap),
        counter: &mut Counter<S>,
        mut see: impl FnMut(F32<S>, &Element<S>, &mut Counter<S>) -> Mask<S>,
    ) -> bool {
        let Progress { mut distance, mut open } = *progress;
        let to = self.leap(s, layers, distance, open);
        counter.skip(to.min(self.length) - distance);
        distance = to;
        for _ in 0..RUN {
            open &= self.goes_on(distance);
            if !open.any_true() {
                break;
            }
            let end = self.end(distance);
            counter.sample(open);
            let sample = self.jitter.mul_add(end - distance, distance);
            if let Some(element) = self.element(s, layers, overlap, [distance, end], open) {
                counter.see(element.visible);
                let done = see(sample, &element, counter) & open;
                counter.terminate(done);
                open &= !done;
            }
            distance = end;
        }
        *progress = Progress { distance, open };
        open.any_true()
    }

    /// What pieces send to the eye, of all layers together. A function of its own, as are all that hold loops over
    /// layers: in one they would take the compiler minutes.
    #[inline(never)]
    fn element(
        &self,
        s: S,
        layers: &[Box<dyn Layer<S> + '_>],
        overlap: Overlap,
        ends: [F32<S>; 2],
        open: Mask<S>,
    ) -> Option<Element<S>> {
        s.vectorize(
            #[inline(always)]
            || {
                let mut elements = Vec::with_capacity(layers.len());
                for (span, layer) in self.spans.iter().zip(layers) {
                    elements.push(self.of_layer(s, span, layer.as_ref(), ends, open));
                }
                merged(s, overlap, &elements)
            },
        )
    }

    #[inline(always)]
    fn of_layer(
        &self,
        s: S,
        span: &Span<S>,
        layer: &dyn Layer<S>,
        [from, to]: [F32<S>; 2],
        open: Mask<S>,
    ) -> Option<Element<S>> {
        let [start, end] = span.ends;
        let middle = (from + to) * 0.5;
        let lanes = open & middle.simd_gt(start) & middle.simd_lt(end);
        if !lanes.any_true() {
            return None;
        }
        let entry = lanes.select(start, from);
        let ends = [from - entry, to - entry];
        let ratio = to - from;
        let distance = self.jitter.mul_add(ratio, ends[0]);
        let shortened = (lanes & ratio.simd_lt(splat(s, 1.0))).any_true();
        let sample = Sample { distance, index: span.rays.at(distance), ratio, level: None, shortened, lanes };
        layer.at(&span.rays, span.beam.as_ref(), &Piece { sample, ends })
    }

    /// Unit normals at distances, of the layer that has most opacity there.
    #[inline(never)]
    pub fn normals(&self, s: S, layers: &[Box<dyn Layer<S> + '_>], distance: F32<S>, lanes: Mask<S>) -> Vec3<S> {
        s.vectorize(
            #[inline(always)]
            || {
                let (mut normal, mut most) = ([splat(s, 0.0); 3], splat(s, 0.0));
                let half = splat(s, 0.5);
                for (span, layer) in self.spans.iter().zip(layers) {
                    let found = self.of_layer(s, span, layer.as_ref(), [distance - half, distance + half], lanes);
                    let Some(Element { rgba, visible }) = found else { continue };
                    let more = visible & rgba[3].simd_gt(most);
                    if more.any_true() {
                        let at = more.select(distance - span.ends[0], splat(s, 0.0));
                        let own = layer.normals(span.rays.at(at), more);
                        normal = xyz!(I => more.select(own[I], normal[I]));
                        most = more.select(rgba[3], most);
                    }
                }
                normal
            },
        )
    }

    #[inline(always)]
    fn goes_on(&self, distance: F32<S>) -> Mask<S> {
        (distance + CLOSE).simd_lt(self.length)
    }

    /// Where the piece ends that begins at a distance: at the next node, or the border of a layer before it.
    #[inline(always)]
    fn end(&self, from: F32<S>) -> F32<S> {
        let beyond = from + CLOSE;
        let mut end = beyond.floor() + 1.0;
        for span in &self.spans {
            for border in span.ends {
                end = (border.simd_gt(beyond) & border.simd_lt(end - CLOSE)).select(border, end);
            }
        }
        end
    }

    /// The last node before which nothing can be seen, or the distance itself.
    #[inline(never)]
    fn leap(&self, s: S, layers: &[Box<dyn Layer<S> + '_>], mut distance: F32<S>, open: Mask<S>) -> F32<S> {
        s.vectorize(
            #[inline(always)]
            || loop {
                let far = splat(s, f32::INFINITY);
                let mut clear = far;
                for (Span { rays, ends: [start, end], .. }, layer) in self.spans.iter().zip(layers) {
                    let ahead = distance.simd_lt(*start);
                    let inside = open & !ahead & distance.simd_lt(*end);
                    let mut to = ahead.select(*start, far);
                    if inside.any_true() {
                        let within = inside.select(distance - *start, splat(s, 0.0));
                        let own = distance + layer.leap(&rays.at(within), &rays.inverse);
                        to = inside.select(own, to);
                    }
                    clear = clear.min(to);
                }
                // A ray that has left all layers, or passes between two.
                let node = clear.min(self.length).floor();
                let further = open & node.simd_gt(distance);
                if !further.any_true() {
                    return distance;
                }
                distance = further.select(node, distance);
            },
        )
    }
}

//! Rays through several layers, on one lattice.
//!
//! The lattice begins where a ray enters the first layer, as it does in a single one. Its pieces end at its nodes and at
//! the borders of layers, so that every layer is covered exactly, whatever else begins or ends in a step.

use pellucid_scene::Overlap;

use super::Layer;
use super::merge::merged;
use super::run::{CLOSE, Run, Span};
use crate::element::Element;
use crate::integrator::Counter;
use crate::lanes::*;
use crate::packet::{Packet, Rays};
use crate::samples::RUN;

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
    /// Opacity of what they have met, if anybody tells.
    pub front: Option<F32<S>>,
    /// What the layers send of the pieces of a run, piece by piece.
    each: Vec<Element<S>>,
    /// The same of all layers together.
    merged: Vec<Element<S>>,
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
        let (distance, layers) = (splat(s, 0.0), self.spans.len());
        let open = (distance + CLOSE).simd_lt(self.length);
        Progress { distance, open, front: None, each: nothings(s, RUN * layers), merged: nothings(s, RUN) }
    }

    /// Looks at the next [`RUN`] pieces, nearest first: `see` is given the distance of their samples and the merged
    /// element, and returns the lanes whose ray is done. Returns whether any ray goes on.
    #[inline(always)]
    pub fn run(
        &self,
        s: S,
        progress: &mut Progress<S>,
        what: (&[Box<dyn Layer<S> + '_>], Overlap),
        counter: &mut Counter<S>,
        mut see: impl FnMut(F32<S>, &Element<S>, &mut Counter<S>) -> Mask<S>,
    ) -> bool {
        let mut open = progress.open;
        let from = self.leap(s, what.0, progress.distance, open);
        counter.skip(from.min(self.length) - progress.distance);
        let run = Run::new(s, &self.spans, (from, self.length, open), self.jitter, progress.front);
        self.look(s, what, &run, progress);
        for (number, element) in progress.merged.iter().take(run.count()).enumerate() {
            open &= run.lanes(number);
            if !open.any_true() {
                break;
            }
            counter.sample(open);
            let visible = element.visible & open;
            if visible.any_true() {
                counter.see(visible);
                let done = see(run.sample(number), &Element { visible, ..*element }, counter) & open;
                counter.terminate(done);
                open &= !done;
            }
        }
        progress.distance = run.end();
        progress.open = open & (run.end() + CLOSE).simd_lt(self.length);
        progress.open.any_true()
    }

    /// What pieces send to the eye, of all layers together. A function of its own, as are all that hold loops over
    /// layers: in one they would take the compiler minutes.
    #[inline(never)]
    fn look(
        &self,
        s: S,
        (layers, overlap): (&[Box<dyn Layer<S> + '_>], Overlap),
        run: &Run<S>,
        Progress { each, merged: together, .. }: &mut Progress<S>,
    ) {
        s.vectorize(
            #[inline(always)]
            || {
                for (number, (span, layer)) in self.spans.iter().zip(layers).enumerate() {
                    layer.look(span, run, (&mut each[number..], layers.len()));
                }
                let pieces = each.chunks_exact(layers.len()).take(run.count());
                for (together, elements) in together.iter_mut().zip(pieces) {
                    *together = merged(s, overlap, elements);
                }
            },
        );
    }

    /// Unit normals at distances, of the layer that has most opacity there.
    #[inline(never)]
    pub fn normals(&self, s: S, layers: &[Box<dyn Layer<S> + '_>], distance: F32<S>, lanes: Mask<S>) -> Vec3<S> {
        s.vectorize(
            #[inline(always)]
            || {
                let (mut normal, mut most) = ([splat(s, 0.0); 3], splat(s, 0.0));
                let (run, mut found) = (Run::around(s, distance, lanes, self.jitter), nothings(s, 1));
                for (span, layer) in self.spans.iter().zip(layers) {
                    layer.look(span, &run, (&mut found, 1));
                    let Element { rgba, visible } = found[0];
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

    /// The last node before which nothing can be seen and no layer begins or ends, or the distance itself.
    #[inline(never)]
    fn leap(&self, s: S, layers: &[Box<dyn Layer<S> + '_>], mut distance: F32<S>, open: Mask<S>) -> F32<S> {
        s.vectorize(
            #[inline(always)]
            || loop {
                let mut clear = self.length;
                for (span, layer) in self.spans.iter().zip(layers) {
                    let [start, end] = span.ends;
                    // Samples of pieces that a border cuts are elsewhere.
                    clear = distance.simd_lt(end).select(clear.min(end), clear);
                    let ahead = distance.simd_lt(start);
                    clear = ahead.select(clear.min(start), clear);
                    let inside = open & !ahead & distance.simd_lt(end);
                    if inside.any_true() {
                        let node = inside.select(distance - start, splat(s, 0.0));
                        let own = distance + layer.clear(&span.rays, node, self.jitter);
                        clear = inside.select(clear.min(own), clear);
                    }
                }
                let node = clear.floor();
                let further = open & node.simd_gt(distance) & distance.simd_eq(distance.floor());
                if !further.any_true() {
                    return distance;
                }
                distance = further.select(node, distance);
            },
        )
    }
}

/// So many elements that nothing is seen of.
fn nothings<S: Lanes>(s: S, count: usize) -> Vec<Element<S>> {
    (0..count).map(|_| Element::nothing(s)).collect()
}

//! Pieces of a lattice that are looked at together: a layer is asked once for all of them.

use super::Beam;
use crate::element::Element;
use crate::lanes::*;
use crate::packet::Rays;
use crate::samples::{RUN, Sample};

/// Nodes and borders that are less apart are one, in steps: positions are rounded by about as much.
pub const CLOSE: f32 = 1e-4;

/// Where a layer lies on the rays of a packet.
pub struct Span<S: Lanes> {
    /// The rays in its index space, from where they enter it.
    pub rays: Rays<S>,
    /// Distances of that entry and of the exit, in steps; infinity and its negative where they miss it.
    pub ends: [F32<S>; 2],
    /// What light needs of the eye's rays, if samples are lit.
    pub beam: Option<Beam<S>>,
}

/// The next pieces of rays, nearest first. They end at the nodes of the lattice and at the borders of layers.
pub struct Run<S: Lanes> {
    /// Where they begin, and where the last of them ends, in steps.
    nodes: [F32<S>; RUN + 1],
    /// The lanes that have them.
    lanes: [Mask<S>; RUN],
    count: usize,
    /// Where in a piece its sample lies.
    jitter: F32<S>,
    /// Opacity in front of the first, if that is known.
    front: Option<F32<S>>,
}

/// A piece of rays between two nodes, or what of it lies in a layer.
pub struct Piece<S: Lanes> {
    /// The sample that stands for it.
    pub sample: Sample<S>,
    /// Distances of its ends from the layer's border, in steps.
    pub ends: [F32<S>; 2],
}

impl<S: Lanes> Run<S> {
    /// The pieces of open rays from a distance on, as far as `length`, behind an opacity.
    #[inline(always)]
    pub fn new(
        s: S,
        spans: &[Span<S>],
        (from, length, open): (F32<S>, F32<S>, Mask<S>),
        jitter: F32<S>,
        front: Option<F32<S>>,
    ) -> Self {
        let mut run = Self { nodes: [from; RUN + 1], lanes: [open; RUN], count: 0, jitter, front };
        let bordered = borders_within(s, spans, from, open);
        for number in 0..RUN {
            let from = run.nodes[number];
            run.lanes[number] = open & (from + CLOSE).simd_lt(length);
            if !run.lanes[number].any_true() {
                break;
            }
            run.nodes[number + 1] = if bordered { end(spans, from) } else { next_node::<S>(from) };
            run.count += 1;
        }
        run
    }

    /// A single piece of rays around a distance.
    #[inline(always)]
    pub fn around(s: S, distance: F32<S>, lanes: Mask<S>, jitter: F32<S>) -> Self {
        let half = splat(s, 0.5);
        let mut nodes = [distance + half; RUN + 1];
        nodes[0] = distance - half;
        Self { nodes, lanes: [lanes; RUN], count: 1, jitter, front: None }
    }

    /// Opacity in front of the first piece, if that is known.
    #[inline(always)]
    pub fn front(&self) -> Option<F32<S>> {
        self.front
    }

    /// How many pieces there are.
    #[inline(always)]
    pub fn count(&self) -> usize {
        self.count
    }

    /// The lanes that have a piece.
    #[inline(always)]
    pub fn lanes(&self, number: usize) -> Mask<S> {
        self.lanes[number]
    }

    /// Distance of the sample of a piece.
    #[inline(always)]
    pub fn sample(&self, number: usize) -> F32<S> {
        let [from, to] = [self.nodes[number], self.nodes[number + 1]];
        self.jitter.mul_add(to - from, from)
    }

    /// Where the last piece ends.
    #[inline(always)]
    pub fn end(&self) -> F32<S> {
        self.nodes[self.count]
    }

    /// Writes down what pieces in a layer send to the eye, as `look` tells of each: into every `stride`-th place.
    /// `prefetch` hears of positions that come next.
    #[inline(always)]
    pub fn each(
        &self,
        s: S,
        span: &Span<S>,
        (found, stride): (&mut [Element<S>], usize),
        prefetch: impl Fn(Vec3<S>),
        mut look: impl FnMut(&Piece<S>) -> Option<Element<S>>,
    ) {
        for (number, place) in found.iter_mut().step_by(stride).take(self.count).enumerate() {
            let piece = self.piece(s, span, number);
            let mut element = None;
            if piece.sample.lanes.any_true() {
                if number % 2 == 0 {
                    prefetch(span.rays.at(piece.sample.distance + RUN as f32));
                }
                element = look(&piece);
            }
            *place = element.unwrap_or(Element::nothing(s));
        }
    }

    /// What of a piece lies in a layer: all of it or nothing.
    #[inline(always)]
    fn piece(&self, s: S, span: &Span<S>, number: usize) -> Piece<S> {
        let [from, to] = [self.nodes[number], self.nodes[number + 1]];
        let [start, end] = span.ends;
        let middle = (from + to) * 0.5;
        let lanes = self.lanes[number] & middle.simd_gt(start) & middle.simd_lt(end);
        let entry = lanes.select(start, from);
        let ends = [from - entry, to - entry];
        let ratio = to - from;
        let distance = self.jitter.mul_add(ratio, ends[0]);
        let shortened = (lanes & ratio.simd_lt(splat(s, 1.0))).any_true();
        let sample = Sample { distance, index: span.rays.at(distance), ratio, level: None, shortened, lanes };
        Piece { sample, ends }
    }
}

/// The next node of the lattice.
#[inline(always)]
fn next_node<S: Lanes>(from: F32<S>) -> F32<S> {
    (from + CLOSE).floor() + 1.0
}

/// Where the piece ends that begins at a distance: at the next node, or the border of a layer before it.
#[inline(always)]
fn end<S: Lanes>(spans: &[Span<S>], from: F32<S>) -> F32<S> {
    let (beyond, mut end) = (from + CLOSE, next_node::<S>(from));
    for span in spans {
        for border in span.ends {
            end = (border.simd_gt(beyond) & border.simd_lt(end - CLOSE)).select(border, end);
        }
    }
    end
}

/// Whether any layer begins or ends within a run.
#[inline(always)]
fn borders_within<S: Lanes>(s: S, spans: &[Span<S>], from: F32<S>, open: Mask<S>) -> bool {
    let (mut within, to) = (all(s, false), from + (RUN + 1) as f32);
    for span in spans {
        for border in span.ends {
            within |= border.simd_gt(from) & border.simd_lt(to);
        }
    }
    (open & within).any_true()
}

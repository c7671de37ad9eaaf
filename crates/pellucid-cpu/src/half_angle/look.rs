//! Rays of the eye through slabs, and what they gather while light passes: of one volume, or of all layers together.

use std::ops::Range;

use pellucid_plan::half_angle::Slabs;
use pellucid_scene::Overlap;

use super::buffer::LightBuffer;
use super::crossing::{Crossing, Crossings, Passage, UNASKED, slabs_of};
use super::eye::{Attenuation, Eye};
use super::optics::SlabOptics;
use super::pieces::{MetLayer, PerLayer, Share, each_piece, leap, shares};
use crate::chroma;
use crate::element::Element;
use crate::field::Field;
use crate::integrator::Tally;
use crate::lanes::*;
use crate::medium::{Beam, OneGrid, merged};
use crate::packet::{Packet, PerLane};
use crate::prepare::Prepared;

/// Rays of the eye side by side, and what they have gathered.
pub struct EyePacket {
    /// Column and row of the first one in its tile.
    pub corner: [usize; 2],
    /// The rays in each of the layers.
    pub crossings: Vec<Crossing>,
    /// Unit vectors to the eye.
    pub to_eye: [PerLane; 3],
    /// 1 where the ray meets the last slabs first, else 0.
    pub backward: PerLane,
    pub color: [PerLane; 4],
    /// Coordinate at which the opacity of rays in the order of slabs first reaches one half, or infinite.
    pub half: PerLane,
    pub samples: PerLane,
    /// The first slab that may hold anything, and the end of all rays.
    next: usize,
    last: usize,
}

impl EyePacket {
    /// Takes up rays, a packet of them for each layer, of which the first is at a corner of its tile; `None` if none of
    /// them meets a slab.
    pub fn new<S: Lanes>(
        s: S,
        rays: &[Packet],
        slabs: &Slabs,
        layers: &[Prepared],
        corner: [usize; 2],
    ) -> Option<Self> {
        let (mut backward, mut to_eye) = ([0.0; MOST_LANES], [[0.0; MOST_LANES]; 3]);
        let mut crossings = Vec::with_capacity(layers.len());
        for (rays, layer) in rays.iter().zip(layers) {
            let mut crossing = Crossing::NOTHING;
            let own = crossing.take(s, rays, slabs, layer.grid(), layer.stage.step);
            backward.iter_mut().zip(own).for_each(|(backward, own)| *backward = own.max(*backward));
            for lane in crossing.lanes() {
                for (lanes, directions) in to_eye.iter_mut().zip(&rays.world_direction) {
                    lanes[lane] = -directions[lane];
                }
            }
            crossings.push(crossing);
        }
        let Range { start, end } = slabs_of(&crossings);
        (start < end).then_some(Self {
            corner,
            crossings,
            to_eye,
            backward,
            color: [[0.0; MOST_LANES]; 4],
            half: [f32::INFINITY; MOST_LANES],
            samples: [0.0; MOST_LANES],
            next: start,
            last: end,
        })
    }

    /// The slabs that it meets.
    pub fn slabs(&self) -> Range<usize> {
        slabs_of(&self.crossings)
    }
}

/// What the eye looks at: one volume, or the layers of a picture.
pub struct EyeLayers<'a, S: Lanes, F> {
    /// The layers.
    pub layers: Vec<Eye<'a, S, F>>,
    /// What lies where they overlap.
    pub overlap: Overlap,
    /// Opacity at which a ray ends.
    pub early_termination: f32,
}

/// What is seen of a slab, or of a piece of it.
struct SlabElement<S: Lanes> {
    /// Coordinates of the samples.
    place: F32<S>,
    element: Element<S>,
}

/// A ray in a layer.
struct LayerRay<S: Lanes> {
    rays: Crossings<S>,
    beam: Option<Beam<S>>,
}

impl<S: Lanes> LayerRay<S> {
    #[inline(always)]
    fn new<F: Field<S>>(eye: &Eye<S, F>, crossing: &Crossing, to_eye: Vec3<S>, backward: Mask<S>) -> Self {
        let rays = Crossings::new(eye.medium.s, crossing);
        let beam = eye.beam(to_eye, &rays, backward);
        Self { rays, beam }
    }
}

impl<'a, S: Lanes, F: Field<S>> EyeLayers<'a, S, F> {
    /// Looks at a run of slabs, each lit by what has come to it. Returns the end of all rays that go on behind it.
    pub fn look(
        &self,
        packets: &mut [EyePacket],
        run: Range<usize>,
        lights: &[LightBuffer],
        tally: &mut Tally,
    ) -> usize {
        self.first().s.vectorize(
            #[inline(always)]
            || {
                for packet in packets.iter_mut().filter(|packet| packet.next < run.end && packet.last > run.start) {
                    self.follow(packet, run.clone(), lights, tally);
                }
            },
        );
        packets.iter().map(|packet| packet.last).filter(|last| *last > run.end).max().unwrap_or(0)
    }

    /// The first of the layers: what all have in common is told of it.
    #[inline(always)]
    pub fn first(&self) -> &OneGrid<'_, S, &F, SlabOptics<'_>> {
        &self.layers[0].medium
    }

    #[inline(always)]
    fn follow(&self, packet: &mut EyePacket, run: Range<usize>, lights: &[LightBuffer], tally: &mut Tally) {
        let first = self.first();
        let (s, chroma) = (first.s, first.chroma.as_ref());
        let backward = load(s, &packet.backward).simd_gt(splat(s, 0.5));
        let to_eye = xyz!(I => load(s, &packet.to_eye[I]));
        let mut lines = PerLayer::new();
        for (eye, crossing) in self.layers.iter().zip(&packet.crossings) {
            lines.push(LayerRay::new(eye, crossing, to_eye, backward));
        }
        let mut color = rgba!(C => load(s, &packet.color[C]));
        let [mut half, mut samples] = [load(s, &packet.half), load(s, &packet.samples)];
        let met = self.met(lines.iter().map(|line| &line.rays));
        let end = run.end.min(packet.last);
        let mut k = packet.next.max(run.start);
        while k < end {
            let leap = leap(&met, k);
            if leap > 0 {
                tally.skipped += leap as u64;
                k += leap;
                continue;
            }
            let stop = end.min(k + UNASKED);
            for k in k..stop {
                let open = backward | color[3].simd_lt(splat(s, self.early_termination));
                let light = (k, &lights[k - run.start]);
                let seen = match (self.layers.as_slice(), lines.as_slice()) {
                    ([eye], [line]) => {
                        let passage = line.rays.passage(s, k);
                        let lanes = passage.lanes & open;
                        if !lanes.any_true() {
                            continue;
                        }
                        samples = lanes.select(samples + 1.0, samples);
                        eye.see(&passage.index, lanes).map(
                            #[inline(always)]
                            |sight| {
                                let held = Attenuation { alpha: sight.rgba[3], transmittance: sight.transmittance };
                                let element = eye.lit(&sight, &held, &passage, light, line.beam.as_ref());
                                SlabElement { place: passage.place, element }
                            },
                        )
                    }
                    _ => {
                        let (lanes, seen) = self.together((&met, &lines), [open, backward], light);
                        samples = lanes.select(samples + 1.0, samples);
                        seen
                    }
                };
                let Some(SlabElement { place, element: Element { rgba, visible } }) = seen else { continue };
                tally.visible += count::<S>(visible);
                // In front of what is there (over), or behind it (under).
                let front = rgba!(C => backward.select(rgba[C], color[C]));
                let behind = rgba!(C => backward.select(color[C], rgba[C]));
                let both = chroma::over(s, chroma, front, behind);
                color = rgba!(C => visible.select(both[C], color[C]));
                let here = color[3].simd_ge(splat(s, 0.5)) & half.simd_eq(splat(s, f32::INFINITY));
                half = here.select(place, half);
            }
            k = stop;
        }
        packet.next = k;
        let open = backward | color[3].simd_lt(splat(s, self.early_termination));
        if !open.any_true() {
            packet.last = packet.last.min(k);
        }
        for channel in 0..4 {
            store::<S>(color[channel], &mut packet.color[channel]);
        }
        store::<S>(half, &mut packet.half);
        store::<S>(samples, &mut packet.samples);
    }

    /// The layers, with rays in each.
    pub fn met<'m>(&'m self, rays: impl Iterator<Item = &'m Crossings<S>>) -> PerLayer<MetLayer<'m, 'a, S, F>> {
        self.layers.iter().map(|eye| &eye.medium).zip(rays).collect()
    }

    /// What all layers send to the eye from a slab, piece by piece, and the lanes that meet any of them.
    #[inline(never)]
    fn together(
        &self,
        (met, lines): (&[MetLayer<S, F>], &[LayerRay<S>]),
        [open, backward]: [Mask<S>; 2],
        light: (usize, &LightBuffer),
    ) -> (Mask<S>, Option<SlabElement<S>>) {
        let (s, chroma) = (self.first().s, self.first().chroma.as_ref());
        s.vectorize(
            #[inline(always)]
            || {
                let (mut is_met, mut place, mut seen) = (all(s, false), splat(s, 0.0), Element::nothing(s));
                each_piece(
                    s,
                    met,
                    light.0,
                    #[inline(always)]
                    |ends| {
                        let (lanes, shares) = self.shares(
                            met,
                            #[inline(always)]
                            |rays| rays.between(s, ends).within(open),
                        );
                        is_met |= lanes;
                        if shares.is_empty() {
                            return;
                        }
                        let piece = self.lit(&shares, lines, light);
                        let Element { rgba, visible } = piece.element;
                        // Rays that travel against the order of slabs meet the last pieces first.
                        let nearer = rgba!(C => backward.select(rgba[C], seen.rgba[C]));
                        let farther = rgba!(C => backward.select(seen.rgba[C], rgba[C]));
                        seen.rgba = chroma::over(s, chroma, nearer, farther);
                        seen.visible |= visible;
                        place = visible.select(piece.place, place);
                    },
                );
                (is_met, seen.visible.any_true().then_some(SlabElement { place, element: seen }))
            },
        )
    }

    /// What shares of layers send to the eye from a piece of a slab: light comes to their samples through all of them, and
    /// emission is weighted by extinction.
    #[inline(always)]
    fn lit(&self, shares: &[Share<S>], lines: &[LayerRay<S>], light: (usize, &LightBuffer)) -> SlabElement<S> {
        let s = self.first().s;
        let one = splat(s, 1.0);
        let mut left = one;
        for Share { sample, .. } in shares {
            left = sample.visible.select(left * (one - sample.rgba[3]), left);
        }
        let mut transmittance = None;
        if shares.iter().any(|share| share.sample.transmittance.is_some()) {
            let mut product = [one; 3];
            for Share { layer, sample, .. } in shares {
                let own = self.layers[*layer].half_transmittance(sample);
                product = xyz!(C => sample.visible.select(product[C] * own[C], product[C]));
            }
            transmittance = Some(product);
        }
        let (held, mut place) = (Attenuation { alpha: one - left, transmittance }, splat(s, 0.0));
        let mut elements = Vec::with_capacity(shares.len());
        for Share { layer, passage, sample } in shares {
            if sample.visible.any_true() {
                elements.push(self.layers[*layer].lit(sample, &held, passage, light, lines[*layer].beam.as_ref()));
                place = sample.visible.select(passage.place, place);
            }
        }
        SlabElement { place, element: merged(s, Overlap::Add, &elements) }
    }

    /// What is left of layers where rays pass, as `passage` says.
    #[inline(always)]
    pub fn shares(
        &self,
        met: &[MetLayer<S, F>],
        passage: impl Fn(&Crossings<S>) -> Passage<S>,
    ) -> (Mask<S>, Vec<Share<S>>) {
        let s = self.first().s;
        shares(
            s,
            self.overlap,
            met,
            passage,
            #[inline(always)]
            |_| splat(s, 1.0),
        )
    }
}

//! Rays of the eye through slabs, and what they gather while light passes: of one volume, or of all layers together.

use std::ops::Range;

use glam::{DAffine3, DVec3};
use pellucid_plan::half_angle::Slabs;
use pellucid_scene::{Overlap, Stage};

use super::buffer::LightBuffer;
use super::crossing::{Crossing, Crossings, Passage, UNASKED};
use super::eye::{Attenuation, Eye};
use super::optics::{SlabOptics, SlabSample};
use crate::chroma;
use crate::element::Element;
use crate::field::{Field, lane_position};
use crate::integrator::{Found, Tally};
use crate::lanes::*;
use crate::medium::{Beam, OneGrid, merged};
use crate::packet::{Packet, PerLane};
use crate::prepare::Prepared;

/// Rays of the eye side by side, and what they have gathered.
pub struct EyePacket {
    /// Column and row of the first one in its tile.
    pub corner: [usize; 2],
    /// The rays in each of the layers.
    crossings: Vec<Crossing>,
    /// Unit vectors to the eye.
    to_eye: [PerLane; 3],
    /// 1 where the ray meets the last slabs first, else 0.
    backward: PerLane,
    color: [PerLane; 4],
    /// Coordinate at which the opacity of rays in the order of slabs first reaches one half, or infinite.
    half: PerLane,
    samples: PerLane,
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

fn slabs_of(crossings: &[Crossing]) -> Range<usize> {
    let slabs = || crossings.iter().map(Crossing::slabs).filter(|slabs| !slabs.is_empty());
    let (first, end) = (slabs().map(|slabs| slabs.start).min(), slabs().map(|slabs| slabs.end).max());
    first.unwrap_or(0)..end.unwrap_or(0)
}

/// What the eye looks at: one volume, or the layers of a picture.
pub struct EyeLayers<'a, S: Lanes, F> {
    /// The layers.
    pub layers: Vec<Eye<'a, S, F>>,
    /// Opacity at which a ray ends.
    pub early_termination: f32,
}

/// What is seen of a slab.
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

impl<S: Lanes, F: Field<S>> EyeLayers<'_, S, F> {
    /// Looks at a run of slabs, each lit by what has come to it.
    pub fn look(&self, packets: &mut [EyePacket], run: Range<usize>, lights: &[LightBuffer], tally: &mut Tally) {
        self.first().s.vectorize(
            #[inline(always)]
            || {
                for packet in packets.iter_mut().filter(|packet| packet.next < run.end && packet.last > run.start) {
                    self.follow(packet, run.clone(), lights, tally);
                }
            },
        );
    }

    /// The first of the layers: what all have in common is told of it.
    #[inline(always)]
    fn first(&self) -> &OneGrid<'_, S, &F, SlabOptics<'_>> {
        &self.layers[0].medium
    }

    #[inline(always)]
    fn follow(&self, packet: &mut EyePacket, run: Range<usize>, lights: &[LightBuffer], tally: &mut Tally) {
        let first = self.first();
        let (s, chroma) = (first.s, first.chroma.as_ref());
        let backward = load(s, &packet.backward).simd_gt(splat(s, 0.5));
        let to_eye = xyz!(I => load(s, &packet.to_eye[I]));
        let mut lines = Vec::with_capacity(self.layers.len());
        for (eye, crossing) in self.layers.iter().zip(&packet.crossings) {
            let rays = Crossings::new(s, crossing);
            let beam = eye.beam(to_eye, &rays, backward);
            lines.push(LayerRay { rays, beam });
        }
        let mut color = rgba!(C => load(s, &packet.color[C]));
        let [mut half, mut samples] = [load(s, &packet.half), load(s, &packet.samples)];
        let end = run.end.min(packet.last);
        let mut k = packet.next.max(run.start);
        while k < end {
            let leap = self.leap(&lines, k);
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
                        let (lanes, seen) = self.together(&lines, open, light);
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

    /// How many slabs from slab k on, itself included, certainly add nothing in any layer.
    #[inline(always)]
    fn leap(&self, lines: &[LayerRay<S>], k: usize) -> usize {
        let mut least = usize::MAX;
        for (eye, line) in self.layers.iter().zip(lines) {
            let Some(skip) = eye.medium.skip else { return 0 };
            // What rays have left behind lets them leap however far, and another layer is still ahead.
            let leap = line.rays.leap(
                eye.medium.s,
                k,
                #[inline(always)]
                |index| skip.clear(eye.medium.s, index, &line.rays.inverse),
            );
            least = least.min(leap);
        }
        least
    }

    /// What all layers send to the eye from a slab, and the lanes that meet any of them: light comes to their samples
    /// through all that is there, and emission is weighted by extinction.
    #[inline(never)]
    fn together(
        &self,
        lines: &[LayerRay<S>],
        open: Mask<S>,
        light: (usize, &LightBuffer),
    ) -> (Mask<S>, Option<SlabElement<S>>) {
        let s = self.first().s;
        s.vectorize(
            #[inline(always)]
            || {
                let one = splat(s, 1.0);
                let (mut met, mut left, mut sights) = (all(s, false), one, Vec::with_capacity(lines.len()));
                for (eye, line) in self.layers.iter().zip(lines) {
                    let passage = line.rays.passage(s, light.0);
                    let lanes = passage.lanes & open;
                    met |= lanes;
                    if !lanes.any_true() {
                        continue;
                    }
                    if let Some(sight) = eye.see(&passage.index, lanes) {
                        left = sight.visible.select(left * (one - sight.rgba[3]), left);
                        sights.push((eye, line, passage, sight));
                    }
                }
                let mut transmittance = None;
                if sights.iter().any(|(.., sight)| sight.transmittance.is_some()) {
                    let mut product = [one; 3];
                    for (eye, .., sight) in &sights {
                        let own = eye.half_transmittance(sight);
                        product = xyz!(C => sight.visible.select(product[C] * own[C], product[C]));
                    }
                    transmittance = Some(product);
                }
                let (held, mut place) = (Attenuation { alpha: one - left, transmittance }, splat(s, 0.0));
                let mut elements = Vec::with_capacity(sights.len());
                for (eye, line, passage, sight) in &sights {
                    elements.push(eye.lit(sight, &held, passage, light, line.beam.as_ref()));
                    place = sight.visible.select(passage.place, place);
                }
                let element = merged(s, Overlap::Add, &elements);
                (met, element.visible.any_true().then_some(SlabElement { place, element }))
            },
        )
    }

    /// What the rays of a packet found, where half of their opacity is reached, and the surface there; `worlds` are
    /// those of the layers' index positions.
    pub fn finish(&self, packet: &EyePacket, stage: &Stage, worlds: &[DAffine3], mut each: impl FnMut(usize, Found)) {
        let (s, chroma) = (self.first().s, self.first().chroma.as_ref());
        let (surface, alpha, opacities) = s.vectorize(
            #[inline(always)]
            || {
                let alpha = load(s, &packet.color[3]);
                (self.half(packet), chroma::coverage(s, chroma, alpha), chroma::opacities(s, chroma, alpha))
            },
        );
        let Reached { met, normal, places } = surface;
        let bits = met.to_bitmask();
        for lane in 0..width::<S>() {
            let Some(layer) = packet.crossings.iter().position(|crossing| crossing.lanes().any(|l| l == lane)) else {
                continue;
            };
            let is_met = bits >> lane & 1 == 1;
            let to_eye = DVec3::from_array([0, 1, 2].map(|axis| f64::from(packet.to_eye[axis][lane])));
            let depth = || {
                let world = worlds[layer].transform_point3(lane_position::<S>(&places[layer], lane));
                (stage.viewpoint.eye - world).dot(to_eye) as f32
            };
            let found = Found {
                color: [packet.color[0][lane], packet.color[1][lane], packet.color[2][lane], alpha[lane]],
                opacities: [opacities[0][lane], opacities[1][lane], opacities[2][lane]],
                depth: if is_met { depth() } else { f32::INFINITY },
                normal: if is_met { [0, 1, 2].map(|axis| normal[axis][lane]) } else { [0.0; 3] },
                samples: packet.samples[lane] as u32,
            };
            each(lane, found);
        }
    }

    /// Where opacity first reaches one half, from the eye.
    #[inline(always)]
    fn half(&self, packet: &EyePacket) -> Reached<S> {
        let (s, zero) = (self.first().s, splat(self.first().s, 0.0));
        let mut lines = Vec::with_capacity(self.layers.len());
        for crossing in &packet.crossings {
            lines.push(Crossings::new(s, crossing));
        }
        let backward = load(s, &packet.backward).simd_gt(splat(s, 0.5));
        let met = load(s, &packet.color[3]).simd_ge(splat(s, 0.5));
        if !met.any_true() {
            return Reached { met, normal: [zero; 3], places: vec![[zero; 3]; lines.len()] };
        }
        let mut half = load(s, &packet.half);
        if (met & backward).any_true() {
            half = backward.select(self.half_from_eye(&lines, packet.slabs(), met & backward), half);
        }
        // By rounding, opacity may reach one half on the one way and not on the other.
        let met = met & half.is_finite();
        let half = met.select(half, zero);
        let mut places = Vec::with_capacity(lines.len());
        for rays in &lines {
            places.push(rays.at(half));
        }
        let normal = match (self.layers.as_slice(), places.as_slice()) {
            ([eye], [place]) => eye.normals(*place, met),
            _ => self.normals_of_densest(&lines, half, met),
        };
        Reached { met, normal, places }
    }

    /// Normals of the layer that has most opacity at coordinates.
    #[inline(never)]
    fn normals_of_densest(&self, lines: &[Crossings<S>], half: F32<S>, met: Mask<S>) -> Vec3<S> {
        let s = self.first().s;
        s.vectorize(
            #[inline(always)]
            || {
                let (mut normal, mut most) = ([splat(s, 0.0); 3], splat(s, 0.0));
                for (eye, rays) in self.layers.iter().zip(lines) {
                    let (place, lanes) = (rays.at(half), met & rays.holds(half));
                    let Some(SlabSample { rgba, visible, .. }) = eye.see(&place, lanes) else { continue };
                    let more = visible & rgba[3].simd_gt(most);
                    if more.any_true() {
                        let own = eye.normals(place, more);
                        normal = xyz!(I => more.select(own[I], normal[I]));
                        most = more.select(rgba[3], most);
                    }
                }
                normal
            },
        )
    }

    /// Coordinates at which opacity first reaches one half, infinite if never: rays whose last slabs were seen first
    /// are followed once more.
    #[inline(always)]
    fn half_from_eye(&self, lines: &[Crossings<S>], slabs: Range<usize>, lanes: Mask<S>) -> F32<S> {
        let (s, one) = (self.first().s, splat(self.first().s, 1.0));
        let (mut found, mut transmittance, mut open) = (splat(s, f32::INFINITY), one, lanes);
        let mut end = slabs.end;
        while end > slabs.start && open.any_true() {
            let k = end - 1;
            let leap = self.leap_back(lines, k);
            if leap > 0 {
                end = end.saturating_sub(leap);
                continue;
            }
            end = k;
            for (eye, rays) in self.layers.iter().zip(lines) {
                let Passage { place, index, ratio, lanes } = rays.passage(s, k);
                let lanes = lanes & open;
                if !lanes.any_true() {
                    continue;
                }
                let Some(SlabSample { rgba, visible, .. }) = eye.see(&index, lanes) else { continue };
                let alpha = opacity_over(s, rgba[3], ratio);
                transmittance = visible.select(transmittance * (one - alpha), transmittance);
                let here = visible & transmittance.simd_le(splat(s, 0.5));
                found = here.select(place, found);
                open &= !here;
            }
        }
        found
    }

    /// How many slabs from slab k back certainly add nothing in any layer.
    #[inline(always)]
    fn leap_back(&self, lines: &[Crossings<S>], k: usize) -> usize {
        let mut least = usize::MAX;
        for (eye, rays) in self.layers.iter().zip(lines) {
            let Some(skip) = eye.medium.skip else { return 0 };
            let back = xyz!(I => -rays.inverse[I]);
            let leap = rays.leap_back(
                eye.medium.s,
                k,
                #[inline(always)]
                |index| skip.clear(eye.medium.s, index, &back),
            );
            least = least.min(leap);
        }
        least
    }
}

/// Where opacity first reaches one half.
struct Reached<S: Lanes> {
    /// Lanes in which it does.
    met: Mask<S>,
    /// Normals there.
    normal: Vec3<S>,
    /// Index positions, in each of the layers.
    places: Vec<Vec3<S>>,
}

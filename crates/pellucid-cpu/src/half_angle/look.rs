//! Rays of the eye through slabs, and what they gather while light passes: of one volume, or of all layers together.

use std::ops::Range;

use glam::{DAffine3, DVec3};
use pellucid_plan::half_angle::Slabs;
use pellucid_scene::{Overlap, Stage};

use super::buffer::LightBuffer;
use super::crossing::{Crossing, Crossings, UNASKED, slabs_of};
use super::eye::{Attenuation, Eye};
use super::optics::SlabOptics;
use super::pieces::{MetLayer, Share, end_of_piece, leap, leap_back, shares};
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
    fn first(&self) -> &OneGrid<'_, S, &F, SlabOptics<'_>> {
        &self.layers[0].medium
    }

    #[inline(always)]
    fn follow(&self, packet: &mut EyePacket, run: Range<usize>, lights: &[LightBuffer], tally: &mut Tally) {
        let first = self.first();
        let (s, chroma) = (first.s, first.chroma.as_ref());
        let backward = load(s, &packet.backward).simd_gt(splat(s, 0.5));
        let to_eye = xyz!(I => load(s, &packet.to_eye[I]));
        // A ray of a single volume needs no memory of its own.
        let (single, several);
        let lines: &[LayerRay<S>] = match (self.layers.as_slice(), packet.crossings.as_slice()) {
            ([eye], [crossing]) => {
                single = [LayerRay::new(eye, crossing, to_eye, backward)];
                &single
            }
            (layers, crossings) => {
                let mut lines = Vec::with_capacity(layers.len());
                for (eye, crossing) in layers.iter().zip(crossings) {
                    lines.push(LayerRay::new(eye, crossing, to_eye, backward));
                }
                several = lines;
                &several
            }
        };
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
                let seen = match (self.layers.as_slice(), lines) {
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
                        let (lanes, seen) = self.together((&met, lines), [open, backward], light);
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
    fn met<'m>(&'m self, rays: impl Iterator<Item = &'m Crossings<S>>) -> Vec<MetLayer<'m, 'a, S, F>> {
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
                let (mut front, back) = (splat(s, light.0 as f32), splat(s, (light.0 + 1) as f32));
                while front.simd_lt(back).any_true() {
                    let end = end_of_piece(met, front, back);
                    let (lanes, shares) = shares(
                        s,
                        self.overlap,
                        met,
                        #[inline(always)]
                        |rays| rays.between(s, [front, end]).within(open),
                        #[inline(always)]
                        |_| splat(s, 1.0),
                    );
                    is_met |= lanes;
                    if !shares.is_empty() {
                        let piece = self.lit(&shares, lines, light);
                        let Element { rgba, visible } = piece.element;
                        // Rays that travel against the order of slabs meet the last pieces first.
                        let nearer = rgba!(C => backward.select(rgba[C], seen.rgba[C]));
                        let farther = rgba!(C => backward.select(seen.rgba[C], rgba[C]));
                        seen.rgba = chroma::over(s, chroma, nearer, farther);
                        seen.visible |= visible;
                        place = visible.select(piece.place, place);
                    }
                    front = end;
                }
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
        let layers = self.met(lines.iter());
        let mut half = load(s, &packet.half);
        if (met & backward).any_true() {
            half = backward.select(self.half_from_eye(&layers, packet.slabs(), met & backward), half);
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
            _ => self.normals_of_densest(&layers, half, met),
        };
        Reached { met, normal, places }
    }

    /// Normals of the layer that has most opacity at coordinates.
    #[inline(never)]
    fn normals_of_densest(&self, met: &[MetLayer<S, F>], half: F32<S>, lanes: Mask<S>) -> Vec3<S> {
        let s = self.first().s;
        s.vectorize(
            #[inline(always)]
            || {
                let (mut normal, mut most) = ([splat(s, 0.0); 3], splat(s, 0.0));
                let (_, shares) = shares(
                    s,
                    self.overlap,
                    met,
                    #[inline(always)]
                    |rays| rays.sample(s, half).within(lanes),
                    #[inline(always)]
                    |_| splat(s, 1.0),
                );
                for Share { layer, passage, sample } in &shares {
                    let more = sample.visible & sample.rgba[3].simd_gt(most);
                    if more.any_true() {
                        let own = self.layers[*layer].normals(passage.index, more);
                        normal = xyz!(I => more.select(own[I], normal[I]));
                        most = more.select(sample.rgba[3], most);
                    }
                }
                normal
            },
        )
    }

    /// Coordinates at which opacity first reaches one half, infinite if never: rays whose last slabs were seen first
    /// are followed once more.
    #[inline(always)]
    fn half_from_eye(&self, met: &[MetLayer<S, F>], slabs: Range<usize>, lanes: Mask<S>) -> F32<S> {
        let s = self.first().s;
        let (mut found, mut transmittance, mut open) = (splat(s, f32::INFINITY), splat(s, 1.0), lanes);
        let mut end = slabs.end;
        while end > slabs.start && open.any_true() {
            let k = end - 1;
            let leap = leap_back(met, k);
            if leap > 0 {
                end = end.saturating_sub(leap);
                continue;
            }
            end = k;
            let [left, place] = self.left_of(met, k, open);
            transmittance *= left;
            let here = open & transmittance.simd_le(splat(s, 0.5)) & place.is_finite();
            found = here.select(place, found);
            open &= !here;
        }
        found
    }

    /// What gets through a slab to the eye, and the coordinate of what is there; infinite where nothing is.
    #[inline(never)]
    fn left_of(&self, met: &[MetLayer<S, F>], k: usize, lanes: Mask<S>) -> [F32<S>; 2] {
        let s = self.first().s;
        s.vectorize(
            #[inline(always)]
            || {
                let (mut left, mut place) = (splat(s, 1.0), splat(s, f32::INFINITY));
                let (mut front, back) = (splat(s, k as f32), splat(s, (k + 1) as f32));
                while front.simd_lt(back).any_true() {
                    let end = end_of_piece(met, front, back);
                    let (_, shares) = shares(
                        s,
                        self.overlap,
                        met,
                        #[inline(always)]
                        |rays| rays.between(s, [front, end]).within(lanes),
                        #[inline(always)]
                        |_| splat(s, 1.0),
                    );
                    for Share { passage, sample, .. } in &shares {
                        let alpha = opacity_over(s, sample.rgba[3], passage.ratio);
                        left = sample.visible.select(left * (splat(s, 1.0) - alpha), left);
                        place = sample.visible.select(passage.place, place);
                    }
                    front = end;
                }
                [left, place]
            },
        )
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

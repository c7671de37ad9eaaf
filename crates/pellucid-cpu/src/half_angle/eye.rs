//! What the eye sees of slabs as light passes them (Eq. 6.9, 6.10, K-05).

use std::ops::Range;

use glam::DVec3;
use pellucid_optics::Chroma;
use pellucid_plan::half_angle::{LightFrame, Slabs, Ways};
use pellucid_scene::{LightCorrection, Stage};

use super::buffer::{Light, LightBuffer};
use super::crossing::{Crossing, Crossings, Passage, UNASKED};
use super::frame::Project;
use super::transport;
use crate::chroma;
use crate::classify::Lookup;
use crate::cut::{Cut, Cuts};
use crate::field::Field;
use crate::integrator::{Found, Tally};
use crate::lanes::*;
use crate::packet::{Packet, PerLane};
use crate::prepare::Prepared;
use crate::skip::SkipGrid;
use crate::surface::{Aim, Surface, Unlit, normals};
use crate::vary::Varied;

/// Rays of the eye side by side, and what they have gathered.
pub struct EyePacket {
    /// Column and row of the first one in its tile.
    pub corner: [usize; 2],
    crossing: Crossing,
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
    /// No rays.
    pub const NOTHING: Self = Self {
        corner: [0; 2],
        crossing: Crossing::NOTHING,
        to_eye: [[0.0; MOST_LANES]; 3],
        backward: [0.0; MOST_LANES],
        color: [[0.0; MOST_LANES]; 4],
        half: [f32::INFINITY; MOST_LANES],
        samples: [0.0; MOST_LANES],
        next: 0,
        last: 0,
    };

    /// Takes up rays, of which the first is at a corner of its tile. Returns whether any of them meets a slab.
    pub fn take<S: Lanes>(
        &mut self,
        s: S,
        rays: &Packet,
        slabs: &Slabs,
        prepared: &Prepared,
        corner: [usize; 2],
    ) -> bool {
        self.corner = corner;
        self.backward = self.crossing.take(s, rays, slabs, prepared.grid(), prepared.stage.step);
        for (lanes, directions) in self.to_eye.iter_mut().zip(&rays.world_direction) {
            for (lane, direction) in lanes.iter_mut().zip(directions) {
                *lane = -direction;
            }
        }
        let Range { start, end } = self.crossing.slabs();
        (self.next, self.last) = (start, end);
        start < end
    }

    /// The slabs that it meets.
    pub fn slabs(&self) -> Range<usize> {
        self.crossing.slabs()
    }
}

/// What is needed to look at slabs.
pub struct Eye<'a, S: Lanes, F> {
    /// The instruction set.
    pub s: S,
    /// The field.
    pub field: &'a F,
    /// Associated colours of one step.
    pub table: Lookup<'a>,
    /// What gets through of indirect light over half of a slab, if that is something else.
    pub half_transport: Option<Lookup<'a>>,
    /// How long that is, in steps.
    pub half: f32,
    /// How each colour is held back, if not all alike.
    pub chroma: Option<Chroma>,
    /// How samples answer the light.
    pub surface: Surface<'a, S>,
    /// Where they are in the light's picture.
    pub frame: &'a LightFrame,
    /// Length of a ray of light in a slab, in steps, or the coordinate of a light that is somewhere.
    pub ways: Ways,
    /// What light loses in front of a sample.
    pub correction: LightCorrection,
    /// Weights of direct light that becomes indirect there, if any does (6.3-7).
    pub into_cone: Option<[f32; 3]>,
    /// Factors of direct and indirect light.
    pub scales: [f32; 2],
    /// Where matter is cut.
    pub cuts: Cuts,
    /// Blocks that can contribute, if empty space is skipped.
    pub skip: Option<&'a SkipGrid>,
    /// What varies optics, if anything does.
    pub varied: Option<Varied<'a>>,
    /// Opacity at which a ray ends.
    pub early_termination: f32,
}

impl<S: Lanes, F: Field<S>> Eye<'_, S, F> {
    /// Looks at a run of slabs, each lit by what has come to it.
    pub fn look(&self, packets: &mut [EyePacket], run: Range<usize>, lights: &[LightBuffer], tally: &mut Tally) {
        self.s.vectorize(
            #[inline(always)]
            || {
                for packet in packets.iter_mut().filter(|packet| packet.next < run.end && packet.last > run.start) {
                    self.follow(packet, run.clone(), lights, tally);
                }
            },
        );
    }

    #[inline(always)]
    fn follow(&self, packet: &mut EyePacket, run: Range<usize>, lights: &[LightBuffer], tally: &mut Tally) {
        let s = self.s;
        let rays = Crossings::new(s, &packet.crossing);
        let mut color = rgba!(C => load(s, &packet.color[C]));
        let [mut half, mut samples] = [load(s, &packet.half), load(s, &packet.samples)];
        let backward = load(s, &packet.backward).simd_gt(splat(s, 0.5));
        let aim = self.surface.aim(s, xyz!(I => load(s, &packet.to_eye[I])));
        let cut = self.cut(&rays, backward);
        let end = run.end.min(packet.last);
        let mut k = packet.next.max(run.start);
        while k < end {
            if let Some(skip) = self.skip {
                let leap = rays.leap(
                    s,
                    k,
                    #[inline(always)]
                    |index| skip.clear(s, index, &rays.inverse),
                );
                if leap > 0 {
                    tally.skipped += leap as u64;
                    k += leap;
                    continue;
                }
            }
            let stop = end.min(k + UNASKED);
            for k in k..stop {
                let passage = rays.passage(s, k);
                let open = backward | color[3].simd_lt(splat(s, self.early_termination));
                let lanes = passage.lanes & open;
                if !lanes.any_true() {
                    continue;
                }
                samples = lanes.select(samples + 1.0, samples);
                let Some((rgba, visible)) = self.sample(&passage, lanes, k, &lights[k - run.start], (&aim, &cut))
                else {
                    continue;
                };
                tally.visible += count::<S>(visible);
                // In front of what is there (over), or behind it (under).
                let front = rgba!(C => backward.select(rgba[C], color[C]));
                let behind = rgba!(C => backward.select(color[C], rgba[C]));
                let both = chroma::over(s, self.chroma.as_ref(), front, behind);
                color = rgba!(C => visible.select(both[C], color[C]));
                let here = color[3].simd_ge(splat(s, 0.5)) & half.simd_eq(splat(s, f32::INFINITY));
                half = here.select(passage.place, half);
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

    /// What samples add, and the lanes in which that is anything.
    #[inline(always)]
    fn sample(
        &self,
        passage: &Passage<S>,
        lanes: Mask<S>,
        k: usize,
        light: &LightBuffer,
        (aim, cut): (&Aim<S>, &Cut<S>),
    ) -> Option<([F32<S>; 4], Mask<S>)> {
        let s = self.s;
        let Passage { place, index, ratio, .. } = *passage;
        let value = self.field.values(s, index, lanes);
        let position = self.table.position(s, value);
        let candidates = lanes & self.table.may_be_visible(s, position);
        if !candidates.any_true() {
            return None;
        }
        let mut one_step = self.table.at(s, position, None);
        let visible = candidates & one_step[3].simd_gt(splat(s, 0.0));
        if !visible.any_true() {
            return None;
        }
        let noise = self.noise(&index);
        if let Some((varied, noise)) = &noise {
            one_step = varied.associated(s, noise, one_step);
        }
        let rgba = chroma::over_length(s, self.chroma.as_ref(), one_step, ratio);
        let indirect = match &self.half_transport {
            Some(table) if light.channels() > 1 => {
                let through = transport::through(s, table, value, splat(s, 1.0));
                Some(match &noise {
                    Some((varied, noise)) => varied.transport(s, noise, through),
                    None => through,
                })
            }
            _ => None,
        };
        let arriving = self.arriving(light, &index, place - k as f32, one_step[3], indirect, k);
        let direct = chroma::each(s, self.chroma.as_ref(), arriving.direct);
        let direct = xyz!(C => direct[C] * self.scales[0]);
        let sample = Unlit { rgba, value, index, lanes: visible };
        let mut lit = self.surface.shade_through(
            s,
            &sample,
            aim,
            #[inline(always)]
            || {
                let gradients = self.field.gradients(s, index, visible);
                if self.surface.weighs_gradients() { gradients } else { cut.gradients(s, &index, gradients) }
            },
            #[inline(always)]
            |_| direct,
        );
        if let Some(indirect) = arriving.indirect {
            let radiance = self.surface.radiance(s, &index, visible);
            for channel in 0..3 {
                let factor = indirect[channel] * radiance[channel] * self.scales[1];
                lit[channel] = visible.select(rgba[channel].mul_add(factor, lit[channel]), lit[channel]);
            }
        }
        Some((lit, visible))
    }

    /// The faces by which the eye's rays come in, which for some is where they leave the last slab.
    #[inline(always)]
    fn cut(&self, rays: &Crossings<S>, backward: Mask<S>) -> Cut<S> {
        let [entry, direction] = rays.entry(backward);
        self.cuts.met(self.s, &entry, &direction)
    }

    /// The noise at index positions, if optics vary.
    #[inline(always)]
    fn noise(&self, index: &Vec3<S>) -> Option<(Varied<'_>, [F32<S>; 4])> {
        self.varied.map(
            #[inline(always)]
            |varied| (varied, varied.noise(self.s, index)),
        )
    }

    /// The light that has come to samples a part of the way through slab k; `through` gets through half
    /// of a slab of indirect light, where most samples are, if that is something else.
    #[inline(always)]
    fn arriving(
        &self,
        light: &LightBuffer,
        index: &Vec3<S>,
        part: F32<S>,
        alpha: F32<S>,
        through: Option<[F32<S>; 3]>,
        k: usize,
    ) -> Light<S> {
        let (s, one) = (self.s, splat(self.s, 1.0));
        let [texels, _] = self.frame.texels(s, index);
        let place = light.place(s, texels);
        let Light { direct, indirect } = light.fetch(s, &place);
        let (inside, halves) = match (self.correction, self.ways) {
            (LightCorrection::None, _) => return Light { direct, indirect },
            (LightCorrection::HalfSlab, Ways::Same(steps)) => (part * steps, part * 2.0),
            (LightCorrection::HalfSlab, Ways::From { place, step }) => {
                let distance = self.frame.distance(s, index);
                let inside = part * (distance / ((part + (k as f32 - place)) * step));
                (inside, inside / self.half)
            }
        };
        let left = part_through(s, one - alpha, inside);
        let indirect = match (indirect, through) {
            (None, _) => None,
            (Some(light), None) => {
                let left = chroma::each(s, self.chroma.as_ref(), left);
                Some(xyz!(C => light[C] * left[C]))
            }
            (Some(light), Some(through)) => {
                let passing = xyz!(C => transport::over(s, through[C], halves));
                let mut indirect = xyz!(C => light[C] * passing[C]);
                if let Some(into_cone) = self.into_cone {
                    // As light does that passes the slab.
                    let [from, left] = [direct, left].map(|light| chroma::each(s, self.chroma.as_ref(), light));
                    for channel in 0..3 {
                        let scattered = (passing[channel] - left[channel]).max(splat(s, 0.0)) * into_cone[channel];
                        indirect[channel] = from[channel].mul_add(scattered, indirect[channel]);
                    }
                }
                Some(indirect)
            }
        };
        Light { direct: direct * left, indirect }
    }

    /// What the rays of a packet found, where half of their opacity is reached, and the surface there.
    pub fn finish(
        &self,
        packet: &EyePacket,
        stage: &Stage,
        world_from_index: &glam::DAffine3,
        mut each: impl FnMut(usize, Found),
    ) {
        let s = self.s;
        let ((index, met, normal), alpha, opacities) = s.vectorize(
            #[inline(always)]
            || {
                let (alpha, chroma) = (load(s, &packet.color[3]), self.chroma.as_ref());
                (self.half(packet), chroma::coverage(s, chroma, alpha), chroma::opacities(s, chroma, alpha))
            },
        );
        let bits = met.to_bitmask();
        for lane in packet.crossing.lanes() {
            let is_met = bits >> lane & 1 == 1;
            let to_eye = DVec3::from_array([0, 1, 2].map(|axis| f64::from(packet.to_eye[axis][lane])));
            let depth = || {
                let world = world_from_index.transform_point3(crate::field::lane_position::<S>(&index, lane));
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

    /// Index positions at which opacity first reaches one half, from the eye, lanes that have one, and
    /// normals there.
    #[inline(always)]
    fn half(&self, packet: &EyePacket) -> (Vec3<S>, Mask<S>, Vec3<S>) {
        let (s, zero) = (self.s, splat(self.s, 0.0));
        let rays = Crossings::new(s, &packet.crossing);
        let backward = load(s, &packet.backward).simd_gt(splat(s, 0.5));
        let met = load(s, &packet.color[3]).simd_ge(splat(s, 0.5));
        if !met.any_true() {
            return ([zero; 3], met, [zero; 3]);
        }
        let mut half = load(s, &packet.half);
        if (met & backward).any_true() {
            half = backward.select(self.half_from_eye(&rays, packet.crossing.slabs(), met & backward), half);
        }
        // By rounding, opacity may reach one half on the one way and not on the other.
        let met = met & half.is_finite();
        let found = rays.at(met.select(half, zero));
        let gradient = self.field.gradients(s, found, met);
        (found, met, normals(s, gradient).0)
    }

    /// Coordinates at which opacity first reaches one half, infinite if never: rays whose last slabs were seen first
    /// are followed once more.
    #[inline(always)]
    fn half_from_eye(&self, rays: &Crossings<S>, slabs: Range<usize>, lanes: Mask<S>) -> F32<S> {
        let (s, one) = (self.s, splat(self.s, 1.0));
        let back = xyz!(I => -rays.inverse[I]);
        let (mut found, mut through, mut open) = (splat(s, f32::INFINITY), one, lanes);
        let mut end = slabs.end;
        while end > slabs.start && open.any_true() {
            let k = end - 1;
            if let Some(skip) = self.skip {
                let leap = rays.leap_back(
                    s,
                    k,
                    #[inline(always)]
                    |index| skip.clear(s, index, &back),
                );
                if leap > 0 {
                    end = end.saturating_sub(leap);
                    continue;
                }
            }
            end = k;
            let Passage { place, index, ratio, lanes } = rays.passage(s, k);
            let lanes = lanes & open;
            if !lanes.any_true() {
                continue;
            }
            let value = self.field.values(s, index, lanes);
            let position = self.table.position(s, value);
            let visible = lanes & self.table.may_be_visible(s, position);
            let mut alpha = self.table.at(s, position, None)[3];
            if let Some((varied, noise)) = self.noise(&index) {
                alpha = varied.opacity(s, &noise, alpha);
            }
            let alpha = opacity_over(s, alpha, ratio);
            through = visible.select(through * (one - alpha), through);
            let here = visible & through.simd_le(splat(s, 0.5));
            found = here.select(place, found);
            open &= !here;
        }
        found
    }
}

/// What gets through so many steps, of which one lets `through` through. Half a step is what most samples ask.
#[inline(always)]
fn part_through<S: Lanes>(s: S, through: F32<S>, steps: F32<S>) -> F32<S> {
    let half = steps.simd_eq(splat(s, 0.5));
    let root = through.max(splat(s, 0.0)).sqrt();
    if half.all_true() { root } else { half.select(root, power(s, through, steps)) }
}

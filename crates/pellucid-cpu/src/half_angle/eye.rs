//! What the eye sees of slabs as light passes them (Eq. 6.9, 6.10, K-05).

use std::ops::Range;

use glam::DVec3;
use pellucid_scene::half_angle::{LightFrame, Slabs, Ways};
use pellucid_scene::{Jitter, LightCorrection, Stage, blue_noise};

use super::buffer::LightBuffer;
use super::crossing::{Crossing, Crossings, Passage, chord};
use super::frame::Project;
use super::transport;
use crate::classify::{Lookup, over_length};
use crate::field::{Any, Field};
use crate::integrator::{Found, Tally};
use crate::lanes::*;
use crate::packet::PerLane;
use crate::prepare::Prepared;
use crate::skip::SkipGrid;
use crate::surface::{Surface, Unlit, normals};
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
    samples: PerLane,
    /// The first slab that may hold anything, and the end of all rays.
    next: usize,
    last: usize,
}

impl EyePacket {
    /// Rays through pixels whose first is at a corner of a tile at a place of the picture, `columns` side by
    /// side; `sub` is the number of the ray within its pixel. `None` if none meets the field.
    pub fn new(
        prepared: &Prepared,
        slabs: &Slabs,
        [place, corner, size]: [[usize; 2]; 3],
        [lanes, columns]: [usize; 2],
        sub: usize,
    ) -> Option<Self> {
        let (stage, grid) = (prepared.stage, prepared.grid());
        let n = stage.quality.supersampling as usize;
        let mut packet = Self {
            corner,
            crossing: Crossing::NOTHING,
            to_eye: [[0.0; MOST_LANES]; 3],
            backward: [0.0; MOST_LANES],
            color: [[0.0; MOST_LANES]; 4],
            samples: [0.0; MOST_LANES],
            next: 0,
            last: 0,
        };
        for lane in 0..lanes {
            let (column, row) = (corner[0] + lane % columns, corner[1] + lane / columns);
            if column >= size[0] || row >= size[1] {
                continue;
            }
            let x = (place[0] + column) as f64 + ((sub % n) as f64 + 0.5) / n as f64;
            let y = (place[1] + row) as f64 + ((sub / n) as f64 + 0.5) / n as f64;
            let ray = stage.viewpoint.ray(x, y);
            let Some(span) = chord(&ray, 0.0, grid, &prepared.region) else { continue };
            let backward = packet.crossing.set(lane, &ray, span, slabs, grid, stage.step);
            packet.backward[lane] = f32::from(u8::from(backward));
            packet.crossing.jitter[lane] = match stage.quality.jitter {
                Jitter::Centered => 0.5,
                Jitter::BlueNoise { seed } => {
                    const GOLDEN: f64 = 0.618_033_988_749_894_9;
                    (blue_noise(x as usize, y as usize, seed) + sub as f64 * GOLDEN).fract() as f32
                }
            };
            for axis in 0..3 {
                packet.to_eye[axis][lane] = -ray.direction[axis] as f32;
            }
        }
        let Range { start, end } = packet.crossing.slabs();
        (packet.next, packet.last) = (start, end);
        (start < end).then_some(packet)
    }

    /// The slabs that it meets.
    pub fn slabs(&self) -> Range<usize> {
        self.crossing.slabs()
    }
}

/// What is needed to look at slabs.
pub struct Eye<'a, S: Lanes> {
    /// The instruction set.
    pub s: S,
    /// The field.
    pub field: Any<'a, S>,
    /// Associated colours of one step.
    pub table: Lookup<'a>,
    /// What gets through of indirect light over half of a slab, if that is something else.
    pub half_transport: Option<Lookup<'a>>,
    /// How long that is, in steps.
    pub half: f32,
    /// How samples answer the light.
    pub surface: Surface<'a, S>,
    /// Where they are in the light's picture.
    pub frame: &'a LightFrame,
    /// Length of a ray of light in a slab, in steps, or the coordinate of a light that is somewhere.
    pub ways: Ways,
    /// What light loses in front of a sample.
    pub correction: LightCorrection,
    /// Factors of direct and indirect light.
    pub scales: [f32; 2],
    /// Blocks that can contribute, if empty space is skipped.
    pub skip: Option<&'a SkipGrid>,
    /// What varies optics, if anything does.
    pub varied: Option<Varied<'a>>,
    /// Opacity at which a ray ends.
    pub early_termination: f32,
}

/// Light as it reaches samples, as shares of the source.
struct Arriving<S: Lanes> {
    direct: F32<S>,
    /// If there is any.
    indirect: Option<[F32<S>; 3]>,
}

impl<S: Lanes> Eye<'_, S> {
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
        let mut samples = load(s, &packet.samples);
        let backward = load(s, &packet.backward).simd_gt(splat(s, 0.5));
        let aim = self.surface.aim(s, xyz!(I => load(s, &packet.to_eye[I])));
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
            for k in k..end {
                let passage = rays.passage(s, k);
                let open = backward | color[3].simd_lt(splat(s, self.early_termination));
                let lanes = passage.lanes & open;
                if !lanes.any_true() {
                    continue;
                }
                samples = lanes.select(samples + 1.0, samples);
                let Some((rgba, visible)) = self.sample(&passage, lanes, k, &lights[k - run.start], &aim) else {
                    continue;
                };
                tally.visible += count::<S>(visible);
                // In front of what is there (over), or behind it (under).
                let (one, zero) = (splat(s, 1.0), splat(s, 0.0));
                let new = visible.select(backward.select(one, one - color[3]), zero);
                let old = (visible & backward).select(one - rgba[3], one);
                color = rgba!(C => new.mul_add(rgba[C], old * color[C]));
            }
            k = end;
        }
        packet.next = k;
        let open = backward | color[3].simd_lt(splat(s, self.early_termination));
        if !open.any_true() {
            packet.last = packet.last.min(k);
        }
        for channel in 0..4 {
            store::<S>(color[channel], &mut packet.color[channel]);
        }
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
        aim: &crate::surface::Aim<S>,
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
        let rgba = over_length(s, one_step, ratio);
        let indirect = match &self.half_transport {
            Some(table) if light.planes.len() > 1 => {
                let through = transport::through(s, table, value, splat(s, 1.0));
                Some(match &noise {
                    Some((varied, noise)) => varied.transport(s, noise, through),
                    None => through,
                })
            }
            _ => None,
        };
        let arriving = self.arriving(light, &index, place - k as f32, one_step[3], indirect, k);
        let direct = arriving.direct * self.scales[0];
        let sample = Unlit { rgba, value, index, lanes: visible };
        let mut lit = self.surface.shade_through(
            s,
            &sample,
            aim,
            #[inline(always)]
            || self.field.gradients(s, index, visible),
            #[inline(always)]
            |_| [direct; 3],
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
    ) -> Arriving<S> {
        let (s, one) = (self.s, splat(self.s, 1.0));
        let [texels, _] = self.frame.texels(s, index);
        let place = light.place(s, texels);
        let direct = light.fetch(s, 0, &place);
        let indirect = (light.planes.len() > 1).then_some(());
        let (inside, halves) = match (self.correction, self.ways) {
            (LightCorrection::None, _) => {
                let indirect = match indirect {
                    Some(()) => Some(xyz!(C => light.fetch(s, C + 1, &place))),
                    None => None,
                };
                return Arriving { direct, indirect };
            }
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
            (Some(()), None) => Some(xyz!(C => light.fetch(s, C + 1, &place) * left)),
            (Some(()), Some(through)) => {
                Some(xyz!(C => light.fetch(s, C + 1, &place) * transport::over(s, through[C], halves)))
            }
        };
        Arriving { direct: direct * left, indirect }
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
        let (index, met, normal) = s.vectorize(
            #[inline(always)]
            || self.half(packet),
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
                color: packet.color.map(|lanes| lanes[lane]),
                depth: if is_met { depth() } else { f32::INFINITY },
                normal: if is_met { [0, 1, 2].map(|axis| normal[axis][lane]) } else { [0.0; 3] },
                samples: packet.samples[lane] as u32,
            };
            each(lane, found);
        }
    }

    /// Index positions at which opacity first reaches one half, from the eye, lanes that have one, and
    /// normals there: looked for once more, as the eye may have seen the last slabs first.
    #[inline(always)]
    fn half(&self, packet: &EyePacket) -> (Vec3<S>, Mask<S>, Vec3<S>) {
        let (s, zero, one) = (self.s, splat(self.s, 0.0), splat(self.s, 1.0));
        let rays = Crossings::new(s, &packet.crossing);
        let backward = load(s, &packet.backward).simd_gt(splat(s, 0.5));
        let enough = load(s, &packet.color[3]).simd_ge(splat(s, 0.5));
        let (mut found, mut met) = ([zero; 3], all(s, false));
        let Range { start, end } = packet.crossing.slabs();
        for reverse in [false, true] {
            let mut open = enough & if reverse { backward } else { !backward };
            let mut through = one;
            let mut number = 0;
            while number < end - start && open.any_true() {
                let k = if reverse { end - 1 - number } else { start + number };
                number += 1;
                let Passage { index, ratio, lanes, .. } = rays.passage(s, k);
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
                found = xyz!(I => here.select(index[I], found[I]));
                met |= here;
                open &= !here;
            }
        }
        let normal = if met.any_true() { normals(s, self.field.gradients(s, found, met)).0 } else { [zero; 3] };
        (found, met, normal)
    }
}

/// What gets through so many steps, of which one lets `through` through. Half a step is what most samples ask.
#[inline(always)]
fn part_through<S: Lanes>(s: S, through: F32<S>, steps: F32<S>) -> F32<S> {
    let half = steps.simd_eq(splat(s, 0.5));
    let root = through.max(splat(s, 0.0)).sqrt();
    if half.all_true() { root } else { half.select(root, power(s, through, steps)) }
}

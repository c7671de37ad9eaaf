//! Paths of light between places of an isosurface (G-07): what arrives at a place of lights, of the sky, and of the surface itself.

use std::ops::Range;

use glam::{DAffine3, Vec3 as GlamVec3};
use pellucid_optics::{Sky, turned};
use pellucid_scene::GlobalIllumination;

use super::gather::Gather;
use super::sequence::Sequence;
use super::surface_rays::SurfaceRays;
use crate::lanes::*;
use crate::packet::PerLane;
use crate::prepare::Prepared;

/// A place of a surface that paths start from.
#[derive(Clone, Copy, Debug)]
pub struct Departure {
    /// Index position.
    pub index: [f32; 3],
    /// Unit normal of the world, on the side that light arrives at.
    pub normal: [f32; 3],
    /// The isovalue of its surface.
    pub level: f32,
    /// Linear RGB of its surface: what of light goes on.
    pub albedo: [f32; 3],
    /// A number that no other place has.
    pub key: u64,
}

/// What paths through a volume find.
pub struct LightPaths<'a, S: Lanes> {
    s: S,
    rays: SurfaceRays<'a, S>,
    settings: &'a GlobalIllumination,
    world_from_index: DAffine3,
    /// How far from surfaces paths start, and how far they see, in world units.
    offset: f32,
    reach: f32,
}

/// A path on its way.
#[derive(Clone, Copy)]
struct Path {
    index: [f32; 3],
    normal: [f32; 3],
    /// How much of the light that arrives goes on to where the path started, of each colour.
    weight: [f32; 3],
    number: u32,
}

/// A packet of paths, lane by lane, with a direction each goes on in and what of light from there it brings.
struct Onward {
    from: [PerLane; 3],
    direction: [PerLane; 3],
    reach: PerLane,
    brings: [[f32; 3]; MOST_LANES],
    there: [bool; MOST_LANES],
}

impl<'a, S: Lanes> LightPaths<'a, S> {
    /// Through a volume and what is around it.
    pub fn new(s: S, prepared: &'a Prepared, settings: &'a GlobalIllumination, rays: SurfaceRays<'a, S>) -> Self {
        let grid = prepared.grid();
        let reach = match (settings.shadows, settings.distance) {
            (false, _) => 0.0,
            (true, distance) => distance.map_or(f32::INFINITY, |distance| distance as f32),
        };
        Self {
            s,
            rays,
            settings,
            world_from_index: grid.world_from_index(),
            offset: (settings.offset * grid.smallest_spacing()) as f32,
            reach,
        }
    }

    /// The surfaces.
    pub fn rays(&self) -> &SurfaceRays<'a, S> {
        &self.rays
    }

    /// Gathers what some of a place's paths find: of each, light that makes a white surface there as bright.
    #[inline(never)]
    pub fn follow(&self, place: &Departure, numbers: Range<u32>, gather: &mut impl Gather) {
        let sequence = Sequence::new(place.key);
        let start = |number| Path { index: place.index, normal: place.normal, weight: [1.0; 3], number };
        let mut paths: Vec<Path> = numbers.map(start).collect();
        let mut next = Vec::new();
        for bounce in 0..=self.settings.bounces {
            for packet in paths.chunks_mut(width::<S>()) {
                self.leave(packet);
                self.find_lights(place.level, packet, (sequence, bounce), gather);
                self.go_on(place, packet, (sequence, bounce), gather, &mut next);
            }
            std::mem::swap(&mut paths, &mut next);
            next.clear();
            if paths.is_empty() {
                break;
            }
        }
    }

    /// Takes paths off the surface (G-06).
    fn leave(&self, packet: &mut [Path]) {
        let Self { s, rays, offset, .. } = self;
        let mut way = [[0.0; MOST_LANES]; 3];
        for (lane, path) in packet.iter().enumerate() {
            (0..3).for_each(|axis| way[axis][lane] = path.normal[axis] * offset);
        }
        s.vectorize(
            #[inline(always)]
            || {
                let moved = rays.index_vector(&xyz!(I => load(*s, &way[I])));
                for axis in 0..3 {
                    store::<S>(moved[axis], &mut way[axis]);
                }
            },
        );
        for (lane, path) in packet.iter_mut().enumerate() {
            (0..3).for_each(|axis| path.index[axis] += way[axis][lane]);
        }
    }

    /// Gathers the light that arrives from one of the lights, which stands for all.
    fn find_lights(&self, level: f32, packet: &[Path], (sequence, bounce): (Sequence, u32), gather: &mut impl Gather) {
        let count = gather.lights().len();
        if count == 0 {
            return;
        }
        let mut onward = Onward::new();
        for (lane, path) in packet.iter().enumerate() {
            let u = sequence.pair(path.number, 3 * bounce + 1);
            // Every light has as many of the paths that start, as far as their number can be shared.
            let chosen = sequence.pair(path.number, 3 * bounce + 2).x * count as f32;
            let light = &gather.lights()[(chosen as usize).min(count - 1)];
            let world = self.world_from_index.transform_point3(GlamVec3::from(path.index).as_dvec3());
            let found = light.sample(world.as_vec3(), u.into());
            let cosine = found.incident.to_light.dot(path.normal.into());
            if cosine > 0.0 {
                let share = cosine * count as f32;
                let brings = [0, 1, 2].map(|c| path.weight[c] * found.incident.radiance[c] * share);
                onward.set(lane, path, found.incident.to_light, self.reach.min(found.distance), brings);
            }
        }
        let held = self.meet(level, &onward, None);
        for lane in onward.lanes().filter(|lane| held >> lane & 1 == 0) {
            gather.arrive(onward.brings[lane]);
        }
    }

    /// Gathers what arrives from the sky, and finds where paths meet the surface again.
    fn go_on(
        &self,
        place: &Departure,
        packet: &[Path],
        (sequence, bounce): (Sequence, u32),
        gather: &mut impl Gather,
        next: &mut Vec<Path>,
    ) {
        let last = bounce == self.settings.bounces;
        if last && !gather.has_sky() {
            return;
        }
        let mut onward = Onward::new();
        for (lane, path) in packet.iter().enumerate() {
            let u = sequence.pair(path.number, 3 * bounce).into();
            let (direction, share) = choose(path.normal.into(), u, gather.picture());
            if share > 0.0 {
                onward.set(lane, path, direction, self.reach, path.weight.map(|weight| weight * share));
            }
        }
        let mut met = Bounced::default();
        let bits = self.meet(place.level, &onward, (!last).then_some(&mut met));
        for lane in onward.lanes() {
            let direction = onward.towards(lane);
            if bits >> lane & 1 == 0 {
                gather.leave(direction, onward.brings[lane]);
            } else if !last {
                let [index, normal] =
                    [&met.index, &met.normal].map(|lanes| [0, 1, 2].map(|axis: usize| lanes[axis][lane]));
                let weight = [0, 1, 2].map(|c| onward.brings[lane][c] * place.albedo[c]);
                let facing = GlamVec3::from(normal);
                let normal = if facing.dot(direction) > 0.0 { -facing } else { facing };
                if normal != GlamVec3::ZERO && weight != [0.0; 3] {
                    next.push(Path { index, normal: normal.into(), weight, number: packet[lane].number });
                }
            }
        }
    }

    /// Lanes, bit by bit, whose way the surface ends, and where it does if that is asked for.
    fn meet(&self, level: f32, onward: &Onward, met: Option<&mut Bounced>) -> u64 {
        if self.reach <= 0.0 {
            return 0;
        }
        let s = self.s;
        s.vectorize(
            #[inline(always)]
            || {
                let (from, direction, reach, lanes) = onward.vectors(s);
                let Some(met) = met else {
                    return self.rays.are_held_back(level, &from, &direction, reach, lanes).to_bitmask();
                };
                let found = self.rays.meet(level, &from, &direction, reach, lanes);
                for axis in 0..3 {
                    store::<S>(found.index[axis], &mut met.index[axis]);
                    store::<S>(found.normal[axis], &mut met.normal[axis]);
                }
                found.lanes.to_bitmask()
            },
        )
    }
}

/// Where a packet of paths meets the surface.
#[derive(Clone, Copy, Default)]
struct Bounced {
    index: [PerLane; 3],
    normal: [PerLane; 3],
}

impl Onward {
    fn new() -> Self {
        Self {
            from: [[0.0; MOST_LANES]; 3],
            direction: [[0.0; MOST_LANES]; 3],
            reach: [0.0; MOST_LANES],
            brings: [[0.0; 3]; MOST_LANES],
            there: [false; MOST_LANES],
        }
    }

    fn set(&mut self, lane: usize, path: &Path, direction: GlamVec3, reach: f32, brings: [f32; 3]) {
        for axis in 0..3 {
            self.from[axis][lane] = path.index[axis];
            self.direction[axis][lane] = direction[axis];
        }
        (self.reach[lane], self.brings[lane], self.there[lane]) = (reach, brings, true);
    }

    #[inline(always)]
    fn vectors<S: Lanes>(&self, s: S) -> (Vec3<S>, Vec3<S>, F32<S>, Mask<S>) {
        let (from, direction) = (xyz!(I => load(s, &self.from[I])), xyz!(I => load(s, &self.direction[I])));
        let reach = load(s, &self.reach);
        (from, direction, reach, reach.simd_gt(splat(s, 0.0)))
    }

    /// Lanes that have a path.
    fn lanes(&self) -> impl Iterator<Item = usize> {
        let there = self.there;
        (0..MOST_LANES).filter(move |&lane| there[lane])
    }

    /// The direction of a lane's path.
    fn towards(&self, lane: usize) -> GlamVec3 {
        GlamVec3::from([0, 1, 2].map(|axis: usize| self.direction[axis][lane]))
    }
}

/// A direction, and how much more than others light from there counts, which is chosen by its cosine with the normal or, for
/// half of the paths, by how bright a picture of the sky is there (one sample of both, with the balance heuristic).
fn choose(normal: GlamVec3, u: [f32; 2], picture: Option<&Sky>) -> (GlamVec3, f32) {
    let by_cosine = |u: [f32; 2]| turned(normal, (1.0 - u[0]).sqrt(), u[1]);
    let Some(sky) = picture else { return (by_cosine(u), 1.0) };
    let direction = match u[0] < 0.5 {
        true => sky.sample([2.0 * u[0], u[1]]),
        false => by_cosine([2.0 * u[0] - 1.0, u[1]]),
    };
    let cosine = direction.dot(normal).max(0.0) / std::f32::consts::PI;
    let density = 0.5 * (cosine + sky.pdf(direction));
    (direction, if cosine > 0.0 { cosine / density } else { 0.0 })
}

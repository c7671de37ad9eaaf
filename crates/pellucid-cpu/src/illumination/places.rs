//! The light of places, found when it is first asked for (G-07, G-09).

use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use glam::Vec3 as GlamVec3;
use half::f16;
use pellucid_optics::{Bands, MOST_COEFFICIENTS, ResolvedLight, Sky, turned};
use pellucid_scene::{Control, GlobalIllumination};

use super::bricks::{Bricks, Known};
use super::distant::Distant;
use super::gather::{Irradiance, Transfer};
use super::kept::{Kept, Surface};
use super::lattice::Lattice;
use super::paths::{Departure, LightPaths};
use super::surface_rays::SurfaceRays;
use crate::RenderError;
use crate::lanes::*;
use crate::medium::Level;
use crate::prepare::Prepared;

/// What is asked for of all light that arrives, and what is kept of it.
#[derive(Clone, Copy)]
pub struct Globally<'a> {
    /// What is asked for.
    pub settings: &'a GlobalIllumination,
    /// What is kept.
    pub kept: &'a Kept,
    /// The light from far away, where that is what places know of.
    pub distant: Option<&'a Distant>,
    /// Who watches, and may be in haste.
    pub control: &'a Control<'a>,
    /// Counts places whose light was not known in time.
    pub waiting: &'a AtomicU64,
}

/// What lights places of a volume's surfaces.
pub struct Places<'a, S: Lanes> {
    s: S,
    paths: LightPaths<'a, S>,
    asked: Globally<'a>,
    /// The bands of light that is kept in harmonics.
    bands: Option<Bands>,
    lights: &'a [ResolvedLight],
    sky: Option<Sky>,
    /// The light where nothing is known of it yet.
    guess: [f32; 3],
    prepared: &'a Prepared<'a>,
    /// The surfaces that are drawn, if some have colours of their own.
    colored: Vec<Level>,
}

/// The sides of surfaces: that of lower values, and the other.
const SIDES: [f32; 2] = [1.0, -1.0];

impl<'a, S: Lanes> Places<'a, S> {
    /// Of a volume that is made ready; what is found is kept.
    ///
    /// # Errors
    /// [`RenderError::Field`] if the filter's parameters are out of range.
    pub fn new(s: S, prepared: &'a Prepared, asked: Globally<'a>) -> Result<Self, RenderError> {
        let rays = SurfaceRays::new(s, prepared, asked.settings.normals, asked.kept.grids.as_deref())?;
        let isovalues = prepared.stage.isovalues(prepared.number);
        let own = isovalues.iter().any(|iso| iso.color.is_some());
        let level = |iso| Level::new(iso, &prepared.volume.transfer_function);
        let sky = prepared.stage.sky();
        Ok(Self {
            s,
            paths: LightPaths::new(s, prepared, asked.settings, rays),
            asked,
            bands: asked.distant.and(asked.settings.harmonics()).map(|(bands, _)| bands),
            lights: &prepared.stage.lights,
            guess: guess(sky.as_ref()),
            sky,
            prepared,
            colored: if own { isovalues.iter().map(level).collect() } else { Vec::new() },
        })
    }

    /// What is asked for.
    pub fn asked(&self) -> &Globally<'a> {
        &self.asked
    }

    /// The number of the light that is asked for: of paths that find it, or of harmonics; and by what what is known of it is
    /// to be multiplied.
    #[inline]
    pub fn number(&self) -> (u32, f32) {
        let samples = self.asked.settings.samples;
        self.asked.distant.map_or((samples, 1.0 / samples as f32), |distant| (distant.number, 1.0))
    }

    /// The light of a place of the lattice on a side of its surface, as bright as a white surface looks in it.
    pub fn light(&self, lattice: &Lattice, surface: &Surface, at: [usize; 3], side: usize) -> Option<[f32; 3]> {
        let (bricks, (number, share)) = (&surface.sides[side], self.number());
        match bricks.get(at, number) {
            Known::Light(light) => return Some(light.map(|v| v * share)),
            Known::Absent => return None,
            Known::Nothing => {}
        }
        if let (Some(distant), Some(transfer)) = (self.asked.distant, bricks.transfer(at)) {
            let light = relit(transfer, distant);
            bricks.set(at, number, Known::Light(light));
            return Some(light);
        }
        let haste = self.asked.control.haste.as_ref();
        let (done, sum) = if self.bands.is_none() { bricks.so_far(at) } else { (0, [0.0; 3]) };
        let enough = haste.map_or(number, |haste| haste.paths.clamp(1, self.asked.settings.samples));
        let known = || (done > 0).then(|| sum.map(|sum| sum / done as f32));
        if self.bands.is_none() && done >= enough {
            return known();
        }
        if self.asked.control.is_cancelled() || haste.is_some_and(|haste| Instant::now() >= haste.due) {
            self.asked.waiting.fetch_add(1, Ordering::Relaxed);
            return known();
        }
        let key = 2 * lattice.number(at) + side as u64;
        let index = lattice.position(at);
        let place = match surface.level {
            Some(level) => {
                let nearest = self.nearest_on(lattice, index, level);
                nearest.and_then(|index| self.place(index, Some(level), side, key))
            }
            None => self.place(index, None, side, key),
        };
        let Some(place) = place else {
            bricks.set(at, number, Known::Absent);
            return None;
        };
        if let (Some(bands), Some(distant)) = (self.bands, self.asked.distant) {
            let light = self.transferred(&place, bands, bricks, at, distant);
            bricks.set(at, number, Known::Light(light));
            return Some(light);
        }
        let sum = self.sum(&place, done..enough, sum);
        bricks.set(at, enough, Known::Light(sum));
        Some(if enough == number { sum.map(|sum| sum * share) } else { sum.map(|sum| sum / enough as f32) })
    }

    /// The light at an index position of a surface itself.
    pub fn light_here(&self, index: [f32; 3], level: f32, side: usize) -> [f32; 3] {
        let haste = self.asked.control.haste.as_ref();
        if self.asked.control.is_cancelled() || haste.is_some_and(|haste| Instant::now() >= haste.due) {
            self.asked.waiting.fetch_add(1, Ordering::Relaxed);
            return self.guess;
        }
        let count = haste.map_or(u32::MAX, |haste| haste.paths.max(1)).min(self.asked.settings.samples);
        let bits = index.map(|v| u64::from(v.to_bits()));
        let key = (bits[0] << 32 | bits[1]) ^ bits[2].rotate_left(16) ^ side as u64;
        let place = self.place(index, Some(level), side, key);
        place.map_or([0.0; 3], |place| self.sum(&place, 0..count, [0.0; 3]).map(|sum| sum / count as f32))
    }

    /// The value of the field at a place of the lattice.
    pub fn value(&self, lattice: &Lattice, at: [usize; 3]) -> f32 {
        self.look(lattice.position(at)).0
    }

    /// What of light goes on from the surface of an isovalue: the transfer function's colour or, where surfaces have their
    /// own, that of the nearest.
    fn albedo(&self, level: f32) -> [f32; 3] {
        let off = |other: &Level| (other.value - level).abs();
        let nearest = self.colored.iter().min_by(|a, b| off(a).total_cmp(&off(b)));
        nearest.map_or_else(|| self.prepared.volume.transfer_function.color(level.into()), |nearest| nearest.color)
    }

    /// A place on the surface through an index position, or on that of a level, which goes through it up to rounding; `None`
    /// where there is none.
    fn place(&self, index: [f32; 3], level: Option<f32>, side: usize, key: u64) -> Option<Departure> {
        let (value, normal) = self.look(index);
        let normal = normal * SIDES[side];
        let there = value.is_finite() && normal != GlamVec3::ZERO;
        let level = level.unwrap_or(value);
        there.then(|| Departure { index, normal: normal.into(), level, albedo: self.albedo(level), key })
    }

    /// Where the surface of a level is nearest to an index position, along the slope there and about as far away as a
    /// place's neighbours are.
    fn nearest_on(&self, lattice: &Lattice, index: [f32; 3], level: f32) -> Option<[f32; 3]> {
        let (value, normal) = self.look(index);
        if !value.is_finite() || normal == GlamVec3::ZERO {
            return None;
        }
        if value == level {
            return Some(index);
        }
        let s = self.s;
        let way = if value > level { normal } else { -normal };
        let [x, y, z] = [0, 1, 2].map(|axis| self.prepared.grid().spacing()[axis] as f32 * lattice.spacing[axis]);
        let reach = 2.0 * x.max(y).max(z);
        let mut met = [[0.0; MOST_LANES]; 3];
        let found = s.vectorize(
            #[inline(always)]
            || {
                let (from, way) = (xyz!(I => splat(s, index[I])), xyz!(I => splat(s, way[I])));
                let found = self.paths.rays().meet(level, &from, &way, splat(s, reach), all(s, true));
                for axis in 0..3 {
                    store::<S>(found.index[axis], &mut met[axis]);
                }
                found.lanes.any_true()
            },
        );
        found.then(|| met.map(|lanes| lanes[0]))
    }

    /// The value and the normal at an index position.
    fn look(&self, index: [f32; 3]) -> (f32, GlamVec3) {
        let s = self.s;
        s.vectorize(
            #[inline(always)]
            || {
                let found = self.paths.rays().look(&xyz!(I => splat(s, index[I])), all(s, true));
                let mut lanes = [[0.0; MOST_LANES]; 4];
                store::<S>(found.value, &mut lanes[3]);
                for axis in 0..3 {
                    store::<S>(found.normal[axis], &mut lanes[axis]);
                }
                let [x, y, z, value] = lanes.map(|lanes| lanes[0]);
                (value, GlamVec3::new(x, y, z))
            },
        )
    }

    /// The sum of what paths from a place find, some of whom have been followed: in runs that are the same whenever they
    /// are, so that the sum is, too.
    fn sum(&self, place: &Departure, paths: Range<u32>, mut sum: [f32; 3]) -> [f32; 3] {
        let mut from = paths.start;
        while from < paths.end {
            let to = run_end(from).min(paths.end);
            let mut found = Irradiance { lights: self.lights, sky: self.sky.as_ref(), sum: [0.0; 3] };
            self.paths.follow(place, from..to, &mut found);
            (0..3).for_each(|c| sum[c] += found.sum[c]);
            from = to;
        }
        sum
    }

    /// What light far away becomes at a place: found, written down, and its light.
    fn transferred(
        &self,
        place: &Departure,
        bands: Bands,
        bricks: &Bricks,
        at: [usize; 3],
        distant: &Distant,
    ) -> [f32; 3] {
        let mut found = Transfer { bands, sum: [[0.0; 3]; MOST_COEFFICIENTS] };
        let count = self.asked.settings.samples;
        self.paths.follow(place, 0..count, &mut found);
        let sums = found.sum[..bands.coefficients()].iter().flatten();
        bricks.set_transfer(at, sums.map(|sum| f16::from_f32(sum / count as f32)));
        bricks.transfer(at).map_or([0.0; 3], |transfer| relit(transfer, distant))
    }
}

/// The end of the run of paths that begins with one: 16, then 64, 256, ...; pictures that come soon ask for so many.
fn run_end(from: u32) -> u32 {
    let mut end = 16;
    while end <= from {
        end *= 4;
    }
    end
}

/// Half of the light of the sky, on the mean of a few directions; of a dark one half of white, for there are lights.
fn guess(sky: Option<&Sky>) -> [f32; 3] {
    const DIRECTIONS: u8 = 16;
    /// Share of a turn between one and the next: the golden section, which spreads them evenly.
    const TURN: f32 = 0.381_966;
    let Some(sky) = sky else { return [0.5; 3] };
    let mut sum = [0.0; 3];
    for k in 0..DIRECTIONS {
        let height = 1.0 - f32::from(2 * k + 1) / f32::from(DIRECTIONS);
        let light = sky.radiance(turned(GlamVec3::Z, height, TURN * f32::from(k)));
        (0..3).for_each(|c| sum[c] += light[c] * 0.5 / f32::from(DIRECTIONS));
    }
    sum
}

/// What light far away becomes.
fn relit(transfer: &[f16], distant: &Distant) -> [f32; 3] {
    let mut light = [0.0; 3];
    for (share, from) in transfer.chunks_exact(3).zip(&distant.coefficients) {
        (0..3).for_each(|c| light[c] += share[c].to_f32() * from[c]);
    }
    light
}

//! Light at surfaces that are seen: of the places of the lattice around them, or of themselves.

use glam::Vec3 as GlamVec3;
use half::f16;
use pellucid_optics::{MOST_COEFFICIENTS, ResolvedLight, Sky};
use pellucid_scene::{Control, GlobalIllumination, IlluminationInterpolation};

use super::bricks::Known;
use super::cache::{Kept, Surface};
use super::distant::Distant;
use super::gather::{Irradiance, Transfer};
use super::lattice::Lattice;
use super::paths::{Paths, Place};
use super::surface_rays::SurfaceRays;
use super::{Illuminate, Seen};
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
    /// Who watches and may stop the search for more.
    pub control: &'a Control<'a>,
}

/// Light of a volume's surfaces.
pub struct Global<'a, S: Lanes> {
    s: S,
    paths: Paths<'a, S>,
    settings: &'a GlobalIllumination,
    kept: &'a Kept,
    distant: Option<&'a Distant>,
    lights: &'a [ResolvedLight],
    sky: Option<Sky>,
    prepared: &'a Prepared<'a>,
    control: &'a Control<'a>,
    /// The surfaces that are drawn, if some have colours of their own.
    colored: Vec<Level>,
}

/// The sides of surfaces: that of lower values, and the other.
const SIDES: [f32; 2] = [1.0, -1.0];

impl<'a, S: Lanes> Global<'a, S> {
    /// Of a volume that is made ready; what is found is kept.
    ///
    /// # Errors
    /// [`RenderError::Field`] if the filter's parameters are out of range.
    pub fn new(
        s: S,
        prepared: &'a Prepared,
        Globally { settings, kept, distant, control }: Globally<'a>,
    ) -> Result<Self, RenderError> {
        let rays = SurfaceRays::new(s, prepared, settings.normals, kept.grids.as_deref())?;
        let paths = Paths::new(s, prepared, settings, rays);
        let isovalues = prepared.stage.isovalues(prepared.number);
        let own = isovalues.iter().any(|iso| iso.color.is_some());
        let level = |iso| Level::new(iso, &prepared.volume.transfer_function);
        let colored = if own { isovalues.iter().map(level).collect() } else { Vec::new() };
        let (lights, sky) = (&*prepared.stage.lights, prepared.stage.sky());
        Ok(Self { s, paths, settings, kept, distant, lights, sky, prepared, control, colored })
    }

    /// What is kept of light.
    pub fn kept(&self) -> &'a Kept {
        self.kept
    }

    /// Who watches and may stop the search for more.
    pub fn control(&self) -> &'a Control<'a> {
        self.control
    }

    /// What of light goes on from the surface of an isovalue: the transfer function's colour or, where surfaces have their
    /// own, that of the nearest.
    fn albedo(&self, level: f32) -> [f32; 3] {
        let off = |other: &Level| (other.value - level).abs();
        let nearest = self.colored.iter().min_by(|a, b| off(a).total_cmp(&off(b)));
        nearest.map_or_else(|| self.prepared.volume.transfer_function.color(level.into()), |nearest| nearest.color)
    }

    /// The light of a place of the lattice on a side of its surface.
    pub fn at_place(&self, (lattice, surface): (&Lattice, &Surface), at: [usize; 3], side: usize) -> Known {
        let bricks = &surface.sides[side];
        let number = self.distant.map_or(0, |distant| distant.number);
        let known = bricks.get(at, number);
        if known != Known::Nothing || self.control.is_cancelled() {
            return known;
        }
        if let (Some(distant), Some(transfer)) = (self.distant, bricks.transfer(at)) {
            let light = Known::Light(relit(transfer, distant));
            bricks.set(at, number, light);
            return light;
        }
        let key = 2 * lattice.number(at) + side as u64;
        let index = lattice.position(at);
        let place = match surface.level {
            Some(level) => {
                self.nearest_on(lattice, index, level).and_then(|index| self.place(index, Some(level), side, key))
            }
            None => self.place(index, None, side, key),
        };
        let found = match place {
            Some(place) => Known::Light(match (self.distant, self.settings.harmonics()) {
                (Some(distant), Some((bands, _))) => {
                    let mut transfer = Transfer { bands, sum: [[0.0; 3]; MOST_COEFFICIENTS] };
                    self.paths.follow(&place, 0..self.settings.samples, &mut transfer);
                    let count = self.settings.samples as f32;
                    let mean =
                        transfer.sum[..bands.coefficients()].iter().flatten().map(|sum| f16::from_f32(sum / count));
                    bricks.set_transfer(at, mean);
                    bricks.transfer(at).map_or([0.0; 3], |transfer| relit(transfer, distant))
                }
                _ => self.mean(&place),
            }),
            None => Known::Absent,
        };
        bricks.set(at, number, found);
        found
    }

    /// A place on the surface through an index position, or on that of a level, which goes through it up to rounding; `None`
    /// where there is none.
    fn place(&self, index: [f32; 3], level: Option<f32>, side: usize, key: u64) -> Option<Place> {
        let (value, normal) = self.look(index);
        let normal = normal * SIDES[side];
        let there = value.is_finite() && normal != GlamVec3::ZERO;
        let level = level.unwrap_or(value);
        there.then(|| Place { index, normal: normal.into(), level, albedo: self.albedo(level), key })
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

    /// The mean of what all paths from a place find.
    fn mean(&self, place: &Place) -> [f32; 3] {
        let count = self.settings.samples;
        let mut found = Irradiance { lights: self.lights, sky: self.sky.as_ref(), sum: [0.0; 3] };
        self.paths.follow(place, 0..count, &mut found);
        found.sum.map(|sum| sum / count as f32)
    }

    /// The light at a surface that is seen at an index position.
    #[inline(never)]
    fn seen(&self, index: [f32; 3], level: f32, side: usize) -> [f32; 3] {
        if let (Some(lattice), Some(surface)) = (&self.kept.lattice, self.kept.surface(level)) {
            let (mut sum, mut shares) = ([0.0; 3], 0.0);
            let by = self.settings.interpolation;
            let nearest =
                (by == IlluminationInterpolation::NearestIsovalue).then(|| self.nearest(lattice, index, level));
            lattice.each_near(index, by, |near| {
                if nearest.is_some_and(|nearest| nearest != Some(near.at)) {
                    return;
                }
                if let Known::Light(light) = self.at_place((lattice, surface), near.at, side) {
                    (0..3).for_each(|c| sum[c] += near.share * light[c]);
                    shares += near.share;
                }
            });
            /// Less than this of all places around tells nothing of what is between them.
            const LEAST: f32 = 1e-3;
            if shares > LEAST {
                // Few bands of a sharp light may be less than nothing in its shadow.
                return sum.map(|sum| (sum / shares).max(0.0));
            }
        }
        if self.control.is_cancelled() {
            return [0.0; 3];
        }
        let bits = index.map(|v| u64::from(v.to_bits()));
        let key = (bits[0] << 32 | bits[1]) ^ bits[2].rotate_left(16) ^ side as u64;
        self.place(index, Some(level), side, key).map_or([0.0; 3], |place| self.mean(&place))
    }

    /// Of the eight places around a position, the one whose value is nearest to a level.
    fn nearest(&self, lattice: &Lattice, index: [f32; 3], level: f32) -> Option<[usize; 3]> {
        let mut nearest = (f32::INFINITY, None);
        lattice.each_near(index, IlluminationInterpolation::Linear, |near| {
            let off = (self.look(lattice.position(near.at)).0 - level).abs();
            if off < nearest.0 {
                nearest = (off, Some(near.at));
            }
        });
        nearest.1
    }
}

/// What light far away becomes.
fn relit(transfer: &[f16], distant: &Distant) -> [f32; 3] {
    let mut light = [0.0; 3];
    for (share, from) in transfer.chunks_exact(3).zip(&distant.coefficients) {
        (0..3).for_each(|c| light[c] += share[c].to_f32() * from[c]);
    }
    light
}

impl<S: Lanes> Illuminate<S> for Global<'_, S> {
    fn light(&self, seen: &Seen<S>) -> [F32<S>; 3] {
        let mut places = [[0.0; MOST_LANES]; 4];
        for (to, lanes) in places.iter_mut().zip([seen.index[0], seen.index[1], seen.index[2], seen.level]) {
            store::<S>(lanes, to);
        }
        let (lanes, below) = (seen.lanes.to_bitmask(), seen.from_below.to_bitmask());
        let mut light = [[0.0; MOST_LANES]; 3];
        for lane in (0..width::<S>()).filter(|lane| lanes >> lane & 1 == 1) {
            let [x, y, z, level] = places.map(|lanes| lanes[lane]);
            let found = self.seen([x, y, z], level, usize::from(below >> lane & 1 == 0));
            light.iter_mut().zip(found).for_each(|(to, v)| to[lane] = v);
        }
        let s = self.s;
        xyz!(C => load(s, &light[C]))
    }
}

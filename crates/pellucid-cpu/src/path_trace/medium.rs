//! The medium that paths cross: where they collide and how much light gets through.

use glam::DVec3;
use pellucid_plan::MajorantGrid;

use super::extinction::Extinctions;
use super::majorants::Walk;
use super::random::Random;
use super::space::{Flight, Space};
use super::values::Values;

/// Where a flight met the medium.
pub struct Collision {
    /// In world units from the flight's origin.
    pub distance: f32,
    /// The data value there.
    pub value: f32,
}

/// A field with an extinction.
pub struct Medium<'a, F> {
    /// The field.
    pub field: F,
    /// Its bounds.
    pub space: Space<'a>,
    /// Extinction by data value.
    pub extinctions: Extinctions,
    /// Bounds of the extinction.
    pub majorants: &'a MajorantGrid,
    /// Factors of the extinction for each colour, 0 to 1, if it has one of its own (K-13).
    pub chroma: Option<[f32; 3]>,
}

/// What a flight comes to in the medium.
enum Event {
    /// A collision that may be one with the medium.
    Met(Tentative),
    /// An optical depth of minorants on the way.
    Passed(f32),
}

/// A collision with a medium as dense as a majorant.
struct Tentative {
    /// In world units from the flight's origin.
    distance: f32,
    /// The data value there.
    value: f32,
    /// How likely the collision is one with the medium, 0 to 1.
    chance: f32,
}

/// Below this, a transmittance is left to chance: what gets through is rare and worth as much more.
const FAINT: f32 = 0.05;

/// An optical depth that leaves less.
const FAINTEST: f32 = 3.0;

impl<F: Values> Medium<'_, F> {
    /// The next collision along a flight, by delta tracking (Woodcock et al. 1965) against the majorant
    /// of each block: distances are those of a medium as dense as the majorant, and a collision there is
    /// one with the medium as often as the medium is as dense.
    ///
    /// Where each colour has its own extinction, the colours decide together, by what they carry (Kutz et al. 2017),
    /// and `carried` becomes what each has after that; their sum stays the same.
    #[inline]
    pub fn collide(
        &self,
        flight: &Flight,
        carried: &mut [f32; 3],
        random: &mut Random,
        evaluations: &mut u32,
    ) -> Option<Collision> {
        let mut collision = None;
        self.visit::<false>(flight, random, evaluations, |event, random| {
            let Event::Met(Tentative { distance, value, chance }) = event else { return false };
            let number = random.number();
            let is_real = match self.chroma {
                None => number < chance,
                Some(chroma) => decide(carried, chroma.map(|factor| factor * chance), number),
            };
            if is_real {
                collision = Some(Collision { distance, value });
            }
            is_real
        });
        collision
    }

    /// The extinction at a position of the world, if it lies in the medium.
    pub fn extinction(&self, world: DVec3) -> Option<f32> {
        let at = self.space.index(world).as_vec3();
        self.space.contains(at).then(|| self.extinctions.at(self.field.value(at)) * self.field.extinction(at))
    }

    /// An estimate of the share of each colour that gets through.
    #[inline]
    pub fn transmittance(&self, flight: &Flight, random: &mut Random, evaluations: &mut u32) -> [f32; 3] {
        match self.chroma {
            None => [self.transmittances([1.0], flight, random, evaluations)[0]; 3],
            Some(chroma) => self.transmittances(chroma, flight, random, evaluations),
        }
    }

    /// The share that gets through of light that the medium takes these shares of its extinction from, by residual
    /// ratio tracking (Novak et al. 2014): as much as the least extinction of each block lets through, times the
    /// chances that none of the collisions is one with what there is beyond it.
    #[inline(always)]
    fn transmittances<const N: usize>(
        &self,
        factors: [f32; N],
        flight: &Flight,
        random: &mut Random,
        evaluations: &mut u32,
    ) -> [f32; N] {
        let (mut transmittance, mut passed) = ([1.0f32; N], 0.0);
        self.visit::<true>(flight, random, evaluations, |event, random| {
            match event {
                Event::Passed(depth) => {
                    passed += depth;
                    if passed < FAINTEST {
                        return false;
                    }
                    lessen(&mut transmittance, factors, &mut passed);
                }
                Event::Met(Tentative { chance, .. }) => {
                    for (transmittance, factor) in transmittance.iter_mut().zip(factors) {
                        *transmittance *= 1.0 - factor * chance;
                    }
                }
            }
            let most = transmittance.iter().fold(0.0f32, |most, transmittance| most.max(*transmittance));
            if most < FAINT {
                let kept = if random.number() * FAINT >= most { 0.0 } else { FAINT / most };
                for transmittance in &mut transmittance {
                    *transmittance *= kept;
                }
                return kept == 0.0;
            }
            false
        });
        lessen(&mut transmittance, factors, &mut passed);
        transmittance
    }

    /// Goes through the collisions with a medium as dense as the majorants, until one is the last; or, of the
    /// residual medium, with one as dense as the majorants less the minorants, and through what of these there is on
    /// the way.
    #[inline(always)]
    fn visit<const RESIDUAL: bool>(
        &self,
        flight: &Flight,
        random: &mut Random,
        evaluations: &mut u32,
        mut is_last: impl FnMut(Event, &mut Random) -> bool,
    ) {
        let mut walk = Walk::new(&self.majorants.leaps, self.majorants.size, flight);
        let (mut distance, mut depth) = (0.0, random.depth());
        loop {
            let [least, most] = self.majorants.bounds[walk.block()];
            if most > 0.0 {
                let (minorant, exit) = (if RESIDUAL { least } else { 0.0 }, walk.exit());
                let (rate, entry) = (most - minorant, distance);
                loop {
                    // Where nothing is left but the minorant, that is infinite, or no number.
                    let next = distance + depth / rate;
                    if next.is_nan() || next >= exit {
                        depth -= rate * (exit - distance).max(0.0);
                        break;
                    }
                    distance = next;
                    *evaluations += 1;
                    let at = flight.at(distance);
                    let value = self.field.value(at);
                    let extinction = self.extinctions.at(value) * self.field.extinction(at);
                    let chance = ((extinction - minorant) / rate).clamp(0.0, 1.0);
                    if is_last(Event::Met(Tentative { distance, value, chance }), random) {
                        return;
                    }
                    depth = random.depth();
                }
                if minorant > 0.0 && is_last(Event::Passed(minorant * (exit - entry).max(0.0)), random) {
                    return;
                }
            }
            let Some(entry) = walk.advance() else { return };
            distance = entry;
        }
    }
}

/// Takes what optical depths of minorants let through of light.
#[inline(always)]
fn lessen<const N: usize>(transmittance: &mut [f32; N], factors: [f32; N], passed: &mut f32) {
    if *passed > 0.0 {
        for (transmittance, factor) in transmittance.iter_mut().zip(factors) {
            *transmittance *= (-factor * *passed).exp();
        }
        *passed = 0.0;
    }
}

/// Whether colours collide that do so with these chances, and what they carry after that.
fn decide(carried: &mut [f32; 3], chances: [f32; 3], number: f32) -> bool {
    let whole: f32 = carried.iter().sum();
    let colliding: f32 = carried.iter().zip(chances).map(|(carried, chance)| carried * chance).sum();
    let chance = colliding / whole;
    let is_real = number < chance;
    for (carried, own) in carried.iter_mut().zip(chances) {
        *carried *= if is_real { own / chance } else { (1.0 - own) / (1.0 - chance) };
    }
    is_real
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::Vec3;
    use pellucid_field::{ComponentView, Grid, Volume, Voxels};
    use pellucid_optics::{Color, ColorPoint, OpacityPoint, TransferFunction};
    use pellucid_plan::PlanCache;
    use pellucid_scene::{Majorants, Scene, Source, VolumeEntry};

    use super::*;
    use crate::path_trace::values::ScalarTrilinear;

    const SIDE: usize = 17;

    /// What to do with a medium whose extinction is `dense` times x, from 0 to 1 across the volume.
    fn with_ramp<R>(
        dense: f32,
        majorants: Majorants,
        chroma: Option<[f32; 3]>,
        look: impl FnOnce(&Medium<ScalarTrilinear<f32>>) -> R,
    ) -> R {
        let values: Vec<f32> = (0..SIDE.pow(3)).map(|k| (k % SIDE) as f32 / (SIDE - 1) as f32).collect();
        let volume = Arc::new(Volume::new(Grid::new([SIDE; 3]).unwrap(), values).unwrap());
        let opacities = (0..=256).map(|k| f64::from(k) / 256.0);
        let opacities = opacities.map(|v| OpacityPoint::new(v, -(-dense * v as f32).exp_m1())).collect();
        let tf = TransferFunction::new(vec![ColorPoint::new(0.0, Color::WHITE)], opacities).unwrap();
        let tf = tf.with_unit_distance(Some(1.0)).unwrap();
        let entry = VolumeEntry { transfer_function: Some(tf), ..VolumeEntry::new(Source::memory()) };
        let scene = Scene { volumes: vec![entry], ..Scene::default() };
        let (stage, _) = scene.resolve(&[volume]).unwrap();
        let volume = &stage.volumes[0];
        let mut cache = PlanCache::default();
        let tables = cache.tables(&stage, 0).unwrap();
        let majorants = cache.majorants(&stage, 0, &tables, majorants).unwrap();
        let Voxels::F32(data) = volume.volume.voxels() else { unreachable!() };
        let region = stage.region(volume);
        look(&Medium {
            field: ScalarTrilinear::new(ComponentView::new(&volume.volume, data, 0)).unwrap(),
            space: Space::new(volume.volume.grid(), &region),
            extinctions: Extinctions::new(&tables.table, volume.unit_distance()),
            majorants: &majorants,
            chroma,
        })
    }

    /// Variances and evaluations of estimates, whose means are checked, of what gets through along x, with a slope.
    fn estimates(medium: &Medium<ScalarTrilinear<f32>>, [from, to]: [f32; 2], slope: f32) -> ([f64; 3], u32) {
        const COUNT: usize = 100_000;
        let origin = Vec3::new(from, 1.0, 2.0);
        let flight =
            Flight { origin, direction: Vec3::new((to - from).signum(), slope, 0.0), length: (to - from).abs() };
        let (mut sums, mut squares, mut evaluations) = ([0.0; 3], [0.0; 3], 0);
        for number in 0..COUNT {
            let transmittance =
                medium.transmittance(&flight, &mut Random::new([5, 6], 7, number as u32), &mut evaluations);
            for channel in 0..3 {
                sums[channel] += f64::from(transmittance[channel]);
                squares[channel] += f64::from(transmittance[channel]).powi(2);
            }
        }
        let means = sums.map(|sum| sum / COUNT as f64);
        let variances = [0, 1, 2].map(|c| squares[c] / COUNT as f64 - means[c] * means[c]);
        for channel in 0..3 {
            let kappa = medium.chroma.map_or(1.0, |chroma| f64::from(chroma[channel])) * f64::from(DENSE);
            let x = [from, to].map(f64::from);
            let expected = (-kappa * (x[1] * x[1] - x[0] * x[0]).abs() / (2.0 * (SIDE - 1) as f64)).exp();
            let error = (variances[channel] / COUNT as f64).sqrt();
            // Four standard errors, and the table's share.
            let difference = (means[channel] - expected).abs();
            assert!(difference < 4.0 * error + 2e-5, "{from} to {to}: {} +- {error}, not {expected}", means[channel]);
        }
        (variances, evaluations)
    }

    const DENSE: f32 = 1.2;

    #[test]
    fn what_gets_through_a_ramp_is_known() {
        for chroma in [None, Some([1.0, 0.5, 0.125])] {
            for (way, slope) in [([0.0, 8.0], 0.0), ([3.0, 9.5], 0.7), ([15.5, 7.0], 0.3), ([0.0, 16.0], 0.0)] {
                let [local, global] = [Majorants::Local, Majorants::Global]
                    .map(|bounds| with_ramp(DENSE, bounds, chroma, |medium| estimates(medium, way, slope)));
                // Fewer evaluations would make more noise, if the least extinctions did not leave less to chance.
                assert!(local.0[0] < 1.1 * global.0[0], "{way:?}: {:?} and {:?}", local.0, global.0);
                assert!(local.1 * 5 < global.1 * 4, "{way:?}: {} evaluations and {}", local.1, global.1);
            }
        }
    }
}

//! Light at surfaces that are seen: of the places of the lattice around them, or of themselves.

use pellucid_scene::IlluminationInterpolation;

use super::kept::Surface;
use super::lattice::Lattice;
use super::places::{Globally, Places};
use super::{Illuminate, SeenSurface};
use crate::RenderError;
use crate::lanes::*;
use crate::prepare::Prepared;

/// Light of a volume's surfaces.
pub struct Global<'a, S: Lanes> {
    s: S,
    places: Places<'a, S>,
}

impl<'a, S: Lanes> Global<'a, S> {
    /// Of a volume that is made ready; what is found is kept.
    ///
    /// # Errors
    /// [`RenderError::Field`] if the filter's parameters are out of range.
    pub fn new(s: S, prepared: &'a Prepared, asked: Globally<'a>) -> Result<Self, RenderError> {
        Ok(Self { s, places: Places::new(s, prepared, asked)? })
    }

    /// What lights places.
    pub fn places(&self) -> &Places<'a, S> {
        &self.places
    }

    /// The light at a surface that is seen at an index position.
    fn seen(&self, index: [f32; 3], level: f32, side: usize) -> [f32; 3] {
        let Globally { settings, kept, .. } = self.places.asked();
        if let (Some(lattice), Some(surface)) = (&kept.lattice, kept.surface(level)) {
            let known = || {
                if settings.interpolation != IlluminationInterpolation::Linear {
                    return None;
                }
                let [x, y, z] = [0, 1, 2].map(|axis| lattice.below(index, axis));
                let (number, share) = self.places.number();
                let (sum, shares) = surface.sides[side].around([x.0, y.0, z.0], [x.1, y.1, z.1], number)?;
                Some((sum.map(|v| v * share), shares))
            };
            let found = known().unwrap_or_else(|| {
                let gathered = self.gathered((lattice, surface), index, level, side);
                // Once places are known they are told in one way, to the bit.
                known().unwrap_or(gathered)
            });
            if let Some(light) = mean(found) {
                return light;
            }
        }
        self.places.light_here(index, level, side)
    }

    /// The sum of the light of places around an index position, and of their shares.
    #[inline(never)]
    fn gathered(
        &self,
        (lattice, surface): (&Lattice, &Surface),
        index: [f32; 3],
        level: f32,
        side: usize,
    ) -> ([f32; 3], f32) {
        let (mut sum, mut shares) = ([0.0; 3], 0.0);
        let by = self.places.asked().settings.interpolation;
        let nearest = (by == IlluminationInterpolation::NearestIsovalue).then(|| self.nearest(lattice, index, level));
        lattice.each_near(index, by, |near| {
            if nearest.is_some_and(|nearest| nearest != Some(near.at)) {
                return;
            }
            if let Some(light) = self.places.light(lattice, surface, near.at, side) {
                (0..3).for_each(|c| sum[c] += near.share * light[c]);
                shares += near.share;
            }
        });
        (sum, shares)
    }

    /// Of the eight places around a position, the one whose value is nearest to a level.
    fn nearest(&self, lattice: &Lattice, index: [f32; 3], level: f32) -> Option<[usize; 3]> {
        let mut nearest = (f32::INFINITY, None);
        lattice.each_near(index, IlluminationInterpolation::Linear, |near| {
            let off = (self.places.value(lattice, near.at) - level).abs();
            if off < nearest.0 {
                nearest = (off, Some(near.at));
            }
        });
        nearest.1
    }
}

/// The mean of shares of light, if they tell anything of what is between.
fn mean((sum, shares): ([f32; 3], f32)) -> Option<[f32; 3]> {
    /// Less than this of all places around does not.
    const LEAST: f32 = 1e-3;
    // Few bands of a sharp light may be less than nothing in its shadow.
    (shares > LEAST).then(|| sum.map(|sum| (sum / shares).max(0.0)))
}

impl<S: Lanes> Illuminate<S> for Global<'_, S> {
    fn light(&self, seen: &SeenSurface<S>) -> [F32<S>; 3] {
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

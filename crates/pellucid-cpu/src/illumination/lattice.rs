//! The places of a lattice of light, and which of them are around a position (G-15, G-16).

use pellucid_field::bspline_weights;
use pellucid_scene::IlluminationInterpolation;

/// Places along the axes of a grid, the first and the last at its first and last voxel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lattice {
    /// Places per axis.
    pub dims: [usize; 3],
    /// Voxels from one to the next, and one over that.
    pub spacing: [f32; 3],
    inverse: [f32; 3],
}

/// A place, and its share of what lies between.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct NearPlace {
    /// Numbers along the axes.
    pub at: [usize; 3],
    /// 0 to 1; those of all places near sum to 1.
    pub share: f32,
}

impl Lattice {
    /// So many places for each voxel and axis, or a few more or less, so that they end with the grid.
    pub fn new(voxels: [usize; 3], resolution: f64) -> Self {
        let dims = voxels.map(|n| (((n - 1) as f64 * resolution).round() as usize).max((n > 1).into()) + 1);
        let spacing = [0, 1, 2].map(|axis| match dims[axis] {
            1 => 1.0,
            places => ((voxels[axis] - 1) as f64 / (places - 1) as f64) as f32,
        });
        Self { dims, spacing, inverse: spacing.map(f32::recip) }
    }

    /// The index position of a place.
    pub fn position(&self, at: [usize; 3]) -> [f32; 3] {
        [0, 1, 2].map(|axis| at[axis] as f32 * self.spacing[axis])
    }

    /// The number of a place among all.
    pub fn number(&self, at: [usize; 3]) -> u64 {
        at[0] as u64 + self.dims[0] as u64 * (at[1] as u64 + self.dims[1] as u64 * at[2] as u64)
    }

    /// The number along an axis of the place below an index position, and the part of the way to the next that it is beyond.
    #[inline]
    pub fn below(&self, index: [f32; 3], axis: usize) -> (usize, f32) {
        let last = self.dims[axis] - 1;
        let place = (index[axis] * self.inverse[axis]).clamp(0.0, last as f32);
        let below = (place as usize).min(last.saturating_sub(1));
        (below, place - below as f32)
    }

    /// Shows the places around an index position, those with any share.
    pub fn each_near(&self, index: [f32; 3], by: IlluminationInterpolation, mut show: impl FnMut(NearPlace)) {
        let axis = |axis: usize| {
            let (last, (below, t)) = (self.dims[axis] - 1, self.below(index, axis));
            match by {
                IlluminationInterpolation::Nearest => {
                    Along { first: below, shares: [1.0 - t.round(), t.round(), 0.0, 0.0] }
                }
                IlluminationInterpolation::Linear | IlluminationInterpolation::NearestIsovalue => {
                    Along { first: below, shares: [1.0 - t, t, 0.0, 0.0] }
                }
                IlluminationInterpolation::Cubic => {
                    let weights = bspline_weights(f64::from(t)).map(|weight| weight as f32);
                    let mut shares = [0.0; 4];
                    // Beyond the ends there are the places at the ends.
                    let first = below.saturating_sub(1).min(last.saturating_sub(3));
                    for (k, weight) in weights.into_iter().enumerate() {
                        shares[(below + k).saturating_sub(1).min(last) - first] += weight;
                    }
                    Along { first, shares }
                }
            }
        };
        let along = [axis(0), axis(1), axis(2)];
        for (z, shares_z) in along[2].each() {
            for (y, shares_y) in along[1].each() {
                for (x, shares_x) in along[0].each() {
                    show(NearPlace { at: [x, y, z], share: shares_x * shares_y * shares_z });
                }
            }
        }
    }
}

/// Places along an axis, and their shares.
struct Along {
    first: usize,
    shares: [f32; 4],
}

impl Along {
    fn each(&self) -> impl Iterator<Item = (usize, f32)> {
        let first = self.first;
        self.shares.into_iter().enumerate().map(move |(k, share)| (first + k, share)).filter(|(_, share)| *share > 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [IlluminationInterpolation; 4] = [
        IlluminationInterpolation::Linear,
        IlluminationInterpolation::Nearest,
        IlluminationInterpolation::NearestIsovalue,
        IlluminationInterpolation::Cubic,
    ];

    #[test]
    fn shares_sum_to_one_wherever_it_is() {
        for dims in [[1, 2, 3], [9, 17, 5], [4, 4, 4]] {
            for resolution in [0.125, 0.5, 1.0, 2.0] {
                let lattice = Lattice::new(dims, resolution);
                assert!((0..3).all(|axis| dims[axis] == 1 || lattice.dims[axis] > 1), "{lattice:?}");
                for by in ALL {
                    for k in 0..50 {
                        let index =
                            [0, 1, 2].map(|axis| (dims[axis] - 1) as f32 * ((k * (axis + 3)) % 50) as f32 / 49.0);
                        let mut sum = 0.0;
                        lattice.each_near(index, by, |near| {
                            assert!((0..3).all(|axis| near.at[axis] < lattice.dims[axis]), "{near:?}");
                            sum += near.share;
                        });
                        assert!((sum - 1.0).abs() < 1e-5, "{by:?} at {index:?} of {dims:?}: {sum}");
                    }
                }
            }
        }
    }

    #[test]
    fn linear_functions_are_told_exactly_between_places() {
        let lattice = Lattice::new([9, 17, 5], 2.0);
        assert_eq!(lattice.dims, [17, 33, 9]);
        let linear = |p: [f32; 3]| 3.0 * p[0] - 2.0 * p[1] + 5.0 * p[2];
        for by in [IlluminationInterpolation::Linear, IlluminationInterpolation::Cubic] {
            for k in 0..40 {
                // The cubic one is linear away from the ends.
                let index = [1.0 + 6.0 * k as f32 / 39.0, 15.0 - 12.0 * k as f32 / 39.0, 1.0 + 2.0 * k as f32 / 39.0];
                let mut sum = 0.0;
                lattice.each_near(index, by, |near| sum += near.share * linear(lattice.position(near.at)));
                assert!((sum - linear(index)).abs() < 1e-4, "{by:?} at {index:?}: {sum}, not {}", linear(index));
            }
        }
    }
}

//! The colours of voxels, for all lanes: the vectors' form of [`ColorGrid::at`], which defines it.

use pellucid_plan::ColorGrid;

use crate::field::lane_position;
use crate::lanes::*;

/// What samples are painted with.
#[derive(Clone, Copy)]
pub struct Paint<'a>(pub &'a ColorGrid);

impl Paint<'_> {
    /// Associated colours at index positions, times those of the voxels.
    #[inline(always)]
    pub fn tint<S: Lanes>(&self, s: S, index: &Vec3<S>, rgba: [F32<S>; 4]) -> [F32<S>; 4] {
        let color = self.colors(s, index);
        let [r, g, b] = xyz!(C => rgba[C] * color[C]);
        [r, g, b, rgba[3]]
    }

    /// Linear colours at index positions.
    #[inline(never)]
    fn colors<S: Lanes>(&self, s: S, index: &Vec3<S>) -> Vec3<S> {
        s.vectorize(
            #[inline(always)]
            || match i32::try_from(self.0.texels().len()) {
                Ok(_) => self.between(s, index),
                Err(_) => self.each(s, index),
            },
        )
    }

    /// Of the eight voxels around positions.
    #[inline(always)]
    fn between<S: Lanes>(&self, s: S, index: &Vec3<S>) -> Vec3<S> {
        let (zero, one, dims) = (splat(s, 0.0), splat(s, 1.0), self.0.dims());
        let strides = [1, dims[0], dims[0] * dims[1]];
        let mut number = whole(s, 0);
        let (mut weights, mut steps) = ([[zero; 2]; 3], [whole(s, 0); 3]);
        for axis in 0..3 {
            let inside = within(s, index[axis], (dims[axis] - 1) as f32);
            let cell = inside.to_int::<I32<S>>();
            let u = inside - cell.to_float::<F32<S>>();
            weights[axis] = [one - u, u];
            let stride = whole(s, strides[axis] as i32);
            number += cell * stride;
            // Behind the last voxel there is none, and no weight.
            steps[axis] = cell.simd_lt(whole(s, dims[axis] as i32 - 1)).select(stride, whole(s, 0));
        }
        let mut sum = [zero; 4];
        for corner in 0..8usize {
            let side = [corner & 1, corner >> 1 & 1, corner >> 2];
            let weight = weights[0][side[0]] * weights[1][side[1]] * weights[2][side[2]];
            let mut at = number;
            for axis in 0..3 {
                if side[axis] == 1 {
                    at += steps[axis];
                }
            }
            // SAFETY: positions are limited to the grid, every voxel of which has its texel of 8 bytes.
            let pair = unsafe { s.gather_pairs::<8>(self.0.texels().as_ptr().cast(), at) };
            let [rg, ba]: [I32<S>; 2] = [pair[0].bitcast(), pair[1].bitcast()];
            let channels = [rg & 0xffff, (rg >> 16) & 0xffff, ba & 0xffff, (ba >> 16) & 0xffff];
            sum = rgba!(C => weight.mul_add(channels[C].to_float::<F32<S>>(), sum[C]));
        }
        let seen = sum[3].simd_gt(zero);
        let share = one / seen.select(sum[3], one);
        xyz!(C => sum[C] * share)
    }

    /// The same where numbers of voxels have more bits than lanes.
    #[inline(never)]
    fn each<S: Lanes>(&self, s: S, index: &Vec3<S>) -> Vec3<S> {
        let mut colors = [splat(s, 0.0); 3];
        for lane in 0..width::<S>() {
            let found = self.0.at(lane_position::<S>(index, lane));
            for (channel, value) in colors.iter_mut().zip(found) {
                channel[lane] = value as f32;
            }
        }
        colors
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;
    use pellucid_field::{Grid, Volume};

    fn found<S: Lanes>(s: S, grid: &ColorGrid, p: [f32; 3]) -> [[f32; 3]; 2] {
        let index = p.map(|p| splat(s, p));
        [Paint(grid).between(s, &index), Paint(grid).each(s, &index)].map(|color| color.map(|channel| channel[0]))
    }

    #[test]
    fn vectors_are_the_definition() {
        for (dims, components) in [([5, 4, 3], 3), ([5, 4, 3], 4), ([1, 3, 1], 4), ([1, 1, 1], 3)] {
            let count: usize = dims.iter().product();
            let data: Vec<u8> = (0..count * components).map(|k| (k * 89 % 251) as u8).collect();
            let volume = Volume::with_components(Grid::new(dims).unwrap(), data, components).unwrap();
            let grid = ColorGrid::new(&volume).unwrap();
            for k in 0..200 {
                let p = [0, 1, 2].map(|axis| (k * (axis * 2 + 7) % 97) as f32 / 97.0 * (dims[axis] + 1) as f32 - 0.9);
                let exact = grid.at(DVec3::from_array(p.map(f64::from)));
                for set in InstructionSet::ALL.into_iter().filter_map(InstructionSet::resolve) {
                    for color in dispatch!(set, s => found(s, &grid, p)) {
                        for (found, exact) in color.iter().zip(exact) {
                            assert!((f64::from(*found) - exact).abs() < 2e-6, "{set}: {color:?} at {p:?}, {exact:?}");
                        }
                    }
                }
            }
        }
    }
}

//! The colours of voxels, as samples between them want them.

use glam::DVec3;
use pellucid_field::{Volume, Voxel, Voxels};
use pellucid_optics::srgb_decode;
use pellucid_scene::{holds_alpha, holds_colors};

/// Linear light of the colours of voxels, times their alpha where that varies, and the alpha; 16 bits each.
pub struct ColorGrid {
    dims: [usize; 3],
    texels: Vec<[u16; 4]>,
}

impl ColorGrid {
    /// The largest number of a texel, which is 1.
    const ONE: f32 = u16::MAX as f32;

    /// The colours of a volume; `None` if its voxels are none.
    pub fn new(volume: &Volume) -> Option<Self> {
        let (components, with_alpha) = (volume.components(), holds_alpha(volume));
        if !holds_colors(volume) {
            return None;
        }
        let texels = match volume.voxels() {
            Voxels::U8(data) => texels(data, components, with_alpha, u8::MAX.into()),
            Voxels::U16(data) => texels(data, components, with_alpha, u16::MAX),
            _ => return None,
        };
        Some(Self { dims: volume.grid().dims(), texels })
    }

    /// Voxels along each axis.
    pub fn dims(&self) -> [usize; 3] {
        self.dims
    }

    /// A row of four numbers for every voxel, x fastest.
    pub fn texels(&self) -> &[[u16; 4]] {
        &self.texels
    }

    /// The linear colour at a position in voxels: the mean of those around it, each by its share of the trilinear sum and
    /// its alpha. Black where all of them are transparent.
    pub fn at(&self, index: DVec3) -> [f64; 3] {
        let last = self.dims.map(|n| (n - 1) as f64);
        let inside = [0, 1, 2].map(|axis| index[axis].max(0.0).min(last[axis]));
        let cell = inside.map(|p| p.floor() as usize);
        let mut sum = [0.0; 4];
        for corner in 0..8 {
            let (mut weight, mut place) = (1.0, [0; 3]);
            for axis in 0..3 {
                let (u, far) = (inside[axis] - cell[axis] as f64, corner >> axis & 1 == 1);
                weight *= if far { u } else { 1.0 - u };
                place[axis] = (cell[axis] + usize::from(far)).min(self.dims[axis] - 1);
            }
            let [x, y, z] = place;
            let texel = self.texels[x + self.dims[0] * (y + self.dims[1] * z)];
            for (sum, channel) in sum.iter_mut().zip(texel) {
                *sum += weight * f64::from(channel);
            }
        }
        let [r, g, b, alpha] = sum;
        [r, g, b].map(|channel| if alpha > 0.0 { channel / alpha } else { 0.0 })
    }
}

fn texels<T: Voxel>(data: &[T], components: usize, with_alpha: bool, most: u16) -> Vec<[u16; 4]> {
    let decode = |encoded: u16| srgb_decode(f32::from(encoded) / f32::from(most));
    let linear: Vec<f32> = (0..=most).map(decode).collect();
    let texel = |voxel: &[T]| {
        let alpha = if with_alpha { voxel[3].to_f64() as f32 / f32::from(most) } else { 1.0 };
        let stored = |part: f32| (part * ColorGrid::ONE).round() as u16;
        let [r, g, b] = [0, 1, 2].map(|number| stored(linear[voxel[number].to_f64() as usize] * alpha));
        [r, g, b, stored(alpha)]
    };
    data.chunks_exact(components).map(texel).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use pellucid_field::Grid;

    fn row(voxels: Vec<u8>, components: usize) -> ColorGrid {
        let grid = Grid::new([voxels.len() / components, 1, 1]).unwrap();
        ColorGrid::new(&Volume::with_components(grid, voxels, components).unwrap()).unwrap()
    }

    #[test]
    fn colors_are_linear_between_voxels() {
        let colors = row(vec![255, 0, 0, 0, 255, 188], 3);
        let [r, g, b] = colors.at(DVec3::new(0.25, 7.0, -3.0));
        assert!((r - 0.75).abs() < 1e-4 && (g - 0.25).abs() < 1e-4 && (b - 0.125).abs() < 1e-3, "{r} {g} {b}");
    }

    #[test]
    fn what_is_transparent_gives_no_color() {
        let colors = row(vec![255, 0, 0, 0, 0, 255, 0, 128], 4);
        assert_eq!(colors.at(DVec3::new(0.1, 0.0, 0.0)), [0.0, 1.0, 0.0]);
        assert_eq!(colors.at(DVec3::new(0.0, 0.0, 0.0)), [0.0; 3]);
        // An alpha that is the same everywhere tells nothing.
        assert_eq!(row(vec![255, 0, 0, 0], 4).at(DVec3::ZERO), [1.0, 0.0, 0.0]);
    }
}

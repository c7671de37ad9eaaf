//! A picture of everything around.

use std::f32::consts::TAU;

use glam::Vec3;

use crate::{OpticsError, luminance};

/// Most texels of a picture: 1 GiB of them with what they are sampled by.
pub(super) const MOST_TEXELS: usize = 1 << 26;

/// Radiance from all directions as an equirectangular picture: a row for every height above the horizon, the
/// first straight above, and a column for every direction around, the middle one along the world's +y and those
/// right of it towards +x, as seen from within. The radiance is that of the texel: so directions can be chosen
/// exactly as often as they are bright.
#[derive(Clone, Debug, PartialEq)]
pub struct SkyMap {
    width: usize,
    height: usize,
    /// Linear RGB, rows from the top.
    texels: Vec<[f32; 3]>,
    /// Share of the light above the end of each row.
    rows: Vec<f32>,
    /// Share of a row's light left of the end of each of its texels.
    columns: Vec<f32>,
    /// The integral of the luminance over all directions.
    flux: f64,
}

impl SkyMap {
    /// A picture of linear RGB radiances, rows from the top.
    ///
    /// # Errors
    /// [`OpticsError::SkyMap`] if the texels do not fill the picture, are none or more than 2^26, or if one is
    /// negative or not finite.
    pub fn new(width: usize, height: usize, texels: Vec<[f32; 3]>) -> Result<Self, OpticsError> {
        let refused = |problem: String| Err(OpticsError::SkyMap { problem });
        let count = width.checked_mul(height).filter(|count| (1..=MOST_TEXELS).contains(count));
        if count != Some(texels.len()) {
            return refused(format!("{width} x {height} with {} texels: expected 1 to {MOST_TEXELS}", texels.len()));
        }
        let unfit = |texel: &[f32; 3]| texel.iter().any(|v| !(v.is_finite() && *v >= 0.0));
        if let Some(at) = texels.iter().position(unfit) {
            let (column, row) = (at % width, at / width);
            return refused(format!("texel {column}, {row} is {:?}: expected finite numbers from 0 on", texels[at]));
        }
        let light = |texel: &[f32; 3]| f64::from(luminance(*texel));
        let columns: Vec<f32> = texels.chunks(width).flat_map(|row| shares(row.iter().map(light))).collect();
        let row_flux = |(number, row): (usize, &[[f32; 3]])| {
            row.iter().map(light).sum::<f64>() * solid_angle(width, height, number)
        };
        let fluxes: Vec<f64> = texels.chunks(width).enumerate().map(row_flux).collect();
        let rows = shares(fluxes.iter().copied()).collect();
        Ok(Self { width, height, rows, columns, flux: fluxes.iter().sum(), texels })
    }

    /// Columns and rows.
    pub fn size(&self) -> [usize; 2] {
        [self.width, self.height]
    }

    /// Linear RGB, rows from the top.
    pub fn texels(&self) -> &[[f32; 3]] {
        &self.texels
    }

    /// Share of the light above the end of each row.
    pub fn row_shares(&self) -> &[f32] {
        &self.rows
    }

    /// Share of a row's light left of the end of each of its texels, in the order of those.
    pub fn column_shares(&self) -> &[f32] {
        &self.columns
    }

    /// The integral of the luminance over all directions.
    pub fn flux(&self) -> f64 {
        self.flux
    }

    /// The height of the upper side of a row, 1 straight above and -1 straight below.
    pub fn side(&self, row: usize) -> f32 {
        cosine(row, self.height) as f32
    }

    /// Whether there is any light.
    pub fn is_dark(&self) -> bool {
        self.flux <= 0.0
    }

    /// Linear RGB radiance from a direction, a unit vector that points away from the scene.
    #[inline]
    pub fn radiance(&self, direction: Vec3) -> [f32; 3] {
        let row = direction.z.clamp(-1.0, 1.0).acos() / (0.5 * TAU) * self.height as f32;
        let turn = direction.x.atan2(direction.y) / TAU + 0.5;
        let column = turn * self.width as f32;
        self.texels[(row as usize).min(self.height - 1) * self.width + (column as usize).min(self.width - 1)]
    }

    /// Density per steradian of [`sample`](Self::sample) where the radiance is this.
    #[inline]
    pub fn pdf(&self, radiance: [f32; 3]) -> f32 {
        (f64::from(luminance(radiance)) / self.flux) as f32
    }

    /// A direction that light comes from, from two numbers in 0..1: a row, a texel of it, and a place in that.
    #[inline]
    pub fn sample(&self, u: [f32; 2]) -> Vec3 {
        let (row, down) = invert(&self.rows, u[0]);
        let (column, right) = invert(&self.columns[row * self.width..][..self.width], u[1]);
        // Places are even in the solid angle, which is the turn times the height.
        let [top, bottom] = [row, row + 1].map(|row| self.side(row));
        let z = top + (bottom - top) * down;
        let turn = ((column as f32 + right) / self.width as f32 - 0.5) * TAU;
        let across = (1.0 - z * z).max(0.0).sqrt();
        Vec3::new(turn.sin() * across, turn.cos() * across, z)
    }
}

/// The height of the upper side of a row.
fn cosine(row: usize, height: usize) -> f64 {
    (std::f64::consts::PI * row as f64 / height as f64).cos()
}

/// The solid angle of a texel.
fn solid_angle(width: usize, height: usize, row: usize) -> f64 {
    std::f64::consts::TAU / width as f64 * (cosine(row, height) - cosine(row + 1, height))
}

/// Shares of the sum up to and with each number; even ones if all are 0.
fn shares(numbers: impl ExactSizeIterator<Item = f64> + Clone) -> impl Iterator<Item = f32> {
    let (count, sum) = (numbers.len() as f64, numbers.clone().sum::<f64>());
    let mut so_far = 0.0;
    numbers.map(move |number| {
        so_far += if sum > 0.0 { number / sum } else { 1.0 / count };
        so_far as f32
    })
}

/// The first entry whose share reaches beyond `u`, and how far in it `u` is, 0 to 1.
fn invert(shares: &[f32], u: f32) -> (usize, f32) {
    let mut entry = shares.partition_point(|share| *share <= u);
    if entry == shares.len() {
        // By rounding the last share may be less than 1: then it is that of the last entry with any.
        entry = shares.partition_point(|share| *share < shares[shares.len() - 1]);
    }
    let from = if entry == 0 { 0.0 } else { shares[entry - 1] };
    let width = shares[entry] - from;
    (entry, if width > 0.0 { ((u - from) / width).min(1.0) } else { 0.5 })
}

//! Where the light around a texel is gathered from (Eq. 6.11, K-09).

use glam::DVec2;
use pellucid_plan::half_angle::{Geometry, taps};
use pellucid_scene::HalfAngle;
use rayon::prelude::*;

use super::buffer::Shape;

/// How far a blur reaches in a slab, to the right and up.
#[derive(Clone, Copy)]
pub enum Radius<'a> {
    /// So many texels, everywhere.
    Texels([f32; 2]),
    /// A number of each texel, row by row, times these.
    Each(&'a [f32], [f32; 2]),
}

/// How far a blur reaches in all slabs.
pub enum Reach {
    /// So many texels to the right and up, everywhere.
    Even([f32; 2]),
    /// Of a light that is somewhere: the way in a slab grows towards the picture's rim, and texels with the distance.
    FromLight {
        /// By texel, in world units, where slabs are at a distance of 1.
        texels: Vec<f32>,
        /// Texels per world unit there, to the right and up.
        density: DVec2,
        /// Distance of the first slab's middle from the light, and of slabs from each other.
        distance: [f64; 2],
    },
}

impl Reach {
    /// As settings say, for voxels of such a spacing and texels of a picture in memory.
    pub fn new(settings: &HalfAngle, geometry: &Geometry, voxel: f64, shape: &Shape) -> Self {
        let Geometry { frame, slabs, longest, .. } = geometry;
        let Some(position) = frame.position() else {
            return Self::Even(frame.across(taps::radius(settings, *longest, voxel)));
        };
        let radius = |at: usize| {
            let [x, y] = [at % shape.width, at / shape.width].map(|texel| texel as f64 + 0.5);
            let ray = frame.ray(x, y).direction;
            let across = ray.dot(slabs.axis);
            let depth = ray.dot(frame.forward) / across;
            (taps::radius(settings, slabs.thickness / across, voxel) / depth) as f32
        };
        let first = slabs.front + slabs.thickness / 2.0 - slabs.axis.dot(position);
        Self::FromLight {
            texels: (0..shape.width * shape.height).into_par_iter().map(radius).collect(),
            density: frame.texel.recip(),
            distance: [first, slabs.thickness],
        }
    }

    /// In a slab.
    pub fn in_slab(&self, slab: usize) -> Radius<'_> {
        match self {
            Self::Even(radius) => Radius::Texels(*radius),
            Self::FromLight { texels, density, distance: [first, thickness] } => {
                let density = *density / (first + thickness * slab as f64);
                Radius::Each(texels, density.as_vec2().to_array())
            }
        }
    }
}

/// Where light is gathered from in a slab.
pub enum Looks<'a> {
    /// In the same places around all texels.
    Alike(Vec<TexelShare>),
    /// At these shares of a radius, from places that differ or count for what they hold.
    Each(&'a [[f32; 2]], Radius<'a>),
}

/// What a texel so far away has in the light of any.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TexelShare {
    /// From a texel to that one.
    pub offset: isize,
    /// How much of it.
    pub weight: f32,
}

impl<'a> Looks<'a> {
    /// At offsets, as shares of a radius; at the texel itself if there are none.
    pub fn new(offsets: &'a [[f32; 2]], radius: Radius<'a>, is_gated: bool, shape: &Shape) -> Self {
        match radius {
            Radius::Texels(radius) if !is_gated => Self::Alike(shares(offsets, radius, shape)),
            _ => Self::Each(offsets, radius),
        }
    }
}

/// The shares of texels in the mean of looks, each texel once, and none that is lost in the rounding of the others.
fn shares(offsets: &[[f32; 2]], radius: [f32; 2], shape: &Shape) -> Vec<TexelShare> {
    const ROUNDING: f32 = 1e-8;
    let looks = offsets.len().max(1);
    let (mut all, pad) = (Vec::with_capacity(4 * looks), shape.pad as f32);
    for look in 0..looks {
        let offset = offsets.get(look).copied().unwrap_or_default();
        let [x, y] = [0, 1].map(|axis| (radius[axis] * offset[axis]).max(-pad).min((pad - 1.0).next_down()));
        let (column, row) = (x.floor(), y.floor());
        let [u, v] = [x - column, y - row];
        let offset = row as isize * shape.stride as isize + column as isize;
        for (across, u) in [(0, 1.0 - u), (1, u)] {
            for (down, v) in [(0, 1.0 - v), (shape.stride as isize, v)] {
                all.push(TexelShare { offset: offset + across + down, weight: u * v / looks as f32 });
            }
        }
    }
    all.retain(|share| share.weight > ROUNDING);
    all.sort_by_key(|share| share.offset);
    all.dedup_by(|again, first| {
        let same = again.offset == first.offset;
        first.weight += if same { again.weight } else { 0.0 };
        same
    });
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Looks between four texels, added up at each.
    #[test]
    fn shares_are_those_of_all_looks() {
        let shape = Shape::new([64, 64], 6);
        let cross = [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]];
        for (offsets, radius, texels) in [
            (&[][..], 3.0, 1),
            (&cross[..], 0.0, 1),
            (&cross[..], 0.5, 5),
            (&cross[..], 2.25, 8),
            (&[[0.6, 0.7], [-0.7, 0.6], [-0.6, -0.7], [0.7, -0.6]][..], 0.5, 9),
        ] {
            let found = shares(offsets, [radius; 2], &shape);
            assert_eq!(found.len(), texels, "{offsets:?} at {radius}: {found:?}");
            let stride = shape.stride as isize;
            let place = |share: &TexelShare| {
                let row = (share.offset + stride / 2).div_euclid(stride);
                [(share.offset - row * stride) as f64, row as f64]
            };
            let sum = |of: &dyn Fn([f64; 2]) -> f64| -> f64 {
                found.iter().map(|share| f64::from(share.weight) * of(place(share))).sum()
            };
            assert!((sum(&|_| 1.0) - 1.0).abs() < 1e-6);
            // What is linear between texels is found exactly.
            let product: f64 = offsets.iter().map(|[x, y]| f64::from(x * y * radius * radius)).sum();
            let exact = product / offsets.len().max(1) as f64;
            assert!(sum(&|[x, _]| x).abs() < 1e-6 && sum(&|[_, y]| y).abs() < 1e-6);
            assert!((sum(&|[x, y]| x * y) - exact).abs() < 1e-6);
        }
    }
}

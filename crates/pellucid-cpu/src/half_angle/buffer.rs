//! The light that has come as far as a slab, texel by texel.

use glam::DVec2;

use crate::lanes::*;

/// How the planes of a light buffer lie in memory: rows of texels, with room around them that light never
/// loses anything in, as far as a blur reaches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shape {
    /// Texels per row and rows; rows are whole vectors.
    pub width: usize,
    pub height: usize,
    /// Texels around them.
    pub pad: usize,
    /// From a row to the next.
    pub stride: usize,
}

impl Shape {
    /// For pictures of a size with so much around them, at least 2.
    pub fn new([width, height]: [usize; 2], pad: usize) -> Self {
        let (width, pad) = (width.next_multiple_of(MOST_LANES), pad.max(2));
        Self { width, height, pad, stride: width + 2 * pad }
    }

    /// The place of a texel.
    #[inline(always)]
    pub fn at(&self, x: usize, y: usize) -> usize {
        (self.pad + y) * self.stride + self.pad + x
    }

    fn len(&self) -> usize {
        self.stride * (self.height + 2 * self.pad)
    }
}

/// Planes of numbers: the share of direct light that is left, and red, green and blue indirect light as shares
/// of the light, if there is any (6.3-4).
#[derive(Clone, Debug)]
pub struct LightBuffer {
    /// How planes lie in memory.
    pub shape: Shape,
    /// Direct light, then indirect light.
    pub planes: Vec<Vec<f32>>,
}

/// Places in a plane.
pub struct Place<S: Lanes> {
    offset: I32<S>,
    u: F32<S>,
    v: F32<S>,
}

impl LightBuffer {
    /// Light as it enters the volume; with `indirect` light, if that is some.
    pub fn new(shape: Shape, indirect: Option<f32>) -> Self {
        let planes = std::iter::once(1.0).chain(indirect.into_iter().flat_map(|level| [level; 3]));
        Self { shape, planes: planes.map(|level| vec![level; shape.len()]).collect() }
    }

    /// A plane at one picture position, in texels.
    pub fn read(&self, plane: usize, at: DVec2) -> f32 {
        let Shape { height, pad, stride, .. } = self.shape;
        let last = DVec2::new((stride - 1) as f64, (height + 2 * pad - 1) as f64);
        let at = (at + DVec2::splat(pad as f64 - 0.5)).clamp(DVec2::ZERO, last);
        // Never the last texel of a row, nor one of the last row: the next one is there, too.
        let (column, row) = ((at.x as usize).min(stride - 2), (at.y as usize).min(height + 2 * pad - 2));
        let [u, v] = [at.x - column as f64, at.y - row as f64].map(|part| part as f32);
        let texel = |dx: usize, dy: usize| self.planes[plane][(row + dy) * stride + column + dx];
        let mix = |t: f32, a: f32, b: f32| a + (b - a) * t;
        mix(v, mix(u, texel(0, 0), texel(1, 0)), mix(u, texel(0, 1), texel(1, 1)))
    }

    /// Where picture positions, in texels, are between the middles of four texels. Outside there is light as
    /// it entered.
    #[inline(always)]
    pub fn place<S: Lanes>(&self, s: S, [x, y]: [F32<S>; 2]) -> Place<S> {
        let Shape { height, pad, stride, .. } = self.shape;
        let (middle, zero) = (pad as f32 - 0.5, splat(s, 0.0));
        // Below the last texel of a plane, so that the next one is there, too; 0 for NaN.
        let last = [stride, height + 2 * pad].map(|n| ((n - 1) as f32).next_down());
        let x = (x + middle).max(zero).min(splat(s, last[0]));
        let y = (y + middle).max(zero).min(splat(s, last[1]));
        let (column, row) = (x.to_int::<I32<S>>(), y.to_int::<I32<S>>());
        let offset = column + row * stride as i32;
        Place { offset, u: x - column.to_float::<F32<S>>(), v: y - row.to_float::<F32<S>>() }
    }

    /// A plane at places.
    #[inline(always)]
    pub fn fetch<S: Lanes>(&self, s: S, plane: usize, place: &Place<S>) -> F32<S> {
        let plane = &self.planes[plane];
        assert!(plane.len() == self.shape.len());
        let base = plane.as_ptr().cast::<u8>();
        // SAFETY: `place` gives a texel that is not the last of its row nor in the last row.
        let [near, far] = unsafe {
            [
                s.gather_pairs::<4>(base, place.offset),
                s.gather_pairs::<4>(base.wrapping_add(4 * self.shape.stride), place.offset),
            ]
        };
        let near = lerp::<S>(place.u, near[0].bitcast(), near[1].bitcast());
        lerp::<S>(place.v, near, lerp::<S>(place.u, far[0].bitcast(), far[1].bitcast()))
    }
}

//! The light that has come as far as a slab, texel by texel.

use glam::DVec2;

use crate::lanes::*;

/// How the texels of a light buffer lie in memory: rows of them, with room around them that light never
/// loses anything in, as far as a blur reaches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shape {
    /// Texels of the picture per row. Those that make rows whole vectors belong to what is around it.
    pub columns: usize,
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
        let (columns, width, pad) = (width, width.next_multiple_of(MOST_LANES), pad.max(2));
        Self { columns, width, height, pad, stride: width + 2 * pad }
    }

    /// The place of a texel.
    #[inline(always)]
    pub fn at(&self, x: usize, y: usize) -> usize {
        (self.pad + y) * self.stride + self.pad + x
    }

    /// How many texels there are, with those around.
    pub fn len(&self) -> usize {
        self.stride * (self.height + 2 * self.pad)
    }
}

/// What light has lost on its way, texel by texel: the share of direct light and, if there is any, red, green and
/// blue indirect light as shares of the light (6.3-4). Where nothing is, these are zeros, and stay zeros to the bit
/// however they are blurred; and one look at a texel finds all of them side by side.
#[derive(Clone, Debug)]
pub struct LightBuffer {
    /// How texels lie in memory.
    pub shape: Shape,
    /// Light as it enters the volume, in every channel: direct light alone, or indirect light, too.
    pub fresh: Vec<f32>,
    /// What is missing of it.
    pub lost: Vec<f32>,
}

/// Most channels of a texel.
pub const MOST_CHANNELS: usize = 4;

/// Places between texels.
pub struct TexelPlace<S: Lanes> {
    offset: I32<S>,
    u: F32<S>,
    v: F32<S>,
}

/// Light at places.
pub struct Light<S: Lanes> {
    /// The share of direct light that is left.
    pub direct: F32<S>,
    /// Indirect light, if there is any.
    pub indirect: Option<[F32<S>; 3]>,
}

impl LightBuffer {
    /// Light as it enters the volume; with `indirect` light, if that is some.
    pub fn new(shape: Shape, indirect: Option<f32>) -> Self {
        let fresh: Vec<f32> = std::iter::once(1.0).chain(indirect.into_iter().flat_map(|level| [level; 3])).collect();
        Self { shape, lost: vec![0.0; shape.len() * fresh.len()], fresh }
    }

    /// How many numbers a texel has.
    #[inline(always)]
    pub fn channels(&self) -> usize {
        self.fresh.len()
    }

    /// Light at one picture position, in texels.
    pub fn read(&self, channel: usize, at: DVec2) -> f32 {
        let Shape { height, pad, stride, .. } = self.shape;
        let last = DVec2::new((stride - 1) as f64, (height + 2 * pad - 1) as f64);
        let at = (at + DVec2::splat(pad as f64 - 0.5)).clamp(DVec2::ZERO, last);
        // Never the last texel of a row, nor one of the last row: the next one is there, too.
        let (column, row) = ((at.x as usize).min(stride - 2), (at.y as usize).min(height + 2 * pad - 2));
        let [u, v] = [at.x - column as f64, at.y - row as f64].map(|part| part as f32);
        let lost = |dx: usize, dy: usize| self.lost[((row + dy) * stride + column + dx) * self.channels() + channel];
        let mix = |t: f32, a: f32, b: f32| a + (b - a) * t;
        self.fresh[channel] - mix(v, mix(u, lost(0, 0), lost(1, 0)), mix(u, lost(0, 1), lost(1, 1)))
    }

    /// Where picture positions, in texels, are between the middles of four texels. Outside there is light as
    /// it entered.
    #[inline(always)]
    pub fn place<S: Lanes>(&self, s: S, [x, y]: [F32<S>; 2]) -> TexelPlace<S> {
        let Shape { height, pad, stride, .. } = self.shape;
        let middle = pad as f32 - 0.5;
        // Below the last texel of a plane, so that the next one is there, too; 0 for NaN.
        let last = [stride, height + 2 * pad].map(|n| ((n - 1) as f32).next_down());
        let x = within(s, x + middle, last[0]);
        let y = within(s, y + middle, last[1]);
        let (column, row) = (x.to_int::<I32<S>>(), y.to_int::<I32<S>>());
        let offset = column + row * stride as i32;
        TexelPlace { offset, u: x - column.to_float::<F32<S>>(), v: y - row.to_float::<F32<S>>() }
    }

    /// Light at places.
    #[inline(always)]
    pub fn fetch<S: Lanes>(&self, s: S, place: &TexelPlace<S>) -> Light<S> {
        assert!(self.lost.len() == self.shape.len() * self.channels());
        let (base, row) = (self.lost.as_ptr(), self.shape.stride);
        let fresh = |channel: usize| splat(s, self.fresh[channel]);
        if self.channels() < MOST_CHANNELS {
            // SAFETY: `place` gives a texel that is not the last of its row nor in the last row.
            let [near, far] = unsafe {
                [
                    s.gather_pairs::<4>(base.cast(), place.offset),
                    s.gather_pairs::<4>(base.wrapping_add(row).cast(), place.offset),
                ]
            };
            let near = lerp::<S>(place.u, near[0].bitcast(), near[1].bitcast());
            let far = lerp::<S>(place.u, far[0].bitcast(), far[1].bitcast());
            return Light { direct: fresh(0) - lerp::<S>(place.v, near, far), indirect: None };
        }
        // SAFETY: as above; a texel has four numbers.
        let [near, near_next, far, far_next] = unsafe {
            [
                s.gather_rows::<2>(base, place.offset),
                s.gather_rows::<2>(base.wrapping_add(4), place.offset),
                s.gather_rows::<2>(base.wrapping_add(4 * row), place.offset),
                s.gather_rows::<2>(base.wrapping_add(4 * row + 4), place.offset),
            ]
        };
        let lost = rgba!(C => {
            let (near, far) = (lerp::<S>(place.u, near[C], near_next[C]), lerp::<S>(place.u, far[C], far_next[C]));
            lerp::<S>(place.v, near, far)
        });
        Light { direct: fresh(0) - lost[0], indirect: Some(xyz!(C => fresh(C + 1) - lost[C + 1])) }
    }
}

/// The same four numbers for every texel, lane by lane.
#[inline(always)]
pub fn each_texel(channels: [f32; MOST_CHANNELS]) -> [f32; MOST_LANES] {
    let mut lanes = [0.0; MOST_LANES];
    for (lane, number) in lanes.iter_mut().enumerate() {
        *number = channels[lane % MOST_CHANNELS];
    }
    lanes
}

/// A number of every texel in each of its channels, texel by texel.
#[inline(always)]
pub fn each_channel<S: Lanes>(numbers: F32<S>) -> [F32<S>; MOST_CHANNELS] {
    let (first, last) = (numbers.zip_low(numbers), numbers.zip_high(numbers));
    [first.zip_low(first), first.zip_high(first), last.zip_low(last), last.zip_high(last)]
}

/// The first number of every texel in each of its channels; both texel by texel.
#[inline(always)]
pub fn first_channel<S: Lanes>([a, b, c, d]: [F32<S>; MOST_CHANNELS]) -> [F32<S>; MOST_CHANNELS] {
    each_channel::<S>(a.unzip_low(b).unzip_low(c.unzip_low(d)))
}

/// Numbers of texels from a place on.
#[inline(always)]
pub fn texels<S: Lanes>(s: S, numbers: &[f32], from: usize) -> F32<S> {
    F32::<S>::from_slice(s, &numbers[from..from + width::<S>()])
}

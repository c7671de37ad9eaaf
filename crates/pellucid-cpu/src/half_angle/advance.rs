//! Light on its way through a slab: attenuated, and what is scattered forward spread over a cone
//! (Eq. 6.6, 6.7, K-06, K-09).

use pellucid_scene::InScatter;
use pellucid_scene::half_angle::LightFrame;

use super::buffer::{LightBuffer, Shape};
use super::frame::Project;
use super::matter::{Band, TILE};
use crate::lanes::*;

/// How light passes one slab, the same for all texels.
pub struct Step<'a, S> {
    /// The instruction set.
    pub s: S,
    /// The slab, and its number in the run.
    pub slab: usize,
    pub number: usize,
    /// Offsets of the taps as shares of the radius; none if nothing is blurred.
    pub offsets: &'a [[f32; 2]],
    /// Radius of the blur.
    pub radius: Radius<'a>,
    /// What becomes indirect light.
    pub in_scatter: InScatter,
    /// Weights of direct light that is scattered into the cone.
    pub phase: [f32; 3],
    /// Where something is, as a plane of a buffer, if light comes from there alone.
    pub presence: Option<&'a LightBuffer>,
}

/// How far a blur reaches.
#[derive(Clone, Copy)]
pub enum Radius<'a> {
    /// So many texels to the right and up, everywhere.
    Texels([f32; 2]),
    /// The tangent of half the cone's angle times this power of the path in a slab, in world units: the way
    /// of a light that is somewhere grows towards the picture's rim, and its texels with the distance.
    Path {
        /// Where texels are in the world.
        frame: &'a LightFrame,
        /// Radius in world units at a path of 1.
        scale: f32,
        /// Whether it grows with the root of the path.
        root: bool,
        /// A step in world units.
        step: f32,
    },
}

/// A tap at the same offset from all texels.
struct Tap<S: Lanes> {
    offset: isize,
    u: F32<S>,
    v: F32<S>,
}

impl<S: Lanes> Step<'_, S> {
    /// Passes a tile of a band: from `light` into rows of the next planes, which begin with the padding at the
    /// left. Returns whether any of it differs from light as it entered.
    pub fn pass(&self, light: &LightBuffer, next: &mut [&mut [f32]], band: &Band, [top, tile]: [usize; 2]) -> bool {
        let s = self.s;
        s.vectorize(
            #[inline(always)]
            || {
                let shape = light.shape;
                let rows = next[0].len() / shape.stride;
                let holds = band.holds(self.number, tile);
                let taps = match self.radius {
                    Radius::Texels(radius) if light.planes.len() > 1 => self.taps(radius, shape),
                    _ => Vec::new(),
                };
                let fresh = shape.at(0, 0) - shape.pad - 1;
                let mut touched = all(s, false);
                for row in 0..rows {
                    for x in (tile * TILE..shape.width.min((tile + 1) * TILE)).step_by(width::<S>()) {
                        let (from, to) = (shape.at(x, top + row), row * shape.stride + shape.pad + x);
                        let at = row * shape.width + x;
                        let zero = splat(s, 0.0);
                        let alpha = if holds { band.opacity(s, self.number, 0, at) } else { zero };
                        let direct = texels(s, &light.planes[0], from);
                        let left = direct * (splat(s, 1.0) - alpha);
                        left.store_slice(&mut next[0][to..to + width::<S>()]);
                        touched |= left.simd_ne(splat(s, light.planes[0][fresh]));
                        if light.planes.len() == 1 {
                            continue;
                        }
                        let places = self.places(light, band, x, top + row, at);
                        let scattered = self.scattered(light, &taps, &places, from);
                        for channel in 0..3 {
                            let plane = &light.planes[channel + 1];
                            let opacity = if holds { band.opacity(s, self.number, channel + 1, at) } else { zero };
                            let mut indirect = self.mean(light, channel + 1, &taps, &places, from);
                            if let Some(direct) = scattered {
                                let weight = (alpha - opacity).max(zero) * self.phase[channel];
                                indirect = weight.mul_add(direct, indirect);
                            }
                            let left = indirect * (splat(s, 1.0) - opacity);
                            left.store_slice(&mut next[channel + 1][to..to + width::<S>()]);
                            touched |= left.simd_ne(splat(s, plane[fresh]));
                        }
                    }
                }
                touched.any_true()
            },
        )
    }

    /// Taps as places in memory.
    #[inline(always)]
    fn taps(&self, radius: [f32; 2], shape: Shape) -> Vec<Tap<S>> {
        let mut taps = Vec::with_capacity(self.offsets.len());
        for offset in self.offsets {
            let [x, y] = [offset[0] * radius[0], offset[1] * radius[1]];
            let offset = y.floor() as isize * shape.stride as isize + x.floor() as isize;
            taps.push(Tap { offset, u: splat(self.s, x - x.floor()), v: splat(self.s, y - y.floor()) });
        }
        taps
    }

    /// Taps as places in the picture, where they are not at the same offset from all texels.
    #[inline(always)]
    fn places(&self, light: &LightBuffer, band: &Band, x: usize, y: usize, at: usize) -> Vec<super::buffer::Place<S>> {
        let s = self.s;
        let Radius::Path { frame, scale, root, step } = self.radius else { return Vec::new() };
        let rays = band.rays(s, at);
        let [[column, row], density] = frame.texels(s, &rays.at(splat(s, self.slab as f32 + 0.5)));
        let mut path = rays.stretch() * step;
        if root {
            path = path.sqrt();
        }
        let radius = [path * scale * density[0], path * scale * density[1]];
        // Texels without a ray have no way either.
        let column = column.is_finite().select(column, splat(s, x as f32));
        let row = row.is_finite().select(row, splat(s, y as f32));
        let mut places = Vec::with_capacity(self.offsets.len());
        for offset in self.offsets {
            let place = [radius[0].mul_add(splat(s, offset[0]), column), radius[1].mul_add(splat(s, offset[1]), row)];
            places.push(light.place(s, place));
        }
        places
    }

    /// Direct light around texels, if some of it becomes indirect light.
    #[inline(always)]
    fn scattered(
        &self,
        light: &LightBuffer,
        taps: &[Tap<S>],
        places: &[super::buffer::Place<S>],
        from: usize,
    ) -> Option<F32<S>> {
        match self.in_scatter {
            InScatter::Indirect => None,
            InScatter::Direct | InScatter::DirectFromMatter | InScatter::BothFromMatter => {
                Some(self.mean(light, 0, taps, places, from))
            }
        }
    }

    /// The mean of a plane at the taps, of what comes from matter alone where that is asked for. As a
    /// difference from the middle: what is even stays exactly even.
    #[inline(always)]
    fn mean(
        &self,
        light: &LightBuffer,
        plane: usize,
        taps: &[Tap<S>],
        places: &[super::buffer::Place<S>],
        from: usize,
    ) -> F32<S> {
        let s = self.s;
        let presence = match (self.in_scatter, plane) {
            (InScatter::DirectFromMatter, 0) | (InScatter::BothFromMatter, _) => self.presence,
            _ => None,
        };
        let middle = texels(s, &light.planes[plane], from);
        let count = taps.len() + places.len();
        let Some(presence) = presence else {
            if count == 0 {
                return middle;
            }
            let mut sum = splat(s, 0.0);
            for tap in taps {
                sum += tap.at(s, light, plane, from) - middle;
            }
            for place in places {
                sum += light.fetch(s, plane, place) - middle;
            }
            return (sum * (1.0 / count as f32)) + middle;
        };
        if count == 0 {
            return middle * texels(s, &presence.planes[0], from);
        }
        let mut sum = splat(s, 0.0);
        for tap in taps {
            sum = tap.at(s, light, plane, from).mul_add(tap.at(s, presence, 0, from), sum);
        }
        for place in places {
            sum = light.fetch(s, plane, place).mul_add(presence.fetch(s, 0, place), sum);
        }
        sum * (1.0 / count as f32)
    }
}

impl<S: Lanes> Tap<S> {
    /// A plane at this offset from texels.
    #[inline(always)]
    fn at(&self, s: S, light: &LightBuffer, plane: usize, from: usize) -> F32<S> {
        let (plane, stride) = (&light.planes[plane], light.shape.stride);
        let corner = from.wrapping_add_signed(self.offset);
        let near = lerp::<S>(self.u, texels(s, plane, corner), texels(s, plane, corner + 1));
        let far = lerp::<S>(self.u, texels(s, plane, corner + stride), texels(s, plane, corner + stride + 1));
        lerp::<S>(self.v, near, far)
    }
}

/// Texels from a place on.
#[inline(always)]
fn texels<S: Lanes>(s: S, plane: &[f32], from: usize) -> F32<S> {
    F32::<S>::from_slice(s, &plane[from..from + width::<S>()])
}

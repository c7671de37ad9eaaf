//! Light from around a texel: the mean of a few looks within the cone (Eq. 6.11, K-09), of what comes from matter
//! alone where that is asked for (6.3-7).

use pellucid_scene::InScatter;

use super::band::Band;
use super::buffer::{LightBuffer, MOST_CHANNELS, Shape, texels};
use super::frame::Project;
use super::step::{Radius, Step};
use crate::lanes::*;
use crate::packet::PerLane;

/// The looks around the texels of a slab.
pub struct Blur<'a, S: Lanes> {
    step: &'a Step<'a, S>,
    light: &'a LightBuffer,
    /// From any texel; none where the radius differs from texel to texel.
    taps: Vec<Tap>,
}

/// A look between four texels.
#[derive(Clone, Copy)]
struct Tap {
    /// From a texel to the first of the four.
    offset: isize,
    /// Shares of the four: side by side, and a row further.
    weights: [f32; 4],
}

/// Where looks from texels side by side are, in texels from each: their middle, and how far away from it.
struct Around {
    middle: [PerLane; 2],
    radius: [PerLane; 2],
}

impl<'a, S: Lanes> Blur<'a, S> {
    /// Of light, as a step says.
    #[inline(always)]
    pub fn new(step: &'a Step<'a, S>, light: &'a LightBuffer) -> Self {
        let taps = match step.radius {
            Radius::Path { .. } => Vec::new(),
            Radius::Texels(radius) => taps(step.offsets, [0.0; 2], radius, &light.shape).collect(),
        };
        Self { step, light, taps }
    }

    /// What is lost around the texels of a row from `[x, y]` on, row `row` of a band; with what direct light
    /// adds to indirect light of these opacities (6.3-7).
    #[inline(always)]
    pub fn spread(&self, to: &mut [f32], [x, y]: [usize; 2], opacity: &[f32], (band, row): (&Band, usize)) {
        let in_scatter = self.step.in_scatter;
        let gated = matches!(in_scatter, InScatter::DirectFromMatter | InScatter::BothFromMatter);
        match self.taps.is_empty() || gated {
            true => self.one_by_one(to, [x, y], (band, row)),
            false => self.side_by_side(to, self.light.shape.at(x, y)),
        }
        if in_scatter == InScatter::Indirect {
            return;
        }
        for (lost, opacity) in to.chunks_exact_mut(MOST_CHANNELS).zip(opacity.chunks_exact(MOST_CHANNELS)) {
            // Of each colour, what is left of direct light and what of it gets through.
            let [direct, transmittance] = [1.0 - lost[0], 1.0 - opacity[0]].map(|left| match self.step.chroma {
                None => [left; 3],
                Some(chroma) => chroma.each(left),
            });
            for channel in 0..3 {
                // Light that becomes indirect on the way loses the rest of the way as such. As a share of what gets
                // through all of it, which the slab takes next.
                let passing = 1.0 - opacity[channel + 1];
                let scattered = if passing > 0.0 { (1.0 - transmittance[channel] / passing).max(0.0) } else { 0.0 };
                lost[channel + 1] -= scattered * self.step.phase[channel] * direct[channel];
            }
        }
    }

    /// The means of looks at the same offsets from all texels.
    #[inline(always)]
    fn side_by_side(&self, to: &mut [f32], from: usize) {
        let (s, stride) = (self.step.s, self.light.shape.stride);
        let share = 1.0 / self.taps.len() as f32;
        for (number, tap) in self.taps.iter().enumerate() {
            let weights = rgba!(C => splat(s, tap.weights[C] * share));
            let corner = from.wrapping_add_signed(tap.offset);
            let rows = [corner, corner + 1, corner + stride, corner + stride + 1];
            let length = to.len();
            let [a, b, c, d] = rgba!(C => &self.light.lost[rows[C] * MOST_CHANNELS..][..length]);
            for at in (0..length).step_by(width::<S>()) {
                let mut sum = texels(s, a, at) * weights[0];
                if number > 0 {
                    sum += texels(s, to, at);
                }
                sum = texels(s, b, at).mul_add(weights[1], sum);
                sum = texels(s, c, at).mul_add(weights[2], sum);
                sum = texels(s, d, at).mul_add(weights[3], sum);
                sum.store_slice(&mut to[at..at + width::<S>()]);
            }
        }
    }

    /// The means of looks that are not alike, and of light from matter.
    #[inline(always)]
    fn one_by_one(&self, to: &mut [f32], [x, y]: [usize; 2], (band, row): (&Band, usize)) {
        let shape = &self.light.shape;
        for (group, to) in to.chunks_mut(width::<S>() * MOST_CHANNELS).enumerate() {
            let x = x + group * width::<S>();
            let around = self.around([x, y], row * shape.width + x, band);
            for (lane, to) in to.chunks_exact_mut(MOST_CHANNELS).enumerate() {
                let at = shape.at(x + lane, y);
                let mean = match &around {
                    None => self.mean(at, self.taps.iter().copied()),
                    Some(Around { middle, radius }) => {
                        let [middle, radius] = [middle, radius].map(|sides| [sides[0][lane], sides[1][lane]]);
                        self.mean(at, taps(self.step.offsets, middle, radius, shape))
                    }
                };
                to.copy_from_slice(&mean);
            }
        }
    }

    /// Where looks are, if that is not the same from all texels.
    #[inline(always)]
    fn around(&self, [x, y]: [usize; 2], at: usize, band: &Band) -> Option<Around> {
        let s = self.step.s;
        let Radius::Path { frame, scale, root, step } = self.step.radius else { return None };
        let rays = band.rays(s, at);
        let [place, density] = frame.texels(s, &rays.at(splat(s, self.step.slab as f32 + 0.5)));
        let mut path = rays.stretch() * step;
        if root {
            path = path.sqrt();
        }
        let [mut middle, mut radius] = [[[0.0; MOST_LANES]; 2]; 2];
        for axis in 0..2 {
            store::<S>(place[axis], &mut middle[axis]);
            store::<S>(path * scale * density[axis], &mut radius[axis]);
        }
        for lane in 0..width::<S>() {
            for (axis, texel) in [x + lane, y].into_iter().enumerate() {
                // Texels without a ray have no way either.
                let middle = &mut middle[axis][lane];
                *middle = if middle.is_finite() { *middle - (texel as f32 + 0.5) } else { 0.0 };
            }
        }
        Some(Around { middle, radius })
    }

    /// What is missing of the mean light at taps from a texel, of what comes from matter where only that counts.
    #[inline(always)]
    fn mean(&self, from: usize, taps: impl ExactSizeIterator<Item = Tap>) -> [f32; MOST_CHANNELS] {
        let share = 1.0 / taps.len() as f32;
        let stride = self.light.shape.stride;
        let mut sum = [0.0; MOST_CHANNELS];
        for tap in taps {
            let corner = from.wrapping_add_signed(tap.offset);
            let texels = [corner, corner + 1, corner + stride, corner + stride + 1];
            let mut lost = [0.0; MOST_CHANNELS];
            for (at, weight) in texels.into_iter().zip(tap.weights) {
                let texel = &self.light.lost[at * MOST_CHANNELS..][..MOST_CHANNELS];
                lost.iter_mut().zip(texel).for_each(|(lost, texel)| *lost += weight * texel);
            }
            if let Some(presence) = self.step.presence {
                let matter: f32 = texels.into_iter().zip(tap.weights).map(|(at, weight)| weight * presence[at]).sum();
                let gated = if self.step.in_scatter == InScatter::BothFromMatter { MOST_CHANNELS } else { 1 };
                for (lost, fresh) in lost.iter_mut().zip(&self.light.fresh).take(gated) {
                    *lost = fresh - (fresh - *lost) * matter;
                }
            }
            sum.iter_mut().zip(lost).for_each(|(sum, lost)| *sum += lost);
        }
        sum.map(|sum| sum * share)
    }
}

/// Looks at offsets, as shares of a radius, from a place beside a texel; one at the place itself if there are none.
#[inline(always)]
fn taps<'a>(
    offsets: &'a [[f32; 2]],
    middle: [f32; 2],
    radius: [f32; 2],
    shape: &'a Shape,
) -> impl ExactSizeIterator<Item = Tap> + 'a {
    let offset = move |number: usize| offsets.get(number).copied().unwrap_or_default();
    (0..offsets.len().max(1)).map(move |number| {
        let [x, y] = [0, 1].map(|axis| radius[axis].mul_add(offset(number)[axis], middle[axis]));
        Tap::new([x, y], shape)
    })
}

impl Tap {
    /// At an offset in texels, limited to what lies around the picture.
    #[inline(always)]
    fn new(offset: [f32; 2], shape: &Shape) -> Self {
        let pad = shape.pad as f32;
        let [x, y] = offset.map(|offset| offset.max(-pad).min((pad - 1.0).next_down()));
        let (column, row) = (x.floor(), y.floor());
        let [u, v] = [x - column, y - row];
        let weights = [(1.0 - u) * (1.0 - v), u * (1.0 - v), (1.0 - u) * v, u * v];
        Self { offset: row as isize * shape.stride as isize + column as isize, weights }
    }
}

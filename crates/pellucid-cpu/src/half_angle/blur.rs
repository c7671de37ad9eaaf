//! Light from around a texel: the mean of a few looks within the cone (Eq. 6.11, K-09), of what comes from matter
//! alone where that is asked for (6.3-7).

use pellucid_scene::InScatter;

use super::buffer::{LightBuffer, MOST_CHANNELS, Shape, each_channel, each_texel, texels};
use super::looks::{Looks, Radius, TexelShare};
use super::step::Step;
use crate::lanes::*;

/// The looks around the texels of a slab.
pub struct Blur<'a, S: Lanes> {
    step: &'a Step<'a, S>,
    light: &'a LightBuffer,
    fresh: F32<S>,
    /// Channels of which only what comes from matter counts.
    gated: Mask<S>,
}

impl<'a, S: Lanes> Blur<'a, S> {
    /// Of light that lies in whole texels, as a step says; with what it is as it enters, texel by texel.
    #[inline(always)]
    pub fn new(step: &'a Step<'a, S>, light: &'a LightBuffer, fresh: F32<S>) -> Self {
        let s = step.s;
        let everything = if step.in_scatter == InScatter::BothFromMatter { 1.0 } else { 0.0 };
        let gated = load(s, &each_texel([1.0, everything, everything, everything])).simd_gt(splat(s, 0.5));
        Self { step, light, fresh, gated }
    }

    /// What is lost around as many texels of a row as there are lanes, from `[x, y]` on: texel by texel, as light lies in
    /// its buffer.
    #[inline(always)]
    pub fn around(&self, [x, y]: [usize; 2]) -> [F32<S>; MOST_CHANNELS] {
        let (s, shape) = (self.step.s, &self.light.shape);
        let from = shape.at(x, y) * MOST_CHANNELS;
        match &self.step.looks {
            Looks::Alike(shares) => self.alike(from, shares),
            Looks::Each(offsets, radius) => {
                let radius = match radius {
                    Radius::Texels([right, up]) => [splat(s, *right), splat(s, *up)],
                    Radius::Each(own, [right, up]) => {
                        let own = texels(s, own, y * shape.width + x);
                        [own * *right, own * *up]
                    }
                };
                self.each(from, offsets, &radius)
            }
        }
    }

    #[inline(always)]
    fn alike(&self, from: usize, shares: &[TexelShare]) -> [F32<S>; MOST_CHANNELS] {
        let s = self.step.s;
        let mut sum = [splat(s, 0.0); MOST_CHANNELS];
        for share in shares {
            let lost = block::<S>(&self.light.lost, from.wrapping_add_signed(share.offset * MOST_CHANNELS as isize));
            sum = plus(s, sum, lost, &[splat(s, share.weight); MOST_CHANNELS]);
        }
        sum
    }

    #[inline(always)]
    fn each(&self, from: usize, offsets: &[[f32; 2]], radius: &[F32<S>; 2]) -> [F32<S>; MOST_CHANNELS] {
        let (s, looks) = (self.step.s, offsets.len().max(1));
        let mut sum = [splat(s, 0.0); MOST_CHANNELS];
        for look in 0..looks {
            let [right, up] = if offsets.is_empty() { [0.0; 2] } else { offsets[look] };
            let lost = self.look(from, [radius[0] * right, radius[1] * up]);
            sum = rgba!(C => sum[C] + lost[C]);
        }
        rgba!(C => sum[C] * (1.0 / looks as f32))
    }

    /// What is lost so many texels away from as many as there are lanes, of what comes from matter where only that
    /// counts.
    #[inline(always)]
    fn look(&self, from: usize, [x, y]: [F32<S>; 2]) -> [F32<S>; MOST_CHANNELS] {
        let (s, Shape { pad, stride, .. }) = (self.step.s, self.light.shape);
        let (zero, one) = (splat(s, 0.0), splat(s, 1.0));
        // Within what lies around the picture, whatever these numbers are.
        let (low, high) = (splat(s, -(pad as f32)), splat(s, (pad as f32 - 1.0).next_down()));
        let (x, y) = (x.max_precise(low).min(high), y.max_precise(low).min(high));
        let (column, row) = (x.floor(), y.floor());
        let (u, v) = (x - column, y - row);
        let weights = [(one - u) * (one - v), u * (one - v), (one - u) * v, u * v];
        let offset = row.to_int::<I32<S>>() * stride as i32 + column.to_int::<I32<S>>();
        let (mut lost, mut matter, mut left) = ([zero; MOST_CHANNELS], [zero; MOST_CHANNELS], all(s, true));
        // Texels side by side look between the same four, or nearly always.
        while left.any_true() {
            let first = offset[left.to_bitmask().trailing_zeros() as usize];
            let same = left & offset.simd_eq(first);
            left &= !same;
            let near = from.wrapping_add_signed(first as isize * MOST_CHANNELS as isize);
            let far = near + stride * MOST_CHANNELS;
            for (at, weight) in [near, near + MOST_CHANNELS, far, far + MOST_CHANNELS].into_iter().zip(weights) {
                let weight = each_channel::<S>(same.select(weight, zero));
                lost = plus(s, lost, block::<S>(&self.light.lost, at), &weight);
                if let Some(presence) = self.step.presence {
                    matter = plus(s, matter, block::<S>(presence, at), &weight);
                }
            }
        }
        if self.step.presence.is_none() {
            return lost;
        }
        rgba!(C => self.gated.select(self.fresh - (self.fresh - lost[C]) * matter[C], lost[C]))
    }
}

/// The numbers of as many texels as there are lanes, from one on.
#[inline(always)]
fn block<S: Lanes>(numbers: &[f32], from: usize) -> &[f32] {
    &numbers[from..from + MOST_CHANNELS * width::<S>()]
}

/// A sum with numbers of texels added to it, each by its weight.
#[inline(always)]
fn plus<S: Lanes>(
    s: S,
    sum: [F32<S>; MOST_CHANNELS],
    numbers: &[f32],
    weights: &[F32<S>; MOST_CHANNELS],
) -> [F32<S>; MOST_CHANNELS] {
    rgba!(C => texels(s, numbers, C * width::<S>()).mul_add(weights[C], sum[C]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_random::random;

    fn mean<S: Lanes>(s: S, gated: Option<InScatter>) {
        let mut random = random();
        let shape = Shape::new([40, 7], 5);
        let mut light = LightBuffer::new(shape, Some(0.7));
        light.lost.iter_mut().for_each(|lost| *lost = random().abs() as f32);
        let presence: Vec<f32> =
            (0..shape.len()).flat_map(|_| [if random() > 0.0 { 1.0 } else { 0.0 }; MOST_CHANNELS]).collect();
        let step = Step {
            s,
            number: 0,
            looks: Looks::Each(&[], Radius::Texels([0.0; 2])),
            chroma: None,
            in_scatter: gated.unwrap_or_default(),
            phase: [1.0; 3],
            presence: gated.map(|_| presence.as_slice()),
        };
        let blur = Blur::new(&step, &light, load(s, &each_texel([1.0, 0.7, 0.7, 0.7])));
        for _ in 0..100 {
            let (mut x, mut y) = ([0.0; MOST_LANES], [0.0; MOST_LANES]);
            for (x, y) in x.iter_mut().zip(&mut y) {
                // Beyond what lies around the picture, too.
                (*x, *y) = (random() as f32 * 6.0, random() as f32 * 0.6 + 2.0);
            }
            let [column, row] = [16, 3];
            let found = blur.look(shape.at(column, row) * MOST_CHANNELS, [load(s, &x), load(s, &y)]);
            for lane in 0..width::<S>() {
                let pad = shape.pad as f64;
                let [u, v] = [x[lane], y[lane]].map(|place| f64::from(place).clamp(-pad, pad - 1.0 - 1e-6));
                for channel in 0..MOST_CHANNELS {
                    let [mut lost, mut matter] = [0.0; 2];
                    for (dx, dy) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)] {
                        let weight = (1.0 - (u - u.floor() - dx).abs()) * (1.0 - (v - v.floor() - dy).abs());
                        let place = [(u.floor() + dx) as isize, (v.floor() + dy) as isize];
                        let at = shape.at(column + lane, row) as isize + place[1] * shape.stride as isize + place[0];
                        let at = at as usize * MOST_CHANNELS + channel;
                        lost += weight * f64::from(light.lost[at]);
                        matter += weight * f64::from(presence[at]);
                    }
                    let fresh = f64::from(light.fresh[channel]);
                    let is_gated = match gated {
                        None => false,
                        Some(gated) => channel == 0 || gated == InScatter::BothFromMatter,
                    };
                    let exact = if is_gated { fresh - (fresh - lost) * matter } else { lost };
                    let number = lane * MOST_CHANNELS + channel;
                    let found = found[number / width::<S>()][number % width::<S>()];
                    assert!((f64::from(found) - exact).abs() < 1e-5, "{gated:?}: {found}, exact {exact}");
                }
            }
        }
    }

    /// Each texel by itself, in f64.
    #[test]
    fn looks_find_what_lies_between_texels() {
        for gated in [None, Some(InScatter::DirectFromMatter), Some(InScatter::BothFromMatter)] {
            for set in InstructionSet::ALL.into_iter().filter_map(InstructionSet::resolve) {
                dispatch!(set, s => mean(s, gated));
            }
        }
    }
}

//! Noise on the optics of samples (K-23), for all lanes: the vectors' form of
//! [`Variation`](pellucid_optics::Variation).

use pellucid_optics::{Chroma, Variation};

use crate::chroma;
use crate::classify::Classify;
use crate::element::Element;
use crate::field::turbulence;
use crate::lanes::*;
use crate::paint::Paint;
use crate::samples::Sample;

/// What happens to classified samples, and to segments, by where they are.
pub trait Vary: Sync {
    /// Associated colours at index positions.
    fn vary<S: Lanes>(&self, s: S, index: &Vec3<S>, rgba: [F32<S>; 4]) -> [F32<S>; 4];
}

/// Nothing: optics depend on the data alone.
pub struct Uniform;

impl Vary for Uniform {
    #[inline(always)]
    fn vary<S: Lanes>(&self, _: S, _: &Vec3<S>, rgba: [F32<S>; 4]) -> [F32<S>; 4] {
        rgba
    }
}

/// Optics that vary.
#[derive(Clone, Copy)]
pub struct Varied<'a> {
    /// How.
    pub variation: &'a Variation,
    /// How each colour is held back, if not all alike.
    pub chroma: Option<Chroma>,
}

/// Optics that vary or do not.
impl Vary for Option<Varied<'_>> {
    #[inline(always)]
    fn vary<S: Lanes>(&self, s: S, index: &Vec3<S>, rgba: [F32<S>; 4]) -> [F32<S>; 4] {
        let Some(varied) = self else { return rgba };
        varied.associated(s, &varied.noise(s, index), rgba)
    }
}

impl Varied<'_> {
    /// The noise at index positions, within -1 and 1.
    #[inline(always)]
    fn noise<S: Lanes>(&self, s: S, index: &Vec3<S>) -> [F32<S>; 4] {
        let noise = turbulence::<S, 4>(s, self.variation.turbulence(), index);
        rgba!(C => noise[C].max(splat(s, -1.0)).min(splat(s, 1.0)))
    }

    /// Factors of the extinction.
    #[inline(always)]
    fn extinction<S: Lanes>(&self, s: S, noise: &[F32<S>; 4]) -> F32<S> {
        noise[3].mul_add(splat(s, self.variation.weights[0]), splat(s, 1.0)).max(splat(s, Variation::LEAST))
    }

    /// Associated colours and opacities of any length.
    #[inline(always)]
    fn associated<S: Lanes>(&self, s: S, noise: &[F32<S>; 4], rgba: [F32<S>; 4]) -> [F32<S>; 4] {
        let mut varied = rgba;
        if self.variation.weights[0] != 0.0 {
            varied = chroma::over_length(s, self.chroma.as_ref(), varied, self.extinction(s, noise));
        }
        if self.variation.weights[1] == 0.0 {
            return varied;
        }
        let [r, g, b] = xyz!(C => {
            let factor = noise[C].mul_add(splat(s, self.variation.weights[1]), splat(s, 1.0));
            (varied[C] * factor).min(varied[C].max(varied[3]))
        });
        [r, g, b, varied[3]]
    }

    /// What gets through of indirect light.
    #[inline(always)]
    fn transport<S: Lanes>(&self, s: S, noise: &[F32<S>; 4], transmittance: [F32<S>; 3]) -> [F32<S>; 3] {
        if self.variation.weights[2] == 0.0 {
            return transmittance;
        }
        xyz!(C => power(s, transmittance[C], noise[C].mul_add(splat(s, self.variation.weights[2]), splat(s, 1.0))))
    }
}

/// What depends on the place, not on the value alone: colours that voxels have of their own, and noise on optics.
#[derive(Clone, Copy)]
pub struct Placed<'a> {
    /// Colours.
    pub paint: Option<Paint<'a>>,
    /// Noise.
    pub varied: Option<Varied<'a>>,
}

impl Placed<'_> {
    /// Associated colours at index positions and, if asked for, what gets through of indirect light there.
    #[inline(always)]
    pub fn at<S: Lanes>(
        &self,
        s: S,
        index: &Vec3<S>,
        mut rgba: [F32<S>; 4],
        transmittance: Option<[F32<S>; 3]>,
    ) -> ([F32<S>; 4], Option<[F32<S>; 3]>) {
        if let Some(paint) = &self.paint {
            rgba = paint.tint(s, index, rgba);
        }
        let Some(varied) = &self.varied else { return (rgba, transmittance) };
        let noise = varied.noise(s, index);
        let transmittance = transmittance.map(
            #[inline(always)]
            |transmittance| varied.transport(s, &noise, transmittance),
        );
        (varied.associated(s, &noise, rgba), transmittance)
    }
}

impl Vary for Placed<'_> {
    #[inline(always)]
    fn vary<S: Lanes>(&self, s: S, index: &Vec3<S>, rgba: [F32<S>; 4]) -> [F32<S>; 4] {
        self.at(s, index, rgba, None).0
    }
}

/// Classified samples that vary.
pub struct VariedSamples<C, V> {
    /// How they are classified.
    pub classifier: C,
    /// What varies them.
    pub vary: V,
}

impl<S: Lanes, C: Classify<S>, V: Vary> Classify<S> for VariedSamples<C, V> {
    #[inline(always)]
    fn classify(&self, s: S, value: F32<S>, sample: &Sample<S>) -> Option<Element<S>> {
        let Element { rgba, visible } = self.classifier.classify(s, value, sample)?;
        Some(Element { rgba: self.vary.vary(s, &sample.index, rgba), visible })
    }
}

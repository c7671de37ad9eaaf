//! An extinction of its own for each colour (K-13).

use crate::Scattering;

/// How much more of each colour is lost than of the one that is lost least. Opacities are that one's: where it has a
/// share `T` left, a colour has `T^r`. Powers of the others would be of numbers near 0, where little is known of them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chroma {
    /// Factor of the extinction for the colour that is lost least, of those that are lost at all.
    pub least: f32,
    /// Extinctions of red, green and blue over that one: 1 or more, or 0 for what is not lost.
    pub ratios: [f32; 3],
}

impl Chroma {
    /// That of a volume whose colours are not all lost alike, but not of one that holds back no colour.
    pub fn of(scattering: &Scattering) -> Option<Self> {
        let factors = scattering.extinction_factors()?;
        let least = factors.into_iter().filter(|factor| *factor > 0.0).reduce(f32::min)?;
        Some(Self { least, ratios: factors.map(|factor| factor / least) })
    }

    /// What is left of each colour where this share of the one that is lost least is left.
    pub fn each(&self, transmittance: f32) -> [f32; 3] {
        self.ratios.map(|ratio| transmittance.powf(ratio))
    }

    /// What is held back of all colours, in the mean, at an opacity of the one that is lost least.
    pub fn coverage(&self, alpha: f32) -> f32 {
        1.0 - self.each(1.0 - alpha).into_iter().sum::<f32>() / 3.0
    }
}

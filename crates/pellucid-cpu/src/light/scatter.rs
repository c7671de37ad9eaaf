//! How samples scatter the light of sources once (6.2, K-07).

use pellucid_optics::{Anisotropy, GradientWeight, Phase, PhaseNormalization, ScatterTable, Scattering, SurfaceShare};

use crate::classify::Lookup;
use crate::lanes::*;

/// How the samples of a volume scatter.
pub struct Scatter<'a> {
    scattering: &'a Scattering,
    table: Lookup<'a>,
    /// The anisotropy, if it is the same everywhere.
    uniform: Option<f32>,
}

/// What samples are.
pub struct Scatterers<S: Lanes> {
    /// Anisotropy.
    pub g: F32<S>,
    /// The part that is a surface, but for what gradients make one.
    pub surface: F32<S>,
}

impl<'a> Scatter<'a> {
    /// A volume's scattering with its table.
    pub fn new(scattering: &'a Scattering, table: &'a ScatterTable) -> Self {
        let uniform =
            (scattering.anisotropy == Anisotropy::Uniform).then(|| scattering.phase.anisotropy().unwrap_or(0.0));
        Self { scattering, table: Lookup::of_rows(table.entries(), table.nodes()), uniform }
    }

    /// Whether any samples are surfaces.
    pub fn has_surfaces(&self) -> bool {
        self.scattering.has_surfaces()
    }

    /// The factor of a light's radiance at cosines `mu`, where the anisotropy is the same everywhere.
    #[inline(always)]
    pub fn along<S: Lanes>(&self, s: S, mu: F32<S>) -> Option<[F32<S>; 3]> {
        self.uniform.map(
            #[inline(always)]
            |g| self.weight(s, splat(s, g), mu, all(s, true)),
        )
    }

    /// Gradient magnitudes between which a cloud turns into a surface, if gradients decide.
    #[inline(always)]
    pub fn by_gradient(&self) -> Option<&GradientWeight> {
        match &self.scattering.surface {
            SurfaceShare::Gradient(weight) => Some(weight),
            _ => None,
        }
    }

    /// What samples of these values are.
    #[inline(always)]
    pub fn at<S: Lanes>(&self, s: S, value: F32<S>) -> Scatterers<S> {
        if let (Some(g), SurfaceShare::None) = (self.uniform, &self.scattering.surface) {
            return Scatterers { g: splat(s, g), surface: splat(s, 0.0) };
        }
        let [g, surface, _, _] = self.table.lookup(s, value);
        Scatterers { g, surface }
    }

    /// The factor of a light's radiance at cosines `mu` between the ways before and after: the vectors'
    /// form of [`Phase::weight`]. Phase functions that are not a single lobe are asked lane by lane.
    #[inline(always)]
    pub fn weight<S: Lanes>(&self, s: S, g: F32<S>, mu: F32<S>, lanes: Mask<S>) -> [F32<S>; 3] {
        match (&self.scattering.phase, self.scattering.phase_normalization) {
            (phase @ Phase::Isotropic, normalization) => {
                let weight = phase.weight(normalization, 0.0, 0.0);
                xyz!(C => splat(s, weight[C]))
            }
            (Phase::HenyeyGreenstein { .. }, normalization) => {
                let (one, size) = (splat(s, 1.0), g.abs());
                let rest = one - size;
                let squared = rest.mul_add(rest, (size - g * mu) * 2.0);
                let numerator = match normalization {
                    // pi times the share per steradian.
                    PhaseNormalization::Physical => (one - g * g) * 0.25,
                    PhaseNormalization::Renormalised => rest * rest * rest,
                };
                [numerator / (squared * squared.sqrt()); 3]
            }
            (phase, normalization) => weight_of_each(s, phase, normalization, g, mu, lanes),
        }
    }
}

/// Weights of any phase function, one lane after the other.
#[inline(never)]
fn weight_of_each<S: Lanes>(
    s: S,
    phase: &Phase,
    normalization: PhaseNormalization,
    g: F32<S>,
    mu: F32<S>,
    lanes: Mask<S>,
) -> [F32<S>; 3] {
    let mut weights = [splat(s, 0.0); 3];
    let bits = lanes.to_bitmask();
    for lane in (0..width::<S>()).filter(|lane| bits >> lane & 1 == 1) {
        for (channel, weight) in weights.iter_mut().zip(phase.weight(normalization, g[lane], mu[lane])) {
            channel[lane] = weight;
        }
    }
    weights
}

//! Phase functions: how much light turns by which angle where a medium scatters it (6.2).
//!
//! `mu` is the cosine of the angle between the ways light travels before and after: +1 is forward.
//! A phase function depends on nothing else; its values are per steradian and integrate to 1 over
//! all directions, in each channel.

use std::f32::consts::{PI, TAU};
use std::path::{Path, PathBuf};

use glam::Vec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::OpticsError;
use crate::error::checked;

mod henyey_greenstein;
mod hybrid;
mod rayleigh;
mod schlick;
mod table;
mod text;

pub use hybrid::BackLobe;
pub use table::{PhaseEntries, PhaseTable, TableAngles};
pub use text::PhaseTextError;

/// The strongest anisotropy: beyond it single precision resolves the peak no longer.
pub const MOST_ANISOTROPY: f32 = 0.99;

/// How a medium scatters, as written in a document.
///
/// `g` is the anisotropy, from -0.99 (back where it came from) over 0 (all around) to 0.99 (straight
/// on). A [`Scattering`](crate::Scattering) may give another one at every data value, which replaces
/// that of the variants that have a single `g`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub enum Phase {
    /// The same in all directions (default).
    #[default]
    Isotropic,
    /// Particles far smaller than a wavelength: as much back as forward, least to the side.
    Rayleigh,
    /// One lobe, whose mean cosine is `g` (6.2-3).
    HenyeyGreenstein {
        /// Anisotropy, -0.99 to 0.99.
        #[schemars(range(min = -0.99, max = 0.99))]
        g: f32,
    },
    /// The mean of two lobes, weighted: a peak forward and a weaker one back, as clouds and tissue have.
    DoubleHenyeyGreenstein {
        /// Anisotropy of the first lobe, -0.99 to 0.99.
        #[schemars(range(min = -0.99, max = 0.99))]
        first: f32,
        /// Anisotropy of the second lobe, -0.99 to 0.99.
        #[schemars(range(min = -0.99, max = 0.99))]
        second: f32,
        /// Share of the first lobe, 0 to 1.
        #[schemars(range(min = 0.0, max = 1.0))]
        share: f32,
    },
    /// Schlick's lobe, shaped to resemble that of Henyey and Greenstein with this `g`, without a power.
    Schlick {
        /// Anisotropy, -0.99 to 0.99.
        #[schemars(range(min = -0.99, max = 0.99))]
        g: f32,
    },
    /// Measured or computed values by angle, for each colour (6.2-2, 6.2-7).
    Table(PhaseTable),
    /// The lobe of Henyey and Greenstein and what is scattered back in colours: the glory (6.2-8).
    Hybrid {
        /// Anisotropy of the forward lobe, -0.99 to 0.99.
        #[schemars(range(min = -0.99, max = 0.99))]
        g: f32,
        /// What is added from 90 to 180 degrees.
        back: BackLobe,
    },
}

/// What the weights of a phase function are relative to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum PhaseNormalization {
    /// Light is conserved: the integral over all directions is 1 (default).
    #[default]
    Physical,
    /// The largest weight is 1, so that no light leaves the displayable range (6.2-4). Not conserved.
    Renormalised,
}

impl Phase {
    /// Checks every number.
    ///
    /// # Errors
    /// [`OpticsError::Parameter`] names the first that is outside its range.
    pub fn validate(&self) -> Result<(), OpticsError> {
        let most = f64::from(MOST_ANISOTROPY);
        let g = |name, g: f32| checked(name, f64::from(g), -most..=most, "-0.99 to 0.99");
        match *self {
            Self::Isotropic | Self::Rayleigh | Self::Table(_) => Ok(()),
            Self::HenyeyGreenstein { g: own } | Self::Schlick { g: own } | Self::Hybrid { g: own, .. } => g("g", own),
            Self::DoubleHenyeyGreenstein { first, second, share } => {
                g("first", first)?;
                g("second", second)?;
                checked("share", share as f64, 0.0..=1.0, "0 to 1")
            }
        }
    }

    /// The file that holds its entries, if one does.
    pub fn file(&self) -> Option<&Path> {
        match self {
            Self::Table(table) => table.file(),
            Self::Hybrid { back, .. } => back.file(),
            _ => None,
        }
    }

    /// The name of that file, to be changed.
    pub fn file_mut(&mut self) -> Option<&mut PathBuf> {
        match self {
            Self::Table(table) => table.file_mut(),
            Self::Hybrid { back, .. } => back.file_mut(),
            _ => None,
        }
    }

    /// Whether its file has yet to be read.
    pub fn is_unread(&self) -> bool {
        match self {
            Self::Table(table) => table.is_unread(),
            Self::Hybrid { back, .. } => back.is_unread(),
            _ => false,
        }
    }

    /// Takes the entries of its file; nothing changes without one.
    ///
    /// # Errors
    /// As [`PhaseTable::fill`].
    pub fn fill(&mut self, entries: &PhaseEntries) -> Result<(), OpticsError> {
        match self {
            Self::Table(table) if table.file().is_some() => table.fill(entries),
            Self::Hybrid { back, .. } if back.file().is_some() => back.fill(entries),
            _ => Ok(()),
        }
    }

    /// Its name, as in a document.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Isotropic => "isotropic",
            Self::Rayleigh => "rayleigh",
            Self::HenyeyGreenstein { .. } => "henyey_greenstein",
            Self::DoubleHenyeyGreenstein { .. } => "double_henyey_greenstein",
            Self::Schlick { .. } => "schlick",
            Self::Table(_) => "table",
            Self::Hybrid { .. } => "hybrid",
        }
    }

    /// The anisotropy, if it is a single number.
    pub fn anisotropy(&self) -> Option<f32> {
        match *self {
            Self::HenyeyGreenstein { g } | Self::Schlick { g } | Self::Hybrid { g, .. } => Some(g),
            _ => None,
        }
    }

    /// Share of the scattered light per steradian at `mu`, for each colour. `g` is the anisotropy at
    /// the sample, which phase functions without a single one ignore.
    #[inline]
    pub fn eval(&self, g: f32, mu: f32) -> [f32; 3] {
        match self {
            Self::Table(table) => table.eval(mu),
            Self::Hybrid { back, .. } => back.eval(g, mu),
            _ => [self.pdf(g, mu); 3],
        }
    }

    /// Density per steradian with which [`sample`](Self::sample) chooses a direction at `mu`: the phase
    /// function itself if it has no colour, else near the mean of its colours, and nowhere 0 where they are not.
    #[inline]
    pub fn pdf(&self, g: f32, mu: f32) -> f32 {
        match self {
            Self::Isotropic => 1.0 / (4.0 * PI),
            Self::Rayleigh => rayleigh::eval(mu),
            Self::HenyeyGreenstein { .. } => henyey_greenstein::eval(g, mu),
            Self::DoubleHenyeyGreenstein { first, second, share } => {
                share * henyey_greenstein::eval(*first, mu) + (1.0 - share) * henyey_greenstein::eval(*second, mu)
            }
            Self::Schlick { .. } => schlick::eval(g, mu),
            Self::Table(table) => mean(table.eval(mu)),
            Self::Hybrid { back, .. } => back.pdf(g, mu),
        }
    }

    /// A cosine distributed as [`pdf`](Self::pdf), from a number in 0..1.
    #[inline]
    pub fn sample(&self, g: f32, u: f32) -> f32 {
        let mu = match self {
            Self::Isotropic => 2.0 * u - 1.0,
            Self::Rayleigh => rayleigh::sample(u),
            Self::HenyeyGreenstein { .. } => henyey_greenstein::sample(g, u),
            Self::DoubleHenyeyGreenstein { first, second, share } => {
                let (is_first, u) = choose(*share, u);
                henyey_greenstein::sample(if is_first { *first } else { *second }, u)
            }
            Self::Schlick { .. } => schlick::sample(g, u),
            Self::Table(table) => table.sample(u),
            Self::Hybrid { back, .. } => back.sample(g, u),
        };
        mu.clamp(-1.0, 1.0)
    }

    /// The direction of light that travelled along the unit vector `forward` and was scattered, from
    /// two numbers in 0..1; a unit vector.
    #[inline]
    pub fn sample_direction(&self, g: f32, forward: Vec3, u: [f32; 2]) -> Vec3 {
        turned(forward, self.sample(g, u[0]), u[1])
    }

    /// The mean of `mu` over the scattered light, for each colour.
    pub fn mean_cosine(&self, g: f32) -> [f32; 3] {
        match self {
            Self::Isotropic | Self::Rayleigh => [0.0; 3],
            Self::HenyeyGreenstein { .. } => [g; 3],
            Self::DoubleHenyeyGreenstein { first, second, share } => [share * first + (1.0 - share) * second; 3],
            Self::Schlick { .. } => [schlick::mean_cosine(g); 3],
            Self::Table(table) => table.mean_cosine(),
            Self::Hybrid { back, .. } => back.mean_cosine(g),
        }
    }

    /// The factor of a light's radiance where its light is scattered once.
    ///
    /// Lights are as bright as in [`blinn_phong`](crate::blinn_phong): one of intensity 1 makes a white
    /// surface that faces it look white, and so brings pi units of light per area. Hence the physical
    /// factor is `pi P`. Renormalised it is `P` over its largest value (6.2-4), and tables keep the
    /// ratios of their colours.
    #[inline]
    pub fn weight(&self, normalization: PhaseNormalization, g: f32, mu: f32) -> [f32; 3] {
        match (normalization, self) {
            (PhaseNormalization::Physical, _) => self.eval(g, mu).map(|v| v * PI),
            (_, Self::Table(table)) => table.renormalised(mu),
            (_, Self::Hybrid { back, .. }) => back.renormalised(g, mu),
            _ => [self.pdf(g, mu) / self.peak(g); 3],
        }
    }

    /// The largest value over all angles, of phase functions without colour.
    fn peak(&self, g: f32) -> f32 {
        let end = |mu| self.pdf(g, mu);
        match self {
            // Each lobe is largest forward or back, and convex in between: so is their mean.
            Self::DoubleHenyeyGreenstein { .. } | Self::Rayleigh => end(1.0).max(end(-1.0)),
            _ => end(if g < 0.0 { -1.0 } else { 1.0 }),
        }
    }
}

/// Mean of three colours.
fn mean([r, g, b]: [f32; 3]) -> f32 {
    (r + g + b) / 3.0
}

/// Whether `u` is within `share`, and the number in 0..1 that is left of it.
#[inline]
fn choose(share: f32, u: f32) -> (bool, f32) {
    if u < share { (true, u / share) } else { (false, (u - share) / (1.0 - share)) }
}

/// The unit vector at an angle of cosine `mu` from the unit vector `axis`, a share `turn` of a full
/// turn around it.
#[inline]
pub fn turned(axis: Vec3, mu: f32, turn: f32) -> Vec3 {
    let (side, up) = axis.any_orthonormal_pair();
    let (sin, cos) = (TAU * turn).sin_cos();
    let across = (1.0 - mu * mu).max(0.0).sqrt();
    (axis * mu + (side * cos + up * sin) * across).normalize()
}

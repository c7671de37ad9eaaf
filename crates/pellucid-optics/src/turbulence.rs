//! Noise of several octaves on the voxels of a grid, and what it does: displace and vary.
//!
//! These are the formulas of both backends, for one position; positions are continuous voxel indices.

use std::sync::Arc;

use pellucid_field::{Grid, Noise};

use crate::{Octave, Perturbation, correct_associated};

/// A sum of noises (Eq. 12.2, K-21), made ready for the voxels of a grid.
#[derive(Clone, Debug)]
pub struct Turbulence {
    noise: Arc<Noise>,
    terms: Vec<Term>,
}

/// One noise of a [`Turbulence`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Term {
    /// Texels of the noise per voxel, along each axis.
    pub scale: [f32; 3],
    /// The texel at voxel 0, at least 0 and less than 32.
    pub start: [f32; 3],
    /// Factor.
    pub weight: f32,
}

impl Turbulence {
    /// Octaves over a grid: a frequency is periods over its longest side, along its axes.
    pub fn new(noise: Arc<Noise>, octaves: &[Octave], grid: &Grid) -> Self {
        let (spacing, longest) = (grid.spacing(), longest_side(grid));
        let texels = Noise::SIZE as f64;
        let term = |octave: &Octave| Term {
            scale: spacing.map(|length| (length / longest * f64::from(octave.frequency) * texels) as f32),
            // Whole periods are taken off before anything is rounded: they change no bit.
            start: octave.offset.map(|offset| (offset.rem_euclid(1.0) * texels) as f32),
            weight: octave.weight,
        };
        let terms = octaves.iter().filter(|octave| octave.weight != 0.0).map(term).collect();
        Self { noise, terms }
    }

    /// The noise.
    pub fn noise(&self) -> &Noise {
        &self.noise
    }

    /// What adds up.
    pub fn terms(&self) -> &[Term] {
        &self.terms
    }

    /// No channel of the sum is further from 0.
    pub fn bound(&self) -> f32 {
        self.terms.iter().map(|term| term.weight.abs()).sum()
    }

    /// The sum at a position, of four channels.
    pub fn at(&self, index: [f32; 3]) -> [f32; 4] {
        let mut sum = [0.0; 4];
        for term in &self.terms {
            let place = [0, 1, 2].map(|axis| index[axis] * term.scale[axis] + term.start[axis]);
            for (sum, channel) in sum.iter_mut().zip(self.noise.signed(place)) {
                *sum += term.weight * channel;
            }
        }
        sum
    }
}

fn longest_side(grid: &Grid) -> f64 {
    let (low, high) = grid.index_bounds();
    let (spacing, cells) = (grid.spacing(), (high - low).to_array());
    (0..3).map(|axis| spacing[axis] * cells[axis]).fold(0.0, f64::max)
}

/// A displacement on a grid (K-24).
#[derive(Clone, Debug)]
pub struct Displacer {
    turbulence: Turbulence,
    /// Voxels that a noise of 1 moves by, along each axis.
    pub amplitude: [f32; 3],
    /// Voxels that nothing moves further than.
    pub reach: [f32; 3],
    /// The lowest position of the grid's box.
    pub low: [f32; 3],
    /// The highest.
    pub high: [f32; 3],
    /// Data values at which nothing and everything moves, if that depends on it.
    pub between: Option<[f32; 2]>,
    /// Voxels between a position and the taps of its gradient, along each axis.
    pub spacing: [f32; 3],
}

impl Displacer {
    /// That of a perturbation, if it displaces at all.
    pub fn new(perturbation: &Perturbation, noise: &Arc<Noise>, grid: &Grid) -> Option<Self> {
        let settings = &perturbation.displacement;
        perturbation.displaces().then(|| {
            let turbulence = Turbulence::new(noise.clone(), &settings.octaves, grid);
            let (spacing, longest) = (grid.spacing(), longest_side(grid));
            let amplitude = spacing.map(|length| (f64::from(settings.amplitude) * longest / length) as f32);
            let (low, high) = grid.index_bounds();
            let finest = |axis: usize| turbulence.terms.iter().map(|term| term.scale[axis]).fold(0.0, f32::max);
            Self {
                amplitude,
                reach: amplitude.map(|voxels| voxels * turbulence.bound()),
                low: low.as_vec3().to_array(),
                high: high.as_vec3().to_array(),
                between: settings.between,
                spacing: [0, 1, 2].map(|axis| finest(axis).recip().clamp(1.0 / 16.0, 1.0)),
                turbulence,
            }
        })
    }

    /// The noise that displaces.
    pub fn turbulence(&self) -> &Turbulence {
        &self.turbulence
    }

    /// The place whose value is drawn at a position inside the box, which is in the box as well. `value` is
    /// asked for the undisplaced value where the amplitude depends on it; what is absent does not move.
    pub fn source(&self, index: [f32; 3], value: impl FnOnce() -> f32) -> [f32; 3] {
        let part = self.between.map_or(1.0, |between| part(between, value()));
        if part == 0.0 {
            return index;
        }
        let noise = self.turbulence.at(index);
        [0, 1, 2].map(|axis| {
            let p = index[axis];
            // Less than the reach from a face, in proportion.
            let room = (p - self.low[axis]).min(self.high[axis] - p).max(0.0) / self.reach[axis];
            p + self.amplitude[axis] * part * room.min(1.0) * noise[axis]
        })
    }
}

/// The part of the amplitude at a data value: smoothstep from the first to the second; 0 where it is absent.
fn part([none, full]: [f32; 2], value: f32) -> f32 {
    let t = (value - none) / (full - none);
    // Absent values are neither.
    if !(t > 0.0 && value.is_finite()) {
        return 0.0;
    }
    let t = t.min(1.0);
    t * t * (3.0 - 2.0 * t)
}

/// A variation of optical properties on a grid (K-23).
#[derive(Clone, Debug)]
pub struct Variation {
    turbulence: Turbulence,
    /// How much extinction, colour and transport vary, 0 to 1.
    pub weights: [f32; 3],
}

impl Variation {
    /// That of a perturbation, if anything varies at all.
    pub fn new(perturbation: &Perturbation, noise: &Arc<Noise>, grid: &Grid) -> Option<Self> {
        let settings = &perturbation.optics;
        perturbation.varies().then(|| Self {
            turbulence: Turbulence::new(noise.clone(), &settings.octaves, grid),
            weights: [settings.opacity, settings.color, settings.transport],
        })
    }

    /// The noise that varies.
    pub fn turbulence(&self) -> &Turbulence {
        &self.turbulence
    }

    /// The noise at a position, within -1 and 1.
    pub fn at(&self, index: [f32; 3]) -> [f32; 4] {
        self.turbulence.at(index).map(|noise| noise.clamp(-1.0, 1.0))
    }

    /// The least factor of an extinction: full opacity, which is an infinite extinction, stays what it is.
    pub const LEAST: f32 = 1e-6;

    /// The factor of the extinction under a noise, up to 2: by its fourth channel.
    pub fn extinction(&self, noise: [f32; 4]) -> f32 {
        (1.0 + self.weights[0] * noise[3]).max(Self::LEAST)
    }

    /// The most that [`extinction`](Self::extinction) can be.
    pub fn most_extinction(&self) -> f32 {
        1.0 + self.weights[0] * self.turbulence.bound().min(1.0)
    }

    /// The least that [`extinction`](Self::extinction) can be.
    pub fn least_extinction(&self) -> f32 {
        (1.0 - self.weights[0] * self.turbulence.bound().min(1.0)).max(Self::LEAST)
    }

    /// A colour that is not associated, under a noise: each channel times 1 and more or less, at most 1.
    pub fn color(&self, noise: [f32; 4], color: [f32; 3]) -> [f32; 3] {
        [0, 1, 2].map(|c| (color[c] * (1.0 + self.weights[1] * noise[c])).min(color[c].max(1.0)))
    }

    /// An associated colour and its opacity under a noise.
    pub fn associated(&self, noise: [f32; 4], rgba: [f32; 4]) -> [f32; 4] {
        let [r, g, b, opacity] = correct_associated(rgba, self.extinction(noise));
        let varied = |c: usize, color: f32| (color * (1.0 + self.weights[1] * noise[c])).min(color.max(opacity));
        [varied(0, r), varied(1, g), varied(2, b), opacity]
    }

    /// What gets through of indirect light, under a noise: its attenuation varies as extinction does, by the
    /// first three channels.
    pub fn transport(&self, noise: [f32; 4], transmittance: [f32; 3]) -> [f32; 3] {
        [0, 1, 2].map(|c| transmittance[c].powf(1.0 + self.weights[2] * noise[c]))
    }
}

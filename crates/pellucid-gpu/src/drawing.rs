//! How frames are drawn, whichever technique draws them.

use std::fmt;

/// How the field is interpolated between voxels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Interpolation {
    /// In the shader, in single precision: agrees with the CPU backend.
    Exact,
    /// By the texture unit, whose positions have some 8 bits between voxels: fast. Falls back to
    /// [`Interpolation::Exact`] where voxels are absent or the format cannot be filtered.
    #[default]
    Hardware,
}

impl fmt::Display for Interpolation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Exact => "exact",
            Self::Hardware => "hardware",
        })
    }
}

/// How the work of a frame is handed to the device.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Passes {
    /// Every ray from its entry to its end at once (7.2), in bands of the picture that take a few
    /// hundredths of a second.
    #[default]
    Single,
    /// All rays for a while, then those that are not done (7.4): the picture is the same to the bit, no
    /// submission is long whatever rays meet, and rays that have ended cost nothing. Volumes in bricks
    /// are drawn brick by brick instead.
    Wavefront,
}

/// How frames are drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Drawing {
    pub interpolation: Interpolation,
    pub passes: Passes,
}

//! How what several volumes send along a ray becomes one.

use pellucid_scene::{Mode, Overlap, Stage};

/// What lies where rays meet several volumes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Merging {
    /// Light of all, each as if it were alone: of what shows values along whole rays, which are nowhere in particular.
    Sum,
    /// Matter, by the rule of the stage.
    Overlap(Overlap),
}

impl Merging {
    /// What a stage asks for.
    pub fn of(stage: &Stage) -> Self {
        match (stage.mode(), stage.overlap) {
            // Light without matter overlaps with nothing.
            (Mode::Additive, _) => Self::Sum,
            // What an X-ray has passed is matter: its extinctions add.
            (Mode::Composite | Mode::Isosurface(_) | Mode::XRay, overlap) => Self::Overlap(overlap),
            (_, Overlap::Add) => Self::Sum,
            (_, overlap) => Self::Overlap(overlap),
        }
    }
}

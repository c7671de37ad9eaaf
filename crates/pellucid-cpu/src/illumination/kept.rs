//! Light that is kept.

use std::sync::Arc;

use pellucid_field::Volume;

use super::bricks::Bricks;
use super::lattice::Lattice;
use super::level_grids::LevelGrids;

/// What is kept of light.
pub struct Kept {
    /// The volume whose surfaces it lights.
    pub volume: Arc<Volume>,
    /// What rays leap over.
    pub grids: Option<Arc<LevelGrids>>,
    /// The places, if any are kept.
    pub lattice: Option<Lattice>,
    /// The coefficients of light of a colour, if they know what becomes of light from far away.
    pub coefficients: Option<usize>,
    /// Paths from a place whose light is known.
    pub paths: u32,
    /// The surfaces that they are on.
    pub surfaces: Vec<Surface>,
}

/// Light of a lattice's places on a surface that is drawn, or each on its own.
pub struct Surface {
    /// The isovalue, if it is the same for all.
    pub level: Option<f32>,
    /// Light on the side of lower values, and on the other.
    pub sides: [Bricks; 2],
}

impl Kept {
    /// The sides of surfaces of whose places anything is known.
    pub fn touched(&self) -> impl Iterator<Item = (&Surface, usize)> {
        let sides = self.surfaces.iter().flat_map(|surface| [(surface, 0), (surface, 1)]);
        sides.filter(|(surface, side)| surface.sides[*side].are_touched())
    }

    /// The surface of an isovalue.
    pub fn surface(&self, level: f32) -> Option<&Surface> {
        self.surfaces.iter().find(|surface| surface.level.is_none_or(|of| of == level))
    }

    /// Whether it is of that volume.
    pub fn is_of(&self, volume: &Arc<Volume>) -> bool {
        Arc::ptr_eq(&self.volume, volume)
    }
}

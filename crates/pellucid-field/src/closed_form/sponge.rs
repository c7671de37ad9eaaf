//! A ball of sponge.

use glam::DVec3;

use super::dice::Dice;
use super::footprint::{Footprint, inside};
use super::formula::value_and_gradient;
use super::number::Number;
use super::shape::{either, length, position, relative};
use super::{About, ScalarField};
use crate::VoxelType;

pub(super) const NAME: &str = "sponge";

const RADIUS: f64 = 0.86;
/// Least distance between the middles of two cells.
const APART: f64 = 0.3;
/// Radius of the smallest cell, and how much larger the largest is.
const SMALLEST: f64 = 0.17;
const VARIES: f64 = 0.05;
/// The width over which density falls.
const EDGE: f64 = 0.06;

/// A ball with many round cells that open into each other and outwards, on [-1, 1]^3: from 1 inside to 0 outside, the
/// surface at 1/2. Deep in its cavities light arrives only from wall to wall.
#[derive(Clone, Debug)]
pub struct Sponge {
    /// Middles and radii.
    cells: Vec<(DVec3, f64)>,
}

impl Default for Sponge {
    /// Cells wherever there is room for one, by chance.
    fn default() -> Self {
        let mut dice = Dice(7);
        let mut cells: Vec<(DVec3, f64)> = vec![];
        for _ in 0..20_000 {
            let middle = DVec3::new(dice.roll(), dice.roll(), dice.roll());
            let radius = SMALLEST + VARIES * (0.5 + 0.5 * dice.roll());
            if middle.length() < RADIUS && cells.iter().all(|cell| cell.0.distance(middle) > APART) {
                cells.push((middle, radius));
            }
        }
        Self { cells }
    }
}

impl Sponge {
    fn formula<N: Number>(&self, p: [N; 3], seen: Footprint) -> N {
        let edge = seen.smooth_edge(EDGE);
        let ball = inside(length(p) - RADIUS, edge);
        if ball.value() == 0.0 {
            return ball;
        }
        let at = position(p);
        let near = self.cells.iter().filter(|cell| cell.0.distance_squared(at) < (cell.1 + edge / 2.0).powi(2));
        // Shares, not distances: walls thinner than an edge are as faint as they should be, and windows are round.
        let hollow = near.fold(N::constant(0.0), |hollow, &(middle, radius)| {
            either(hollow, inside(length(relative(p, middle)) - radius, edge))
        });
        ball * (-hollow + 1.0)
    }
}

impl ScalarField for Sponge {
    value_and_gradient!(edges);

    fn bounds(&self) -> (DVec3, DVec3) {
        (DVec3::NEG_ONE, DVec3::ONE)
    }

    fn range(&self) -> (f64, f64) {
        (0.0, 1.0)
    }

    fn about(&self) -> About {
        About {
            name: NAME,
            description: "a ball of sponge, level 0.5: deep cavities that open into each other",
            dims: [128; 3],
            voxel_type: VoxelType::U8,
            value_unit: None,
            length_unit: None,
            whole_units: false,
        }
    }
}

//! A machined casting.

use glam::DVec3;

use super::footprint::Footprint;
use super::formula::value_and_gradient;
use super::number::Number;
use super::shape::{either, join, position, relative, rounded_cuboid};
use super::{About, ScalarField};
use crate::VoxelType;

pub(super) const NAME: &str = "engine";

/// Values.
const WALL: f64 = 0.45;
const SLEEVE: f64 = 0.9;
const EDGE: f64 = 1.0;
/// Rounding of what is cast where two parts meet.
const FILLET: f64 = 8.0;
/// Where the bores are along y, and how wide.
const BORES: [f64; 2] = [-42.0, 42.0];
const BORE: f64 = 23.0;

/// Cylinders by axis, middle, half their length and radius.
type Drum = (usize, [f64; 3], f64, f64);

/// What sticks out of the block: a collar around each bore, a boss on one side and a stud on the other.
const BOSSES: [Drum; 4] = [
    (2, [0.0, BORES[0], 50.0], 18.0, 34.0),
    (2, [0.0, BORES[1], 50.0], 18.0, 34.0),
    (0, [-40.0, 0.0, 14.0], 12.0, 16.0),
    (0, [40.0, 58.0, 30.0], 9.0, 9.0),
];

/// What lines the bores, from above the collars down to where the hollow is near.
const SLEEVES: [Drum; 2] = [(2, [0.0, BORES[0], 28.0], 52.0, BORE + 4.0), (2, [0.0, BORES[1], 28.0], 52.0, BORE + 4.0)];

/// What is drilled: the bores; oil channels along the block, across it to the boss, and up; bolt holes in the deck and
/// in the flange.
const DRILLED: [Drum; 18] = [
    (2, [0.0, BORES[0], 20.0], 90.0, BORE),
    (2, [0.0, BORES[1], 20.0], 90.0, BORE),
    (1, [-32.0, 0.0, 14.0], 110.0, 4.0),
    (1, [32.0, 0.0, -14.0], 70.0, 4.0),
    (0, [-22.0, 0.0, 14.0], 34.0, 6.0),
    (2, [0.0, 0.0, 45.0], 31.0, 5.0),
    (2, [-32.0, -78.0, 48.0], 20.0, 4.0),
    (2, [32.0, -78.0, 48.0], 20.0, 4.0),
    (2, [-32.0, 78.0, 48.0], 20.0, 4.0),
    (2, [32.0, 78.0, 48.0], 20.0, 4.0),
    (2, [-32.0, 0.0, 48.0], 20.0, 4.0),
    (2, [32.0, 0.0, 48.0], 20.0, 4.0),
    (2, [-45.0, -88.0, -60.0], 20.0, 3.5),
    (2, [45.0, -88.0, -60.0], 20.0, 3.5),
    (2, [-45.0, 0.0, -60.0], 20.0, 3.5),
    (2, [45.0, 0.0, -60.0], 20.0, 3.5),
    (2, [-45.0, 88.0, -60.0], 20.0, 3.5),
    (2, [45.0, 88.0, -60.0], 20.0, 3.5),
];

/// A block with two bores in harder sleeves, oil channels, bolt holes, a flange and a hollow below, in a box of
/// 109 x 207 x 148: stands in for the CT of an engine block, with as many voxels. Values are 0 (air), 0.45 (block) and
/// 0.9 (sleeves).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Engine;

impl Engine {
    fn formula<N: Number>(&self, p: [N; 3], seen: Footprint) -> N {
        let cast = seen.inside(casting(p), EDGE);
        if cast.value() == 0.0 {
            return cast;
        }
        let inside =
            |drums: &[Drum]| drums.iter().fold(N::constant(0.0), |all, drum| either(all, share(p, *drum, seen)));
        let (lining, holes) = (inside(&SLEEVES), inside(&DRILLED));
        cast * (lining * (SLEEVE - WALL) + WALL) * (-holes + 1.0)
    }
}

/// Distance to what is cast: the block and what sticks out of it, the flange, all of it hollow below.
fn casting<N: Number>(p: [N; 3]) -> N {
    let block = rounded_cuboid(p, DVec3::new(0.0, 0.0, 5.0), DVec3::new(41.0, 90.0, 55.0), 8.0);
    let flange = rounded_cuboid(p, DVec3::new(0.0, 0.0, -56.0), DVec3::new(52.0, 98.0, 8.0), 3.0);
    let solid =
        BOSSES.into_iter().fold(join(block, flange, FILLET), |solid, drum| join(solid, cylinder(p, drum), FILLET));
    let hollow = rounded_cuboid(p, DVec3::new(0.0, 0.0, -60.0), DVec3::new(31.0, 80.0, 26.0), 8.0);
    solid.max(-hollow)
}

/// Distance to a cylinder with flat ends.
fn cylinder<N: Number>(p: [N; 3], (axis, middle, half, radius): Drum) -> N {
    let q = relative(p, DVec3::from_array(middle));
    let [a, b] = [q[(axis + 1) % 3], q[(axis + 2) % 3]];
    ((a.square() + b.square()).sqrt() - radius).max(q[axis].abs() - half)
}

/// Share of a voxel inside a cylinder, cheap where there is nothing.
fn share<N: Number>(p: [N; 3], drum: Drum, seen: Footprint) -> N {
    let (axis, middle, half, radius) = drum;
    let mut reach = DVec3::splat(radius);
    reach[axis] = half;
    if (position(p) - DVec3::from_array(middle)).abs().cmpgt(reach + seen.edge(EDGE)).any() {
        return N::constant(0.0);
    }
    seen.inside(cylinder(p, drum), EDGE) * seen.thin([radius; 2], EDGE)
}

impl ScalarField for Engine {
    value_and_gradient!(edges);

    fn bounds(&self) -> (DVec3, DVec3) {
        (DVec3::new(-54.5, -103.5, -74.0), DVec3::new(54.5, 103.5, 74.0))
    }

    fn range(&self) -> (f64, f64) {
        (0.0, SLEEVE)
    }

    fn about(&self) -> About {
        About {
            name: NAME,
            description: "a machined casting of two materials: stands in for the CT of an engine block",
            dims: [110, 208, 149],
            voxel_type: VoxelType::U8,
            value_unit: None,
            length_unit: None,
            whole_units: false,
        }
    }
}

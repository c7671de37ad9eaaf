//! Vessels and bone: what a CT angiogram is made of.

use std::f64::consts::{PI, TAU};

use glam::{DQuat, DVec3};

use super::dice::Dice;
use super::footprint::Footprint;
use super::formula::value_and_gradient;
use super::number::Number;
use super::shape::{Bundle, Path, blob, common, ellipsoid};
use super::{About, ScalarField};
use crate::VoxelType;

pub(super) const NAME: &str = "tubes";

/// Values, as shares of the brightest.
const TISSUE: f64 = 0.15;
const VESSEL: f64 = 0.6;
const BONE: f64 = 1.0;
const EDGE: f64 = 0.02;
/// Half the thickness of the shell.
const SHELL: f64 = 0.025;
const SKULL: DVec3 = DVec3::new(0.80, 0.94, 0.84);

/// A tree of bright, ever thinner tubes in dark tissue, held by a brighter shell that is open
/// above and in front, on [-1, 1]^3: stands in for a CT angiogram of the head. Values are 0 (air),
/// 0.15 (tissue), 0.6 (vessels) and 1 (shell).
#[derive(Clone, Debug)]
pub struct Tubes {
    vessels: Bundle,
}

impl Default for Tubes {
    fn default() -> Self {
        let mut vessels = vec![];
        for (side, x) in [(-1.0, -0.16), (1.0, 0.16)] {
            let root = Twig {
                from: DVec3::new(x, 0.1, -0.98),
                along: DVec3::new(0.3 * side, -0.1, 1.0),
                radius: 0.045,
                level: 0,
            };
            grow(root, &mut Dice(if side < 0.0 { 3 } else { 21 }), &mut vessels);
        }
        Self { vessels: Bundle::new(&vessels) }
    }
}

/// The beginning of a tube.
struct Twig {
    from: DVec3,
    along: DVec3,
    radius: f64,
    level: u32,
}

/// A twig of four bends, then two more from its tip, until they are about as thin as three voxels
/// of a grid of 256.
fn grow(twig: Twig, dice: &mut Dice, vessels: &mut Vec<Path>) {
    let Twig { from, along, radius, level } = twig;
    let length = if level == 0 { 0.5 } else { 0.42 * 0.86f64.powi(level as i32) };
    let taper = 0.80;
    let (mut tip, mut along) = (from, along.normalize());
    let mut points = vec![(tip, radius)];
    for bend in 1..=4 {
        let sway = DVec3::new(dice.roll(), dice.roll(), dice.roll()) * if level == 0 { 0.08 } else { 0.28 };
        // Close to the bone, vessels turn and follow it.
        let outward = tip / SKULL;
        let near = ((outward.length() - 0.6) / 0.2).clamp(0.0, 1.0) * f64::from(level.min(1));
        let normal = (outward / SKULL).normalize_or_zero();
        along = (along + sway - normal * near * (along.dot(normal) + 0.1).max(0.0)).normalize();
        tip += along * length / 4.0;
        points.push((tip, radius * (1.0 + (taper - 1.0) * f64::from(bend) / 4.0)));
    }
    let smooth: Vec<[f64; 4]> = points.iter().map(|&(p, r)| [p.x, p.y, p.z, r]).collect();
    vessels.push(Path::smooth(&smooth));
    if level == 6 {
        return;
    }
    let turn = dice.roll() * PI;
    for (side, spread, thinner) in [(0.0, 0.35, 0.80), (0.5, 0.6, 0.66)] {
        let axis = DQuat::from_axis_angle(along, turn + side * TAU) * along.any_orthonormal_vector();
        let along = DQuat::from_axis_angle(axis, spread + 0.2 * dice.roll()) * along;
        grow(Twig { from: tip, along, radius: radius * thinner, level: level + 1 }, dice, vessels);
    }
}

impl Tubes {
    fn formula<N: Number>(&self, p: [N; 3], seen: Footprint) -> N {
        let tissue = blob(p, [0.0; 3], (SKULL - 0.03).to_array(), EDGE, seen) * TISSUE;
        let vessels = self.vessels.inside(p, EDGE, seen);
        let skull = ellipsoid(p, DVec3::ZERO, SKULL).abs() - SHELL;
        // Open above a plane that rises towards the back (+y).
        let open = (p[2] - p[1] * 0.7 - 0.02) * 0.82;
        let shell = seen.inside(common(skull, open, 0.03), EDGE) * seen.thin([SHELL], EDGE);
        tissue.mix(N::constant(BONE), shell).mix(N::constant(VESSEL), vessels)
    }
}

impl ScalarField for Tubes {
    value_and_gradient!(edges);

    fn bounds(&self) -> (DVec3, DVec3) {
        (DVec3::NEG_ONE, DVec3::ONE)
    }

    fn range(&self) -> (f64, f64) {
        (0.0, BONE)
    }

    fn about(&self) -> About {
        About {
            name: NAME,
            description: "a tree of thin bright tubes and a brighter shell: stands in for a CT angiogram",
            dims: [256; 3],
            voxel_type: VoxelType::U8,
            value_unit: None,
            length_unit: None,
            whole_units: false,
        }
    }
}

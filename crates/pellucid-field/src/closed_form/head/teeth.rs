//! Teeth: thirty-one of them.

use glam::{DVec2, DVec3};

use super::super::number::Number;
use super::super::shape::{blob, join, length, position, relative, rod};
use super::{EDGE, Tissue, hu};

/// Widths along the arch from the middle to the back, in millimetres.
const UPPER: [f64; 7] = [8.6, 6.8, 7.6, 7.0, 6.8, 10.2, 9.6];
const LOWER: [f64; 8] = [5.6, 6.1, 7.0, 7.1, 7.2, 11.0, 10.4, 9.6];
/// Height between the crowns.
const BITE: f64 = -71.0;

/// One tooth, its crown turned along the arch.
#[derive(Clone, Debug)]
pub(super) struct Tooth {
    /// Middle of the crown.
    crown: DVec3,
    /// Direction along the arch.
    along: DVec2,
    radii: DVec3,
    /// Tips of its roots.
    roots: Vec<DVec3>,
}

/// Every tooth of both jaws; the first lower molar on the right (-x) is missing.
pub(super) fn all() -> Vec<Tooth> {
    let mut teeth = vec![];
    for side in [-1.0, 1.0] {
        arch(&UPPER, side, 1.0, DVec2::new(28.0, 42.0), &mut teeth);
        let before = teeth.len();
        arch(&LOWER, side, -1.0, DVec2::new(27.0, 41.0), &mut teeth);
        if side < 0.0 {
            teeth.remove(before + 5);
        }
    }
    teeth
}

/// Half an arch: teeth side by side on an ellipse whose middle lies at y = -43.
fn arch(widths: &[f64], side: f64, up: f64, radii: DVec2, teeth: &mut Vec<Tooth>) {
    let on_arch = |t: f64| DVec2::new(radii.x * t.sin() * side, -43.0 - radii.y * t.cos());
    let (mut t, mut last) = (0.0, on_arch(0.0));
    let mut walk = |distance: f64| {
        let mut left = distance;
        while left > 0.0 {
            t += 1e-3;
            let next = on_arch(t);
            left -= next.distance(last);
            last = next;
        }
        (last, on_arch(t + 1e-3) - last)
    };
    for (i, width) in widths.iter().enumerate() {
        let (middle, along) = walk(width / 2.0);
        walk(width / 2.0);
        let molar = i >= 5;
        let (deep, tall) = if molar {
            (5.0, 3.9)
        } else if i >= 3 {
            (4.2, 4.3)
        } else {
            (3.4, 5.2)
        };
        let crown = middle.extend(BITE + up * (tall - 0.2));
        let along = along.normalize();
        let tip = up * (if i == 2 { 17.0 } else { 14.0 });
        let spread: &[f64] = if molar { &[-2.4, 2.4] } else { &[0.0] };
        let roots = spread.iter().map(|s| crown + (along * *s).extend(tip)).collect();
        teeth.push(Tooth { crown, along, radii: DVec3::new(width / 2.0 + 0.05, deep, tall), roots });
    }
}

/// Distance to a crown: a box with well rounded edges.
fn crown<N: Number>(q: [N; 3], radii: DVec3) -> N {
    let round = radii.min_element() * 0.75;
    let flat = radii - round;
    let over = |axis: usize| (q[axis].abs() - flat[axis]).max(N::constant(0.0));
    length([over(0), over(1), over(2)]) - round
}

pub(super) fn paint<N: Number>(tissue: &mut Tissue<N>, teeth: &[Tooth]) {
    let at = position(tissue.p);
    if !(-100.0..-40.0).contains(&at.z) || at.y > -20.0 {
        return;
    }
    for tooth in teeth {
        if (at - tooth.crown).abs().cmpgt(DVec3::new(9.0, 9.0, 21.0)).any() {
            continue;
        }
        let q = relative(tissue.p, tooth.crown);
        // Into the frame of the tooth: along the arch, across it, up.
        let u = q[0] * tooth.along.x + q[1] * tooth.along.y;
        let w = q[1] * tooth.along.x - q[0] * tooth.along.y;
        let local = [u, w, q[2]];
        let root = tooth.roots.iter().fold(N::constant(30.0), |root, tip| {
            let start = DVec3::new(tip.x, tip.y, tooth.crown.z);
            join(root, rod(tissue.p, (start, 2.7), (*tip, 1.1)), 2.0)
        });
        tissue.fill(hu::DENTIN, root, EDGE);
        tissue.fill(hu::ENAMEL, crown(local, tooth.radii), EDGE);
        let dentin = tooth.radii - 1.5;
        tissue.fill(hu::DENTIN, crown(local, dentin), EDGE);
        tissue.paint(hu::PULP, blob(local, [0.0; 3], [0.9, 0.9, 2.2], EDGE, tissue.seen));
    }
}

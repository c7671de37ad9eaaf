//! Shapes as signed distances (negative inside), and what becomes of them in a field.

use glam::DVec3;

use super::footprint::{Footprint, inside};
use super::number::Number;

/// `p - center`.
pub(super) fn relative<N: Number>(p: [N; 3], center: DVec3) -> [N; 3] {
    [p[0] - center.x, p[1] - center.y, p[2] - center.z]
}

/// The position without its dependence, for deciding what can be left out.
pub(super) fn position<N: Number>(p: [N; 3]) -> DVec3 {
    DVec3::from_array(p.map(N::value))
}

/// Euclidean length.
pub(super) fn length<N: Number>([x, y, z]: [N; 3]) -> N {
    (x.square() + y.square() + z.square()).sqrt()
}

/// Distance to an ellipsoid along its axes, to first order: exact on the surface and for spheres.
pub(super) fn ellipsoid<N: Number>(p: [N; 3], center: DVec3, radii: DVec3) -> N {
    let q = relative(p, center);
    let over = |k: DVec3| length([q[0] * k.x, q[1] * k.y, q[2] * k.z]);
    let level = over(radii.recip());
    // At the centre the ratio below is 0/0; any distance that deep inside serves.
    if level.value() < 1e-3 {
        return N::constant(-radii.min_element());
    }
    level * (level - 1.0) * over((radii * radii).recip()).recip()
}

/// Distance to a rod from `a` to `b` whose radius goes from `ra` to `rb`, with round ends.
pub(super) fn rod<N: Number>(p: [N; 3], (a, ra): (DVec3, f64), (b, rb): (DVec3, f64)) -> N {
    let (q, axis) = (relative(p, a), b - a);
    let along = (q[0] * axis.x + q[1] * axis.y + q[2] * axis.z) * axis.length_squared().recip();
    let t = along.clamp(0.0, 1.0);
    length([q[0] - t * axis.x, q[1] - t * axis.y, q[2] - t * axis.z]) - t * (rb - ra) - ra
}

/// Distance to a ring around the y axis through `center`: `radius` to the middle of a tube of
/// `thickness` (its radius).
pub(super) fn ring<N: Number>(p: [N; 3], center: DVec3, radius: f64, thickness: f64) -> N {
    let [x, y, z] = relative(p, center);
    let around = (x.square() + z.square()).sqrt() - radius;
    (around.square() + y.square()).sqrt() - thickness
}

/// Distance to a box along the axes, as far as a face of it would be: beyond edges and corners that is less.
pub(super) fn cuboid<N: Number>(p: [N; 3], center: DVec3, half: DVec3) -> N {
    let [x, y, z] = past_faces(p, center, half);
    x.max(y).max(z)
}

/// Distance to a box along the axes whose edges and corners are rounded.
pub(super) fn rounded_cuboid<N: Number>(p: [N; 3], center: DVec3, half: DVec3, round: f64) -> N {
    let [x, y, z] = past_faces(p, center, half - round);
    let none = N::constant(0.0);
    length([x.max(none), y.max(none), z.max(none)]) + x.max(y).max(z).min(none) - round
}

/// How far beyond the faces of a box, by axis.
fn past_faces<N: Number>(p: [N; 3], center: DVec3, half: DVec3) -> [N; 3] {
    let [x, y, z] = relative(p, center);
    [x.abs() - half.x, y.abs() - half.y, z.abs() - half.z]
}

/// Union of two shapes with a fillet about `fillet` wide.
pub(super) fn join<N: Number>(a: N, b: N, fillet: f64) -> N {
    let overlap = ((a - b).abs() * -1.0 + fillet).max(N::constant(0.0));
    a.min(b) - overlap.square() * (0.25 / fillet)
}

/// What `a` and `b` have in common, with a rounded edge.
pub(super) fn common<N: Number>(a: N, b: N, fillet: f64) -> N {
    -join(-a, -b, fillet)
}

/// Share of a voxel inside an ellipsoid with an edge `own` wide, cheap where there is nothing.
pub(super) fn blob<N: Number>(p: [N; 3], center: [f64; 3], radii: [f64; 3], own: f64, seen: Footprint) -> N {
    let (center, radii, width) = (DVec3::from_array(center), DVec3::from_array(radii), seen.edge(own));
    // The distance is to first order, so an edge may reach further along a long axis.
    let reach = radii * (1.0 + width / radii.min_element());
    if (position(p) - center).abs().cmpgt(reach).any() {
        return N::constant(0.0);
    }
    inside(ellipsoid(p, center, radii), width) * seen.thin(radii.to_array(), own)
}

/// Share of a voxel inside a rod with an edge `own` wide, cheap where there is nothing.
pub(super) fn bar<N: Number>(p: [N; 3], a: (DVec3, f64), b: (DVec3, f64), own: f64, seen: Footprint) -> N {
    let (at, width) = (position(p), seen.edge(own));
    let (low, high) = ((a.0 - a.1).min(b.0 - b.1) - width, (a.0 + a.1).max(b.0 + b.1) + width);
    if at.cmplt(low).any() || at.cmpgt(high).any() {
        return N::constant(0.0);
    }
    inside(rod(p, a, b), width) * seen.thin([(a.1 + b.1) / 2.0; 2], own)
}

/// Share inside either of two things of which nothing more is known: a union without creases.
pub(super) fn either<N: Number>(a: N, b: N) -> N {
    a + b - a * b
}

/// A bent tube: rods through its points, in order.
#[derive(Clone, Debug)]
pub(super) struct Path {
    points: Vec<(DVec3, f64)>,
    low: DVec3,
    high: DVec3,
}

impl Path {
    /// A tube through points given as x, y, z and radius there.
    pub fn new(points: &[[f64; 4]]) -> Self {
        Self::through(points.iter().map(|&[x, y, z, r]| (DVec3::new(x, y, z), r)).collect())
    }

    /// A tube through points with radii, drawn smoothly (Catmull-Rom, four rods per span).
    pub fn smooth(points: &[[f64; 4]]) -> Self {
        let at = |i: isize| glam::DVec4::from_array(points[i.clamp(0, points.len() as isize - 1) as usize]);
        let mut fine = vec![];
        for span in 0..points.len() as isize - 1 {
            let [a, b, c, d] = [at(span - 1), at(span), at(span + 1), at(span + 2)];
            for t in [0.0, 0.25, 0.5, 0.75] {
                let slope = (c - a) + (2.0 * a - 5.0 * b + 4.0 * c - d) * t + (3.0 * (b - c) + d - a) * t * t;
                fine.push((b + 0.5 * t * slope).to_array());
            }
        }
        fine.extend(points.last());
        Self::new(&fine)
    }

    /// A tube through points with radii.
    pub fn through(points: Vec<(DVec3, f64)>) -> Self {
        let low = points.iter().fold(DVec3::INFINITY, |low, &(p, r)| low.min(p - r));
        let high = points.iter().fold(DVec3::NEG_INFINITY, |high, &(p, r)| high.max(p + r));
        Self { points, low, high }
    }

    /// Distance to the tube; further off than `reach`, something between that and the distance.
    pub fn distance<N: Number>(&self, p: [N; 3], reach: f64) -> N {
        let at = position(p);
        let outside = (self.low - at).max(at - self.high).max_element();
        if outside > reach { N::constant(outside) } else { self.nearest(p).0 }
    }

    /// Distance to the tube, and its radius about there.
    fn nearest<N: Number>(&self, p: [N; 3]) -> (N, f64) {
        let far = (N::constant(f64::INFINITY), 0.0);
        self.points.windows(2).fold(far, |nearest, ends| {
            let distance = rod(p, ends[0], ends[1]);
            if distance.value() < nearest.0.value() { (distance, (ends[0].1 + ends[1].1) / 2.0) } else { nearest }
        })
    }

    /// Share of a voxel inside the tube with an edge `own` wide, cheap where there is nothing.
    pub fn inside<N: Number>(&self, p: [N; 3], own: f64, seen: Footprint) -> N {
        let (at, width) = (position(p), seen.edge(own));
        if (at + width).cmplt(self.low).any() || (at - width).cmpgt(self.high).any() {
            return N::constant(0.0);
        }
        let (distance, radius) = self.nearest(p);
        inside(distance, width) * seen.thin([radius; 2], own)
    }
}

/// Many tubes. Tubes that follow each other in the list should be neighbours in space: groups of
/// them are left out together.
#[derive(Clone, Debug)]
pub(super) struct Bundle(Vec<Group>);

#[derive(Clone, Debug)]
struct Group {
    paths: Vec<Path>,
    low: DVec3,
    high: DVec3,
}

impl Bundle {
    pub fn new(paths: &[Path]) -> Self {
        let group = |paths: &[Path]| Group {
            paths: paths.to_vec(),
            low: paths.iter().fold(DVec3::INFINITY, |low, path| low.min(path.low)),
            high: paths.iter().fold(DVec3::NEG_INFINITY, |high, path| high.max(path.high)),
        };
        Self(paths.chunks(8).map(group).collect())
    }

    /// Share of a voxel inside the union of the tubes with edges `own` wide.
    pub fn inside<N: Number>(&self, p: [N; 3], own: f64, seen: Footprint) -> N {
        let (at, width) = (position(p), seen.edge(own));
        let near = |group: &&Group| (at + width).cmpge(group.low).all() && (at - width).cmple(group.high).all();
        let paths = self.0.iter().filter(near).flat_map(|group| &group.paths);
        paths.fold(N::constant(0.0), |union, path| either(union, path.inside(p, own, seen)))
    }
}

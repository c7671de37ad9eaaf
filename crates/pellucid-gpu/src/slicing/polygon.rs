//! The polygon in which a plane cuts a box, on the processor (3.3-2).

use glam::DVec3;

/// An edge of a box: where it begins, the axis it runs along, and the two faces that meet in it, a bit each.
struct Edge {
    start: usize,
    axis: usize,
    faces: u8,
}

/// The edges, between corners whose bits say which coordinates are the high ones.
fn edges() -> impl Iterator<Item = Edge> {
    (0..3).flat_map(|axis| {
        (0..8).filter(move |corner| corner & (1 << axis) == 0).map(move |start| {
            let face = |across: usize| 1 << (2 * across + (start >> across & 1));
            Edge { start, axis, faces: face((axis + 1) % 3) | face((axis + 2) % 3) }
        })
    })
}

/// The corners of the polygon where `normal . p = offset`, in order around it: three to six, or none if the plane
/// meets less than that of the box.
///
/// Along an edge the corner moves by the same way from slice to slice (3.3-3): slices of one box differ in `offset`
/// alone, and what is divided by is the same.
pub fn polygon(low: DVec3, high: DVec3, normal: DVec3, offset: f64) -> Vec<DVec3> {
    // Corners of a box that the plane passes through come from several edges.
    let same = (high - low).max_element() * 1e-9;
    let mut open: Vec<(DVec3, u8)> = Vec::with_capacity(6);
    for Edge { start, axis, faces } in edges() {
        let bit = |axis: usize| start >> axis & 1 == 1;
        let corner = DVec3::select(glam::BVec3::new(bit(0), bit(1), bit(2)), high, low);
        let along = normal[axis];
        if along == 0.0 {
            continue;
        }
        let mut p = corner;
        p[axis] = corner[axis] + (offset - normal.dot(corner)) / along;
        if p[axis] < low[axis] - same || p[axis] > high[axis] + same {
            continue;
        }
        match open.iter_mut().find(|(other, _)| (*other - p).abs().max_element() <= same) {
            Some((_, all)) => *all |= faces,
            None => open.push((p, faces)),
        }
    }
    if open.len() < 3 {
        return Vec::new();
    }
    // Neighbours lie on a common face; where the plane is one, those that share another as well.
    let mut ordered = vec![open.swap_remove(0)];
    while !open.is_empty() {
        let (_, faces) = ordered[ordered.len() - 1];
        let next = (0..open.len()).max_by_key(|&k| (open[k].1 & faces).count_ones()).unwrap_or(0);
        ordered.push(open.swap_remove(next));
    }
    ordered.into_iter().map(|(p, _)| p).collect()
}

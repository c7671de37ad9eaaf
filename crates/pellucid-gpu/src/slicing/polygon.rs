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

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use proptest::strategy::ValueTree;
    use proptest::test_runner::TestRunner;

    /// Twice the area, along the normal if that is the way the corners turn.
    fn area(corners: &[DVec3]) -> DVec3 {
        corners.windows(2).skip(1).map(|two| (two[0] - corners[0]).cross(two[1] - corners[0])).sum()
    }

    /// The same corners, sorted by their angle around their middle.
    fn sorted(mut corners: Vec<DVec3>, normal: DVec3) -> Vec<DVec3> {
        let middle = corners.iter().sum::<DVec3>() / corners.len() as f64;
        let along = (corners[0] - middle).normalize();
        let across = normal.normalize().cross(along);
        let angle = |p: &DVec3| (*p - middle).dot(across).atan2((*p - middle).dot(along));
        corners.sort_by(|a, b| angle(a).total_cmp(&angle(b)));
        corners
    }

    #[test]
    fn a_hundred_thousand_polygons_are_convex_and_have_their_area() {
        let mut runner = TestRunner::deterministic();
        let three = |range: std::ops::Range<f64>| prop::array::uniform3(range).prop_map(DVec3::from_array);
        // Corners, faces and edges in the plane are as likely as none.
        let share = prop::array::uniform3(prop_oneof![Just(0.0), Just(1.0), -0.1..1.1f64]).prop_map(DVec3::from_array);
        let normal = prop::array::uniform3(prop_oneof![2 => -1.0..1.0f64, 1 => Just(0.0)]).prop_map(DVec3::from_array);
        let case = (three(-20.0..20.0), three(0.1..30.0), normal, share);
        let mut found = [0; 7];
        for _ in 0..100_000 {
            let (low, size, normal, share) = case.new_tree(&mut runner).unwrap().current();
            if normal == DVec3::ZERO {
                continue;
            }
            let corners = polygon(low, low + size, normal, normal.dot(low + size * share));
            found[corners.len()] += 1;
            if corners.is_empty() {
                continue;
            }
            let scale = size.max_element();
            for p in &corners {
                assert!(normal.dot(*p - low - size * share).abs() < 1e-9 * scale, "{p} is beside the plane");
                let inside = (*p - low).min_element() > -1e-6 && (low + size - *p).min_element() > -1e-6;
                assert!(inside, "{p} is outside of {low} and {size}");
            }
            let [chained, by_angle] = [area(&corners), area(&sorted(corners.clone(), normal))].map(DVec3::length);
            assert!((chained - by_angle).abs() < 1e-6 * scale * scale, "{corners:?}: {chained} for {by_angle}");
        }
        // Three to six corners, each of them often.
        assert_eq!(found[1] + found[2], 0);
        assert!(found[3..].iter().all(|&n| n > 500), "{found:?}");
    }
}

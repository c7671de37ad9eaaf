//! Where a field is: the box of its grid, and what clips leave of it.

use glam::{DAffine3, DVec3};
use pellucid_field::Grid;
use pellucid_scene::Region;

use crate::lines::Lines;

/// A convex solid, in the index space of a grid.
pub struct Solid {
    index_from_world: DAffine3,
    /// Corners of the box.
    low: DVec3,
    high: DVec3,
    half_spaces: Vec<(DVec3, f64)>,
}

impl Solid {
    /// What a region leaves of a grid's box.
    pub fn new(grid: &Grid, region: &Region) -> Self {
        let (low, high) = grid.index_bounds();
        // Rounding must not make lines along a face of the box miss it.
        let room = (high - low).max_element() * 1e-12;
        Self {
            index_from_world: grid.index_from_world(),
            low: low - room,
            high: high + room,
            half_spaces: half_spaces(grid, region).collect(),
        }
    }

    /// The first `n` lines of the world, in index space.
    #[inline(always)]
    pub fn carry<const N: usize>(&self, n: usize, world: &Lines<N>) -> Lines<N> {
        world.carried(n, &self.index_from_world)
    }

    /// Keeps what of the first `n` lines of index space lies inside.
    #[inline(always)]
    pub fn cut<const N: usize>(&self, n: usize, lines: &mut Lines<N>) {
        lines.keep_box(n, self.low, self.high);
        for (normal, offset) in &self.half_spaces {
            lines.keep_side(n, *normal, *offset);
        }
    }
}

/// The half-spaces `normal . p >= offset` of a region in a grid's index space, with normals of any length.
pub fn half_spaces(grid: &Grid, region: &Region) -> impl Iterator<Item = (DVec3, f64)> {
    let world = grid.world_from_index();
    let kept = region.half_spaces().iter();
    kept.map(move |(normal, offset)| (world.matrix3.transpose() * *normal, offset - normal.dot(world.translation)))
}

#[cfg(test)]
mod tests {
    use glam::DMat3;
    use pellucid_scene::Ray;

    use super::*;
    use crate::lanes::MOST_LANES;
    use crate::test_random::random;

    /// Half-spaces of the world, the faces of the box among them, say the same.
    #[test]
    fn lines_are_cut_where_half_spaces_of_the_world_begin_and_end() {
        let mut random = random();
        let mut vector = || DVec3::new(random(), random(), random());
        let mut met = [0; 2];
        for number in 0..200 {
            let turn = DMat3::from_cols(vector(), vector(), vector());
            if turn.determinant().abs() < 0.05 {
                continue;
            }
            let world = DAffine3::from_mat3_translation(turn, vector() * 10.0);
            let grid = Grid::with_affine([5, 8, 11], world).unwrap();
            let mut region = Region::from_clips(&[]);
            if number % 2 == 1 {
                region.keep(vector().normalize(), grid.center());
            }
            let solid = Solid::new(&grid, &region);
            let (low, high) = grid.index_bounds();
            for axis in 0..3 {
                let normal = grid.world_from_index_gradient().col(axis).normalize();
                region.keep(normal, world.transform_point3(low));
                region.keep(-normal, world.transform_point3(high));
            }
            let mut lines = Lines::<MOST_LANES>::UNDIRECTED;
            let mut rays = Vec::new();
            for lane in 0..MOST_LANES {
                let origin = grid.center() + vector() * 10.0;
                let ray = Ray { origin, direction: (grid.center() + vector() * 5.0 - origin).normalize() };
                for axis in 0..3 {
                    lines.origin[axis][lane] = ray.origin[axis];
                    lines.direction[axis][lane] = ray.direction[axis];
                }
                rays.push(ray);
            }
            let mut cut = solid.carry(MOST_LANES, &lines);
            solid.cut(MOST_LANES, &mut cut);
            for (lane, ray) in rays.iter().enumerate() {
                let expected = region.interval(ray, 0.0, f64::INFINITY).filter(|(from, to)| to - from > 1e-6);
                let [from, to] = cut.ends.map(|end| end[lane]);
                met[usize::from(expected.is_some())] += 1;
                match expected {
                    Some(ends) => assert!((from - ends.0).abs().max((to - ends.1).abs()) < 1e-9, "{ray:?}"),
                    None => assert!(to - from < 2e-6, "{ray:?}: {from} to {to}"),
                }
                let mut single = solid.carry(1, &Lines::from((ray, [0.0, f64::INFINITY])));
                solid.cut(1, &mut single);
                assert_eq!(single.ends, [[from], [to]]);
            }
        }
        assert!(met.iter().all(|count| *count > 300), "{met:?}");
    }
}

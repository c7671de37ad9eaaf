//! Where the slices lie (K-05, 6.1-3).

use glam::DVec3;
use pellucid_field::Grid;

/// The middle between the ways in which view and light travel, or between the light's and the reverse of
/// the view's if these are nearer to each other. Both cross slices by at least the cosine of 45 degrees.
pub fn slice_axis(view: DVec3, light: DVec3) -> DVec3 {
    if view.dot(light) >= 0.0 { (view + light).normalize() } else { (light - view).normalize() }
}

/// The axis nearest to this one, on the way to the light's middle direction, along which every ray of the
/// light travels: they must all meet the slices in the same order.
pub fn along_light(axis: DVec3, light: DVec3, rays: &[DVec3]) -> DVec3 {
    /// Cosine between a ray and the axis below which slices are too steep.
    const STEEPEST: f64 = 0.2;
    const TRIES: u32 = 8;
    let leaning = |share: u32| (axis * f64::from(TRIES - share) + light * f64::from(share)).normalize();
    let follows = |axis: &DVec3| rays.iter().all(|ray| ray.dot(*axis) >= STEEPEST);
    (0..TRIES).map(leaning).find(follows).unwrap_or(light)
}

/// Slabs of equal thickness across an axis, which light crosses in the order of their numbers.
#[derive(Clone, Debug)]
pub struct Slabs {
    /// Unit vector across them.
    pub axis: DVec3,
    /// Distance of the first one's front from the world's origin along the axis.
    pub front: f64,
    /// Their thickness in world units.
    pub thickness: f64,
    /// How many there are.
    pub count: usize,
    /// How many there would be as thin as asked for.
    pub asked: usize,
}

impl Slabs {
    /// Those through a grid's box; thicker than asked for where voxels are so long that they would be more than
    /// through a grid of as many cubes with the shortest side, and more than 2048.
    pub fn new(axis: DVec3, thickness: f64, grid: &Grid) -> Self {
        const FEW: f64 = 2048.0;
        let along = grid.world_corners().map(|corner| axis.dot(corner));
        let front = along.into_iter().fold(f64::INFINITY, f64::min);
        let back = along.into_iter().fold(f64::NEG_INFINITY, f64::max);
        // A remainder below the precision of the box is no slab.
        let needed = |thickness: f64| ((back - front) / thickness - 1e-9).ceil().max(1.0);
        let cubes = grid.dims().map(|n| n as f64).iter().sum::<f64>() * grid.smallest_spacing();
        let (asked, most) = (needed(thickness), (cubes / thickness).ceil().max(FEW));
        if asked <= most {
            return Self { axis, front, thickness, count: asked as usize, asked: asked as usize };
        }
        let thickness = (back - front) / most;
        Self { axis, front, thickness, count: most as usize, asked: asked as usize }
    }

    /// The number of the slab that a world position is in, and how far, 0 to 1.
    pub fn coordinate(&self, position: DVec3) -> f64 {
        (self.axis.dot(position) - self.front) / self.thickness
    }
}

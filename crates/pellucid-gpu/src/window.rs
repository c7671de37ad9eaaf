//! The part of the picture that volumes can be in.

use glam::DVec3;
use pellucid_scene::Viewpoint;

/// A rectangle of pixels; nothing of the volumes is outside of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Window {
    /// First column and row.
    pub low: [u32; 2],
    /// Columns and rows.
    pub size: [u32; 2],
}

impl Window {
    /// What is seen of boxes with these corners, and a pixel around it for roundings; all of the picture
    /// if they reach behind the eye.
    pub fn of(view: &Viewpoint, corners: impl IntoIterator<Item = DVec3>) -> Self {
        let size = [view.width as f64, view.height as f64];
        let pixel = 2.0 * view.half_height / size[1];
        let middle = [size[0] / 2.0 - view.shift.x, size[1] / 2.0 - view.shift.y];
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for corner in corners {
            let from_eye = corner - view.eye;
            let depth = from_eye.dot(view.forward);
            let unit = if view.perspective { pixel * depth } else { pixel };
            let at = [from_eye.dot(view.right) / unit + middle[0], middle[1] - from_eye.dot(view.up) / unit];
            // Where nothing can be said, everything is in question.
            if !(depth > 0.0 && at.iter().all(|v| v.is_finite())) {
                return Self { low: [0; 2], size: [view.width as u32, view.height as u32] };
            }
            for axis in 0..2 {
                low[axis] = low[axis].min(at[axis]);
                high[axis] = high[axis].max(at[axis]);
            }
        }
        let limit = |axis: usize, v: f64| v.clamp(0.0, size[axis]) as u32;
        let low = [0, 1].map(|axis| limit(axis, low[axis].floor() - 1.0));
        let high = [0, 1].map(|axis| limit(axis, high[axis].ceil() + 1.0));
        Self { low, size: [0, 1].map(|axis| high[axis] - low[axis]) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pellucid_scene::{Camera, LookAt, Projection, View};

    /// Whether a ray meets the box from -1 to 1.
    fn meets(view: &Viewpoint, column: u32, row: u32) -> bool {
        let ray = view.ray(f64::from(column) + 0.5, f64::from(row) + 0.5);
        let one = (DVec3::NEG_ONE - ray.origin) / ray.direction;
        let other = (DVec3::ONE - ray.origin) / ray.direction;
        one.min(other).max_element().max(0.0) < one.max(other).min_element()
    }

    #[test]
    fn every_ray_that_meets_the_box_is_in_it() {
        let corners: [DVec3; 8] = std::array::from_fn(|i| {
            DVec3::from_array([0, 1, 2].map(|axis| f64::from(i as i32 >> axis & 1) * 2.0 - 1.0))
        });
        let perspective = Projection::Perspective { vertical_fov: 40.0 };
        let parallel = Projection::Orthographic { height: Some(5.0) };
        for (projection, position, target, is_part) in [
            (perspective, [2.0, -7.0, 3.0], [0.0; 3], true),
            (perspective, [2.0, -7.0, 3.0], [2.0, 0.0, 1.5], true),
            (perspective, [0.2, -0.7, 0.3], [0.5, 1.0, 0.0], false),
            (perspective, [2.0, -7.0, 3.0], [4.0, -14.0, 6.0], false),
            (parallel, [2.0, -7.0, 3.0], [0.3, 0.0, 0.0], true),
        ] {
            let view = View::LookAt(LookAt { position, target, up: [0.0, 0.0, 1.0] });
            let view = Camera { projection, view, ..Camera::default() }.viewpoint(61, 47, &corners);
            let window = Window::of(&view, corners);
            assert_eq!(window.size != [61, 47], is_part, "{window:?}");
            for (column, row) in (0..47).flat_map(|row| (0..61).map(move |column| (column, row))) {
                let at: [u32; 2] = [column, row];
                let inside = (0..2).all(|axis| at[axis].wrapping_sub(window.low[axis]) < window.size[axis]);
                assert!(inside || !meets(&view, column, row), "{column}, {row} is not in {window:?}");
            }
        }
    }
}

//! The readable statement of what the ray caster computes: a page of plain f64 code straight from
//! the definitions, slow and without any acceleration. It shares the camera, the control points of
//! the transfer function and the voxel values with the engine, and nothing else: no tables, no
//! samplers, no blocks, no lattice.

use glam::DVec3;
use pellucid_field::Volume;
use pellucid_optics::Material;
use pellucid_scene::{Ray, Stage, StageVolume};

/// Trilinear interpolation between the voxels; clamped at the border.
pub fn value(volume: &Volume, p: DVec3) -> f64 {
    let n = volume.grid().dims();
    let mut sum = 0.0;
    for corner in 0..8 {
        let mut weight = 1.0;
        let mut voxel = [0; 3];
        for axis in 0..3 {
            let x = p[axis].clamp(0.0, (n[axis] - 1) as f64);
            let upper = corner >> axis & 1;
            voxel[axis] = (x.floor() as usize + upper).min(n[axis] - 1);
            let u = x - x.floor();
            weight *= if upper == 1 { u } else { 1.0 - u };
        }
        if weight > 0.0 {
            sum += weight * volume.value(voxel, 0);
        }
    }
    sum
}

/// Where a ray is inside the box and the clips, by clipping against every face's plane.
pub fn interval(ray: &Ray, staged: &StageVolume) -> Option<(f64, f64)> {
    let grid = staged.volume.grid();
    let (low, high) = grid.index_bounds();
    let origin = grid.index_from_world().transform_point3(ray.origin);
    let direction = grid.index_from_world().transform_vector3(ray.direction);
    let (mut t0, mut t1) = (0.0f64, f64::INFINITY);
    for axis in 0..3 {
        for (bound, side) in [(low[axis], 1.0), (high[axis], -1.0)] {
            let (above, slope) = (side * (origin[axis] - bound), side * direction[axis]);
            if slope == 0.0 && above < 0.0 {
                return None;
            }
            if slope > 0.0 {
                t0 = t0.max(-above / slope);
            }
            if slope < 0.0 {
                t1 = t1.min(-above / slope);
            }
        }
    }
    staged.region.interval(ray, t0, t1)
}

/// Two-sided Blinn-Phong with one white light that shines along the ray, on a surface colour.
fn headlit(base: [f64; 3], gradient: DVec3, direction: DVec3, material: &Material, ambient: f64) -> [f64; 3] {
    let [diffuse, specular, shininess] = [material.diffuse, material.specular, material.shininess].map(f64::from);
    let ambient = f64::from(material.ambient) * ambient;
    let facing = gradient.try_normalize().map_or(0.0, |normal| normal.dot(direction).abs());
    base.map(|c| c * (ambient + diffuse * facing) + specular * facing.powf(shininess))
}

/// Emission and absorption along one ray: associated RGBA, by midpoint samples of the exact curves.
pub fn composite(ray: &Ray, stage: &Stage) -> [f64; 4] {
    let staged = &stage.volumes[0];
    let (volume, tf) = (&*staged.volume, &staged.transfer_function);
    let Some((entry, exit)) = interval(ray, staged) else { return [0.0; 4] };
    let unit = tf.unit_distance().unwrap();
    let mut rgba = [0.0; 4];
    let segments = ((exit - entry) / stage.step).ceil().max(1.0) as usize;
    for k in 0..segments {
        let from = entry + k as f64 * stage.step;
        let to = (from + stage.step).min(exit);
        let world = ray.at((from + to) / 2.0);
        let p = volume.grid().index_from_world().transform_point3(world);
        let v = value(volume, p);
        let opacity = 1.0 - (1.0 - f64::from(tf.opacity(v))).powf((to - from) / unit);
        if opacity == 0.0 {
            continue;
        }
        let mut color = tf.color(v).map(f64::from);
        if let Some(material) = &staged.material {
            let slope = |axis: DVec3| (value(volume, p + axis) - value(volume, p - axis)) / 2.0;
            let index_gradient = DVec3::new(slope(DVec3::X), slope(DVec3::Y), slope(DVec3::Z));
            let gradient = volume.grid().index_from_world().matrix3.transpose() * index_gradient;
            color = headlit(color, gradient, ray.direction, material, f64::from(stage.ambient));
        }
        let through = 1.0 - rgba[3];
        for channel in 0..3 {
            rgba[channel] += through * opacity * color[channel];
        }
        rgba[3] += through * opacity;
    }
    rgba
}

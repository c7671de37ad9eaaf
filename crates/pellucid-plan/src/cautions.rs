//! What a stage asks for that would take far more time or memory than its picture is worth, and what is done.

use pellucid_optics::path_extinction;
use pellucid_scene::{LightPath, RenderWarning, Stage, StageVolume};

use crate::half_angle::{Geometry, LightPoints, around, lights};

/// What a user should know of how light is followed: where it was followed more coarsely than asked for, and
/// where a medium is so dense that its light hardly gets anywhere. A light volume has at most `side` points along an
/// axis.
pub fn cautions(stage: &Stage, side: usize) -> impl Iterator<Item = RenderWarning> {
    let scatters = stage.technique.needs().light == LightPath::Scatters;
    let dense = stage.volumes.iter().enumerate().filter(move |_| scatters);
    let dense = dense.filter_map(|(number, volume)| too_dense(number, volume));
    dense.chain(too_many_points(stage, side)).chain(too_many_slabs(stage, side))
}

fn too_many_points(stage: &Stage, side: usize) -> Option<RenderWarning> {
    let asked = stage.light_resolution()?;
    let points = LightPoints::of(stage, side).ok()??;
    let [x, y, z] = points.grid.dims();
    (points.resolution < asked).then(|| {
        let reason = format!(
            "lighting.shadows.volume.resolution is {:.3}, not {asked}: {x} x {y} x {z} points for each of {} lights \
             are as many as there is room for",
            points.resolution,
            stage.lights.len()
        );
        RenderWarning::Memory { reason }
    })
}

fn too_many_slabs(stage: &Stage, side: usize) -> Option<RenderWarning> {
    let grid = around(stage).ok()?;
    let geometries: Vec<Geometry> = match stage.half_angle() {
        Some(settings) => {
            let lights = lights(stage, settings).ok()?;
            lights.iter().filter_map(|(_, light)| Geometry::new(stage, &grid, settings, light)).collect()
        }
        None => {
            let points = LightPoints::of(stage, side).ok()??;
            let sweep = |light| Geometry::of_light(stage.step, &grid, light, points.texels);
            stage.lights.iter().filter_map(sweep).collect()
        }
    };
    let slabs = geometries.iter().map(|geometry| &geometry.slabs).filter(|slabs| slabs.count < slabs.asked);
    slabs.max_by_key(|slabs| slabs.asked).map(|slabs| {
        let [x, y, z] = grid.spacing();
        let reason = format!(
            "light passes the volume in {} slabs instead of {}: its voxels are {x} x {y} x {z}, and as many slabs as \
             their shortest side asks for would take very long; what is shorter than {:.3} has no sharp shadow. \
             Resample the volume to sides that are more alike, or cast shadow rays",
            slabs.count, slabs.asked, slabs.thickness
        );
        RenderWarning::Fallback { reason }
    })
}

/// Says so where light is lost in a small part of a voxel.
fn too_dense(number: usize, volume: &StageVolume) -> Option<RenderWarning> {
    /// Unit distances of dense matter in a voxel, where one is usual.
    const MOST: f64 = 16.0;
    let (unit, voxel) = (volume.unit_distance(), volume.volume.grid().mean_spacing());
    let statistics = volume.volume.statistics();
    let (low, high) = (statistics.min, statistics.max);
    let tf = &volume.transfer_function;
    let points = tf.opacities().iter().map(|point| point.value).filter(|value| (low..=high).contains(value));
    let opacity = points.chain([low, high]).map(|value| tf.opacity(value)).fold(0.0, f32::max);
    let depth = f64::from(path_extinction(opacity, 1.0));
    // Full opacity stands for whatever cannot be seen through, not for a depth.
    (depth.min(1.0) * voxel / unit > MOST).then(|| {
        let corners = volume.volume.grid().world_corners();
        let across = corners[0].distance(corners[7]) / unit * depth;
        RenderWarning::Dense { volume: number, unit_distance: unit, in_voxel: depth * voxel / unit, across, voxel }
    })
}

//! What shaders are told of paths: the structure of `lists.wgsl`.

use bytemuck::{Pod, Zeroable};
use glam::{DAffine3, DVec3, Vec3};
use pellucid_optics::Sky;
use pellucid_plan::MajorantGrid;
use pellucid_scene::{Jitter, PathTrace, Stage, StageVolume};

use crate::four::Four;
use crate::uniforms::{four, rows};

/// The settings of paths, in steps.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct Paths {
    pub counts: [u32; 4],
    pub more: [u32; 4],
    pub numbers: Four,
    pub top: Four,
    pub bottom: Four,
    pub picture: Four,
    pub picture_size: [u32; 4],
    pub surface: Four,
    pub chroma: Four,
    pub index_x: Four,
    pub index_y: Four,
    pub index_z: Four,
    pub lens_right: Four,
    pub lens_up: Four,
    pub first_x: Four,
    pub first_y: Four,
    pub first_z: Four,
    pub own_x: Four,
    pub own_y: Four,
    pub own_z: Four,
}

impl Paths {
    /// Of a stage that looks at a volume, which is the first of those that are drawn, or another one.
    pub fn new(
        stage: &Stage,
        [first, volume]: [&StageVolume; 2],
        settings: &PathTrace,
        majorants: &MajorantGrid,
        sky: Option<&Sky>,
    ) -> Self {
        let (view, grid) = (&stage.viewpoint, volume.volume.grid());
        // Colours of several volumes are lost alike.
        let chroma = volume.scattering.extinction_factors().filter(|_| !stage.has_layers());
        let frames = match stage.quality.jitter {
            Jitter::Centered => 0,
            // Frames to be averaged differ by it.
            Jitter::BlueNoise { seed } => seed.wrapping_add(1),
        };
        let focus = settings.focus.unwrap_or_else(|| (view.target - view.eye).dot(view.forward));
        let [x, y, z] = majorants.leaps.dims().map(|n| n as u32);
        let in_steps = |length: f64| (length / stage.step) as f32;
        // A single block is as large as anything.
        let size = majorants.size.min(1e9);
        let steps = DAffine3 { translation: DVec3::ZERO, matrix3: grid.index_from_world().matrix3 * stage.step };
        let [index_x, index_y, index_z] = rows(steps);
        let first = first.volume.grid();
        let [first_x, first_y, first_z] = rows(first.index_from_world() * grid.world_from_index());
        let [own_x, own_y, own_z] = rows(grid.index_from_world() * first.world_from_index());
        let mut paths = Self {
            counts: [settings.seed, frames, settings.samples, settings.bounces],
            more: [settings.roulette, x, y, z],
            numbers: [settings.noise, in_steps(settings.aperture), in_steps(focus), size],
            // No surface is told more finely than in voxels.
            surface: [
                settings.surface_depth,
                in_steps(grid.mean_spacing()),
                settings.firefly_clamp,
                f32::from(volume.scattering.has_surfaces()),
            ],
            chroma: chroma.map_or([1.0, 1.0, 1.0, 0.0], |[r, g, b]| [r, g, b, 1.0]),
            index_x,
            index_y,
            index_z,
            lens_right: four(view.right, 0.0),
            lens_up: four(view.up, 0.0),
            first_x,
            first_y,
            first_z,
            own_x,
            own_y,
            own_z,
            ..Self::default()
        };
        if let Some(sky) = sky {
            paths.set_sky(sky);
        }
        paths
    }

    fn set_sky(&mut self, sky: &Sky) {
        self.bottom[3] = 1.0;
        match sky {
            Sky::Gradient { top: [r, g, b], bottom: [red, green, blue], slope } => {
                self.top = [*r, *g, *b, *slope];
                self.bottom = [*red, *green, *blue, 1.0];
            }
            Sky::Image { map, turn, intensity } => {
                let x = *turn * Vec3::X;
                let [width, height] = map.size().map(|n| n as u32);
                self.picture = [x.x, x.y, *intensity, map.flux().recip() as f32];
                self.picture_size = [width, height, 0, 0];
            }
        }
    }
}

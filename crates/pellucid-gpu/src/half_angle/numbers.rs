//! What shaders are told of a sweep: the structure of `sweep.wgsl`.

use std::f64::consts::TAU;

use bytemuck::{Pod, Zeroable};
use glam::DVec3;
use pellucid_field::Grid;
use pellucid_optics::ResolvedLight;
use pellucid_plan::half_angle::{Geometry, Ways, taps};
use pellucid_scene::{BlurScaling, HalfAngle, InScatter, LightCorrection, Stage};

use crate::four::Four;
use crate::lights::Light;
use crate::uniforms::four;

/// Where light and slabs are, and how light passes them.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct Sweep {
    pub slabs: Four,
    pub texel_x: Four,
    pub texel_y: Four,
    pub depth: Four,
    pub origin_middle: Four,
    pub origin_right: Four,
    pub origin_up: Four,
    pub direction_middle: Four,
    pub direction_right: Four,
    pub direction_up: Four,
    pub plane: Four,
    pub ways: Four,
    pub blur: Four,
    pub scales: Four,
    pub cone: Four,
    pub taps: Four,
    pub size: [u32; 4],
    pub counts: [u32; 4],
    pub light: Light,
}

impl Sweep {
    /// Of a light among so many, as it passes a grid among those of a stage, in layers with sides of so many texels;
    /// direct light is scattered into the cone with weights.
    pub fn new(
        (stage, grid): (&Stage, &Grid),
        (settings, [r, g, b]): (&HalfAngle, [f32; 3]),
        geometry: &Geometry,
        (light, lights): (&ResolvedLight, usize),
        sides: [u32; 2],
    ) -> Self {
        let mut sweep = Self::default();
        sweep.set_rays(geometry, grid);
        let Geometry { frame, slabs, ways, longest, .. } = geometry;
        let across = grid.world_from_index().matrix3.transpose() * slabs.axis / slabs.thickness;
        sweep.slabs = four(across, slabs.coordinate(grid.world_from_index().translation));
        [sweep.texel_x, sweep.texel_y, sweep.depth] = frame.on(grid).rows;
        let (low, texel) = (frame.low.as_vec2(), frame.texel.as_vec2());
        sweep.plane = [low.x, low.y, texel.x, texel.y];
        let step = stage.step as f32;
        let voxel = geometry.grid.smallest_spacing();
        let radius = |path: f64| taps::radius(settings, path, voxel);
        match *ways {
            Ways::Same(steps) => {
                sweep.ways = [steps, 0.0, step, 0.0];
                let [x, y] = frame.across(radius((f64::from(steps) * stage.step).min(*longest)));
                sweep.blur = [x, y, 0.0, 0.0];
            }
            Ways::From { place, .. } => {
                sweep.ways = [0.0, place, step, 1.0];
                let grows_by_root = f32::from(settings.blur_scaling == BlurScaling::PerDistance);
                sweep.blur = [radius(1.0) as f32, grows_by_root, 1.0 / texel.x, 1.0 / texel.y];
            }
        }
        sweep.scales = [settings.direct, settings.indirect, settings.initial_indirect, lights as f32];
        sweep.cone = [r, g, b, 0.0];
        let turn = TAU / f64::from(taps::count(settings).max(1));
        sweep.taps = [turn.cos() as f32, turn.sin() as f32, 1.0 / sides[0] as f32, 1.0 / sides[1] as f32];
        sweep.size = [frame.size[0], frame.size[1], slabs.count, 0].map(|n| n as u32);
        // What is scattered goes on with it, and no path finds it by chance.
        sweep.light = Light::new(light, false);
        let gate = match settings.in_scatter {
            InScatter::Indirect | InScatter::Direct => 0,
            InScatter::DirectFromMatter => 1,
            InScatter::BothFromMatter => 2,
        };
        let is_uncorrected = u32::from(settings.correction == LightCorrection::None);
        sweep.counts = [taps::count(settings), is_uncorrected, gate, 0];
        sweep
    }

    /// Rays count from the plane across the light in which the volume begins, with coefficients in double
    /// precision: from a far light, single precision would blur where they enter.
    fn set_rays(&mut self, geometry: &Geometry, grid: &Grid) {
        let Geometry { frame, slabs, .. } = geometry;
        let depths = grid.world_corners().map(|corner| (corner - frame.origin).dot(frame.forward));
        let base = depths.into_iter().fold(f64::INFINITY, f64::min);
        let along = |v: DVec3| slabs.axis.dot(v) / slabs.thickness;
        let vector = |v: DVec3| four(grid.index_from_world().transform_vector3(v), along(v));
        let start = frame.origin + frame.forward * base;
        self.origin_middle = four(grid.index_from_world().transform_point3(start), slabs.coordinate(start));
        self.direction_middle = vector(frame.forward);
        // Rays of a light that is somewhere leave one point, others one direction.
        let (across, turning) = if frame.is_directional { (1.0, 0.0) } else { (base, 1.0) };
        [self.origin_right, self.origin_up] = [frame.right, frame.up].map(|side| vector(side * across));
        [self.direction_right, self.direction_up] = [frame.right, frame.up].map(|side| vector(side * turning));
    }
}

//! Random scenes for the agreement of engines.
//!
//! Transfer functions are bounded in slope: f32 rounds positions to about 1e-5 voxel and values to
//! 1e-7 of their range, and a picture may not depend on that.

use glam::DVec3;
use pellucid_field::{Filter, Gradient, Grid};
use pellucid_optics::{
    Color, ColorPoint, ColorSpace, Falloff, Frame, GradientWeight, Light, LightKind, Material, OpacityPoint,
    TransferFunction,
};
use pellucid_scene::{
    Classification, Clip, Crop, Isosurface, Isovalue, Jitter, Mode, Orbit, Projection, Quality, Scene, Stage, View,
};
use proptest::collection::vec;
use proptest::prelude::*;

use super::data::{Data, Texture, data};
use super::set_mode;

/// A random scene.
#[derive(Clone, Debug)]
pub struct Case {
    /// Its volume.
    pub data: Data,
    /// Opacities at a third, two thirds and the whole of the range of values, and where they rise
    /// from 0.
    pub opacities: [f32; 3],
    /// Where the colours and opacities begin and end, as shares of the range of values.
    pub hull: [f64; 2],
    /// Colours from the smallest to the largest value, linear.
    pub colors: [[f32; 3]; 3],
    /// The camera.
    pub view: (Projection, Orbit),
    /// Light, if there is any: material, lights in volume sizes around its middle, weight.
    pub light: Option<(Material, Vec<Light>, Option<GradientWeight>)>,
    /// Clip planes by a point in shares of the box and a normal.
    pub clips: Vec<[[f64; 3]; 2]>,
    /// The part of the box that is kept, as shares.
    pub crop: Option<[f64; 3]>,
    /// Quality settings; the step is overwritten if rays would be very long.
    pub quality: Quality,
    /// Isovalues as shares of the range of values.
    pub levels: Vec<(f64, f32)>,
}

/// Random scenes in which surfaces are lit or not.
pub fn case() -> impl Strategy<Value = Case> {
    let color = || [0.0..1.0f32, 0.0..1.0f32, 0.0..1.0f32];
    let opacity = || prop_oneof![1 => Just(0.0f32), 4 => 0.0..0.8f32];
    let projection = prop_oneof![
        (5.0..80.0f64).prop_map(|vertical_fov| Projection::Perspective { vertical_fov }),
        Just(Projection::Orthographic { height: None }),
    ];
    let angles =
        prop_oneof![4 => (0.0..360.0f64, -90.0..90.0f64), 1 => (0..4u8).prop_map(|k| (90.0 * f64::from(k), 0.0))];
    let view = (projection, angles, prop_oneof![4 => 1.0..1.5f64, 1 => 1.5..30.0f64]).prop_map(
        |(projection, (azimuth, elevation), zoom)| (projection, Orbit { azimuth, elevation, zoom, ..Orbit::default() }),
    );
    let jitter = prop_oneof![Just(Jitter::Centered), any::<u32>().prop_map(|seed| Jitter::BlueNoise { seed })];
    let quality = (0.3..2.0f64, jitter, prop_oneof![3 => Just(1u32), 1 => Just(2)], any::<bool>()).prop_map(
        |(step, jitter, supersampling, early)| Quality {
            step,
            jitter,
            supersampling,
            early_termination: if early { 0.9 } else { 1.0 },
            ..Quality::default()
        },
    );
    let unit = || -1.0..1.0f64;
    (
        (data(), [opacity(), opacity(), opacity()], prop_oneof![Just([0.0, 1.0]), Just([0.2, 0.9]), Just([0.4, 1.0])]),
        ([color(), color(), color()], view, prop_oneof![Just(None), light().prop_map(Some)]),
        vec([[0.2..0.8f64, 0.2..0.8f64, 0.2..0.8f64], [unit(), unit(), 0.1..1.0f64]], 0..3),
        prop_oneof![3 => Just(None), 1 => [0.0..0.4f64, 0.0..0.4f64, 0.0..0.4f64].prop_map(Some)],
        (quality, vec((0.15..0.85f64, prop_oneof![Just(1.0f32), 0.1..0.9f32]), 1..4)),
    )
        .prop_map(|((data, opacities, hull), (colors, view, light), clips, crop, (mut quality, levels))| {
            // Half way between a voxel and a hole, rounding decides; for every ray of a pixel by itself.
            if data.holes > 0.0 {
                quality.supersampling = 1;
            }
            Case { data, opacities, hull, colors, view, light, clips, crop, quality, levels }
        })
}

/// Random scenes of several blocks, most of them empty.
pub fn sparse_case() -> impl Strategy<Value = Case> {
    (case(), [16usize..36, 16usize..36, 16usize..36]).prop_map(|(case, dims)| {
        let data = Data { dims, texture: Texture::Crumbs, ..case.data };
        // Room for a table's next node, or no block counts as empty.
        Case { data, hull: [0.05, 1.0], ..case }
    })
}

fn light() -> impl Strategy<Value = (Material, Vec<Light>, Option<GradientWeight>)> {
    let material =
        (0.0..0.3f32, 0.0..0.3f32, 0.2..0.8f32, prop_oneof![Just(0.0f32), 0.0..0.4f32], 1.0..12.0f32, any::<bool>())
            .prop_map(|(emission, ambient, diffuse, specular, shininess, two_sided)| Material {
                emission,
                ambient,
                diffuse,
                specular,
                shininess,
                two_sided,
            });
    let direction = || [-1.0..1.0f64, -1.0..1.0f64, 0.1..1.0f64];
    // Around the volume and outside of it.
    let position = || {
        let away = ([-1.0..1.0f64, -1.0..1.0f64, 0.8..2.0f64], any::<bool>());
        away.prop_map(|([x, y, z], below)| [x, y, if below { -z } else { z }])
    };
    let falloff =
        || prop_oneof![Just(Falloff::None), (0.5..1.5f64).prop_map(|reference| Falloff::InverseSquare { reference })];
    let kind = prop_oneof![
        direction().prop_map(|direction| LightKind::Directional { direction }),
        (position(), falloff()).prop_map(|(position, falloff)| LightKind::Point { position, falloff }),
        (position(), falloff(), 0.0..30.0f64, 25.0..60.0f64).prop_map(|(position, falloff, inner_angle, soft)| {
            let outer_angle = inner_angle + soft;
            LightKind::Spot { position, direction: position.map(|x| -x), inner_angle, outer_angle, falloff }
        }),
    ];
    let one = (kind, [0.0..1.0f32, 0.0..1.0f32, 0.0..1.0f32], 0.2..1.0f32, any::<bool>(), any::<bool>()).prop_map(
        |(kind, color, intensity, camera, specular)| Light {
            kind,
            color: Color::new(color).unwrap(),
            intensity,
            frame: if camera && matches!(kind, LightKind::Directional { .. }) { Frame::Camera } else { Frame::World },
            specular,
            radius: 0.0,
        },
    );
    let weight = prop_oneof![
        2 => Just(None),
        1 => (0.0..0.1f32, 0.2..0.6f32).prop_map(|(low, high)| Some(GradientWeight { low, high })),
    ];
    (material, vec(one, 1..4), weight)
}

/// Columns and rows of a picture: no multiples of what engines work on at once.
pub const PICTURE: [u32; 2] = [13, 11];

impl Case {
    /// The stage under a mode and a classification, with or without skipping.
    pub fn stage(&self, mode: &Mode, classification: Classification, skipping: bool) -> Stage {
        let volume = self.data.volume();
        let statistics = *volume.statistics();
        let low = statistics.min;
        // Wide enough for the control points to be apart, in levels and beside the rounding of values.
        let largest = low.abs().max(statistics.max.abs());
        let range = (statistics.max - low).max(30.0 * self.data.map[0].abs()).max(0.05 * largest);
        let grid = *volume.grid();
        let inside = |share: [f64; 3]| {
            let (low, high) = grid.index_bounds();
            low + (high - low) * DVec3::from_array(share)
        };
        let radius = (grid.world_corners()[0] - grid.center()).length();
        let stage = super::stage(volume, self.transfer_function(low, range), |scene| {
            [scene.image.width, scene.image.height] = PICTURE;
            set_mode(scene, self.leveled(mode, low, range));
            (scene.camera.projection, scene.camera.view) = (self.view.0, View::Orbit(self.view.1));
            scene.quality = Quality { classification, empty_space_skipping: skipping, ..self.quality.clone() };
            scene.volumes[0].component = Some(self.data.components - 1);
            self.illuminate(scene, &grid, radius, range);
            let plane = |[share, normal]: [[f64; 3]; 2]| Clip::Plane {
                point: grid.world_from_index().transform_point3(inside(share)).to_array(),
                normal,
            };
            scene.clips = self.clips.iter().copied().map(plane).collect();
            let crop = |from: [f64; 3]| Crop {
                from: inside(from).to_array(),
                to: inside(from.map(|share| share + 0.55)).to_array(),
            };
            scene.volumes[0].crop = self.crop.map(crop);
        });
        // However long the box, some hundred samples are enough.
        Stage { step: stage.step.max(radius / 60.0), ..stage }
    }

    /// The optics over values from `low` on. Control points lie on nodes of the tables that engines
    /// look up, whose resolution is not the question here: at levels of integers, and at multiples
    /// of 1/253 of the hull.
    fn transfer_function(&self, low: f64, range: f64) -> TransferFunction {
        let at = |share: f64| {
            let value = range * (self.hull[0] + (self.hull[1] - self.hull[0]) * share / 253.0);
            let spacing = self.data.map[0].abs();
            low + if self.data.voxel_type.is_integer() { (value / spacing).round() * spacing } else { value }
        };
        let colors = [0.0, 126.0, 253.0].into_iter().zip(self.colors);
        let colors = colors.map(|(share, color)| ColorPoint::new(at(share), Color::new(color).unwrap()));
        let opacities = [0.0, 84.0, 168.0, 253.0].into_iter().zip([0.0].into_iter().chain(self.opacities));
        let opacities = opacities.map(|(share, opacity)| OpacityPoint::new(at(share), opacity));
        let tf = TransferFunction::new(colors.collect(), opacities.collect()).unwrap();
        tf.with_color_space(ColorSpace::Linear).with_unit_distance(Some(1.7)).unwrap()
    }

    fn leveled(&self, mode: &Mode, low: f64, range: f64) -> Mode {
        let level = |&(share, opacity): &(f64, f32)| Isovalue {
            value: low + range * share,
            color: None,
            opacity,
            volume: None,
        };
        match mode {
            Mode::Isosurface(Isosurface { search, .. }) => {
                let isovalues = self.levels.iter().map(level).collect();
                Mode::Isosurface(Isosurface { search: *search, ..Isosurface::new(isovalues) })
            }
            other => other.clone(),
        }
    }

    fn illuminate(&self, scene: &mut Scene, grid: &Grid, radius: f64, range: f64) {
        let Some((material, lights, weight)) = &self.light else { return };
        let placed = |position: [f64; 3]| (grid.center() + DVec3::from_array(position) * 2.0 * radius).to_array();
        let scaled = |falloff| match falloff {
            Falloff::InverseSquare { reference } => Falloff::InverseSquare { reference: reference * radius },
            Falloff::None => Falloff::None,
        };
        let light = |light: &Light| {
            let kind = match light.kind {
                LightKind::Point { position, falloff } => {
                    LightKind::Point { position: placed(position), falloff: scaled(falloff) }
                }
                LightKind::Spot { position, direction, inner_angle, outer_angle, falloff } => {
                    let (position, falloff) = (placed(position), scaled(falloff));
                    LightKind::Spot { position, direction, inner_angle, outer_angle, falloff }
                }
                directional => directional,
            };
            Light { kind, ..*light }
        };
        scene.lighting.lights = lights.iter().map(light).collect();
        scene.volumes[0].shading = Some(true);
        scene.volumes[0].material = Some(*material);
        let weight = weight.map(|w| GradientWeight { low: w.low * range as f32, high: w.high * range as f32 });
        scene.volumes[0].gradient_weight = weight;
    }

    /// The same scene with a transfer function of straight curves over all values. How closely tables
    /// follow bends is not the question here.
    pub fn straight(mut self) -> Self {
        let [first, middle, last] = &mut self.opacities;
        // The curve starts at 0.
        (*first, *middle) = (*last * (84.0 / 253.0), *last * (168.0 / 253.0));
        let [first, middle, last] = &mut self.colors;
        (0..3)
            .for_each(|channel| middle[channel] = first[channel] + (last[channel] - first[channel]) * (126.0 / 253.0));
        self.hull = [0.0, 1.0];
        self
    }

    /// The same scene under other reconstructions.
    pub fn reconstructed(mut self, filter: Filter, gradient: Gradient) -> Self {
        (self.quality.filter, self.quality.gradient) = (filter, gradient);
        if filter == Filter::Nearest {
            // As beside holes.
            self.quality.supersampling = 1;
        }
        self
    }
}

//! Lights as shaders take them: the structures of `light.wgsl`.

use crate::four::Four;
use bytemuck::{Pod, Zeroable};
use pellucid_optics::{Extent as Shape, LightShape, ResolvedLight};

/// What an extent is, for shaders: nothing around a point.
const DISC: u32 = 1;
const BALL: u32 = 2;
const FACE: u32 = 3;

/// A light.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct Light {
    pub place: Four,
    pub radiance: Four,
    pub axis: Four,
    pub cone: Four,
    pub extent: Extent,
}

/// What shines around its middle.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct Extent {
    pub kind: [u32; 4],
    pub first: Four,
    pub second: Four,
    pub normal: Four,
}

impl Light {
    /// Of a light, which scattered paths find as well if it `is_met`.
    pub fn new(light: &ResolvedLight, is_met: bool) -> Self {
        let [r, g, b] = light.radiance();
        let radiance = [r, g, b, f32::from(u8::from(light.is_specular()))];
        let extent = Extent::new(light, is_met);
        match light.shape() {
            LightShape::Directional { to_light } => {
                Self { place: to_light.extend(0.0).to_array(), radiance, extent, ..Self::default() }
            }
            LightShape::Local { position, reference, cone } => {
                let place = position.extend(1.0).to_array();
                let axis = cone.map_or([0.0; 4], |cone| cone.axis.extend(1.0).to_array());
                let [inner, outer] = cone.map_or([0.0; 2], |cone| [cone.inner, cone.outer]);
                Self { place, radiance, axis, cone: [inner, outer, reference.unwrap_or(0.0), 0.0], extent }
            }
        }
    }
}

impl Extent {
    fn new(light: &ResolvedLight, is_met: bool) -> Self {
        let is_met = u32::from(is_met);
        let round = |kind, size| Self { kind: [kind, is_met, 0, 0], normal: [0.0, 0.0, 0.0, size], ..Self::default() };
        match light.extent() {
            Shape::Point => Self::default(),
            Shape::Disc { sine_squared } => round(DISC, sine_squared),
            Shape::Ball { radius } => round(BALL, radius),
            Shape::Face(face) => {
                let [first, second] = face.edges().map(|edge| edge.extend(0.0).to_array());
                let kind = [FACE, is_met, u32::from(face.is_two_sided()), 0];
                Self { kind, first, second, normal: face.normal().extend(face.area()).to_array() }
            }
        }
    }
}

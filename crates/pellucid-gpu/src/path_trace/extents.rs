//! What shines around the middles of lights: the structure of `extent.wgsl`.

use bytemuck::{Pod, Zeroable};
use pellucid_optics::{Extent as Shape, ResolvedLight, Scattering};

type Four = [f32; 4];

/// What it is, for shaders: nothing around a point.
const DISC: u32 = 1;
const BALL: u32 = 2;
const FACE: u32 = 3;

/// The size of a light.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct Extent {
    pub kind: [u32; 4],
    pub first: Four,
    pub second: Four,
    pub normal: Four,
}

impl Extent {
    /// Of a light, as paths find it that this medium scatters.
    pub fn new(light: &ResolvedLight, scattering: &Scattering) -> Self {
        let is_met = u32::from(scattering.meets(light));
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

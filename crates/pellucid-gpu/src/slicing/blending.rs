//! How slices are blended (2.4-4, 3.2-5 to 3.2-10), and into what (9.5-1).

use pellucid_scene::{BlendOrder, ColorWeight, SliceTarget, Slicing};
use wgpu::{BlendComponent, BlendFactor, BlendOperation, BlendState, Color, Features, TextureFormat};

use crate::Device;
use crate::shaders::Pass;

/// The blending of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Blending {
    /// What fragments and pixels become.
    pub state: BlendState,
    /// The colours' format.
    pub format: TextureFormat,
    /// The format of counts of samples.
    pub counts: TextureFormat,
    /// Whether nothing is seen behind what is opaque, so that it need not be drawn.
    pub terminates: bool,
}

impl Blending {
    /// The blending of a pass, and whether its numbers are coarser than asked for.
    pub fn new(device: &Device, pass: Pass, slicing: &Slicing) -> (Self, bool) {
        let float = device.capabilities.has(Features::FLOAT32_BLENDABLE);
        let format = match slicing.target {
            SliceTarget::U8 => TextureFormat::Rgba8Unorm,
            SliceTarget::F32 if float => TextureFormat::Rgba32Float,
            SliceTarget::F16 | SliceTarget::F32 => TextureFormat::Rgba16Float,
        };
        // Half precision counts to 2048.
        let counts = if float { TextureFormat::Rg32Float } else { TextureFormat::Rg16Float };
        let composited = composites(pass);
        let front_to_back = slicing.order == BlendOrder::FrontToBack;
        let blending = Self {
            state: state(pass, front_to_back, unassociated(pass, slicing)),
            format,
            counts,
            terminates: composited && front_to_back,
        };
        (blending, slicing.target == SliceTarget::F32 && !float)
    }
}

/// Whether colours are blended before they are multiplied by their opacity: by the blending itself.
pub fn unassociated(pass: Pass, slicing: &Slicing) -> bool {
    composites(pass) && slicing.colors == ColorWeight::NonAssociated && slicing.order == BlendOrder::BackToFront
}

/// Whether slices hide each other.
fn composites(pass: Pass) -> bool {
    matches!(pass, Pass::Composite | Pass::CompositePre | Pass::PreIntegrated | Pass::Isosurface)
}

/// What pixels are before the first slice.
pub fn cleared(pass: Pass) -> Color {
    match pass {
        Pass::XRay => Color::WHITE,
        // Nothing is larger than the largest place in the table.
        Pass::Minimum => Color { a: 0.0, ..Color::WHITE },
        _ => Color::TRANSPARENT,
    }
}

/// Adding of counts, and of light without absorption.
pub const SUM: BlendState = {
    let sum = component(BlendFactor::One, BlendFactor::One, BlendOperation::Add);
    BlendState { color: sum, alpha: sum }
};

const fn component(src_factor: BlendFactor, dst_factor: BlendFactor, operation: BlendOperation) -> BlendComponent {
    BlendComponent { src_factor, dst_factor, operation }
}

fn state(pass: Pass, front_to_back: bool, unassociated: bool) -> BlendState {
    use BlendFactor::{One, OneMinusDstAlpha, OneMinusSrcAlpha, SrcAlpha, Zero};
    use BlendOperation::{Add, Max, Min};
    let both = |component| BlendState { color: component, alpha: component };
    match pass {
        Pass::Maximum => both(component(One, One, Max)),
        Pass::Minimum => BlendState { color: component(One, One, Min), alpha: component(One, One, Max) },
        Pass::Average | Pass::Additive => SUM,
        // What light is left.
        Pass::XRay => both(component(Zero, OneMinusSrcAlpha, Add)),
        _ if front_to_back => both(component(OneMinusDstAlpha, One, Add)),
        _ if unassociated => {
            let over = component(One, OneMinusSrcAlpha, Add);
            BlendState { color: component(SrcAlpha, OneMinusSrcAlpha, Add), alpha: over }
        }
        _ => both(component(One, OneMinusSrcAlpha, Add)),
    }
}

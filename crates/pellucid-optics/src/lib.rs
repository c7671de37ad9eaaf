//! What it looks like: transfer functions, pre-integration, colour, materials and lights, as pure
//! functions and tables that every backend shares.
//!
//! An opacity holds for a length, its unit distance ([`correct_opacity`]); colours in the renderer
//! are linear RGB. A [`TransferFunction`] is what the user writes; a [`Table`] is its sampled
//! form, a [`StepTable`] what a ray marcher looks up and a [`PreIntegration`] what it looks up
//! for whole segments. Values that are not finite are absent: they have no opacity.

mod color;
mod control_point;
mod error;
mod nodes;
mod opacity;
mod preintegration;
mod segment;
mod table;
mod transfer_function;
mod visibility;

pub use color::{Color, ColorSpace, luminance, srgb_decode, srgb_encode, srgb8};
pub use control_point::{ColorPoint, Interpolation, OpacityPoint};
pub use error::OpticsError;
pub use nodes::{DataRange, Nodes};
pub use opacity::{correct_associated, correct_opacity, extinction, opacity_from_extinction, over};
pub use preintegration::PreIntegration;
pub use table::{StepTable, Table};
pub use transfer_function::TransferFunction;
pub use visibility::Visibility;

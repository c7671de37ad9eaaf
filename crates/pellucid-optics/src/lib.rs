//! What it looks like: transfer functions, pre-integration, colour, materials and lights, as pure
//! functions and tables that every backend shares.
//!
//! An opacity holds for a length, its unit distance ([`correct_opacity`]); colours in the renderer
//! are linear RGB. A [`TransferFunction`] is what the user writes; a [`Table`] is its sampled
//! form, a [`StepTable`] what a ray marcher looks up and a [`PreIntegration`] what it looks up
//! for whole segments. Values that are not finite are absent: they have no opacity.

mod bend;
mod chroma;
mod color;
mod color_names;
mod colormap;
mod control_point;
mod curves;
mod environment;
mod error;
mod extent;
mod extinction_bounds;
mod harmonics;
mod knots;
mod light;
mod light_sample;
mod lighting;
mod material;
mod maxima;
mod nodes;
mod opacity;
mod opacity_shapes;
mod perturbation;
mod phase;
mod placement;
mod polyline;
mod preintegration;
mod presets;
mod reflection;
mod scattering;
mod scattering_tables;
mod segment;
mod sequence;
mod shading;
mod shadows;
mod slicer;
mod table;
mod transfer_function;
mod turbulence;
mod visibility;

pub use bend::Bend;
pub use chroma::Chroma;
pub use color::{Color, ColorSpace, luminance, srgb_decode, srgb_encode, srgb8};
pub use colormap::ColorMap;
pub use control_point::{ColorPoint, Interpolation, NumberPoint, OpacityPoint};
pub use environment::{Environment, Sky, SkyImage, SkyMap, SkySource};
pub use error::OpticsError;
pub use extent::{Extent, Face};
pub use extinction_bounds::ExtinctionBounds;
pub use harmonics::{
    Bands, Harmonics, MOST_BANDS, MOST_COEFFICIENTS, Rotation, Window, Zonal, spherical_harmonics,
    spherical_harmonics_f64,
};
pub use light::{Falloff, Frame, Incident, Light, LightCone, LightKind, LightShape, ResolvedLight};
pub use light_sample::{LightSample, LightSeen};
pub use lighting::Lighting;
pub use material::Material;
pub use nodes::{DataRange, Nodes};
pub use opacity::{
    advance, correct_associated, correct_opacity, correct_segment, extinction, opacity_from_extinction, over,
    path_extinction,
};
pub use opacity_shapes::{opacity_shape, opacity_shape_names};
pub use perturbation::{Displacement, Octave, Perturbation, PropertyNoise};
pub use phase::{
    BackLobe, MOST_ANISOTROPY, Phase, PhaseEntries, PhaseNormalization, PhaseTable, PhaseTextError, TableAngles, turned,
};
pub use preintegration::PreIntegration;
pub use presets::{Modality, Preset, Scale};
pub use reflection::Reflection;
pub use scattering::{Albedo, Anisotropy, Scatterer, Scattering, SurfaceShare};
pub use scattering_tables::{ScatterTable, TransportTable};
pub use shading::{GradientWeight, blinn_phong};
pub use shadows::{LightModel, ShadowRays, ShadowVolume, Shadows};
pub use slicer::{SlicerWarning, VolumeProperty};
pub use table::{StepTable, Table};
pub use transfer_function::TransferFunction;
pub use turbulence::{Displacer, Term, Turbulence, Variation};
pub use visibility::Visibility;

//! What to draw.
//!
//! A [`Scene`] is a document: volumes with their optics, camera, lights, clips, technique and
//! quality, in TOML or JSON with one schema. [`Scene::resolve`] meets it with the loaded volumes,
//! fills in everything left automatic, says what it chose, and gives a [`Stage`]: the explicit
//! description that every backend draws. A backend answers with a [`Frame`].

mod auto;
mod brightness;
mod camera;
mod check;
mod check_optics;
mod choice;
mod citations;
mod clip;
mod colors;
mod control;
mod denoise;
mod document;
mod empty;
mod encode;
mod files;
mod format;
mod frame;
mod frame_statistics;
mod framing;
mod fused;
mod image;
mod locate;
mod look;
mod meant;
mod model_source;
mod origin;
mod overlap;
mod population;
mod quality;
mod relight;
mod render_warning;
mod resolve;
mod scene;
mod srgb8;
mod stage;
mod stage_volume;
mod technique;

pub use camera::{Camera, Framing, LookAt, Orbit, Projection, Ray, View, Viewpoint};
pub use check::Invalid;
pub use choice::Choice;
pub use clip::{Clip, Region};
pub use colors::{Colors, holds_alpha, holds_colors};
pub use control::{Cancel, Cancelled, Control, Haste};
pub use denoise::denoise;
pub use document::{DocumentError, json_schema};
pub use format::Format;
pub use frame::Frame;
pub use frame_statistics::FrameStatistics;
pub use image::{Background, Encoding, ImageSettings};
pub use look::Look;
pub use meant::{meant, pointed};
pub use model_source::{CloudsSource, HeightFieldSource, HeightSource, ModelSource, SpectralSource};
pub use overlap::Overlap;
pub use quality::{Classification, Jitter, Quality};
pub use render_warning::RenderWarning;
pub use resolve::ResolveError;
pub use scene::{Crop, Held, SampleSource, Scene, Source, VolumeEntry};
pub use stage::Stage;
pub use stage_volume::StageVolume;
pub use technique::{
    BlendOrder, BlurJitter, BlurScaling, ColorWeight, Combine, Correction, GlobalIllumination, HalfAngle,
    HarmonicTransfer, HarmonicWindow, Illumination, IlluminationBasis, IlluminationInterpolation, IlluminationMethod,
    InScatter, Isosurface, Isovalue, LightCorrection, LightPath, Likeness, Majorants, Mode, Needs, PathTrace, PlacesOn,
    Proxy, RayCast, Slice, SliceGeometry, SliceTarget, Slicing, SurfaceNormals, SurfaceSearch, TECHNIQUES, Technique,
};

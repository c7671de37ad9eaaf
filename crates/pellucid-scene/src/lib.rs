//! What to draw.
//!
//! A [`Scene`] is a document: volumes with their optics, camera, lights, clips, technique and
//! quality, in TOML or JSON with one schema. [`Scene::resolve`] meets it with the loaded volumes,
//! fills in everything left automatic, says what it chose, and gives a [`Stage`]: the explicit
//! description that every backend draws. A backend answers with a [`Frame`].

mod auto;
mod blocks;
mod blue_noise;
mod brightness;
mod camera;
mod cautions;
mod check;
mod check_optics;
mod choice;
mod citations;
mod clip;
mod control;
mod denoise;
mod document;
mod empty;
mod encode;
mod files;
mod frame;
mod framing;
pub mod half_angle;
mod image;
mod light_tables;
mod locate;
mod look;
mod majorants;
mod meant;
mod model_source;
mod origin;
mod population;
mod quality;
mod resolve;
mod scene;
mod srgb8;
mod stage;
mod strides;
mod tables;
mod technique;

pub use blocks::{BlockContent, BlockMap};
pub use blue_noise::{TILE as BLUE_NOISE_TILE, blue_noise, blue_noise_shift};
pub use camera::{Camera, Framing, LookAt, Orbit, Projection, Ray, View, Viewpoint};
pub use check::Invalid;
pub use choice::Choice;
pub use clip::{Clip, Region};
pub use control::{Cancel, Cancelled, Control};
pub use denoise::denoise;
pub use document::{DocumentError, Format, json_schema};
pub use frame::{Frame, FrameStatistics, RenderWarning};
pub use image::{Background, Encoding, ImageSettings};
pub use light_tables::LightTables;
pub use look::Look;
pub use majorants::MajorantGrid;
pub use meant::{meant, pointed};
pub use model_source::{CloudsSource, HeightFieldSource, HeightSource, ModelSource, SpectralSource};
pub use quality::{Classification, Jitter, Quality};
pub use resolve::{ResolveError, Stage, StageVolume};
pub use scene::{Crop, Held, SampleSource, Scene, Source, VolumeEntry};
pub use strides::SAMPLES_PER_LOOK;
pub use tables::{TableCache, TableError, Tables};
pub use technique::{
    BlendOrder, BlurJitter, BlurScaling, ColorWeight, Combine, Correction, HalfAngle, InScatter, Isosurface, Isovalue,
    LightCorrection, Majorants, Mode, PathTrace, Proxy, RayCast, Slice, SliceGeometry, SliceTarget, Slicing, Technique,
};

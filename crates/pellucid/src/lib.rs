//! Volume graphics: scalar fields in, light out.
//!
//! A [`Scene`](scene::Scene) says what to draw. [`load`] fetches its volumes,
//! [`Scene::resolve`](scene::Scene::resolve) fills in what the scene leaves open and says what it
//! chose, a [`Renderer`] draws, and [`save`](save()) writes the picture.
//!
//! ```
//! use pellucid::scene::{Control, SampleSource, Scene, Source};
//! use pellucid::{Backend, Renderer, load, save};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let ball = SampleSource { name: "ball".into(), dims: Some([32; 3]), voxel_type: None };
//! let mut scene = Scene::of(Source::Sample(ball));
//! (scene.image.width, scene.image.height) = (64, 48);
//!
//! let (volumes, warnings) = load(&scene, "")?;
//! assert!(warnings.is_empty());
//! let (stage, choices) = scene.resolve(&volumes)?;
//! for choice in &choices {
//!     println!("{choice}");
//! }
//! let frame = Renderer::new(Backend::Auto)?.render(&stage, &Control::default())?;
//! assert!(frame.statistics.samples_visible > 0);
//!
//! let picture = std::env::temp_dir().join("pellucid-doc-example.png");
//! save(&picture, &frame, &scene.image)?;
//! # std::fs::remove_file(picture)?;
//! # Ok(())
//! # }
//! ```
//!
//! For a window, [`Progressive`] draws a preview first and then ever better pictures. [`Passes`] trace paths so that a
//! picture that takes long can be stopped and kept.
//!
//! Pictures are made of many small steps, which are slow where nothing optimizes them. A program that is
//! built without `--release` says so in its `Cargo.toml`:
//!
//! ```toml
//! [profile.dev.package."*"]
//! opt-level = 2
//! ```
//!
//! The parts can be imported on their own: [`field`] is what is measured, [`optics`] what it
//! looks like, [`scene`] what to draw, [`io`] files in and out.

mod effect;
mod load;
mod load_error;
mod phase_file;
mod progressive;
mod renderer;
mod save;

/// The example of the README is compiled and run.
#[cfg(doctest)]
#[doc = include_str!("../../../README.md")]
struct Readme;

pub use effect::{WithoutEffect, without_effect};
pub use load::{LoadOptions, load, load_optics, load_optics_with, load_with};
pub use load_error::LoadError;
pub use pellucid_cpu::{CpuRenderer, InstructionSet};
pub use progressive::{Passes, Picture, Progressive, Step};
pub use renderer::{Backend, RenderError, Renderer};
pub use save::{PngDepth, SaveError, save, save_exr, save_png};

pub use glam;
pub use pellucid_cpu as cpu;
pub use pellucid_field as field;
#[cfg(feature = "gpu")]
pub use pellucid_gpu as gpu;
#[cfg(feature = "gpu")]
pub use pellucid_gpu::wgpu;
pub use pellucid_io as io;
pub use pellucid_model as model;
pub use pellucid_optics as optics;
pub use pellucid_scene as scene;

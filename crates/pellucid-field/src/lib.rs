//! What is measured.
//!
//! A [`Volume`] is a regular [`Grid`] of samples with 1 to 4 components per voxel, stored in its
//! own type ([`Voxels`]) and placed in the world by one affine, `world_from_index`. Nothing here
//! knows about colour, files or cameras.
//!
//! Conventions, obeyed by every crate above this one:
//!
//! - Voxels are samples **at** integer index points; x is fastest in memory.
//! - A value that is not finite is *absent*: it has no opacity, no part in a projection, and its
//!   neighbours take one-sided gradients.
//! - Spacing, direction, mirroring and origin live in the affine and nowhere else.

mod blocks;
pub mod closed_form;
mod component;
mod crop;
mod distance;
mod error;
mod filter;
mod gradient;
mod grid;
mod histogram;
mod joint_histogram;
mod kernel;
mod leaps;
pub mod memory;
mod noise;
mod prefilter;
mod pyramid;
mod resample;
mod sampler;
mod threads;
mod volume;
mod voxels;
mod words;

pub use blocks::Blocks;
pub use component::component;
pub use crop::crop;
pub use distance::distances;
pub use error::{FieldError, Warning};
pub use filter::{
    Filter, MAX_HALF_WIDTH, SincWindow, Weights, bspline_derivative_weights, bspline_second_derivative_weights,
    bspline_weights,
};
pub use gradient::{Gradient, SplineCell, index_gradient, normal, world_gradient};
pub use grid::Grid;
pub use histogram::Histogram;
pub use joint_histogram::JointHistogram;
pub use kernel::Kernel;
pub use leaps::Leaps;
pub use noise::Noise;
pub use prefilter::spline_coefficients;
pub use pyramid::{halve, pyramid};
pub use resample::{resample, resample_dims};
pub use sampler::{ComponentView, Linear, Nearest, Reconstruct, Sampler, Wide};
pub use threads::{Threads, ThreadsError, parallel, thread_count};
pub use volume::{Statistics, ValueMap, Volume};
pub use voxels::{Buffer, Voxel, VoxelType, Voxels};
pub use words::{Short, nearest, printable};

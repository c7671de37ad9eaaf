//! How a stage is drawn: what both backends decide of it, decided once.
//!
//! A [`Stage`](pellucid_scene::Stage) says what to draw. From it, and from the data, follow tables of the optics, blocks
//! that tell where nothing can be seen, bounds of the extinction, slabs through which light travels, and how rays
//! are jittered. A [`PlanCache`] keeps what has not changed from one frame to the next.

mod blocks;
mod blue_noise;
mod cache;
mod cautions;
mod color_grid;
pub mod half_angle;
mod kept;
mod level_blocks;
mod light_tables;
mod majorants;
mod merging;
mod noises;
mod order;
mod strides;
mod tables;

pub use blocks::{BlockContent, BlockMap};
pub use blue_noise::{TILE as BLUE_NOISE_TILE, blue_noise, blue_noise_shift};
pub use cache::PlanCache;
pub use cautions::cautions;
pub use color_grid::ColorGrid;
pub use level_blocks::LevelBlocks;
pub use light_tables::LightTables;
pub use majorants::MajorantGrid;
pub use merging::Merging;
pub use order::merge_order;
pub use strides::SAMPLES_PER_LOOK;
pub use tables::{TableError, Tables};

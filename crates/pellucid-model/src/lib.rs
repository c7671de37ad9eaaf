//! Making volumes: fields defined by procedures (12.3).
//!
//! Every model is a [`ScalarField`](pellucid_field::closed_form::ScalarField): it is evaluated where it is
//! asked, or baked by [`sample_field`](pellucid_field::closed_form::sample_field) into a volume that every
//! technique draws. Baking evaluates the field once a voxel, on all cores; a volume of n voxels a side has errors
//! that fall as 1 / n² (MOD-05).

mod clouds;
mod height_field;
mod spectral;
mod terrain;

pub use clouds::Clouds;
pub use height_field::{HeightField, HeightMap, Ramp};
pub use spectral::Spectral;

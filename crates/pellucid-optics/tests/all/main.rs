//! The tests of the crate that need no process of their own, in one program: one link instead of many.

mod area_lights;
mod harmonic_light;
mod harmonic_rotation;
mod harmonics;
mod nodes_on_sphere;
mod perturbation;
mod phase;
mod placement;
mod preintegration;
mod scattering;
mod shading;
mod sky_map;
mod slicer;
mod table;
mod transfer_function;

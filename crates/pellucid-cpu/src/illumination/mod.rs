//! All light that arrives at isosurfaces: from lights, from around, and from other places of the surface (Wyman et al. 2006).
//!
//! [`LightPaths`] follow it from a place of the surface backwards, by [`SurfaceRays`] that meet the surface of any isovalue.
//! They start at what is seen or, as light varies slowly over surfaces and from one isovalue to the next, at the places of a
//! [`Lattice`] around what is seen, once, each on the surface that is drawn there or on that of its own value. A place is lit when it is first
//! asked for, and its light belongs to it whoever asks: a picture is the same whatever was seen before. It can be
//! [saved], with a [mark] of what it is the light of.

mod bake;
mod bricks;
mod cache;
mod distant;
mod gather;
mod global;
mod kept;
mod lattice;
mod level_grids;
mod mark;
mod paths;
mod places;
mod saved;
mod saved_error;
mod sequence;
mod surface_rays;

pub use bake::{Bake, Baked};
pub use cache::IlluminationCache;
pub use global::Global;
pub use places::Globally;
pub use saved_error::SavedLightError;

use crate::lanes::*;

/// Places where rays meet surfaces.
pub struct SeenSurface<S: Lanes> {
    /// Index positions.
    pub index: Vec3<S>,
    /// Isovalues.
    pub level: F32<S>,
    /// Lanes that are seen from the side of lower values.
    pub from_below: Mask<S>,
    /// Lanes that have one.
    pub lanes: Mask<S>,
}

/// Something that lights surfaces from everywhere.
pub trait Illuminate<S: Lanes>: Sync {
    /// The light that arrives at places, as bright as a white surface looks in it: irradiance over pi, linear RGB.
    fn light(&self, seen: &SeenSurface<S>) -> [F32<S>; 3];
}

//! Fields known in closed form, value and gradient: what reconstruction, gradients and pictures
//! are tested against, and pellucid's own pictures when there is no data at hand.

mod ball;
mod bowl;
mod cloud;
mod dice;
mod engine;
mod footprint;
mod formula;
mod gyroid;
mod head;
mod hydrogen;
mod marschner_lobb;
mod noise;
mod number;
mod ramp;
mod sample;
mod shape;
mod sines;
mod sponge;
mod tubes;
mod uptake;
mod wavelet;

use glam::DVec3;

pub use ball::Ball;
pub use bowl::Bowl;
pub use cloud::Cloud;
pub use engine::Engine;
pub use gyroid::Gyroid;
pub use head::HeadPhantom;
pub use hydrogen::Hydrogen;
pub use marschner_lobb::MarschnerLobb;
pub use ramp::Ramp;
pub use sample::sample_field;
pub use sines::Sines;
pub use sponge::Sponge;
pub use tubes::Tubes;
pub use uptake::Uptake;
pub use wavelet::Wavelet;

use crate::VoxelType;

/// A scalar function of world position, finite all over its box.
pub trait ScalarField: Send + Sync {
    /// The value at a world position.
    fn value(&self, p: DVec3) -> f64;

    /// The gradient at a world position: value per unit length.
    fn gradient(&self, p: DVec3) -> DVec3;

    /// What a voxel of that width sees at a world position: about the mean of the field over it, so that edges and
    /// thin things finer than the grid neither alias nor show as rings. The value itself unless a field has such
    /// edges; signals that are to show what a filter does with them have none.
    fn seen(&self, p: DVec3, voxel: f64) -> f64 {
        let _ = voxel;
        self.value(p)
    }

    /// The value seen all over a ball, where that is known without asking for each point.
    fn even(&self, center: DVec3, radius: f64, voxel: f64) -> Option<f64> {
        let _ = (center, radius, voxel);
        None
    }

    /// The box it is meant to be sampled in: lowest and highest corner.
    fn bounds(&self) -> (DVec3, DVec3);

    /// Lowest and highest value in that box: exact, or bounds that are nearly reached.
    fn range(&self) -> (f64, f64);

    /// What to call it and how to sample it.
    fn about(&self) -> About;
}

/// What a user should know of a field before sampling it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct About {
    /// Its name in [`by_name`], in kebab case.
    pub name: &'static str,
    /// What it is, in one line.
    pub description: &'static str,
    /// Samples per axis that show it well.
    pub dims: [usize; 3],
    /// Voxel type that suits it.
    pub voxel_type: VoxelType,
    /// Unit of its values.
    pub value_unit: Option<&'static str>,
    /// Unit of its positions.
    pub length_unit: Option<&'static str>,
    /// Whether values are usually stored as whole units (Hounsfield): integer voxels then hold
    /// the values themselves.
    pub whole_units: bool,
}

type Make = fn() -> Box<dyn ScalarField>;

const FIELDS: [(&str, Make); 14] = [
    (marschner_lobb::NAME, || Box::new(MarschnerLobb::default())),
    (ball::NAME, || Box::new(Ball::default())),
    (ramp::NAME, || Box::new(Ramp::default())),
    (tubes::NAME, || Box::new(Tubes::default())),
    (sines::NAME, || Box::new(Sines::default())),
    (wavelet::NAME, || Box::new(Wavelet)),
    (hydrogen::NAME, || Box::new(Hydrogen::default())),
    (head::NAME, || Box::new(HeadPhantom::default())),
    (cloud::NAME, || Box::new(Cloud)),
    (uptake::NAME, || Box::new(Uptake)),
    (gyroid::NAME, || Box::new(Gyroid::default())),
    (bowl::NAME, || Box::new(Bowl::default())),
    (engine::NAME, || Box::new(Engine)),
    (sponge::NAME, || Box::new(Sponge::default())),
];

/// The names of all fields.
pub fn names() -> impl Iterator<Item = &'static str> {
    FIELDS.iter().map(|(name, _)| *name)
}

/// The field of that name with its default settings.
pub fn by_name(name: &str) -> Option<Box<dyn ScalarField>> {
    FIELDS.iter().find(|(known, _)| *known == name).map(|(_, make)| make())
}

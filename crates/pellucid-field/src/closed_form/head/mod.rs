//! A head as computed tomography sees it.
//!
//! Tissues are painted one over the other, each with the share of a small neighbourhood it fills,
//! as the partial-volume effect of a scanner does. All numbers are millimetres and Hounsfield units.

mod bone;
mod brain;
mod face;
mod teeth;
mod vessels;

use glam::DVec3;

use super::footprint::{Footprint, inside};
use super::formula::value_and_gradient;
use super::number::Number;
use super::shape::{bar, blob};
use super::{About, ScalarField};
use crate::VoxelType;

pub(super) const NAME: &str = "head";

/// Hounsfield units of what a head is made of. Enamel stands for the densest there is.
mod hu {
    pub const AIR: f64 = -1000.0;
    pub const FAT: f64 = -95.0;
    pub const WATER: f64 = 6.0;
    pub const WHITE_MATTER: f64 = 28.0;
    pub const GREY_MATTER: f64 = 40.0;
    pub const SKIN: f64 = 45.0;
    pub const MUSCLE: f64 = 58.0;
    pub const DURA: f64 = 75.0;
    pub const BLOOD: f64 = 75.0;
    pub const LENS: f64 = 95.0;
    pub const CARTILAGE: f64 = 130.0;
    pub const PULP: f64 = 60.0;
    pub const MARROW: f64 = 320.0;
    pub const VEIN: f64 = 260.0;
    pub const ARTERY: f64 = 380.0;
    pub const SPONGE: f64 = 480.0;
    pub const THIN_BONE: f64 = 850.0;
    pub const BONE: f64 = 1350.0;
    pub const DENTIN: f64 = 1400.0;
    pub const ENAMEL: f64 = 1800.0;
}

/// Width of the edge between two tissues.
const EDGE: f64 = 1.2;
/// Width of the edges of the large smooth surfaces, skin and skull: as wide as a scanner's blur.
const BROAD_EDGE: f64 = 2.8;

/// A CT angiogram of a head in Hounsfield units (-1000 to 1800), in millimetres on LPS axes: +x to
/// its left, +y to the back, +z up. It has what makes heads hard to draw: bone sheets a voxel
/// thin, marrow between two tables of bone, sinuses, teeth, and vessels full of contrast agent.
///
/// The two sides differ, so that a mirrored picture gives itself away: on the **left** it has an
/// mole on the cheek and an aneurysm of the middle cerebral artery, on the **right** a haemorrhage in the
/// parietal lobe and a gap where the first lower molar was.
#[derive(Clone, Debug)]
pub struct HeadPhantom {
    teeth: Vec<teeth::Tooth>,
    vessels: vessels::Vessels,
    bones: bone::Rods,
}

impl Default for HeadPhantom {
    fn default() -> Self {
        Self { teeth: teeth::all(), vessels: vessels::Vessels::new(), bones: bone::Rods::new() }
    }
}

/// A position while it is being painted.
struct Tissue<N> {
    p: [N; 3],
    /// The same with |x|, for what comes in pairs.
    pair: [N; 3],
    value: N,
    seen: Footprint,
}

impl<N: Number> Tissue<N> {
    /// Share of the voxel inside a shape with an edge `own` wide.
    fn inside(&self, distance: N, own: f64) -> N {
        self.seen.inside(distance, own)
    }

    /// The same with the edge of a large smooth surface.
    fn inside_smooth(&self, distance: N) -> N {
        inside(distance, self.seen.smooth_edge(BROAD_EDGE))
    }

    /// Covers what is inside a shape.
    fn fill(&mut self, hu: f64, distance: N, own: f64) {
        self.paint(hu, self.inside(distance, own));
    }

    /// Covers a share of what is here.
    fn paint(&mut self, hu: f64, share: N) {
        if share.value() > 0.0 {
            self.value = self.value.mix(N::constant(hu), share);
        }
    }

    /// Covers what is inside one shape but outside another that lies within it and is to be covered next.
    fn coat(&mut self, hu: f64, outer: N, inner: N, own: f64) {
        let (outer, inner) = (self.inside(outer, own), self.inside(inner, own));
        if inner.value() < 1.0 {
            // Of what the inner one leaves uncovered.
            self.paint(hu, (outer - inner).max(N::constant(0.0)) * (-inner + 1.0).recip());
        }
    }

    /// Paints a rod on either side; the ends given are the left one's.
    fn rods(&mut self, hu: f64, a: (DVec3, f64), b: (DVec3, f64)) {
        self.paint(hu, bar(self.pair, a, b, EDGE, self.seen));
    }

    /// Paints an ellipsoid.
    fn blob(&mut self, hu: f64, center: [f64; 3], radii: [f64; 3]) {
        self.paint(hu, blob(self.p, center, radii, EDGE, self.seen));
    }

    /// Paints an ellipsoid on either side; the centre given is the left one.
    fn blobs(&mut self, hu: f64, center: [f64; 3], radii: [f64; 3]) {
        self.paint(hu, blob(self.pair, center, radii, EDGE, self.seen));
    }
}

/// A position with |x| for x, rounded off over `round` at the middle, where shapes that come in
/// pairs would otherwise meet in a crease.
fn both_sides<N: Number>([x, y, z]: [N; 3], round: f64) -> [N; 3] {
    [(x.square() + round * round).sqrt(), y, z]
}

impl HeadPhantom {
    fn formula<N: Number>(&self, p: [N; 3], seen: Footprint) -> N {
        let pair = both_sides(p, 0.5);
        let skin = face::skin(p);
        if skin.value() > seen.smooth_edge(BROAD_EDGE) / 2.0 {
            return N::constant(hu::AIR);
        }
        let cavity = bone::cavity(p, pair);
        let mut tissue = Tissue { p, pair, value: N::constant(hu::SKIN), seen };
        // The water around the brain covers whatever would be painted in the cavity before it.
        if cavity.value() > -seen.edge(EDGE) / 2.0 {
            face::paint_flesh(&mut tissue, skin);
            self.vessels.paint_outer(&mut tissue, skin);
            bone::paint(&mut tissue, cavity, skin, &self.bones);
            face::paint_airways(&mut tissue, skin);
            face::paint_eyes(&mut tissue);
            teeth::paint(&mut tissue, &self.teeth);
        }
        tissue.fill(hu::WATER, cavity, EDGE);
        brain::paint(&mut tissue, cavity);
        self.vessels.paint(&mut tissue);
        tissue.paint(hu::AIR, tissue.inside_smooth(-skin));
        tissue.value
    }
}

impl ScalarField for HeadPhantom {
    value_and_gradient!(edges);

    fn even(&self, center: DVec3, radius: f64, voxel: f64) -> Option<f64> {
        // Distances to the skin grow by up to 1.3 a millimetre, beside the ears.
        let reach = Footprint(voxel).smooth_edge(BROAD_EDGE) / 2.0 + 1.3 * radius;
        (face::skin(center.to_array()) > reach).then_some(hu::AIR)
    }

    fn bounds(&self) -> (DVec3, DVec3) {
        (DVec3::new(-102.0, -132.0, -142.0), DVec3::new(102.0, 120.0, 114.0))
    }

    fn range(&self) -> (f64, f64) {
        (hu::AIR, hu::ENAMEL)
    }

    fn about(&self) -> About {
        About {
            name: NAME,
            description: "a CT angiogram of a head, in Hounsfield units and LPS millimetres",
            dims: [205, 253, 257],
            voxel_type: VoxelType::I16,
            value_unit: Some("HU"),
            length_unit: Some("mm"),
            whole_units: true,
        }
    }
}

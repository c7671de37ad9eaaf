//! One volume of a stage.

use std::sync::Arc;

use glam::DVec3;
use pellucid_field::Volume;
use pellucid_optics::{GradientWeight, Material, Perturbation, Scattering, TransferFunction};

use crate::{Crop, Region, Slice};

/// A volume with its optics, nothing left to choose.
#[derive(Clone, Debug)]
pub struct StageVolume {
    /// The voxels.
    pub volume: Arc<Volume>,
    /// The component drawn.
    pub component: usize,
    /// The voxels whose colours it is drawn in, times those of the transfer function: on the same grid.
    pub colors: Option<Arc<Volume>>,
    /// The transfer function; its unit distance is set.
    pub transfer_function: TransferFunction,
    /// How surfaces reflect; `None` leaves them unlit.
    pub material: Option<Material>,
    /// Gradient magnitudes between which unlit turns into lit, if shading is weighted.
    pub gradient_weight: Option<GradientWeight>,
    /// How light is scattered.
    pub scattering: Scattering,
    /// Noise that displaces it and varies its optics.
    pub perturbation: Perturbation,
    /// Where in the world this volume is not clipped or cropped away.
    pub region: Region,
    /// The crop that is a part of the region.
    pub crop: Option<Crop>,
    /// The data value that all values count from, of the volume, its optics and isosurfaces: 0, or the smallest of
    /// integers that single precision would not tell apart.
    pub origin: f64,
}

impl StageVolume {
    /// World distance the transfer function's opacities hold for.
    pub fn unit_distance(&self) -> f64 {
        self.transfer_function.unit_distance().unwrap_or_else(|| self.volume.grid().mean_spacing())
    }

    /// The world position that a slice passes through: its own, or the middle of what the crop leaves of the grid.
    pub fn slice_point(&self, slice: &Slice) -> DVec3 {
        slice.point.map_or_else(|| self.middle(), DVec3::from_array)
    }

    fn middle(&self) -> DVec3 {
        let grid = self.volume.grid();
        let (mut from, mut to) = grid.index_bounds();
        if let Some(crop) = self.crop {
            [from, to] = [crop.from, crop.to].map(|bound| DVec3::from_array(bound).clamp(from, to));
        }
        grid.world_from_index().transform_point3((from + to) / 2.0)
    }
}

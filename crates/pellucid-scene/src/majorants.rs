//! Bounds of the extinction in blocks of the data, for paths that look for their next collision.

use pellucid_field::{Blocks, distances};
use pellucid_optics::{Variation, Visibility, path_extinction};

use crate::{Majorants, StageVolume, TableCache, TableError, Tables};

/// The largest extinction in every block.
#[derive(Clone, Debug)]
pub struct MajorantGrid {
    /// Blocks per axis.
    pub dims: [usize; 3],
    /// Cells of the data along a side of a block.
    pub size: f32,
    /// Per world unit, x fastest.
    pub values: Vec<f32>,
    /// How many blocks away the next one is where there is extinction; 0 if there is some in the block.
    pub distances: Vec<u8>,
}

impl MajorantGrid {
    /// Those of blocks, or one that bounds everything if nothing is known of blocks, where opacities hold for
    /// `unit_distance` world units; `factor` is the most by which the extinction of a value varies.
    fn new(blocks: Option<&Blocks>, visibility: &Visibility, unit_distance: f64, factor: f32) -> Self {
        let bound = |low, high| path_extinction(visibility.max_opacity(low, high), unit_distance) * factor;
        let Some(blocks) = blocks else {
            let values = vec![bound(f32::MIN, f32::MAX)];
            return Self { dims: [1; 3], size: f32::INFINITY, values, distances: vec![0] };
        };
        let of_block = |&range: &[f32; 2]| {
            let [low, high] = Blocks::interpolated(range);
            if range == Blocks::ABSENT { 0.0 } else { bound(low, high) }
        };
        let values: Vec<f32> = blocks.ranges().iter().map(of_block).collect();
        let distances = distances(blocks.dims(), |block| values[block] > 0.0);
        Self { dims: blocks.dims(), size: blocks.size() as f32, values, distances }
    }
}

impl TableCache {
    /// Bounds of the extinction of a volume, for whose tables they are.
    ///
    /// # Errors
    /// [`TableError::Field`] if there is no such component.
    pub fn majorants(
        &mut self,
        tables: &Tables,
        volume: &StageVolume,
        bounds: Majorants,
    ) -> Result<MajorantGrid, TableError> {
        let ranges = match bounds {
            Majorants::Local => self.fine_ranges(tables)?,
            Majorants::Global => None,
        };
        let visibility = Visibility::of_table(&tables.table);
        let most = tables.variation.as_ref().map_or(1.0, Variation::most_extinction);
        Ok(MajorantGrid::new(ranges.as_deref(), &visibility, volume.unit_distance(), most))
    }
}

//! Where light has something to do: slabs and texels that hold matter, as far as a blur reaches from there.

use std::ops::Range;

use glam::{DVec2, DVec3};
use pellucid_field::Grid;
use pellucid_plan::half_angle::Geometry;
use pellucid_plan::{BlockContent, BlockMap};

/// Most groups of blocks per axis that are looked at one by one.
const MOST_GROUPS: usize = 16;

/// Slabs that light has to pass, and the texels in each of them.
pub struct Areas {
    /// The slabs; before the first nothing is lost, and behind the last it matters to nothing.
    pub slabs: Range<u32>,
    /// Texels from and to, for each of them.
    pub texels: Vec<[[u32; 2]; 2]>,
}

/// A box of texels.
#[derive(Clone, Copy)]
struct Rectangle {
    low: DVec2,
    high: DVec2,
}

impl Rectangle {
    const NOTHING: Self = Self { low: DVec2::INFINITY, high: DVec2::NEG_INFINITY };

    fn with(self, other: Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    fn grown(self, by: f64) -> Self {
        Self { low: self.low - by, high: self.high + by }
    }

    fn both(self, other: Self) -> Self {
        Self { low: self.low.max(other.low), high: self.high.min(other.high) }
    }
}

impl Areas {
    /// For slabs in which a blur reaches so many texels, around volumes with their blocks; everything if of any nothing is
    /// known.
    pub fn new(geometry: &Geometry, volumes: &[(&Grid, Option<&BlockMap>)], reach: f64) -> Self {
        let (count, size) = (geometry.slabs.count, geometry.frame.size.map(|n| n as u32));
        let boxes = volumes.iter().map(|(grid, blocks)| {
            let blocks = (*blocks)?;
            let BlockContent::Distances(distances) = &blocks.content else { return None };
            Some((*grid, live_boxes(blocks, distances)))
        });
        let Some(boxes) = boxes.collect::<Option<Vec<_>>>() else {
            return Self { slabs: 0..count as u32, texels: vec![[[0; 2], size]; count] };
        };
        // What begins in every slab, and what ends there.
        let (mut begun, mut ended) = (vec![Rectangle::NOTHING; count], vec![Rectangle::NOTHING; count]);
        let (mut first, mut last) = (count, 0);
        for (grid, (low, high)) in
            boxes.into_iter().flat_map(|(grid, each)| each.into_iter().map(move |one| (grid, one)))
        {
            let (texels, slabs) = seen_by_light(geometry, grid, low, high);
            // A bilinear look from an eye's sample reaches a texel further.
            let texels = texels.grown(2.0);
            begun[slabs.start] = begun[slabs.start].with(texels);
            ended[slabs.end - 1] = ended[slabs.end - 1].with(texels);
            (first, last) = (first.min(slabs.start), last.max(slabs.end));
        }
        // Light is lost where something has been, and matters where something will be.
        let spread = if reach > 0.0 { reach + 1.0 } else { 0.0 };
        let mut lost = Rectangle::NOTHING;
        let grow = |begun: &Rectangle| {
            lost = lost.grown(spread).with(*begun);
            lost
        };
        let lost: Vec<_> = begun.iter().map(grow).collect();
        let mut needed = Rectangle::NOTHING;
        let mut texels: Vec<_> = (first..last.max(first))
            .rev()
            .map(|slab| {
                needed = needed.grown(spread).with(ended[slab]);
                let both = lost[slab].both(needed);
                let limited = |v: DVec2| [v.x, v.y].map(|v| v.clamp(0.0, f64::from(u32::MAX)) as u32);
                let low = limited(both.low.floor());
                let high = limited(both.high.ceil());
                [low, [0, 1].map(|axis| high[axis].min(size[axis]).max(low[axis]))]
            })
            .collect();
        texels.reverse();
        Self { slabs: first as u32..last.max(first) as u32, texels }
    }

    /// The texels of a slab.
    pub fn of(&self, slab: u32) -> [[u32; 2]; 2] {
        self.texels[(slab - self.slabs.start) as usize]
    }
}

/// Boxes of voxels that hold all live blocks: a few blocks at a time, where there are many.
fn live_boxes(blocks: &BlockMap, distances: &[u8]) -> Vec<(DVec3, DVec3)> {
    let [nx, ny, nz] = blocks.dims;
    let side = blocks.dims.into_iter().max().unwrap_or(1).div_ceil(MOST_GROUPS);
    let groups = blocks.dims.map(|n| n.div_ceil(side));
    let mut live = vec![false; groups.iter().product()];
    for (row, distances) in distances.chunks_exact(nx).enumerate() {
        let first = ((row / ny / side) * groups[1] + row % ny / side) * groups[0];
        for (x, _) in distances.iter().enumerate().filter(|(_, distance)| **distance == 0) {
            live[first + x / side] = true;
        }
    }
    debug_assert!(distances.len() == nx * ny * nz);
    let cells = (side * blocks.size) as f64;
    let corner = |group: usize| {
        DVec3::from_array(
            [group % groups[0], group / groups[0] % groups[1], group / groups[0] / groups[1]].map(|g| g as f64),
        ) * cells
    };
    (0..live.len()).filter(|&group| live[group]).map(|group| (corner(group), corner(group) + cells)).collect()
}

/// Texels and slabs in which a box of voxels is.
fn seen_by_light(geometry: &Geometry, grid: &Grid, low: DVec3, high: DVec3) -> (Rectangle, Range<usize>) {
    let (mut texels, mut near, mut far) = (Rectangle::NOTHING, f64::INFINITY, f64::NEG_INFINITY);
    for corner in 0..8 {
        let choose = |axis: usize| if corner >> axis & 1 == 1 { high[axis] } else { low[axis] };
        let world = grid.world_from_index().transform_point3(DVec3::new(choose(0), choose(1), choose(2)));
        let place = geometry.frame.project(world);
        texels = texels.with(Rectangle { low: place, high: place });
        let coordinate = geometry.slabs.coordinate(world);
        (near, far) = (near.min(coordinate), far.max(coordinate));
    }
    let count = geometry.slabs.count;
    // Rounding must not put anything into a slab that is left out.
    let first = ((near - 1e-3).max(0.0) as usize).min(count - 1);
    let end = ((far + 1e-3).max(0.0).ceil() as usize).clamp(first + 1, count);
    (texels, first..end)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn many_blocks_are_looked_at_in_groups() {
        let dims = [40, 3, 17];
        let mut distances = vec![1; dims.iter().product()];
        distances[2 + 40 * (1 + 3 * 16)] = 0;
        let content = BlockContent::Distances(distances.clone());
        let blocks = BlockMap { dims, size: 4, content, levels: None };
        let boxes = live_boxes(&blocks, &distances);
        assert_eq!(boxes, [(DVec3::new(0.0, 0.0, 60.0), DVec3::new(12.0, 12.0, 72.0))]);
    }
}

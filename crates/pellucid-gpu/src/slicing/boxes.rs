//! The boxes of cells that slices are cut into: where blocks are empty nothing is drawn (8.4-2). All boxes are cut
//! by the same slices, and whatever is seen through two of them is drawn in their order.

use bytemuck::{Pod, Zeroable};
use pellucid_field::Grid;
use pellucid_plan::{BlockContent, BlockMap};
use pellucid_scene::Stage;

use crate::bricks::{Brick, sort_boxes};
use crate::texture::Part;

/// Cells whose samples are drawn together: the structure of `slices.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct SliceBox {
    pub low: [u32; 4],
    pub high: [u32; 4],
}

/// Most boxes along the longest axis: smaller ones fit the data more closely and have more slices to draw.
const MOST: usize = 8;

/// The boxes of a brick with something to see, from the nearest on; all of it as one box where nothing is known of
/// its blocks. A sample contributes by voxels up to `reach` cells away.
pub fn boxes(brick: &Brick, blocks: Option<&BlockMap>, reach: usize, stage: &Stage, grid: &Grid) -> Vec<Part> {
    let Some(BlockMap { dims, size, content: BlockContent::Distances(distances), .. }) = blocks else {
        return vec![brick.core];
    };
    let cells = grid.dims().map(|n| (n - 1).max(1));
    let longest = cells.into_iter().max().unwrap_or(1);
    let side = longest.div_ceil(MOST).next_multiple_of(*size);
    // How near blocks that can be seen may be before a block counts as one.
    let is_live = |[x, y, z]: [usize; 3]| match distances[x + dims[0] * (y + dims[1] * z)] {
        0 => true,
        away => (usize::from(away) - 1) * size < reach,
    };
    let places = |axis: usize| brick.core.low[axis] / side..=(brick.core.high[axis] - 1) / side;
    let mut found = Vec::new();
    for z in places(2) {
        for y in places(1) {
            for x in places(0) {
                let place = [x, y, z];
                let cube = Part { low: place.map(|v| v * side), high: place.map(|v| (v + 1) * side) };
                let live = brick.core.common(&cube).and_then(|part| tightened(part, *size, is_live));
                found.extend(live.map(|part| (part, place)));
            }
        }
    }
    sort_boxes(&mut found, stage, grid, |(_, place)| (place.map(|v| v * side), *place));
    found.into_iter().map(|(part, _)| part).collect()
}

/// The smallest box around the live blocks of a part, if there are any.
fn tightened(part: Part, size: usize, is_live: impl Fn([usize; 3]) -> bool) -> Option<Part> {
    let blocks = |axis: usize| part.low[axis] / size..=(part.high[axis] - 1) / size;
    let (mut low, mut high) = (part.high, part.low);
    for z in blocks(2) {
        for y in blocks(1) {
            for x in blocks(0) {
                let block = [x, y, z];
                if is_live(block) {
                    for axis in 0..3 {
                        low[axis] = low[axis].min((block[axis] * size).max(part.low[axis]));
                        high[axis] = high[axis].max(((block[axis] + 1) * size).min(part.high[axis]));
                    }
                }
            }
        }
    }
    (0..3).all(|axis| low[axis] < high[axis]).then_some(Part { low, high })
}

impl From<Part> for SliceBox {
    fn from(part: Part) -> Self {
        let four = |[x, y, z]: [usize; 3]| [x as u32, y as u32, z as u32, 0];
        Self { low: four(part.low), high: four(part.high) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pellucid_field::distances;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn every_live_block_is_in_one_box(
            dims in prop::array::uniform3(1usize..9),
            live in prop::collection::vec(any::<bool>(), 512),
            reach in 0usize..20,
        ) {
            let size = 4;
            let cells = dims.map(|n| n * size);
            let live: Vec<bool> = live[..dims.iter().product()].to_vec();
            let map = BlockMap {
                dims,
                size,
                content: BlockContent::Distances(distances(dims, |block| live[block])),
                levels: None,
            };
            let grid = Grid::new(cells.map(|n| n + 1)).unwrap();
            let stage = crate::bricks::tests::stage(&grid, glam::DVec3::splat(-30.0), grid.center(), true);
            let whole = Part { low: [0; 3], high: cells };
            let brick = Brick { core: whole, voxels: Part { low: [0; 3], high: cells.map(|n| n + 1) }, place: [0; 3] };
            let found = boxes(&brick, Some(&map), reach, &stage, &grid);
            for z in 0..dims[2] {
                for y in 0..dims[1] {
                    for x in 0..dims[0] {
                        let block = [x, y, z];
                        let has = |part: &&Part| {
                            (0..3).all(|a| (part.low[a]..part.high[a]).contains(&(block[a] * size)))
                        };
                        let owners = found.iter().filter(has).count();
                        prop_assert!(owners <= 1);
                        // The nearest cell of a live block may be this far.
                        let near = (0..live.len()).any(|other| {
                            let place = [other % dims[0], other / dims[0] % dims[1], other / dims[0] / dims[1]];
                            let gap = (0..3).map(|a| block[a].abs_diff(place[a])).max().unwrap_or(0);
                            live[other] && (gap == 0 || (gap - 1) * size < reach)
                        });
                        prop_assert!(!near || owners == 1, "{block:?} is in no box of {found:?}");
                    }
                }
            }
        }
    }
}

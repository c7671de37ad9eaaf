//! How far every block is from one that can contribute.

/// The Chebyshev distance of every block, in blocks, to the nearest one for which `live` says yes
/// (7.3-6): 0 for those themselves, at most 255. A block at distance d is the middle of a cube of
/// `2 d - 1` blocks a side that can be leapt over whole. `dims` blocks, x fastest.
///
/// Two sweeps, one from the first block to the last and one back; a block is one further than the
/// nearest of the 13 neighbours that the sweep has passed.
pub fn distances(dims: [usize; 3], live: impl Fn(usize) -> bool) -> Vec<u8> {
    let [nx, ny, nz] = dims;
    // With a border, so that every block has all of its neighbours.
    let stride = [nx + 2, (nx + 2) * (ny + 2)];
    let mut padded = vec![u8::MAX; stride[1] * (nz + 2)];
    let start = |row: usize| 1 + (row % ny + 1) * stride[0] + (row / ny + 1) * stride[1];
    for row in 0..ny * nz {
        for (x, place) in padded[start(row)..][..nx].iter_mut().enumerate() {
            *place = if live(x + nx * row) { 0 } else { u8::MAX };
        }
    }
    let mut nearest = vec![0u8; nx];
    let offsets = [stride[0], stride[1] - stride[0], stride[1], stride[1] + stride[0]];
    for row in 0..ny * nz {
        let at = start(row);
        passed_rows(&padded, offsets.map(|offset| at - offset), &mut nearest);
        let mut left = u8::MAX;
        for (place, &near) in padded[at..at + nx].iter_mut().zip(&nearest) {
            left = (*place).min(near.min(left).saturating_add(1));
            *place = left;
        }
    }
    for row in (0..ny * nz).rev() {
        let at = start(row);
        passed_rows(&padded, offsets.map(|offset| at + offset), &mut nearest);
        let mut right = u8::MAX;
        for (place, &near) in padded[at..at + nx].iter_mut().zip(&nearest).rev() {
            right = (*place).min(near.min(right).saturating_add(1));
            *place = right;
        }
    }
    (0..ny * nz).flat_map(|row| &padded[start(row)..][..nx]).copied().collect()
}

/// For every block of a row the smallest distance in four rows beside it, in columns x - 1 to x + 1.
fn passed_rows(padded: &[u8], rows: [usize; 4], nearest: &mut [u8]) {
    nearest.fill(u8::MAX);
    for row in rows {
        let n = nearest.len();
        let columns = [0, 1, 2].map(|x| &padded[row - 1 + x..][..n]);
        for (x, place) in nearest.iter_mut().enumerate() {
            *place = (*place).min(columns[0][x]).min(columns[1][x]).min(columns[2][x]);
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn distances_are_what_a_search_finds(
            dims in [1usize..9, 1usize..9, 1usize..9],
            seed in 0u64..1000,
            rarity in 1u64..60,
        ) {
            let [nx, ny, nz] = dims;
            let hash = |block: usize| (block as u64 + 7).wrapping_mul(0x9E37_79B9_7F4A_7C15 ^ seed) >> 40;
            let live = |block: usize| hash(block) % rarity == 0;
            let live: Vec<bool> = (0..nx * ny * nz).map(live).collect();
            let found = distances(dims, |block| live[block]);
            let position = |b: usize| [b % nx, b / nx % ny, b / (nx * ny)];
            for block in 0..live.len() {
                let from = position(block);
                let to = |other| position(other).iter().zip(from).map(|(a, b)| a.abs_diff(b)).max().unwrap_or(0);
                let exact = (0..live.len()).filter(|&other| live[other]).map(to).min().unwrap_or(255);
                prop_assert_eq!(usize::from(found[block]), exact, "block {:?} of {:?}", from, dims);
            }
        }
    }
}

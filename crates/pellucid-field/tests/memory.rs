//! What a pass over a volume takes beside the volume.
#![cfg(target_os = "linux")]

use pellucid_field::{Blocks, Grid, Volume};

/// The most memory this process has ever held, in bytes.
fn peak() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let line = status.lines().find(|line| line.starts_with("VmHWM:")).unwrap();
    line.split_whitespace().nth(1).unwrap().parse::<u64>().unwrap() * 1024
}

/// The only test in its process. A single row of voxels is not looked at as a whole: beside their ranges, blocks take
/// next to nothing.
#[test]
fn long_rows_take_no_more_than_others() {
    const VOXELS: usize = 1 << 26;
    let volume = Volume::new(Grid::new([VOXELS, 1, 1]).unwrap(), vec![7u8; VOXELS]).unwrap();
    let before = peak();
    let blocks = Blocks::new(&volume, 0, Blocks::CELLS, 0).unwrap();
    let taken = peak() - before;
    let ranges = size_of_val(blocks.ranges()) as u64;
    assert!(taken < ranges + (8 << 20), "{taken} bytes for {ranges} of ranges");
}

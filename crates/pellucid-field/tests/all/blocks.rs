//! Block ranges against looking at every voxel.

use glam::DVec3;
use half::f16;
use pellucid_field::{Blocks, FieldError, Filter, Grid, Sampler, SincWindow, ValueMap, Volume, Voxel, Voxels};
use proptest::prelude::*;

/// Values of any kind, some of them absent in float types.
fn volume<T: Voxel>(dims: [usize; 3], components: usize, map: ValueMap, seed: u64) -> Volume {
    let count = dims.iter().product::<usize>() * components;
    let mut state = seed;
    let values: Vec<T> = (0..count)
        .map(|_| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            match state >> 60 {
                0..4 => T::from_f64(f64::NAN),
                4 => T::from_f64(f64::INFINITY),
                _ => T::from_f64((state >> 40) as f64 / 997.0 - 3000.0),
            }
        })
        .collect();
    let grid = Grid::new(dims).unwrap();
    Volume::with_components(grid, values, components).unwrap().with_value_map(map).unwrap()
}

fn check(volume: &Volume, component: usize, size: usize, reach: usize) {
    let blocks = Blocks::new(volume, component, size, reach).unwrap();
    let dims = volume.grid().dims();
    assert_eq!(blocks.dims(), dims.map(|n| (n - 1).max(1).div_ceil(size)));
    let [bx, by, bz] = blocks.dims();
    for (z, y, x) in (0..bz).flat_map(|z| (0..by).flat_map(move |y| (0..bx).map(move |x| (z, y, x)))) {
        let span = |b: usize, n: usize| (b * size).saturating_sub(reach)..((b + 1) * size + reach + 1).min(n);
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for k in span(z, dims[2]) {
            for j in span(y, dims[1]) {
                for i in span(x, dims[0]) {
                    let value = volume.value([i, j, k], component);
                    if value.is_finite() {
                        (low, high) = (low.min(value), high.max(value));
                    }
                }
            }
        }
        match blocks.range([x, y, z]) {
            None => assert!(low > high),
            Some([least, most]) => {
                // Outward, and by no more than one step of f32.
                assert!(f64::from(least) <= low && f64::from(least.next_up()) > low, "{least} for {low}");
                assert!(f64::from(most) >= high && f64::from(most.next_down()) < high, "{most} for {high}");
            }
        }
    }
}

macro_rules! for_types {
    ($($type:ty),+; $check:expr) => {
        $( { let make = volume::<$type>; $check(&make); } )+
    };
}

type Make<'a> = &'a dyn Fn([usize; 3], usize, ValueMap, u64) -> Volume;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn ranges_are_those_of_brute_force(
        dims in [1usize..14, 1usize..14, 1usize..14],
        components in 1usize..4,
        size in 1usize..9,
        reach in 0usize..4,
        scale in prop::sample::select(vec![1.0, -0.3, 0.1]),
        seed: u64,
    ) {
        let map = ValueMap { scale, offset: -1024.0 };
        for_types!(u8, i8, u16, i16, u32, i32, f16, f32; |make: Make| {
            check(&make(dims, components, map, seed), components - 1, size, reach)
        });
    }
}

/// Rows are looked at in parts, and the parts meet.
#[test]
fn long_rows_are_those_of_brute_force() {
    for (size, reach) in [(8, 0), (8, 3), (3, 1), (1, 0)] {
        check(&volume::<i16>([9001, 2, 3], 2, ValueMap::IDENTITY, 7), 1, size, reach);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]
    /// Whatever lies in a block, holes and all, no sample leaves its range by more than a filter's share.
    #[test]
    fn overshot_ranges_hold_the_samples_of_their_filter(
        dims in [6usize..12, 6usize..12, 6usize..12],
        size in 1usize..5,
        filter in prop::sample::select(vec![
            Filter::CATMULL_ROM,
            Filter::MITCHELL,
            Filter::Sinc { window: SincWindow::Lanczos, half_width: 3 },
            Filter::Sinc { window: SincWindow::Blackman, half_width: 2 },
        ]),
        at in prop::collection::vec([0.0..1.0f64, 0.0..1.0f64, 0.0..1.0f64], 60),
        seed: u64,
    ) {
        let volume = volume::<f32>(dims, 1, ValueMap { scale: -0.3, offset: 7.0 }, seed);
        let blocks = Blocks::new(&volume, 0, size, filter.half_width() - 1).unwrap().overshot(filter.overshoot());
        let sampler = Sampler::new(&volume, 0, filter).unwrap();
        for share in at {
            let index = DVec3::from_array(share) * DVec3::from_array(dims.map(|n| (n - 1) as f64));
            let value = sampler.value(index);
            let range = blocks.range(blocks.block_at(index));
            if value.is_finite() {
                let [low, high] = range.unwrap().map(f64::from);
                prop_assert!((low..=high).contains(&value), "{filter:?} at {index}: {value} in {low}..={high}");
            }
        }
    }
}

/// Voxels of 1 under positive weights of the middle of a cell and 0 under negative ones: the share is
/// reached, so it is no larger than it must be.
#[test]
fn ranges_overshoot_by_the_share_and_no_further() {
    let ones = |i: usize| (0..3).filter(|axis| matches!(i / 4usize.pow(*axis) % 4, 0 | 3)).count() % 2 == 0;
    let values: Vec<f32> = (0..64).map(|i| f32::from(u8::from(ones(i)))).collect();
    let volume = Volume::new(Grid::new([4, 4, 4]).unwrap(), Voxels::from(values)).unwrap();
    let filter = Filter::CATMULL_ROM;
    let blocks = Blocks::new(&volume, 0, 4, 1).unwrap();
    let middle = Sampler::new(&volume, 0, filter).unwrap().value(DVec3::splat(1.5));
    let [low, high] = blocks.overshot(filter.overshoot()).ranges()[0].map(f64::from);
    assert!((middle..middle + 2e-3).contains(&high), "{middle} and {high}");
    assert!((low - (1.0 - high)).abs() < 1e-6, "{low} and {high}");
    assert_eq!(blocks.overshot(0.0), blocks);
    let nothing = Volume::new(Grid::new([2, 2, 2]).unwrap(), Voxels::from(vec![f32::NAN; 8])).unwrap();
    assert_eq!(Blocks::new(&nothing, 0, 4, 1).unwrap().overshot(0.5).ranges(), [Blocks::ABSENT]);
}

#[test]
fn lines_and_slivers_have_blocks() {
    for (dims, size) in [([1, 1, 50], 8), ([1, 70, 1], 7), ([2049, 3, 2], 16), ([1, 1, 1], 4), ([3, 2, 2], 2)] {
        for reach in [0, 1, 3] {
            check(&volume::<i16>(dims, 1, ValueMap::IDENTITY, 5), 0, size, reach);
            check(&volume::<f32>(dims, 2, ValueMap::IDENTITY, 6), 1, size, reach);
        }
    }
}

#[test]
fn a_block_of_nothing_is_marked_and_positions_find_their_blocks() {
    let mut values = vec![1.0f32; 9 * 3 * 3];
    for (i, value) in values.iter_mut().enumerate() {
        *value = if i % 9 >= 4 { f32::NAN } else { *value };
    }
    let volume = Volume::new(Grid::new([9, 3, 3]).unwrap(), Voxels::from(values)).unwrap();
    let blocks = Blocks::new(&volume, 0, 4, 0).unwrap();
    assert_eq!(blocks.ranges(), [[1.0, 1.0], Blocks::ABSENT]);
    assert_eq!(blocks.range([1, 0, 0]), None);
    for (x, block) in [(-3.0, 0), (0.0, 0), (3.99, 0), (4.0, 1), (8.0, 1), (100.0, 1), (f64::NAN, 0)] {
        assert_eq!(blocks.block_at(DVec3::new(x, 1.0, 1.0)), [block, 0, 0]);
    }
    assert!(matches!(Blocks::new(&volume, 0, 0, 0), Err(FieldError::Parameter { name: "block size", .. })));
    assert!(matches!(Blocks::new(&volume, 1, 4, 0), Err(FieldError::Parameter { name: "component", .. })));
    assert_eq!(Blocks::new(&volume, 0, usize::MAX, usize::MAX).map(|blocks| blocks.dims()), Ok([1, 1, 1]));
}

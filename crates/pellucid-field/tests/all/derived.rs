//! Histograms against sorting, pyramids against what they must keep, crops against the world, components against voxels.

use glam::{DAffine3, DMat3, DVec3};
use half::f16;
use pellucid_field::{FieldError, Grid, Histogram, ValueMap, Volume, Voxel, Voxels, component, crop, halve, pyramid};
use proptest::prelude::*;

/// A rotated, sheared, mirrored and shifted grid.
fn skewed(dims: [usize; 3]) -> Grid {
    let linear = DMat3::from_cols_array(&[0.5, 0.1, 0.0, -0.2, 0.7, 0.3, 0.1, 0.0, -2.0]);
    Grid::with_affine(dims, DAffine3 { matrix3: linear, translation: DVec3::new(10.0, -20.0, 5.0) }).unwrap()
}

/// A volume from a function of voxel and component.
fn make<T: Voxel>(grid: Grid, components: usize, value: impl Fn([usize; 3], usize) -> f64) -> Volume {
    let [nx, ny, _] = grid.dims();
    let values: Vec<T> = (0..grid.len() * components)
        .map(|i| (i / components, i % components))
        .map(|(i, component)| T::from_f64(value([i % nx, i / nx % ny, i / nx / ny], component)))
        .collect();
    Volume::with_components(grid, values, components).unwrap()
}

fn world(volume: &Volume, [x, y, z]: [usize; 3]) -> DVec3 {
    volume.grid().world_from_index().transform_point3(DVec3::new(x as f64, y as f64, z as f64))
}

fn every_voxel(volume: &Volume) -> impl Iterator<Item = [usize; 3]> {
    let [nx, ny, nz] = volume.grid().dims();
    (0..nx * ny * nz).map(move |i| [i % nx, i / nx % ny, i / nx / ny])
}

fn mean(volume: &Volume) -> f64 {
    every_voxel(volume).map(|voxel| volume.value(voxel, 0)).sum::<f64>() / volume.grid().len() as f64
}

const SLOPE: DVec3 = DVec3::new(0.03, -0.02, 0.01);

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn pyramids_keep_ramps_and_means(dims in [1usize..23, 1usize..23, 1usize..23]) {
        let grid = skewed(dims);
        let ramp = |p: DVec3| SLOPE.dot(p) + 0.5;
        let at = |[x, y, z]: [usize; 3]| grid.world_from_index().transform_point3(DVec3::new(x as f64, y as f64, z as f64));
        let fine = make::<f32>(grid, 1, |voxel, _| ramp(at(voxel)));
        let levels = pyramid(&fine, None).unwrap();
        prop_assert_eq!(levels.last().unwrap().grid().dims(), [1, 1, 1]);
        for (coarse, finer) in levels[1..].iter().zip(&levels) {
            prop_assert_eq!(coarse.grid().dims(), finer.grid().dims().map(|n| n.div_ceil(2)));
            prop_assert!((mean(coarse) - mean(&fine)).abs() < 1e-6);
            for voxel in every_voxel(coarse) {
                let error = (coarse.value(voxel, 0) - ramp(world(coarse, voxel))).abs();
                prop_assert!(error < 1e-6, "{error} at {voxel:?} of {:?}", coarse.grid().dims());
            }
        }
    }

    #[test]
    fn histograms_agree_with_sorting(values in prop::collection::vec(-50.0f32..50.0, 1..300), bins in 1usize..70, q in 0.0..=1.0f64) {
        let mut sorted: Vec<f64> = values.iter().map(|v| f64::from(*v)).collect();
        let mut with_gaps = values.clone();
        with_gaps.extend([f32::NAN, f32::INFINITY, f32::NEG_INFINITY]);
        let volume = Volume::new(Grid::new([with_gaps.len(), 1, 1]).unwrap(), with_gaps).unwrap();
        let histogram = Histogram::new(&volume, 0, bins).unwrap();
        prop_assert_eq!((histogram.total(), histogram.absent()), (values.len() as u64, 3));
        sorted.sort_by(f64::total_cmp);
        let exact = sorted[(q * (sorted.len() - 1) as f64) as usize];
        let found = histogram.percentile(q).unwrap();
        prop_assert!((found - exact).abs() <= histogram.width() * (1.0 + 1e-9), "{found} for {exact}");
        let (low, width) = (histogram.range().0, histogram.width());
        for (bin, &count) in histogram.counts().iter().enumerate() {
            // Values within rounding of an edge may fall to either side.
            let between = |slack: f64| {
                let (a, b) = (low + bin as f64 * width, low + (bin + 1) as f64 * width);
                let last = if bin + 1 == bins { f64::INFINITY } else { b };
                sorted.iter().filter(|v| **v >= a - slack && **v < last + slack).count() as u64
            };
            prop_assert!((between(-1e-9)..=between(1e-9)).contains(&count));
        }
    }

    #[test]
    fn level_histograms_are_exact(values in prop::collection::vec(any::<i16>(), 1..200), scale in prop::sample::select(vec![1.0, 0.5, -2.0]), q in 0.0..=1.0f64) {
        let map = ValueMap { scale, offset: 3.0 };
        let mut sorted: Vec<f64> = values.iter().map(|v| map.value(f64::from(*v))).collect();
        sorted.sort_by(f64::total_cmp);
        let volume = Volume::new(Grid::new([values.len(), 1, 1]).unwrap(), values).unwrap().with_value_map(map).unwrap();
        let histogram = Histogram::of_levels(&volume, 0).unwrap();
        prop_assert_eq!(histogram.total(), sorted.len() as u64);
        prop_assert_eq!(histogram.percentile(q), Some(sorted[(q * (sorted.len() - 1) as f64) as usize]));
        for (bin, &count) in histogram.counts().iter().enumerate().filter(|(_, count)| **count > 0) {
            prop_assert_eq!(sorted.iter().filter(|v| **v == histogram.middle(bin)).count() as u64, count);
        }
    }
}

#[test]
fn every_type_is_averaged_and_kept() {
    fn check<T: Voxel>() {
        // Means of pairs that end in 1/2 and in whole numbers; the second component is offset.
        let volume =
            make::<T>(Grid::new([4, 2, 2]).unwrap(), 2, |[x, _, _], component| (10 * x + 20 * component) as f64);
        let coarse = halve(&volume).unwrap();
        assert_eq!(coarse.voxels().voxel_type(), T::TYPE);
        assert_eq!(coarse.grid().dims(), [2, 1, 1]);
        let found: Vec<f64> = (0..4).map(|i| coarse.voxels().get(i)).collect();
        assert_eq!(found, [5.0, 25.0, 25.0, 45.0], "{}", T::TYPE);
    }
    check::<u8>();
    check::<i8>();
    check::<u16>();
    check::<i16>();
    check::<u32>();
    check::<i32>();
    check::<f16>();
    check::<f32>();
}

#[test]
fn a_coarse_sample_is_absent_only_if_all_it_replaces_are() {
    let values = vec![f32::NAN, f32::NAN, 4.0, f32::INFINITY, 1.0, 2.0];
    let volume = Volume::new(Grid::new([6, 1, 1]).unwrap(), values).unwrap();
    let coarse = halve(&volume).unwrap();
    assert!(coarse.value([0, 0, 0], 0).is_nan());
    assert_eq!(coarse.value([1, 0, 0], 0), 4.0);
    assert_eq!(coarse.value([2, 0, 0], 0), 1.5);
}

#[test]
fn pyramids_stop_when_told_and_keep_names() {
    let mut volume = make::<u8>(Grid::new([9, 5, 1]).unwrap(), 1, |[x, ..], _| x as f64).with_name("ramp");
    volume.value_unit = Some("K".into());
    let volume = volume.with_value_map(ValueMap { scale: 2.0, offset: 1.0 }).unwrap();
    let levels = pyramid(&volume, Some(3)).unwrap();
    let dims: Vec<_> = levels.iter().map(|level| level.grid().dims()).collect();
    assert_eq!(dims, [[9, 5, 1], [5, 3, 1], [3, 2, 1]]);
    assert_eq!(levels[2].name, "ramp");
    assert_eq!(levels[2].value_unit.as_deref(), Some("K"));
    assert_eq!(levels[2].value_map(), volume.value_map());
    assert_eq!(pyramid(&volume, Some(0)).unwrap().len(), 1);
}

#[test]
fn crops_stay_where_they_are_in_every_type() {
    fn check<T: Voxel>() {
        let whole = make::<T>(skewed([7, 6, 5]), 3, |[x, y, z], component| (x + 3 * y + 7 * z + 20 * component) as f64);
        let (from, size) = ([2, 1, 3], [4, 5, 2]);
        let part = crop(&whole, from, size).unwrap();
        assert_eq!((part.grid().dims(), part.components()), (size, 3));
        assert_eq!(part.voxels().voxel_type(), T::TYPE);
        for voxel in every_voxel(&part) {
            let original = [0, 1, 2].map(|axis| voxel[axis] + from[axis]);
            assert!((world(&part, voxel) - world(&whole, original)).length() < 1e-12);
            for component in 0..3 {
                assert_eq!(part.value(voxel, component), whole.value(original, component), "{}", T::TYPE);
            }
        }
    }
    check::<u8>();
    check::<i8>();
    check::<u16>();
    check::<i16>();
    check::<u32>();
    check::<i32>();
    check::<f16>();
    check::<f32>();
}

#[test]
fn regions_outside_the_grid_are_refused() {
    let volume = make::<u8>(Grid::new([4, 4, 4]).unwrap(), 1, |_, _| 0.0);
    for (from, size) in
        [([0, 0, 0], [4, 0, 4]), ([1, 0, 0], [4, 4, 4]), ([0, 0, 5], [1, 1, 1]), ([0, 2, 0], [1, usize::MAX, 1])]
    {
        assert_eq!(crop(&volume, from, size).err(), Some(FieldError::Region { from, size, dims: [4, 4, 4] }));
    }
}

#[test]
fn otsu_parts_two_heaps_and_the_mode_is_the_higher_one() {
    let heaps: Vec<u8> = [(20u8, 30), (21, 60), (22, 30), (200, 20), (201, 40), (202, 20)]
        .iter()
        .flat_map(|&(value, count)| std::iter::repeat_n(value, count))
        .collect();
    let volume = Volume::new(Grid::new([heaps.len(), 1, 1]).unwrap(), heaps).unwrap();
    // The middle of the empty bins: between levels 22 and 200; between bins that end at 23 and begin at 200.
    let levels = Histogram::of_levels(&volume, 0).unwrap();
    for (histogram, middle) in [(levels, 111.0), (Histogram::new(&volume, 0, 182).unwrap(), 111.5)] {
        assert_eq!(histogram.otsu(), Some(middle));
        assert!((histogram.mode().unwrap() - 21.0).abs() < 1.0);
    }
}

#[test]
fn components_are_counted_apart_and_nothing_has_no_percentile() {
    let pair = make::<f32>(Grid::new([100, 1, 1]).unwrap(), 2, |[x, ..], component| (x + 1000 * component) as f64);
    let second = Histogram::new(&pair, 1, Histogram::BINS).unwrap();
    assert_eq!(second.range(), (1000.0, 1099.0));
    assert_eq!(second.total(), 100);
    assert_eq!(second.counts()[0], 1, "only the lowest value, not those of the first component");
    assert!(matches!(Histogram::new(&pair, 2, 8), Err(FieldError::Parameter { name: "component", .. })));
    assert!(matches!(Histogram::new(&pair, 0, 0), Err(FieldError::Parameter { name: "bins", .. })));

    let nothing = Volume::new(Grid::new([5, 1, 1]).unwrap(), Voxels::from(vec![f32::NAN; 5])).unwrap();
    let empty = Histogram::new(&nothing, 0, 4).unwrap();
    assert_eq!((empty.total(), empty.absent()), (0, 5));
    assert_eq!((empty.percentile(0.5), empty.mode(), empty.otsu()), (None, None, None));

    let same = Volume::new(Grid::new([5, 1, 1]).unwrap(), Voxels::from(vec![1e30f32; 5])).unwrap();
    let single = Histogram::new(&same, 0, 4).unwrap();
    assert_eq!((single.total(), single.otsu()), (5, None));
}

#[test]
fn levels_are_for_short_integers() {
    for (voxels, has) in [
        (Voxels::from(vec![1u8]), true),
        (Voxels::from(vec![1i8]), true),
        (Voxels::from(vec![1u16]), true),
        (Voxels::from(vec![1i16]), true),
        (Voxels::from(vec![1u32]), false),
        (Voxels::from(vec![1i32]), false),
        (Voxels::from(vec![f16::ONE]), false),
        (Voxels::from(vec![1f32]), false),
    ] {
        let volume = Volume::new(Grid::new([1, 1, 1]).unwrap(), voxels).unwrap();
        assert_eq!(Histogram::of_levels(&volume, 0).is_some(), has);
        assert!(Histogram::of_levels(&volume, 1).is_none());
        assert_eq!(Histogram::new(&volume, 0, 3).unwrap().counts(), [0, 1, 0]);
    }
}

#[test]
fn a_component_by_itself_has_its_values() {
    let map = ValueMap { scale: 0.5, offset: -3.0 };
    let value = |[x, y, z]: [usize; 3], component: usize| (x + 7 * y + 31 * z + 50 * component) as f64;
    for components in 1..=4 {
        let mut whole =
            make::<u16>(skewed([5, 4, 3]), components, value).with_value_map(map).unwrap().with_name("cells");
        whole.value_unit = Some("counts".to_owned());
        for number in 0..components {
            let alone = component(&whole, number).unwrap();
            assert_eq!((alone.components(), alone.grid(), alone.value_map()), (1, whole.grid(), map));
            assert_eq!((&alone.name, &alone.value_unit), (&whole.name, &whole.value_unit));
            assert!(every_voxel(&whole).all(|voxel| alone.value(voxel, 0) == whole.value(voxel, number)));
            let range = alone.statistics();
            // From the first voxel to the last.
            let expected = [0, 4 + 7 * 3 + 31 * 2].map(|place| map.value((50 * number + place) as f64));
            assert_eq!([range.min, range.max], expected);
        }
        assert!(matches!(component(&whole, components), Err(FieldError::Parameter { name: "component", .. })));
    }
}

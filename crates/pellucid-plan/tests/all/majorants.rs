//! Bounds of the extinction against looks at the field.

use std::sync::Arc;

use glam::DVec3;
use pellucid_field::{Filter, Grid, Sampler, Volume};
use pellucid_optics::{
    Color, ColorPoint, Displacement, Octave, OpacityPoint, Perturbation, PropertyNoise, TransferFunction,
    path_extinction,
};
use pellucid_plan::{MajorantGrid, PlanCache, Tables};
use pellucid_scene::{Majorants, Scene, Source, Stage, VolumeEntry};

const DIMS: [usize; 3] = [21, 18, 23];

/// Waves of values from 0 to 1, with or without a hole.
fn waves(hole: bool) -> Arc<Volume> {
    let grid = Grid::with_spacing(DIMS, [0.5, 1.0, 0.7], [0.0; 3]).unwrap();
    let value = |k: usize| {
        let [x, y, z] = [k % DIMS[0], k / DIMS[0] % DIMS[1], k / (DIMS[0] * DIMS[1])].map(|i| i as f32);
        0.5 + 0.5 * (0.3 * x + 0.2 * y).sin() * (0.25 * z - 0.1 * x).cos()
    };
    let mut values: Vec<f32> = (0..grid.len()).map(value).collect();
    if hole {
        values[1234] = f32::NAN;
    }
    Arc::new(Volume::new(grid, values).unwrap())
}

fn stage(volume: Arc<Volume>, filter: Filter, perturbation: Perturbation) -> Stage {
    let opacities = [(0.0, 0.0), (0.15, 0.0), (0.3, 0.7), (0.6, 0.2), (0.9, 0.95)];
    let opacities = opacities.map(|(value, opacity)| OpacityPoint::new(value, opacity)).to_vec();
    let tf = TransferFunction::new(vec![ColorPoint::new(0.0, Color::WHITE)], opacities).unwrap();
    let entry = VolumeEntry { transfer_function: Some(tf), perturbation, ..VolumeEntry::new(Source::memory()) };
    let mut scene = Scene { volumes: vec![entry], ..Scene::default() };
    scene.quality.filter = filter;
    scene.resolve(&[volume]).unwrap().0
}

/// The extinction at a position in index space.
fn extinction(tables: &Tables, unit_distance: f64, index: DVec3) -> f32 {
    let sampler = Sampler::new(&tables.field, tables.component, tables.filter).unwrap();
    let last = DVec3::from_array(DIMS.map(|n| (n - 1) as f64));
    let value = |at: DVec3| sampler.value(at.clamp(DVec3::ZERO, last)) as f32;
    let place = index.as_vec3().to_array();
    let moved = tables.displacer.as_ref().map(|displacer| displacer.source(place, || value(index)));
    let value = moved.map_or_else(|| value(index), |at| value(DVec3::from_array(at.map(f64::from))));
    let factor = tables.variation.as_ref().map_or(1.0, |variation| variation.extinction(variation.at(place)));
    // Between nodes of the table it is the extinction that is linear.
    let position = tables.table.nodes().clamped_position(value);
    let node = (position as usize).min(tables.table.entries().len() - 2);
    let [from, to] = [node, node + 1].map(|node| path_extinction(tables.table.entries()[node][3], unit_distance));
    if value.is_nan() { 0.0 } else { (from + (to - from) * (position - node as f32)) * factor }
}

#[test]
fn extinctions_lie_between_the_bounds_of_their_blocks() {
    let octaves = vec![Octave::new(2.0, 1.0), Octave::new(5.0, 0.5)];
    let noisy = Perturbation {
        displacement: Displacement { amplitude: 0.12, octaves, between: None },
        optics: PropertyNoise { opacity: 0.8, ..PropertyNoise::default() },
        ..Perturbation::default()
    };
    for (filter, perturbation, hole) in [
        (Filter::Linear, Perturbation::default(), false),
        (Filter::Linear, Perturbation::default(), true),
        (Filter::Linear, noisy.clone(), false),
        (Filter::CATMULL_ROM, Perturbation::default(), false),
        (Filter::BSpline { prefilter: true }, noisy, false),
    ] {
        let stage = stage(waves(hole), filter, perturbation);
        let mut cache = PlanCache::default();
        let tables = cache.tables(&stage, 0).unwrap();
        let unit = stage.volumes[0].unit_distance();
        let mut bounds = |bounds| cache.majorants(&stage, 0, &tables, bounds).unwrap();
        let (local, global) = (bounds(Majorants::Local), bounds(Majorants::Global));
        let dims = local.leaps.dims();
        let block = |p: DVec3| {
            let [x, y, z] = [0, 1, 2].map(|axis| ((p[axis] / f64::from(local.size)) as usize).min(dims[axis] - 1));
            x + dims[0] * (y + dims[1] * z)
        };
        let mut state = 1u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 11) as f64 / (1u64 << 53) as f64
        };
        let (mut bounded, mut above) = (0, 0);
        for _ in 0..20_000 {
            let p = DVec3::new(random(), random(), random()) * DVec3::from_array(DIMS.map(|n| (n - 1) as f64));
            let found = extinction(&tables, unit, p);
            let inside = |[least, most]: [f32; 2]| (least * 0.999_99..=most * 1.000_01).contains(&found);
            let own = local.bounds[block(p)];
            assert!(inside(own), "{filter:?}, {hole}: {found} at {p}, {own:?}");
            assert!(inside(global.bounds[0]) && (own[1] > 0.0) == (local.leaps.distance(block(p)) == 0));
            bounded += usize::from(own[1] < 0.99 * global.bounds[0][1]);
            above += usize::from(own[0] > 0.0);
        }
        let exact = filter == Filter::Linear && tables.displacer.is_none();
        assert!(!exact || bounded > 10_000, "{bounded} positions have a bound of their own");
        // One value that is absent may be anywhere.
        let is_bounded_below = if hole { above == 0 } else { !exact || above > 100 };
        assert!(is_bounded_below, "{filter:?}: {above} positions are in blocks without holes");
    }
}

#[test]
fn bounds_are_kept_while_the_tables_are() {
    let mut stage = stage(waves(false), Filter::Linear, Perturbation::default());
    let mut cache = PlanCache::default();
    let mut bounds = |stage: &Stage, bounds| -> Arc<MajorantGrid> {
        let tables = cache.tables(stage, 0).unwrap();
        cache.majorants(stage, 0, &tables, bounds).unwrap()
    };
    let first = bounds(&stage, Majorants::Local);
    assert!(Arc::ptr_eq(&first, &bounds(&stage, Majorants::Local)));
    assert_eq!(bounds(&stage, Majorants::Global).bounds.len(), 1);
    let tf = &mut stage.volumes[0].transfer_function;
    *tf = tf.clone().with_unit_distance(Some(7.0)).unwrap();
    assert_ne!(first.bounds, bounds(&stage, Majorants::Local).bounds);
}

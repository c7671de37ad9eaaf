//! The engine against the plain f64 reference, on random scenes: every mode, with every instruction
//! set, with and without skipping.

use std::sync::Arc;

use crate::common::data::Data;
use crate::common::random::{Case, case, sparse_case};
use crate::reference::{DEPTH, NORMAL, Reading, Reference, Seen};
use glam::DVec3;
use pellucid_cpu::{CpuRenderer, InstructionSet};
use pellucid_field::{Filter, Gradient, SincWindow};
use pellucid_optics::PreIntegration;
use pellucid_plan::PlanCache;
use pellucid_scene::{Classification, Combine, Control, Frame, Isosurface, Mode, Slice, Stage, SurfaceSearch};
use proptest::prelude::*;

/// The largest difference of a channel, before anything is quantised.
const CHANNEL: f64 = 1e-4;

/// What is wrong with a pixel, if anything is.
fn wrong(stage: &Stage, frame: &Frame, pixel: usize, seen: &Seen) -> Option<String> {
    let extreme = match stage.mode() {
        Mode::Maximum | Mode::Minimum => true,
        Mode::Slice(slice) => matches!(slice.combine, Combine::Maximum | Combine::Minimum),
        _ => false,
    };
    let volume = &stage.volumes[0].volume;
    // At the border of a hole the field ends in the middle of a slope: so much for where rounding puts that.
    let absent = volume.statistics().nan + volume.statistics().infinite;
    let border = if extreme && absent > 0 { 1e-3 } else { 0.0 };
    let color = frame.color[pixel].map(f64::from);
    let near = |a: f64, b: f64, bound: f64| a == b || (a - b).abs() <= bound;
    if !(0..4).all(|channel| near(color[channel], seen.color[channel], CHANNEL + border + seen.doubt[channel])) {
        return Some(format!("color {color:.6?}, reference {:.6?}", seen.color));
    }
    let depth = f64::from(frame.depth[pixel]);
    // The frame keeps distances as f32.
    // Where a field is flat, as around an extreme, its place is known to the root of what its value is known to.
    let flat = if extreme { 2e-3 * volume.grid().mean_spacing() } else { 0.0 };
    let rounding = 1e-7 * depth + flat;
    if let Some(exact) = seen.depth.filter(|&exact| !near(depth, exact, DEPTH * stage.step + rounding)) {
        return Some(format!("depth {depth}, reference {exact}"));
    }
    let normal = glam::Vec3::from_array(frame.normal[pixel]).as_dvec3();
    let exact = seen.normal.filter(|exact| !normal.abs_diff_eq(*exact, NORMAL))?;
    Some(format!("normal {normal}, reference {exact}"))
}

/// The other readings of the definition.
fn readings() -> impl Iterator<Item = Reading> {
    let signs = |bits: i32| DVec3::from_array([0, 1, 2].map(|axis| f64::from(bits >> axis & 1) * 2.0 - 1.0));
    let shifts = std::iter::once(DVec3::ZERO).chain((0..8).map(move |bits| signs(bits) * 1e-5));
    shifts.flat_map(|shift| [0.0, 1e-4].map(|slack| Reading { shift, slack })).skip(1)
}

/// Makes sure that every pixel is what the reference says, under any reading.
fn check(stage: &Stage, frame: &Frame, plain: &[Option<Seen>], table: Table) -> Result<(), TestCaseError> {
    for (pixel, seen) in plain.iter().enumerate() {
        let wrong = |seen: Option<Seen>| wrong(stage, frame, pixel, &seen?);
        let Some(message) = wrong(*seen) else { continue };
        let (x, y) = (pixel % frame.width, pixel / frame.width);
        let read = |reading| Reference::new(stage, reading).with_table(table.clone()).pixel(x, y);
        prop_assert!(readings().any(|reading| wrong(read(reading)).is_none()), "pixel {x}, {y}: {message}");
    }
    Ok(())
}

/// The table that defines pre-integrated segments, if the reference does not integrate them itself.
type Table = Option<Arc<PreIntegration>>;

/// Draws a scene with every instruction set, with and without skipping.
fn check_all(
    case: &Case,
    mode: &Mode,
    classification: Classification,
    table: impl Fn(&Stage) -> Table,
) -> Result<(), TestCaseError> {
    let stages = [false, true].map(|skipping| (skipping, case.stage(mode, classification, skipping)));
    let stage = &stages[0].1;
    let table = table(stage);
    let reference = Reference::new(stage, Reading::default()).with_table(table.clone());
    let (width, height) = (stage.viewpoint.width, stage.viewpoint.height);
    let plain: Vec<Option<Seen>> = (0..width * height).map(|i| reference.pixel(i % width, i / width)).collect();
    for set in [InstructionSet::Avx512, InstructionSet::Avx2, InstructionSet::Baseline] {
        let Ok(mut renderer) = CpuRenderer::new().with_instructions(set) else { continue };
        for (skipping, stage) in &stages {
            let frame = renderer.render(stage, &Control::default()).unwrap();
            check(stage, &frame, &plain, table.clone())
                .map_err(|error| TestCaseError::fail(format!("{set}, skipping {skipping}, {mode:?}: {error}")))?;
        }
    }
    Ok(())
}

/// Without a table.
fn integrated(_: &Stage) -> Table {
    None
}

/// The table of a stage.
fn tabulated(stage: &Stage) -> Table {
    let staged = &stage.volumes[0];
    let range = PlanCache::default().tables(stage, 0).unwrap().range;
    let ratio = stage.step / staged.unit_distance();
    Some(Arc::new(PreIntegration::for_data(&staged.transfer_function, &range, ratio).unwrap()))
}

/// As many cases, or with `PELLUCID_TIMES=10` ten times as many; other ones with `PROPTEST_RNG_SEED=1`.
fn config(cases: u32) -> ProptestConfig {
    let times = std::env::var("PELLUCID_TIMES").map_or(1, |times| times.parse().unwrap());
    ProptestConfig {
        cases: cases * times,
        max_shrink_iters: 200,
        failure_persistence: None,
        ..ProptestConfig::default()
    }
}

proptest! {
    #![proptest_config(config(100))]

    #[test]
    fn post_classified(case in case()) {
        check_all(&case, &Mode::Composite, Classification::Post, integrated)?;
    }

    #[test]
    fn isosurfaces(case in case(), mode in surfaces()) {
        check_all(&case, &mode, Classification::Post, integrated)?;
    }

    #[test]
    fn extremes(case in case(), mode in prop::sample::select(vec![Mode::Maximum, Mode::Minimum])) {
        check_all(&case, &mode, Classification::Post, integrated)?;
    }
}

fn slice() -> impl Strategy<Value = Mode> {
    let combine = prop::sample::select(vec![Combine::Maximum, Combine::Minimum, Combine::Average]);
    let normal = prop::option::of([-1.0..1.0f64, -1.0..1.0f64, 0.1..1.0f64]);
    let thickness = prop_oneof![Just(0.0), 0.5..6.0f64];
    (combine, normal, thickness)
        .prop_map(|(combine, normal, thickness)| Mode::Slice(Slice { normal, thickness, combine, ..Slice::default() }))
}

/// Filters and gradients beside the usual ones.
fn reconstruction() -> impl Strategy<Value = (Filter, Gradient)> {
    let sinc = |window, half_width| Filter::Sinc { window, half_width };
    let filters = vec![
        Filter::Linear,
        Filter::Nearest,
        Filter::BSpline { prefilter: false },
        Filter::BSpline { prefilter: true },
        Filter::CATMULL_ROM,
        Filter::MITCHELL,
        sinc(SincWindow::Lanczos, 3),
        sinc(SincWindow::Kaiser, 2),
    ];
    let gradients = vec![
        Gradient::Central,
        Gradient::Forward,
        Gradient::Backward,
        Gradient::Sobel,
        Gradient::SobelIsotropic,
        Gradient::Prewitt,
        Gradient::Gaussian { sigma: 0.8 },
        Gradient::BSpline,
    ];
    (prop::sample::select(filters), prop::sample::select(gradients))
}

/// Random scenes of volumes that wide sums fit into, and whose middle is away from borders.
fn roomy_case() -> impl Strategy<Value = Case> {
    (case(), [6usize..16, 6usize..16, 6usize..16])
        .prop_map(|(case, dims)| Case { data: Data { dims, ..case.data }, ..case })
}

/// Isosurfaces however they are looked for; a case has their levels.
fn surfaces() -> impl Strategy<Value = Mode> {
    prop::sample::select(vec![SurfaceSearch::Exact, SurfaceSearch::Sampled])
        .prop_map(|search| Mode::Isosurface(Isosurface { search, ..Isosurface::new(Vec::new()) }))
}

/// The modes that leap over empty blocks.
fn leaping() -> impl Strategy<Value = (Mode, Classification)> {
    let modes = vec![Mode::Composite, Mode::Additive, Mode::XRay, Mode::Maximum, Mode::Minimum];
    let preintegrated = Just((Mode::Composite, Classification::PreIntegrated));
    let post = |mode| (mode, Classification::Post);
    prop_oneof![
        5 => prop::sample::select(modes).prop_map(post),
        2 => surfaces().prop_map(post),
        2 => preintegrated,
    ]
}

proptest! {
    #![proptest_config(config(100))]

    #[test]
    fn empty_space(case in sparse_case(), (mode, classification) in leaping()) {
        let preintegrated = classification == Classification::PreIntegrated;
        check_all(&case, &mode, classification, if preintegrated { tabulated } else { integrated })?;
    }
}

proptest! {
    #![proptest_config(config(32))]

    #[test]
    fn other_reconstructions(case in case(), (filter, gradient) in reconstruction()) {
        let case = case.reconstructed(filter, gradient);
        check_all(&case, &Mode::Composite, Classification::Post, integrated)?;
    }

    #[test]
    fn roomy_reconstructions(case in roomy_case(), (filter, gradient) in reconstruction()) {
        let case = case.reconstructed(filter, gradient);
        check_all(&case, &Mode::Composite, Classification::Post, integrated)?;
    }

    #[test]
    fn reconstructed_empty_space(case in sparse_case(), (filter, gradient) in reconstruction()) {
        let case = case.reconstructed(filter, gradient);
        check_all(&case, &Mode::Composite, Classification::Post, integrated)?;
    }

    #[test]
    fn reconstructed_extremes(case in roomy_case(), (filter, gradient) in reconstruction()) {
        let case = case.reconstructed(filter, gradient);
        check_all(&case, &Mode::Maximum, Classification::Post, integrated)?;
    }

    #[test]
    fn pre_classified(case in case()) {
        check_all(&case, &Mode::Composite, Classification::Pre, integrated)?;
    }

    #[test]
    fn preintegrated(case in case()) {
        check_all(&case.straight(), &Mode::Composite, Classification::PreIntegrated, integrated)?;
    }

    #[test]
    fn preintegrated_by_table(case in case()) {
        check_all(&case, &Mode::Composite, Classification::PreIntegrated, tabulated)?;
    }

    #[test]
    fn sums(case in case(), mode in prop::sample::select(vec![Mode::Average, Mode::Additive, Mode::XRay])) {
        check_all(&case, &mode, Classification::Post, integrated)?;
    }

    #[test]
    fn slices(case in case(), mode in slice()) {
        check_all(&case, &mode, Classification::Post, integrated)?;
    }
}

/// Values a thousand times as large as the differences that the transfer function shows.
#[test]
fn a_mean_of_large_values() {
    let value = |p: DVec3| 1000.0 + 0.3 * (p.y * 0.7).sin() + 0.2 * (1.7 * p.x + p.z).sin();
    let tf = crate::common::transfer_function(&[(999.5, 0x000000), (1000.5, 0xffffff)], &[(0.0, 0.9)]);
    let stage = crate::common::stage(crate::common::unit_volume([8, 200, 8], value), tf, |scene| {
        crate::common::set_mode(scene, Mode::Average);
        scene.quality.step = 0.1;
    });
    let frame = crate::common::render(&stage);
    let reference = Reference::new(&stage, Reading::default());
    for pixel in 0..frame.color.len() {
        let seen = reference.pixel(pixel % frame.width, pixel / frame.width).unwrap();
        assert_eq!(wrong(&stage, &frame, pixel, &seen), None);
    }
}

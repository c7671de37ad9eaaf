//! Closed-form fields against finite differences, published values and what is known of them.

use glam::DVec3;
use pellucid_field::closed_form::{
    Ball, HeadPhantom, Hydrogen, MarschnerLobb, ScalarField, Sines, Wavelet, by_name, names, sample_field,
};
use pellucid_field::{FieldError, VoxelType};

/// Evenly scattered points in [0, 1]^3 (Halton).
fn scattered(count: u32) -> impl Iterator<Item = DVec3> {
    let radical = |mut i: u32, base: u32| {
        let (mut value, mut digit) = (0.0, 1.0);
        while i > 0 {
            digit /= f64::from(base);
            value += digit * f64::from(i % base);
            i /= base;
        }
        value
    };
    (1..=count).map(move |i| DVec3::new(radical(i, 2), radical(i, 3), radical(i, 5)))
}

fn points(field: &dyn ScalarField, count: u32) -> impl Iterator<Item = DVec3> {
    let (low, high) = field.bounds();
    scattered(count).map(move |t| low + (high - low) * t)
}

fn check_gradient(field: &dyn ScalarField, count: u32) {
    let (low, high) = field.bounds();
    let extent = (high - low).max_element();
    let h = 3e-7 * extent;
    let (lowest, highest) = field.range();
    let floor = (highest - lowest) / extent * 1e-2;
    let mut sloped = 0;
    for p in points(field, count) {
        let gradient = field.gradient(p);
        // Of fourth order: edges are sharp enough for the error of the plain one to show.
        let pair = |step: DVec3| field.value(p + step) - field.value(p - step);
        let difference = |axis: DVec3| (8.0 * pair(h * axis) - pair(2.0 * h * axis)) / (12.0 * h);
        let expected = DVec3::new(difference(DVec3::X), difference(DVec3::Y), difference(DVec3::Z));
        let tolerance = 1e-5 * gradient.length().max(floor);
        let name = field.about().name;
        assert!(
            (gradient - expected).length() <= tolerance,
            "{name} at {p}: {gradient} but differences say {expected}"
        );
        sloped += u32::from(gradient.length() > floor);
    }
    assert!(sloped > count / 100, "only {sloped} points with a slope");
}

#[test]
fn gradients_agree_with_central_differences() {
    for name in names() {
        check_gradient(&*by_name(name).unwrap(), 10_000);
    }
    for (n, l, m) in orbitals() {
        check_gradient(&Hydrogen::new(n, l, m).unwrap(), 300);
    }
}

#[test]
fn ranges_hold_and_are_nearly_reached() {
    for name in names() {
        let field = by_name(name).unwrap();
        assert_eq!(field.about().name, name);
        let (low, high) = field.range();
        let volume = sample_field(&*field, field.about().dims.map(|n| n.min(96)), VoxelType::F32).unwrap();
        let found = volume.statistics();
        assert!(found.min >= low - 1e-6 && found.max <= high + 1e-6, "{name}: {found:?}");
        let slack = 0.07 * (high - low);
        let values = points(&*field, 300_000).map(|p| field.value(p));
        let (least, most) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
        assert!(least >= low - 1e-6 && most <= high + 1e-6, "{name}: {least} to {most}");
        assert!(least <= low + slack && most >= high - slack, "{name}: {least} to {most} in {low}..{high}");
    }
    let gentle = Sines { frequency: 0.1 };
    assert!((gentle.range().1 - gentle.value(DVec3::ONE)).abs() < 1e-15);
}

#[test]
fn marschner_lobb_has_the_values_of_its_formula() {
    let field = MarschnerLobb::default();
    let trough = (11.0f64 / 12.0).acos() * 2.0 / std::f64::consts::PI;
    for (p, expected) in [
        (DVec3::ZERO, 0.6),
        (DVec3::X, 0.6),
        (DVec3::Z, 0.2),
        (DVec3::NEG_Z, 1.0),
        (DVec3::new(0.0, trough, 0.0), 0.4),
        (DVec3::new(0.6 * trough, -0.8 * trough, 1.0), 0.0),
    ] {
        assert!((field.value(p) - expected).abs() < 1e-12, "{p}: {}", field.value(p));
    }
}

#[test]
fn wavelet_is_the_one_vtk_makes() {
    // ParaView's Information panel shows RTData in [37.3531, 276.829], and its spreadsheet begins
    // with 60.7635.
    let volume = sample_field(&Wavelet, [21; 3], VoxelType::F32).unwrap();
    let found = volume.statistics();
    assert!((found.min - 37.353_104).abs() < 1e-4 && (found.max - 276.828_83).abs() < 1e-4, "{found:?}");
    assert!((volume.value([0, 0, 0], 0) - 60.763_466).abs() < 1e-4);
    assert!((volume.value([10, 10, 10], 0) - 260.0).abs() < 1e-4);
}

#[test]
fn balls_are_round_and_half_way_at_their_radius() {
    let ball = Ball { radius: 0.5, edge: 0.4 };
    for t in scattered(100) {
        let direction = (t - 0.5).normalize();
        assert!((ball.value(direction * 0.5) - 0.5).abs() < 1e-12);
        assert_eq!(ball.value(direction * 0.29), 1.0);
        assert_eq!(ball.value(direction * 0.71), 0.0);
        assert!((ball.gradient(direction * 0.6).normalize() + direction).length() < 1e-12);
    }
}

fn orbitals() -> impl Iterator<Item = (u32, u32, i32)> {
    (1..=4).flat_map(|n| (0..n).flat_map(move |l| (-(l as i32)..=l as i32).map(move |m| (n, l, m))))
}

#[test]
fn hydrogen_decays_and_vanishes_where_it_should() {
    let ground = Hydrogen::new(1, 0, 0).unwrap();
    for r in [0.0, 0.5, 1.0, 3.0] {
        assert!((ground.value(DVec3::new(0.0, r * 0.6, r * 0.8)) - (-2.0 * r).exp()).abs() < 1e-12);
    }
    let dumbbell = Hydrogen::new(2, 1, 0).unwrap();
    assert!((dumbbell.value(DVec3::new(0.0, 0.0, 2.0)) - 1.0).abs() < 1e-9, "r^2 exp(-r) peaks at 2");
    assert_eq!(dumbbell.value(DVec3::new(1.0, 2.0, 0.0)), 0.0);
    let default = Hydrogen::default();
    assert!(default.value(DVec3::new(0.0, 0.0, 12.0)) < 1e-20, "4d has its radial node at 12");
    assert!(default.value(DVec3::new(2f64.sqrt(), 0.0, 1.0)) < 1e-20, "d_z2 vanishes on its cone");
    for (n, l, m) in [(0, 0, 0), (5, 0, 0), (2, 2, 0), (3, 1, -2)] {
        assert!(matches!(Hydrogen::new(n, l, m), Err(FieldError::Parameter { .. })), "{n} {l} {m}");
    }
}

#[test]
fn every_orbital_has_the_mean_radius_of_quantum_mechanics_and_peaks_at_one() {
    for (n, l, m) in orbitals() {
        let orbital = Hydrogen::new(n, l, m).unwrap();
        let half = orbital.bounds().1.x;
        let (mut mass, mut moment, mut top) = (0.0, 0.0, DVec3::ZERO);
        let cells = 72;
        for i in 0..cells * cells * cells {
            let at = [i % cells, i / cells % cells, i / cells / cells].map(|i| (i as f64 + 0.5) / f64::from(cells));
            let p = (DVec3::from_array(at) * 2.0 - 1.0) * half;
            let density = orbital.value(p);
            mass += density;
            moment += density * p.length();
            top = if density > orbital.value(top) { p } else { top };
        }
        let expected = f64::from(3 * n * n - l * (l + 1)) / 2.0;
        assert!((moment / mass / expected - 1.0).abs() < 0.02, "{n} {l} {m}: {} for {expected}", moment / mass);
        // Climb from the best of these points.
        let mut step = half / f64::from(cells);
        while step > 1e-7 {
            let around = DVec3::AXES.into_iter().flat_map(|axis| [top + axis * step, top - axis * step]);
            match around.max_by(|a, b| orbital.value(*a).total_cmp(&orbital.value(*b))) {
                Some(next) if orbital.value(next) > orbital.value(top) => top = next,
                _ => step /= 2.0,
            }
        }
        let peak = orbital.value(top);
        assert!((peak - 1.0).abs() < 1e-6, "{n} {l} {m}: {peak} at {top}");
    }
}

#[test]
fn the_head_has_its_tissues_where_they_belong() {
    let head = HeadPhantom::default();
    let at = |x: f64, y: f64, z: f64| head.value(DVec3::new(x, y, z));
    let (left, right) = (1.0, -1.0);
    for side in [left, right] {
        assert_eq!(at(101.0 * side, -100.0, 100.0), -1000.0, "outside");
        assert!((at(31.5 * side, -74.5, -8.0) - 6.0).abs() < 1.0, "vitreous body");
        assert!(at(0.0, -25.0, -130.0) < -990.0, "windpipe");
        assert!(at(7.0 * side, -26.0, -13.0) < -990.0, "sphenoid sinus");
        assert!(at(19.0 * side, -5.0, 55.0) < 45.0 && at(19.0 * side, -5.0, 55.0) > 5.0, "brain");
        assert!((at(8.5 * side, 10.0, 32.5) - 6.0).abs() < 2.0, "lateral ventricle");
        assert!((at(25.0 * side, 5.0, -48.0) - 380.0).abs() < 20.0, "internal carotid artery");
    }
    assert!(at(0.0, 30.0, 70.0) > 60.0, "falx");
    // A ray through the vault to the left: skin, outer table, marrow, inner table.
    let ray: Vec<f64> = (0..240).map(|i| at(78.0 - f64::from(i) * 0.1, 10.0, 40.0)).collect();
    let peaks = ray.windows(3).filter(|w| w[1] > 1000.0 && w[1] >= w[0] && w[1] > w[2]).count();
    assert_eq!(peaks, 2, "two tables of bone");
    // What tells left from right.
    let cheek = |side: f64| (0..400).map(|i| -100.0 + f64::from(i) * 0.1).find(|y| at(36.0 * side, *y, -52.0) > -500.0);
    let stands_out = cheek(right).unwrap() - cheek(left).unwrap();
    assert!((1.0..3.0).contains(&stands_out), "a mole on the left cheek, {stands_out} mm");
    assert!(at(47.2, -16.2, 6.9) > 370.0 && at(-47.2, -16.2, 6.9) < 100.0, "aneurysm on the left");
    assert!(at(-37.0, 34.0, 50.0) > 70.0 && at(37.0, 34.0, 50.0) < 50.0, "haemorrhage on the right");
    let lower_molars = |side: f64| {
        let enamel = |p: DVec3| head.value(DVec3::new(p.x * side, p.y, p.z)) > 1600.0;
        scattered(20_000).filter(|t| enamel(DVec3::new(18.0, -66.0, -80.0) + DVec3::new(14.0, 24.0, 8.0) * *t)).count()
    };
    assert!(lower_molars(right) * 10 < lower_molars(left) * 9, "a molar is missing on the right");
    assert!(lower_molars(right) > 0);
}

#[test]
fn sampling_spans_the_box_and_keeps_values_in_every_type() {
    for name in ["marschner-lobb", "head", "wavelet"] {
        let field = by_name(name).unwrap();
        let (low, high) = field.bounds();
        for voxel_type in VoxelType::ALL {
            let volume = sample_field(&*field, [9, 7, 8], voxel_type).unwrap();
            assert_eq!(volume.voxels().voxel_type(), voxel_type);
            assert_eq!(volume.name, name);
            let (first, last) = volume.grid().world_bounds();
            assert!((first - low).length() < 1e-9 && (last - high).length() < 1e-9);
            let (lowest, highest) = field.range();
            let step = match voxel_type {
                VoxelType::F16 => lowest.abs().max(highest) / 1024.0,
                VoxelType::F32 => lowest.abs().max(highest) / 8e6,
                _ => volume.value_map().scale,
            };
            for (x, y, z) in [(0, 0, 0), (3, 4, 5), (8, 6, 7), (4, 2, 3)] {
                let p = volume.grid().world_from_index().transform_point3(DVec3::new(x as f64, y as f64, z as f64));
                // Signals are sampled at points, fields with edges as voxels see them.
                let width = volume.grid().spacing().iter().product::<f64>().cbrt();
                let expected = if name == "head" { field.seen(p, width) } else { field.value(p) };
                let error = (volume.value([x, y, z], 0) - expected).abs();
                assert!(error <= step * 0.5 + 1e-9, "{name} {voxel_type}: {error} at {p}");
            }
        }
    }
}

#[test]
fn hounsfield_units_stay_hounsfield_units_where_they_fit() {
    let head = HeadPhantom::default();
    let wide = sample_field(&head, [4; 3], VoxelType::I16).unwrap();
    assert_eq!((wide.value_map().scale, wide.value_map().offset), (1.0, 0.0));
    assert_eq!((wide.value_unit.as_deref(), wide.length_unit.as_deref()), (Some("HU"), Some("mm")));
    let narrow = sample_field(&head, [4; 3], VoxelType::U8).unwrap();
    assert_eq!(narrow.value_map().value(0.0), -1000.0);
    assert!((narrow.value_map().value(255.0) - 1800.0).abs() < 1e-9);
}

#[test]
fn a_single_sample_lies_in_the_middle_and_none_is_an_error() {
    let flat = sample_field(&Wavelet, [5, 1, 3], VoxelType::F32).unwrap();
    let (low, high) = flat.grid().world_bounds();
    assert!((low + 10.0).length() < 1e-12 && (high - 10.0).length() < 1e-12);
    assert!((flat.value([2, 0, 1], 0) - 260.0).abs() < 1e-4);
    assert!(matches!(sample_field(&Wavelet, [5, 0, 3], VoxelType::F32), Err(FieldError::Dims { .. })));
    assert!(by_name("Head").is_none());
}

/// The mean of a field under a Gaussian, by points a quarter of a voxel apart.
fn mean(field: &dyn ScalarField, p: DVec3, voxel: f64, deviation: f64) -> f64 {
    let taps: Vec<(f64, f64)> =
        (-8..=8).map(|i| f64::from(i) / 4.0).map(|t| (t, (-0.5 * (t / deviation).powi(2)).exp())).collect();
    let (mut sum, mut whole) = (0.0, 0.0);
    for (x, wx) in &taps {
        for (y, wy) in &taps {
            for (z, wz) in &taps {
                let weight = wx * wy * wz;
                sum += weight * field.value(p + voxel * DVec3::new(*x, *y, *z));
                whole += weight;
            }
        }
    }
    sum / whole
}

/// Root mean squares of what differs from that mean: as voxels see the field, and at points; as shares of its range.
fn errors(field: &dyn ScalarField, cells: f64, deviation: f64, count: u32) -> [f64; 2] {
    let (low, high) = field.bounds();
    let voxel = (high - low).max_element() / cells;
    let (mut squares, mut found) = ([0.0; 2], 0);
    for p in points(field, 20_000) {
        let (seen, value) = (field.seen(p, voxel), field.value(p));
        // Where there is something to blur.
        let sloped = field.gradient(p).length() * voxel > 0.02 * (field.range().1 - field.range().0);
        if found < count && (sloped || (seen - value).abs() > 0.02 * (field.range().1 - field.range().0)) {
            let expected = mean(field, p, voxel, deviation);
            squares = [squares[0] + (seen - expected).powi(2), squares[1] + (value - expected).powi(2)];
            found += 1;
        }
    }
    assert_eq!(found, count, "{}: too few points with edges", field.about().name);
    squares.map(|sum| (sum / f64::from(count)).sqrt() / (field.range().1 - field.range().0))
}

#[test]
fn voxels_see_the_mean_of_what_is_finer_than_they_are() {
    // The deviations of the steps over 3 and 4.5 voxels: 0.57 and 0.85.
    // The cloud's own edges are nearly as wide as the steps.
    for (name, cells, deviation, bound) in [
        ("head", 128.0, 0.6, 0.035),
        ("head", 256.0, 0.65, 0.02),
        ("tubes", 96.0, 0.57, 0.03),
        ("cloud", 48.0, 0.4, 0.06),
        ("engine", 104.0, 0.57, 0.03),
        ("sponge", 64.0, 0.8, 0.05),
    ] {
        let [seen, at_points] = errors(&*by_name(name).unwrap(), cells, deviation, 150);
        println!("{name} {cells}: {seen:.4}, at points {at_points:.4}");
        assert!(seen < bound && seen < 0.7 * at_points, "{name} of {cells}: {seen}, at points {at_points}");
    }
    let [seen, at_points] = errors(&Ball { radius: 0.7, edge: 1e-3 }, 48.0, 0.85, 150);
    // A quintic step is not quite the Gaussian's, and near the surface of a ball nothing hides that.
    assert!(seen < 0.03 && at_points > 0.2, "sharp ball: {seen}, at points {at_points}");
}

#[test]
fn a_sharp_ball_has_no_rings() {
    let (ball, n) = (Ball { radius: 0.7, edge: 1e-3 }, 49);
    let voxels = |volume: &dyn Fn(DVec3) -> f64| {
        let step = 2.0 / (n - 1) as f64;
        let at = |i: usize| DVec3::new((i % n) as f64, (i / n % n) as f64, (i / n / n) as f64) * step - 1.0;
        (0..n * n * n).map(|i| volume(at(i))).collect::<Vec<f64>>()
    };
    /// Trilinear, at a place in voxels.
    fn trilinear(voxels: &[f64], n: usize, place: DVec3) -> f64 {
        let (floor, t) = (place.floor(), place - place.floor());
        let corner = |i: usize| {
            let step = [i & 1, i >> 1 & 1, i >> 2];
            let weight = (0..3).map(|a| if step[a] == 1 { t[a] } else { 1.0 - t[a] }).product::<f64>();
            let [x, y, z] = [0, 1, 2].map(|a| floor[a] as usize + step[a]);
            weight * voxels[x + n * (y + n * z)]
        };
        (0..8).map(corner).sum()
    }
    // How far normals on an isosurface are off, in degrees.
    let residual = |voxels: &[f64], level: f64| {
        let middle = DVec3::splat((n - 1) as f64 / 2.0);
        let squares = scattered(2000).map(|t| {
            let (height, angle) = (2.0 * t.x - 1.0, std::f64::consts::TAU * t.y);
            let out = DVec3::new(angle.cos(), angle.sin(), 0.0) * (1.0f64 - height * height).sqrt() + DVec3::Z * height;
            let (mut inner, mut outer) = (12.0, 21.0);
            while outer - inner > 1e-6 {
                let between = (inner + outer) / 2.0;
                let inside = trilinear(voxels, n, middle + out * between) > level;
                (inner, outer) = if inside { (between, outer) } else { (inner, between) };
            }
            let p = middle + out * inner;
            let slope = |axis: DVec3| trilinear(voxels, n, p - axis) - trilinear(voxels, n, p + axis);
            let normal = DVec3::new(slope(DVec3::X), slope(DVec3::Y), slope(DVec3::Z)).normalize();
            normal.dot(out).clamp(-1.0, 1.0).acos().to_degrees().powi(2)
        });
        (squares.sum::<f64>() / 2000.0).sqrt()
    };
    let sampled = sample_field(&ball, [n; 3], VoxelType::F32).unwrap();
    let sampled: Vec<f64> = (0..n * n * n).map(|i| sampled.value([i % n, i / n % n, i / n / n], 0)).collect();
    let points = voxels(&|p| ball.value(p));
    for level in [0.25, 0.5, 0.75] {
        let (found, before) = (residual(&sampled, level), residual(&points, level));
        assert!(found < 1.6 && before > 5.0, "level {level}: {found} degrees, {before} from points");
    }
}

#[test]
fn what_is_filled_at_once_is_what_each_voxel_sees() {
    for name in ["head", "cloud"] {
        let field = by_name(name).unwrap();
        let volume = sample_field(&*field, [57, 43, 49], VoxelType::F32).unwrap();
        let (grid, width) = (volume.grid(), volume.grid().spacing().iter().product::<f64>().cbrt());
        for i in 0..grid.len() {
            let at = [i % 57, i / 57 % 43, i / 57 / 43];
            let p = grid.world_from_index().transform_point3(DVec3::from_array(at.map(|i| i as f64)));
            let error = (volume.value(at, 0) - field.seen(p, width)).abs();
            assert!(error < 1e-3, "{name} at {at:?}: {error}");
        }
    }
}

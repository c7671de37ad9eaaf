//! The denoiser: noise goes, edges and light stay.

use pellucid_scene::{Cancel, Cancelled, Control, Frame, denoise};

/// A frame of one depth and coverage, of these luminances and noise.
fn frame(side: usize, value: impl Fn(usize) -> f32, noise: f32) -> Frame {
    let mut frame = Frame::new(side, side);
    for pixel in 0..side * side {
        let v = value(pixel);
        frame.color[pixel] = [v, v, v, 1.0];
        frame.depth[pixel] = 10.0;
        frame.noise[pixel] = noise;
    }
    frame
}

/// Numbers of mean 0 and variance 1 that look random.
fn normal(pixel: usize) -> f32 {
    let hash = |seed: usize| {
        let v = (pixel * 2 + seed + 1) as u64;
        let v = (v ^ v << 31).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let v = (v ^ v >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((v ^ v >> 31) >> 40) as f32 / (1 << 24) as f32
    };
    (0..12).map(|k| hash(k * 7919)).sum::<f32>() - 6.0
}

fn run(frame: &Frame) -> Vec<[f32; 4]> {
    let mut smooth = frame.clone();
    denoise(&mut smooth, 16, &Control::default()).unwrap();
    // Nothing but colours is changed.
    assert_eq!((&smooth.depth, &smooth.normal, &smooth.noise), (&frame.depth, &frame.normal, &frame.noise));
    smooth.color
}

fn rmse(colors: &[[f32; 4]], truth: impl Fn(usize) -> f32) -> f32 {
    let squares = colors.iter().enumerate().map(|(pixel, color)| (color[0] - truth(pixel)).powi(2));
    (squares.sum::<f32>() / colors.len() as f32).sqrt()
}

#[test]
fn without_noise_nothing_changes() {
    let frame = frame(24, |pixel| (pixel * 37 % 101) as f32 / 101.0, 0.0);
    assert_eq!(run(&frame), frame.color);
}

#[test]
fn an_even_picture_stays_so_and_its_noise_goes() {
    let even = run(&frame(24, |_| 0.7, 0.1));
    assert!(even.iter().all(|color| (color[0] - 0.7).abs() < 1e-5 && color[3] == 1.0));
    const SIDE: usize = 64;
    let noisy = frame(SIDE, |pixel| 0.7 + 0.1 * normal(pixel), 0.1);
    let smooth = run(&noisy);
    let mean = |colors: &[[f32; 4]]| colors.iter().map(|c| f64::from(c[0])).sum::<f64>() / (SIDE * SIDE) as f64;
    // Roundings of single precision alone.
    assert!((mean(&smooth) - mean(&noisy.color)).abs() < 1e-6, "{} and {}", mean(&smooth), mean(&noisy.color));
    let [before, after] = [&noisy.color, &smooth].map(|colors| rmse(colors, |_| 0.7));
    assert!(before > 0.09 && after < before / 4.0, "{before}, then {after}");
}

#[test]
fn edges_of_colour_and_of_guides_are_kept() {
    const SIDE: usize = 64;
    let right = |pixel: usize| pixel % SIDE >= SIDE / 2;
    // A step of five deviations, told by the colours alone.
    let step = |pixel| if right(pixel) { 0.8 } else { 0.3 };
    let mut noisy = frame(SIDE, |pixel| step(pixel) + 0.1 * normal(pixel), 0.1);
    let by_color = run(&noisy);
    let column = |colors: &[[f32; 4]], x: usize| (0..SIDE).map(|y| colors[y * SIDE + x][0]).sum::<f32>() / SIDE as f32;
    assert!(column(&by_color, 31) < 0.37 && column(&by_color, 32) > 0.73, "{}", column(&by_color, 31));
    // A step of one deviation, which only guides tell: each of them does, and without them it is blurred.
    let faint = |pixel| if right(pixel) { 0.6 } else { 0.5 };
    noisy = frame(SIDE, |pixel| faint(pixel) + 0.1 * normal(pixel), 0.1);
    let contrast = |frame: &Frame| {
        let smooth = run(frame);
        let side = |columns: std::ops::Range<usize>| columns.map(|x| column(&smooth, x)).sum::<f32>() / 3.0;
        side(32..35) - side(29..32)
    };
    let raw = (32..35).map(|x| column(&noisy.color, x) - column(&noisy.color, x - 3)).sum::<f32>() / 3.0;
    let blurred = contrast(&noisy);
    let guided = |guide: &dyn Fn(&mut Frame, usize)| {
        let mut frame = noisy.clone();
        (0..SIDE * SIDE).filter(|pixel| right(*pixel)).for_each(|pixel| guide(&mut frame, pixel));
        contrast(&frame)
    };
    let mut faced = noisy.clone();
    faced.normal.fill([0.0, 0.0, 1.0]);
    (0..SIDE * SIDE).filter(|pixel| right(*pixel)).for_each(|pixel| faced.normal[pixel] = [1.0, 0.0, 0.0]);
    let kept = [
        guided(&|frame, pixel| frame.depth[pixel] = 12.0),
        guided(&|frame, pixel| frame.color[pixel][3] = 0.2),
        contrast(&faced),
    ];
    assert!(blurred < 0.6 * raw, "{blurred} of {raw}");
    assert!(kept.iter().all(|kept| *kept > 0.7 * raw), "{kept:?} of {raw}");
}

fn sums(colors: &[[f32; 4]]) -> [f64; 4] {
    [0, 1, 2, 3].map(|c| colors.iter().map(|color| f64::from(color[c])).sum())
}

/// A path that is thousands of times as bright as others, in a dark and in a bright place, by an edge and at the
/// border of the picture: its light is there afterwards, and nowhere to be seen.
#[test]
fn speckles_vanish_and_their_light_does_not() {
    const SIDE: usize = 48;
    let right = |pixel: usize| pixel % SIDE >= SIDE / 2;
    let level = |pixel| if right(pixel) { 0.5 } else { 0.02 };
    let mut noisy = frame(SIDE, |pixel| level(pixel) * (1.0 + 0.2 * normal(pixel)), 0.0);
    let speckles = [[10, 10], [0, 30], [22, 40], [24, 5], [40, 24], [47, 47]].map(|[x, y]| y * SIDE + x);
    for pixel in 0..SIDE * SIDE {
        noisy.noise[pixel] = 0.2 * level(pixel);
        noisy.depth[pixel] = if right(pixel) { 12.0 } else { 10.0 };
    }
    for pixel in speckles {
        noisy.color[pixel] = [3.0, 2.0, 1.0, 1.0];
        noisy.noise[pixel] = 2.0;
    }
    let smooth = run(&noisy);
    for (pixel, color) in smooth.iter().enumerate() {
        // 2 are spread over the better part of 21 x 21 pixels, a quarter of them in a corner.
        let most = if right(pixel) { 0.65 } else { 0.06 };
        assert!(color[1] < most, "pixel {pixel} has {color:?}");
    }
    let [before, after] = [sums(&noisy.color), sums(&smooth)];
    assert!((0..4).all(|c| (after[c] / before[c] - 1.0).abs() < 1e-5), "{before:?}, then {after:?}");
    // What is bright for sure is no speckle, however small it is.
    let mut lamp = frame(SIDE, |_| 0.02, 0.004);
    lamp.color[24 * SIDE + 24] = [3.0, 3.0, 3.0, 1.0];
    assert!(run(&lamp)[24 * SIDE + 24][0] > 2.99);
}

/// A white disc on nothing: what lies behind it stays black and uncovered, and what the disc has stays in it.
#[test]
fn nothing_crosses_a_silhouette() {
    const SIDE: usize = 64;
    let inside = |pixel: usize| {
        let [x, y] = [pixel % SIDE, pixel / SIDE].map(|v| v as f32 - 31.5);
        x.hypot(y) < 20.0
    };
    for samples in [4, 16] {
        let mut noisy = frame(SIDE, |_| 0.0, 0.0);
        for pixel in 0..SIDE * SIDE {
            let v = if inside(pixel) { 0.5 + 0.2 * normal(pixel) } else { 0.0 };
            noisy.color[pixel] = [v, v, v, f32::from(inside(pixel))];
            noisy.depth[pixel] = if inside(pixel) { 10.0 } else { f32::INFINITY };
            noisy.noise[pixel] = if inside(pixel) { 0.2 } else { 0.0 };
        }
        let mut smooth = noisy.clone();
        denoise(&mut smooth, samples, &Control::default()).unwrap();
        for (pixel, color) in smooth.color.iter().enumerate() {
            let covered = f32::from(inside(pixel));
            // A tenth of what an 8-bit picture tells, and at few samples a hundredth of white.
            let most = if samples == 4 { 0.01 } else { 0.0004 };
            assert!((color[3] - covered).abs() < most, "{samples} samples, pixel {pixel}: {color:?}");
            assert!(inside(pixel) || color[0] < most, "{samples} samples, pixel {pixel}: {color:?}");
        }
        assert!(rmse(&smooth.color, |pixel| if inside(pixel) { 0.5 } else { 0.0 }) < 0.05);
    }
}

/// Coverage and what is held back of each colour are of the same matter, and exchanged alike.
#[test]
fn what_is_held_back_goes_with_coverage() {
    const SIDE: usize = 32;
    let mut noisy = frame(SIDE, |pixel| 0.3 + 0.1 * normal(pixel), 0.1);
    for pixel in 0..SIDE * SIDE {
        let alpha = (0.5 + 0.12 * normal(pixel + 7)).clamp(0.0, 1.0);
        noisy.color[pixel][3] = alpha;
        noisy.opacities.push([alpha, 0.5 * alpha, 0.25 * alpha]);
    }
    let mut smooth = noisy.clone();
    denoise(&mut smooth, 16, &Control::default()).unwrap();
    for (color, opacities) in smooth.color.iter().zip(&smooth.opacities) {
        assert!((0..3).all(|c| (opacities[c] - color[3] / (1 << c) as f32).abs() < 1e-5), "{color:?}, {opacities:?}");
    }
    assert_ne!(smooth.opacities, noisy.opacities);
}

#[test]
fn a_cancelled_one_changes_nothing() {
    let noisy = frame(32, |pixel| 0.5 + 0.1 * normal(pixel), 0.1);
    let (mut smooth, cancel) = (noisy.clone(), Cancel::default());
    cancel.cancel();
    let control = Control { cancel: Some(&cancel), ..Control::default() };
    assert_eq!(denoise(&mut smooth, 16, &control), Err(Cancelled));
    assert_eq!(smooth.color, noisy.color);
}

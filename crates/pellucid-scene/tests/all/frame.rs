//! From linear associated radiance to picture numbers.

use pellucid_optics::{Color, srgb_encode};
use pellucid_scene::{Background, Encoding, Frame, ImageSettings, RenderWarning};

fn frame(pixels: &[[f32; 4]]) -> Frame {
    Frame { color: pixels.to_vec(), ..Frame::new(1, pixels.len()) }
}

fn settings(background: Background) -> ImageSettings {
    ImageSettings { background, ..ImageSettings::default() }
}

#[test]
fn a_new_frame_is_empty() {
    let frame = Frame::new(3, 2);
    assert_eq!((frame.color.len(), frame.depth.len(), frame.normal.len(), frame.samples.len()), (6, 6, 6, 6));
    assert!(frame.color.iter().all(|c| *c == [0.0; 4]) && frame.depth.iter().all(|d| *d == f32::INFINITY));
    let warning = RenderWarning::Empty { reason: "all is clipped".to_owned() };
    assert_eq!(warning.to_string(), "the picture is empty: all is clipped");
}

#[test]
fn a_cleared_frame_is_a_new_one_in_the_memory_it_had() {
    let mut frame = Frame::new(8, 5);
    frame.color.fill([0.5; 4]);
    frame.depth.fill(1.0);
    frame.normal.fill([1.0, 0.0, 0.0]);
    frame.samples.fill(7);
    frame.statistics.rays = 40;
    frame.warnings.push(RenderWarning::Empty { reason: String::new() });
    let memory = (frame.color.as_ptr(), frame.depth.as_ptr(), frame.normal.as_ptr(), frame.samples.as_ptr());
    for (width, height) in [(3, 4), (8, 5)] {
        frame.clear(width, height);
        let new = Frame::new(width, height);
        assert_eq!((frame.width, frame.height, &frame.color, &frame.depth), (width, height, &new.color, &new.depth));
        assert_eq!((&frame.normal, &frame.samples), (&new.normal, &new.samples));
        assert_eq!((frame.statistics, &frame.warnings), (new.statistics, &new.warnings));
    }
    assert_eq!(memory, (frame.color.as_ptr(), frame.depth.as_ptr(), frame.normal.as_ptr(), frame.samples.as_ptr()));
}

/// IEC 61966-2-1 code values of linear 0, 0.0031308, 0.01, 0.18, 0.5 and 1, computed elsewhere.
#[test]
fn srgb_code_values_are_those_of_the_standard() {
    let linear = [0.0f32, 0.003_130_8, 0.01, 0.18, 0.5, 1.0];
    let frame = frame(&linear.map(|v| [v, v, v, 1.0]));
    let gray = |image: &ImageSettings| frame.to_rgba8(image).chunks(4).map(|p| p[1]).collect::<Vec<_>>();
    let srgb = ImageSettings::default();
    assert_eq!(gray(&srgb), [0, 10, 25, 118, 188, 255]);
    assert_eq!(gray(&ImageSettings { encoding: Encoding::Linear, ..srgb.clone() }), [0, 1, 3, 46, 128, 255]);
    let deep: Vec<u16> = frame.to_rgba16(&srgb).chunks(4).map(|p| p[0]).collect();
    for (found, expected) in deep.iter().zip([0.0f64, 0.040_449_9, 0.099_853, 0.461_356, 0.735_357, 1.0]) {
        assert!((f64::from(*found) - expected * 65535.0).abs() < 1.0, "{found} {expected}");
    }
    assert!(frame.to_rgba8(&srgb).chunks(4).all(|p| p[3] == 255));
}

#[test]
fn transparent_pictures_have_straight_alpha() {
    let image = ImageSettings { encoding: Encoding::Linear, ..settings(Background::Transparent) };
    let frame = frame(&[[0.25, 0.0, 0.125, 0.25], [0.0; 4], [0.2, 0.4, 0.6, 1.0]]);
    assert_eq!(frame.composited(0, &image), [1.0, 0.0, 0.5, 0.25]);
    assert_eq!(frame.composited(1, &image), [0.0; 4]);
    assert_eq!(frame.composited(2, &image), [0.2, 0.4, 0.6, 1.0]);
    assert_eq!(frame.to_rgba8(&image)[..8], [255, 0, 128, 64, 0, 0, 0, 0]);
}

/// Light that nothing covers is seen over black as it is; associated, it keeps its coverage of 0.
#[test]
fn light_without_coverage_is_kept_on_a_transparent_background() {
    let image = ImageSettings { encoding: Encoding::Linear, exposure: 2.0, ..settings(Background::Transparent) };
    let light = [[0.1, 0.3, 0.0, 0.0], [0.05, 0.4, 0.2, 0.25], [3.0, 0.0, 0.0, 0.0], [0.1, 0.1, 0.1, 0.5]];
    let frame = frame(&light);
    for (pixel, [r, g, b, a]) in light.into_iter().enumerate() {
        let [red, green, blue, alpha] = frame.composited(pixel, &image);
        for (found, light) in [(red, r), (green, g), (blue, b)] {
            let over_black = found.min(1.0) * alpha;
            assert!((over_black - (2.0 * light).min(1.0)).abs() < 1e-6, "{pixel}: {over_black} of {light}");
        }
        assert!(alpha >= a);
        assert_eq!(frame.associated(pixel, &image), [2.0 * r, 2.0 * g, 2.0 * b, a]);
    }
    // What covers as much as it shines has its own alpha.
    assert_eq!(frame.composited(3, &image)[3], 0.5);
}

/// Each colour of the background comes through its own opacity.
#[test]
fn each_colour_behind_is_held_back_in_its_own_way() {
    let opacities = vec![[0.9, 0.5, 0.1]];
    let frame = Frame { opacities, ..frame(&[[0.2, 0.1, 0.0, 0.5]]) };
    let found = frame.composited(0, &settings(Background::Color(Color::WHITE)));
    for (found, expected) in found.into_iter().zip([0.3, 0.6, 0.9, 1.0]) {
        assert!((found - expected).abs() < 1e-6, "{found}, not {expected}");
    }
    assert_eq!(frame.composited(0, &settings(Background::Transparent))[3], 0.5);
}

#[test]
fn what_lies_behind_shines_through() {
    let behind = settings(Background::Color(Color::new([1.0, 0.5, 0.0]).unwrap()));
    // sRGB 0.5 is linear 0.21404.
    let [r, g, b, a] = frame(&[[0.25, 0.25, 0.25, 0.5]]).composited(0, &behind);
    assert!((r - 0.75).abs() < 1e-6 && (g - (0.25 + 0.5 * 0.214_041)).abs() < 1e-6 && b == 0.25 && a == 1.0);
    // Untouched, the background comes out as it was written.
    assert_eq!(frame(&[[0.0; 4]]).to_rgba8(&behind), [255, 128, 0, 255]);
}

#[test]
fn a_gradient_runs_from_top_to_bottom_in_linear_light() {
    let image = settings(Background::Gradient { top: Color::WHITE, bottom: Color::BLACK });
    let frame = Frame::new(3, 4);
    for (row, expected) in [1.0f32, 2.0 / 3.0, 1.0 / 3.0, 0.0].into_iter().enumerate() {
        for column in 0..3 {
            let [r, g, b, a] = frame.composited(row * 3 + column, &image);
            assert!([r, g, b].iter().all(|c| (c - expected).abs() < 1e-6) && a == 1.0, "{row}: {r} {g} {b} {a}");
        }
    }
    // A single row has the colour halfway.
    assert_eq!(Frame::new(1, 1).composited(0, &image), [0.5, 0.5, 0.5, 1.0]);
}

#[test]
fn exposure_scales_light_and_not_alpha() {
    for background in [Background::Transparent, Background::default()] {
        let plain = settings(background);
        let bright = ImageSettings { exposure: 4.0, ..plain.clone() };
        let frame = frame(&[[0.1, 0.05, 0.0, 0.5]]);
        let (a, b) = (frame.composited(0, &plain), frame.composited(0, &bright));
        assert_eq!(b, [a[0] * 4.0, a[1] * 4.0, a[2] * 4.0, a[3]]);
    }
}

#[test]
fn numbers_out_of_range_are_clamped() {
    let linear = ImageSettings { encoding: Encoding::Linear, ..ImageSettings::default() };
    for image in [linear, ImageSettings::default()] {
        let frame = frame(&[[7.0, -1.0, f32::NAN, 1.0], [f32::INFINITY, 0.0, 0.0, 1.0]]);
        assert_eq!(frame.to_rgba8(&image), [255, 0, 0, 255, 255, 0, 0, 255]);
    }
}

/// Every pixel by the formulas, one by one: rows, threads and tables must not show.
#[test]
fn a_large_picture_is_encoded_pixel_by_pixel() {
    let (width, height) = (301, 203);
    let mut frame = Frame::new(width, height);
    for (k, color) in frame.color.iter_mut().enumerate() {
        let part = |period: usize| (k % period) as f32 / (period - 1) as f32;
        let alpha = part(97);
        *color = [part(1009) * alpha, part(211) * alpha, 1.2 * part(13) * alpha, alpha];
    }
    let gradient = Background::Gradient { top: Color::hex(0xff8000), bottom: Color::hex(0x102030) };
    for background in [Background::Transparent, Background::Color(Color::hex(0x336699)), gradient] {
        for encoding in [Encoding::Srgb, Encoding::Linear] {
            let image = ImageSettings { encoding, exposure: 0.9, ..settings(background.clone()) };
            let (eight, sixteen) = (frame.to_rgba8(&image), frame.to_rgba16(&image));
            assert_eq!((eight.len(), sixteen.len()), (width * height * 4, width * height * 4));
            for pixel in 0..width * height {
                let [r, g, b, a] = frame.composited(pixel, &image).map(|v| v.clamp(0.0, 1.0));
                let curve = |c: f32| if encoding == Encoding::Srgb { srgb_encode(c) } else { c };
                let expected = [curve(r), curve(g), curve(b), a];
                let at = pixel * 4..pixel * 4 + 4;
                assert_eq!(eight[at.clone()], expected.map(|v| (v * 255.0).round() as u8), "{pixel} {image:?}");
                assert_eq!(sixteen[at], expected.map(|v| (v * 65535.0).round() as u16), "{pixel} {image:?}");
            }
        }
    }
    assert!(Frame::default().to_rgba8(&ImageSettings::default()).is_empty());
}

//! `pellucid render` from input to picture.

use std::path::Path;

use crate::common::{fail_in, files, picture, run_in, scene_in, succeed_in, text};
use pellucid::io::Transfer;
use serde_json::Value;
use tempfile::tempdir;

const SMALL: [&str; 4] = ["--size", "24x16", "--quiet", "-o"];

/// Two components of a file, each in a colour of its own.
#[test]
fn channels_are_layers_in_colors() {
    let folder = tempdir().unwrap();
    // Along x first one channel, then both, then the other.
    let values: Vec<u8> = (0..8 * 8 * 9).flat_map(|k| [u8::from(k % 9 < 6) * 255, u8::from(k % 9 > 2) * 255]).collect();
    let header =
        b"NRRD0004\ntype: uint8\ndimension: 4\nsizes: 2 9 8 8\nkinds: vector domain domain domain\nencoding: raw\n\n";
    std::fs::write(folder.path().join("two.nrrd"), [&header[..], &values].concat()).unwrap();
    let flags = ["two.nrrd", "--channels", "0:lime,1:#f0f", "--azimuth", "0", "--elevation", "0", "--orthographic"];
    let flags = [&flags[..], &["--encoding", "linear", "--background", "black", "--shading", "off", "--window", "0,1"]]
        .concat();
    render(folder.path(), &flags, "two.png");
    let drawn = picture(&folder.path().join("two.png"));
    let row = &drawn.pixels[8 * 24..9 * 24];
    let (left, middle, right) = (row[6], row[12], row[18]);
    assert!(left[1] > 0.8 && left[0] < 0.01 && left[2] < 0.01, "{left:?}");
    assert!(right[1] < 0.01 && right[0] > 0.8 && right[2] > 0.8, "{right:?}");
    // Of the same extinction, each gives half of the light.
    assert!(middle[..3].iter().all(|v| (v - 0.5).abs() < 0.05), "{middle:?}");
    let scene = scene_in(folder.path(), &flags);
    assert_eq!((&scene["volumes"][0]["component"], &scene["volumes"][1]["component"]), (&0.into(), &1.into()));
    let message = fail_in(folder.path(), &["render", "two.nrrd", "--channels", "0:grene", "-o", "x.png"], 2);
    assert!(message.contains("green"), "{message}");
    let message = fail_in(folder.path(), &["render", "two.nrrd", "--channels", "0:green,2:red", "-o", "x.png"], 2);
    assert!(message.contains("component is 2"), "{message}");
}

fn render(folder: &Path, args: &[&str], output: &str) {
    succeed_in(folder, &[&["render"], args, &SMALL, &[output]].concat());
}

/// A raw file of 5 x 4 x 3 values that tell where they are: x + 10 y + 100 z.
fn write_raw(path: &Path, big_endian: bool, header: usize) {
    let mut bytes = vec![0xee; header];
    for (z, y, x) in (0..3u16).flat_map(|z| (0..4).flat_map(move |y| (0..5).map(move |x| (z, y, x)))) {
        let value = x + 10 * y + 100 * z;
        bytes.extend(if big_endian { value.to_be_bytes() } else { value.to_le_bytes() });
    }
    std::fs::write(path, bytes).unwrap();
}

#[test]
fn one_slice_shows_the_values_themselves() {
    let folder = tempdir().unwrap();
    write_raw(&folder.path().join("a.raw"), false, 0);
    // One pixel per voxel, by parallel rays just inside the outermost voxels. Gray over 0..255 in
    // linear numbers gives the value itself.
    let gray = folder.path().join("gray.toml");
    std::fs::write(
        gray,
        "colors = [[0, \"#000000\"], [255, \"#ffffff\"]]\ncolor_space = \"linear\"\nopacities = [[0, 1]]\n",
    )
    .unwrap();
    let args = [
        "a.raw",
        "--dims",
        "5x4x3",
        "--type",
        "u16",
        "--slice",
        "axial",
        "--at",
        "50%",
        "--orthographic=3.99",
        "--elevation",
        "-90",
        "--azimuth",
        "0",
        "--transfer-function",
        "gray.toml",
        "--encoding",
        "linear",
        "--size",
        "5x4",
        "--quiet",
        "-o",
        "s.png",
    ];
    succeed_in(folder.path(), &[&["render"], &args[..]].concat());
    let picture = picture(&folder.path().join("s.png"));
    assert_eq!((picture.width, picture.height, picture.transfer), (5, 4, Transfer::Linear));
    for (y, x) in (0..4).flat_map(|y| (0..5).map(move |x| (y, x))) {
        let found = picture.pixels[y * 5 + x][0] * 255.0;
        // The middle slice; +x to the right and +y down: the radiological convention.
        let expected = (x + 10 * y + 100) as f32;
        assert!((found - expected).abs() <= 1.0, "({x}, {y}): {found}, expected {expected}");
    }
}

#[test]
fn headerless_files_give_the_same_picture_in_every_layout() {
    let folder = tempdir().unwrap();
    write_raw(&folder.path().join("little.raw"), false, 0);
    write_raw(&folder.path().join("big.raw"), true, 7);
    let layout = ["--dims", "5x4x3", "--type", "u16"];
    render(folder.path(), &[&["little.raw"], &layout[..]].concat(), "little.png");
    render(folder.path(), &[&["big.raw", "--endian", "big", "--skip", "7"], &layout[..]].concat(), "big.png");
    assert_eq!(picture(&folder.path().join("little.png")), picture(&folder.path().join("big.png")));

    let scene = scene_in(folder.path(), &[&["big.raw", "--endian", "big", "--skip", "7"], &layout[..]].concat());
    let raw = &scene["volumes"][0]["source"]["raw"];
    assert_eq!((&raw["big_endian"], &raw["skip"]), (&Value::Bool(true), &serde_json::json!(7)));
    let two = scene_in(folder.path(), &["little.raw", "--dims", "5x4x1", "--type", "u16", "--components", "3"]);
    assert_eq!(two["volumes"][0]["source"]["raw"]["components"], serde_json::json!(3));

    for (args, parts) in [
        (&["little.raw"][..], &["little.raw"][..]),
        (&["little.raw", "--dims", "5x4x3"], &["--dims", "--type"]),
        (&["little.raw", "--skip", "2"], &["--dims", "--type"]),
        (&["little.raw", "--dims", "5x4x4", "--type", "u16"], &["little.raw", "120", "160", "5 x 4 x 3"]),
        (&["big.raw", "--dims", "5x4x3", "--type", "u16"], &["big.raw", "127", "120", "skip 7"]),
    ] {
        let message = fail_in(folder.path(), &[&["render", "-o", "x.png"], args].concat(), 2);
        parts.iter().for_each(|part| assert!(message.contains(part), "{args:?}: '{part}' is not in {message}"));
    }
}

#[test]
fn the_picture_does_not_depend_on_the_number_of_threads() {
    let folder = tempdir().unwrap();
    let args = ["sample:tubes@24x24x24", "--jitter", "blue-noise", "--size", "100x80", "--quiet"];
    for threads in ["1", "2", "5"] {
        let output = format!("{threads}.exr");
        succeed_in(folder.path(), &[&["render"], &args[..], &["--threads", threads, "-o", &output]].concat());
    }
    let bytes = |name: &str| std::fs::read(folder.path().join(name)).unwrap();
    assert_eq!(bytes("1.exr"), bytes("2.exr"));
    assert_eq!(bytes("1.exr"), bytes("5.exr"));
}

/// One frame is the plain picture; the mean of more is nearer to what many rays a pixel show.
#[test]
fn frames_are_averaged() {
    let folder = tempdir().unwrap();
    let path = folder.path();
    let ball = ["sample:ball@16x16x16", "--step", "0.1", "--encoding", "linear"];
    render(path, &ball, "plain.png");
    for frames in ["1", "64"] {
        render(path, &[&ball[..], &["--accumulate", frames]].concat(), &format!("{frames}.png"));
    }
    render(path, &[&ball[..], &["--supersampling", "8"]].concat(), "fine.png");
    let [plain, one, mean, fine] = ["plain", "1", "64", "fine"].map(|name| picture(&path.join(format!("{name}.png"))));
    assert_eq!(plain, one);
    let [from_one, from_mean] = [&one, &mean].map(|picture| {
        let pairs = picture.pixels.iter().flatten().zip(fine.pixels.iter().flatten());
        pairs.map(|(a, b)| (a - b).powi(2)).sum::<f32>()
    });
    assert!(from_mean < from_one / 4.0, "{from_mean} and {from_one}");

    let args = ["render", ball[0], "--accumulate", "3", "--json", "--size", "8x8", "-o", "b.png"];
    let output = run_in(path, &args);
    assert!(text(&output.stderr).contains("drew 8x8 3 times in"), "{}", text(&output.stderr));
    let told: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((&told["frames"], &told["statistics"]["rays"]), (&3.into(), &192.into()));
    for wrong in ["0", "65536", "2.5"] {
        let message = fail_in(path, &["render", ball[0], "--accumulate", wrong, "-o", "b.png"], 2);
        assert!(message.contains("--accumulate"), "{message}");
    }
}

#[test]
fn a_saved_scene_draws_the_same_picture_from_anywhere() {
    let folder = tempdir().unwrap();
    let path = folder.path();
    std::fs::create_dir(path.join("scenes")).unwrap();
    succeed_in(path, &["sample", "head", "--dims", "16x16x16", "-o", "head.nrrd", "--quiet"]);
    for (saved, flags) in [
        ("scenes/a.toml", &["--preset", "ct-bone", "--clip", "0,1,0,0,0,0", "--light", "three-point"][..]),
        ("scenes/b.json", &["--slice", "coronal", "--at", "30%", "--thickness", "5", "--background", "transparent"]),
    ] {
        render(path, &[&["head.nrrd", "--save-scene", saved], flags].concat(), "direct.png");
        render(path, &[saved, "--allow-outside"], "again.png");
        assert_eq!(picture(&path.join("direct.png")), picture(&path.join("again.png")), "{saved}");
        let scene = std::fs::read_to_string(path.join(saved)).unwrap();
        assert!(!scene.contains('%'), "a place in percent is saved as a position: {scene}");
    }
}

#[test]
fn slices_face_the_camera_in_the_radiological_convention() {
    let folder = tempdir().unwrap();
    let orbit = |flags: &[&str]| {
        let scene = scene_in(folder.path(), &[&["sample:ball@4x4x4"], flags].concat());
        let camera = &scene["camera"];
        let angle = |key: &str| camera["view"]["orbit"][key].as_f64().unwrap();
        (camera["projection"].get("orthographic").is_some(), angle("azimuth"), angle("elevation"))
    };
    assert_eq!(orbit(&["--slice", "axial"]), (true, 0.0, -90.0));
    assert_eq!(orbit(&["--slice", "coronal"]), (true, 0.0, 0.0));
    assert_eq!(orbit(&["--slice", "sagittal"]), (true, 90.0, 0.0));
    assert_eq!(orbit(&["--slice", "0,-3,0"]), (true, 0.0, 0.0));
    assert_eq!(orbit(&["--slice", "axial", "--azimuth", "30"]), (false, 30.0, 20.0));
    // What those angles mean: axial shows +x (left) to the right and +y (posterior) down.
    let camera = pellucid::scene::Camera {
        projection: pellucid::scene::Projection::Orthographic { height: None },
        view: pellucid::scene::View::Orbit(pellucid::scene::Orbit {
            azimuth: 0.0,
            elevation: -90.0,
            ..Default::default()
        }),
        ..Default::default()
    };
    let view = camera.viewpoint(10, 10, &[]);
    assert!(
        (view.right.x - 1.0).abs() < 1e-12 && (view.up.y + 1.0).abs() < 1e-12 && (view.forward.z - 1.0).abs() < 1e-12
    );
}

#[test]
fn json_tells_everything_once() {
    let folder = tempdir().unwrap();
    let output =
        succeed_in(folder.path(), &["render", "sample:ball@16x16x16", "--json", "--size", "20x10", "-o", "b.png"]);
    let told: Value = serde_json::from_str(&output).unwrap();
    assert_eq!((&told["width"], &told["height"]), (&20.into(), &10.into()));
    assert_eq!(told["dims"][0], serde_json::json!([16, 16, 16]));
    assert_eq!(told["output"], "b.png");
    assert_eq!(told["statistics"]["rays"], 200);
    assert!(told["statistics"]["samples_visible"].as_u64().unwrap() > 0);
    assert!(told["timings"]["render_seconds"].as_f64().unwrap() >= 0.0);
    let settings: Vec<&str> =
        told["choices"].as_array().unwrap().iter().filter_map(|c| c["setting"].as_str()).collect();
    assert!(settings.contains(&"unit distance"), "{settings:?}");
}

#[test]
fn remarks_go_to_standard_error_and_can_be_silenced() {
    let folder = tempdir().unwrap();
    let args = ["render", "sample:ball@16x16x16", "--size", "8x8", "-o", "b.png"];
    let output = run_in(folder.path(), &args);
    let said = text(&output.stderr);
    assert!(output.stdout.is_empty() && said.lines().all(|line| line.starts_with("pellucid: ")), "{said}");
    for part in ["ball: 16x16x16", "unit distance", "wrote b.png"] {
        assert!(said.contains(part), "'{part}' is not in {said}");
    }
    let away = run_in(folder.path(), &[&args[..], &["--target", "1000,0,0", "--distance", "1"]].concat());
    assert!(text(&away.stderr).contains("warning: the picture is empty"), "{}", text(&away.stderr));
    assert!(run_in(folder.path(), &[&args[..], &["--quiet"]].concat()).stderr.is_empty());
}

#[test]
fn pictures_have_the_depth_and_layers_asked_for() {
    let folder = tempdir().unwrap();
    let path = folder.path();
    let ball = ["sample:ball@16x16x16", "--background", "transparent"];
    render(path, &ball, "eight.png");
    render(path, &[&ball[..], &["--bits", "16", "--aux", "layers.exr"]].concat(), "sixteen.png");
    // Byte 24 of a PNG is the bit depth of its header chunk.
    let depth = |name: &str| std::fs::read(path.join(name)).unwrap()[24];
    assert_eq!((depth("eight.png"), depth("sixteen.png")), (8, 16));
    let [eight, sixteen] = ["eight.png", "sixteen.png"].map(|name| picture(&path.join(name)).pixels);
    let difference = eight.iter().flatten().zip(sixteen.iter().flatten()).map(|(a, b)| (a - b).abs());
    assert!(difference.fold(0.0, f32::max) <= 0.5 / 255.0 + 1e-6);
    assert!(eight.iter().any(|pixel| pixel[3] == 0.0) && eight.iter().any(|pixel| pixel[3] > 0.0));
    let exr = std::fs::read(path.join("layers.exr")).unwrap();
    for channel in ["A", "B", "G", "N.X", "N.Y", "N.Z", "R", "Z", "samples"] {
        let header = [b"\0", channel.as_bytes(), b"\0"].concat();
        assert!(exr[..600].windows(header.len()).any(|window| window == header), "{channel}");
    }
}

#[test]
fn nothing_half_written_is_left_where_nothing_can_be_written() {
    let folder = tempdir().unwrap();
    let path = folder.path();
    let args = ["render", "sample:ball@8x8x8", "--size", "8x8"];
    let message = fail_in(path, &[&args[..], &["-o", "no/such/folder.png"]].concat(), 1);
    assert!(message.contains("no/such/folder.png"), "{message}");
    for (flags, part) in [(["-o", "a.jpg"], ".png or .exr"), (["--save-scene", "a.yaml"], ".toml or .json")] {
        assert!(fail_in(path, &[&args[..], &flags].concat(), 2).contains(part));
    }
    assert!(fail_in(path, &[&args[..], &["-o", "a.png", "--aux", "a.png"]].concat(), 2).contains(".exr"));
    assert_eq!(files(path), [""; 0]);
    // A folder in the way of the file.
    std::fs::create_dir(path.join("b.png")).unwrap();
    fail_in(path, &[&args[..], &["-o", "b.png"]].concat(), 1);
    assert_eq!(files(path), ["b.png"]);
}

#[test]
fn what_does_not_fit_into_memory_is_refused() {
    let folder = tempdir().unwrap();
    // 2^48 bytes: more than any address space has.
    let message = fail_in(folder.path(), &["render", "sample:ball@65536x65536x65536", "-o", "x.png"], 1);
    assert!(message.contains("281474976710656 bytes"), "{message}");
}

#[test]
fn scene_files_with_errors_point_at_the_line() {
    let folder = tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    write("key.toml", "[[volumes]]\nsource.sample.name = \"ball\"\n\n[quality]\nstepp = 1\n");
    write("value.toml", "[[volumes]]\nsource.sample.name = \"ball\"\n\n[quality]\nstep = -1\n");
    write("syntax.json", "{\n \"quality\": {\n  \"step\": ,\n }\n}\n");
    write("sample.toml", "[[volumes]]\nsource.sample.name = \"bal\"\n");
    write("empty.toml", "");
    for (file, parts) in [
        ("key.toml", &["key.toml: line 5", "stepp", "step"][..]),
        ("value.toml", &["value.toml: line 5", "quality.step", "-1", "0.01 to 100"]),
        ("syntax.json", &["syntax.json: line 3"]),
        ("sample.toml", &["bal", "ball"]),
        ("empty.toml", &["volume"]),
        ("missing.toml", &["missing.toml"]),
        ("missing.nrrd", &["missing.nrrd", "sample:NAME"]),
        ("sample:bal", &["bal", "ball"]),
        ("sample:ball@8x8", &["sample:ball@8x8", "128x128x128"]),
        ("key.toml/inside.nrrd", &["key.toml/inside.nrrd"]),
        (".", &["."]),
    ] {
        let message = fail_in(folder.path(), &["render", file, "-o", "x.png"], 2);
        parts.iter().for_each(|part| assert!(message.contains(part), "{file}: '{part}' is not in {message}"));
    }
    let message = fail_in(folder.path(), &["render", "value.toml", "--dims", "1x1x1", "-o", "x.png"], 2);
    assert!(message.contains("--dims") && message.contains("scene"), "{message}");
}

#[test]
fn slicer_volume_properties_are_used() {
    let folder = tempdir().unwrap();
    let property = r#"{"@schema": "https://example.org/volume-property-schema-v1.0.0.json#", "volumeProperties": [{"components": [{
        "shade": true, "scalarOpacityUnitDistance": 2.0,
        "lighting": {"ambient": 0.2, "diffuse": 0.9, "specular": 0.1, "specularPower": 5.0},
        "rgbTransferFunction": {"type": "colorTransferFunction", "points": [
            {"x": 0.0, "color": [0, 0, 0]}, {"x": 1.0, "color": [1, 0.5, 0]}]},
        "scalarOpacity": {"type": "piecewiseLinearFunction", "points": [{"x": 0.0, "y": 0.0}, {"x": 1.0, "y": 0.5}]}
    }]}]}"#;
    std::fs::write(folder.path().join("look.vp.json"), property).unwrap();
    let scene = scene_in(folder.path(), &["sample:ball@8x8x8", "--transfer-function", "look.vp.json"]);
    let volume = &scene["volumes"][0];
    assert_eq!(volume["transfer_function"]["unit_distance"], 2.0);
    assert_eq!(volume["transfer_function"]["opacities"], serde_json::json!([[0.0, 0.0], [1.0, 0.5]]));
    assert_eq!((&volume["shading"], &volume["material"]["shininess"]), (&true.into(), &5.0.into()));
}

//! The subcommands around `render`.

use crate::common::{command, fail_in, files, run_in, succeed_in, text};
use serde_json::Value;
use tempfile::tempdir;

#[test]
fn info_tells_what_is_in_a_file() {
    let folder = tempdir().unwrap();
    // 4 x 3 x 2 floats at x + y + z, one of them NaN, in a NRRD written by hand.
    let mut file = b"NRRD0004\ntype: float\ndimension: 3\nsizes: 4 3 2\nendian: little\nencoding: raw\n\
        space: left-posterior-superior\nspace directions: (0.5,0,0) (0,-2,0) (0,0,3)\nspace origin: (10,20,30)\n\n"
        .to_vec();
    for (z, y, x) in (0..2).flat_map(|z| (0..3).flat_map(move |y| (0..4).map(move |x| (z, y, x)))) {
        let value = if (x, y, z) == (0, 0, 0) { f32::NAN } else { (x + y + z) as f32 };
        file.extend(value.to_le_bytes());
    }
    std::fs::write(folder.path().join("a.nrrd"), file).unwrap();
    let said = succeed_in(folder.path(), &["info", "a.nrrd"]);
    for part in ["4 x 3 x 2", "f32", "0.5 x 2 x 3", "1.5 x 4 x 3", "10, 20, 30", "LAS", "1 to 6", "1 NaN", "█"] {
        assert!(said.contains(part), "'{part}' is not in {said}");
    }
    assert!(said.lines().all(|line| line.chars().count() <= 200));

    let told: Value =
        serde_json::from_str(&succeed_in(folder.path(), &["info", "--json", "a.nrrd", "a.nrrd"])).unwrap();
    assert_eq!(told.as_array().map(Vec::len), Some(2));
    let volume = &told[0];
    assert_eq!((&volume["min"], &volume["max"], &volume["nan"]), (&1.0.into(), &6.0.into(), &1.into()));
    assert_eq!(volume["orientation"], "LAS");
    // 0 once (absent), then the sums of 0..4, 0..3 and 0..2: mean of the other 23.
    assert!((volume["mean"].as_f64().unwrap() - 72.0 / 23.0).abs() < 1e-6, "{}", volume["mean"]);
    let counts: u64 = volume["histogram"]["counts"].as_array().unwrap().iter().filter_map(Value::as_u64).sum();
    assert_eq!(counts, 23);
    assert_eq!(volume["warnings"].to_string().matches("1 NaN").count(), 1, "{}", volume["warnings"]);
    fail_in(folder.path(), &["info", "a.nrrd", "--component", "1"], 2);
}

#[test]
fn graphics_adapters_are_listed() {
    let folder = tempdir().unwrap();
    let all: Value = serde_json::from_str(&succeed_in(folder.path(), &["info", "--adapters", "--json"])).unwrap();
    let said = succeed_in(folder.path(), &["info", "--adapters"]);
    let all = all.as_array().unwrap();
    assert!(!all.is_empty(), "the tests need a Vulkan driver; on Debian: apt-get install mesa-vulkan-drivers");
    for adapter in all {
        assert!(said.contains(adapter["name"].as_str().unwrap()), "{said}");
        assert!(adapter["limits"]["texture_3d"].as_u64().unwrap() >= 256, "{adapter}");
        assert!(adapter["features"]["float32_filterable"].is_boolean(), "{adapter}");
    }
    fail_in(folder.path(), &["info", "--adapters", "sample:ball"], 2);
    fail_in(folder.path(), &["info"], 2);
}

#[test]
fn what_draws_is_said_with_its_reason() {
    let folder = tempdir().unwrap();
    let draw = |flags: &[&str]| {
        let input = ["render", "sample:ball@16x16x16", "--size", "32x32", "-o", "a.png"];
        let output = run_in(folder.path(), &[&input, flags].concat());
        (output.status.code(), text(&output.stderr))
    };
    let (code, said) = draw(&["--adapter", "software", "--interpolation", "exact", "--gpu-memory", "64"]);
    assert_eq!(code, Some(0), "{said}");
    for part in
        ["backend: ", "3D textures to", "exact interpolation", "graphics memory: ", "MiB of 64.0 (voxels", "whole"]
    {
        assert!(said.contains(part), "'{part}' is not in {said}");
    }
    let (code, said) = draw(&["--adapter", "none such"]);
    assert!(code == Some(1) && said.contains("'none such'; found: "), "{said}");
    // Whatever this machine has.
    let (code, said) = draw(&[]);
    assert!(code == Some(0) && said.contains("backend: "), "{said}");
    assert!(
        said.contains("backend: cpu, as there is no graphics adapter that is hardware") || said.contains("3D textures")
    );
    let (code, said) = draw(&["--backend", "cpu"]);
    assert!(code == Some(0) && !said.contains("backend: "), "{said}");
}

#[test]
fn samples_are_written_in_every_format_and_converted() {
    let folder = tempdir().unwrap();
    let path = folder.path();
    let read = |name: &str| pellucid::io::read(path.join(name), &pellucid::io::ReadOptions::default()).unwrap().volume;
    succeed_in(path, &["sample", "head", "--dims", "7x6x5", "--type", "i16", "-o", "head.nrrd", "--quiet"]);
    let original = read("head.nrrd");
    assert_eq!(original.grid().dims(), [7, 6, 5]);
    for name in ["head.mha", "head.nii.gz", "head.nhdr"] {
        succeed_in(path, &["convert", "head.nrrd", "-o", name, "--quiet"]);
        let converted = read(name);
        for voxel in [[0, 0, 0], [3, 2, 1], [6, 5, 4]] {
            assert_eq!(converted.value(voxel, 0), original.value(voxel, 0), "{name}");
        }
    }
    let message = fail_in(path, &["convert", "head.nrrd", "-o", "head.xyz"], 2);
    assert!(message.contains("head.xyz"), "{message}");
    fail_in(path, &["sample", "head", "-o", "no/folder.nrrd"], 1);
    fail_in(path, &["sample", "heads", "-o", "a.nrrd"], 2);
    assert!(!files(path).iter().any(|name| name.contains("tmp")));
    let list = succeed_in(path, &["sample", "--list"]);
    for name in pellucid::field::closed_form::names() {
        assert!(list.lines().any(|line| line.starts_with(name)), "{name} is not in {list}");
    }
}

#[test]
fn presets_colormaps_and_opacities_are_listed() {
    let folder = tempdir().unwrap();
    let list = |args: &[&str]| succeed_in(folder.path(), &[&["presets"], args].concat());
    for preset in pellucid::optics::Preset::all() {
        assert!(list(&[]).contains(&preset.name));
    }
    assert!(list(&["--colormaps"]).lines().any(|line| line == "viridis"));
    assert!(list(&["--opacities"]).lines().any(|line| line == "sigmoid_5"));
    let json: Value = serde_json::from_str(&list(&["ct-bone", "--json"])).unwrap();
    assert_eq!(json["name"], "ct-bone");
    let names: Vec<String> = serde_json::from_str(&list(&["--json"])).unwrap();
    assert!(names.contains(&"ct-bone".to_owned()));
    assert!(list(&["ct-bone"]).contains("opacities"));
    assert!(fail_in(folder.path(), &["presets", "ct"], 2).contains("ct-bone"));
}

#[test]
fn schema_and_completions_are_printed() {
    let folder = tempdir().unwrap();
    let schema: Value = serde_json::from_str(&succeed_in(folder.path(), &["schema"])).unwrap();
    assert!(schema["properties"]["quality"].is_object());
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        assert!(succeed_in(folder.path(), &["completions", shell]).contains("supersampling"), "{shell}");
    }
    fail_in(folder.path(), &["completions", "tcsh"], 2);
}

#[test]
fn help_is_short_or_long_and_tells_the_exit_codes() {
    let folder = tempdir().unwrap();
    let (short, long) = (succeed_in(folder.path(), &["-h"]), succeed_in(folder.path(), &["--help"]));
    assert!(short.len() < long.len());
    for code in ["  0  fine", "  1  ", "  2  ", "130  cancelled"] {
        assert!(long.contains(code), "{long}");
    }
    let (short, long) =
        (succeed_in(folder.path(), &["render", "-h"]), succeed_in(folder.path(), &["render", "--help"]));
    assert!(short.len() < long.len() && !short.contains("radiological") && long.contains("radiological"));
    for heading in
        ["Picture:", "Camera:", "Look:", "Technique:", "Quality:", "Clipping and data:", "Raw input:", "Output:"]
    {
        assert!(long.contains(heading) && short.contains(heading), "{heading}");
    }
    assert_eq!(run_in(folder.path(), &[]).status.code(), Some(2));
    fail_in(folder.path(), &["paint"], 2);
}

#[test]
fn techniques_are_compared_side_by_side() {
    let folder = tempdir().unwrap();
    let input = "sample:marschner-lobb";
    let techniques = "ray-cast@cpu,view-aligned@gpu,shells@gpu";
    let size = ["--size", "40x30", "--dims", "24x24x24", "--adapter", "software", "--frames", "1"];
    let args = [&["compare", input, "--techniques", techniques, "--json", "-q", "-o", "both.png"], &size[..]].concat();
    let told: Value = serde_json::from_str(&succeed_in(folder.path(), &args)).unwrap();
    let names = ["ray-cast@cpu", "view-aligned@gpu", "shells@gpu"];
    for (name, row) in names.iter().zip(told.as_array().unwrap()) {
        assert_eq!(row["technique"], *name);
        // Other samples of the same field; the reference itself has no distance.
        let psnr = row["psnr_db"].as_f64().unwrap_or(f64::INFINITY);
        assert!(psnr > 25.0 && psnr.is_infinite() == (*name == names[0]), "{row}");
    }
    let sheet = crate::common::picture(&folder.path().join("both.png"));
    assert_eq!((sheet.width, sheet.height), (3 * 40, 2 * 30));
    // What the processor does not draw it says.
    let said =
        fail_in(folder.path(), &["render", input, "--technique", "shells", "--backend", "cpu", "-o", "a.png", "-q"], 2);
    assert!(said.contains("slicing") && said.contains("--backend gpu"), "{said}");
    let said = fail_in(folder.path(), &["compare", input, "--techniques", "rays"], 2);
    assert!(said.contains("ray-cast, view-aligned"), "{said}");
}

#[test]
fn a_reader_that_has_seen_enough_is_no_failure() {
    let mut child =
        command(&["schema"]).stdout(std::process::Stdio::piped()).stderr(std::process::Stdio::piped()).spawn().unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!((output.status.code(), text(&output.stderr).as_str()), (Some(0), ""));
}

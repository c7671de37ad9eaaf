//! `pellucid bench`: figures that can be trusted, from the right frames.

use std::path::Path;

use crate::common::{fail_in, files, run_in, succeed_in, text};
use serde_json::{Value, json};
use tempfile::tempdir;

/// What `bench FLAGS --json -` prints of a few small frames.
fn told(folder: &Path, frames: &str, args: &[&str]) -> Value {
    let small = ["bench", "sample:ball@16x16x16", "--size", "24x16", "--warmup", "1", "--quiet", "--json", "-"];
    let output = succeed_in(folder, &[&small[..], &["--frames", frames], args].concat());
    serde_json::from_str(&output).expect("standard output is JSON and nothing else")
}

fn orbit(told: &Value) -> &Value {
    &told["scenes"][0]["orbit"]["timing"]
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is not a number"))
}

fn assert_sound(timing: &Value, frames: usize) {
    let [median, min, max] = ["median_ms", "min_ms", "max_ms"].map(|key| number(&timing[key]));
    assert!(0.0 < min && min <= median && median <= max, "{timing}");
    let all: Vec<f64> = timing["frames_ms"].as_array().unwrap().iter().map(number).collect();
    assert!(all.len() == frames && all.contains(&min) && all.contains(&max), "{timing}");
    let parts = ["setup_ms", "render_ms", "encode_ms"].map(|key| number(&timing[key]));
    assert!(parts.iter().all(|part| *part > 0.0 && *part <= max), "{timing}");
    assert!(number(&timing["msamples_per_second_per_thread"]) > 0.0);
}

#[test]
fn json_has_every_figure_and_the_machine() {
    let folder = tempdir().unwrap();
    let told = told(folder.path(), "3", &["--threads", "2"]);
    assert!(number(&told["machine"]["cores"]) >= 1.0);
    assert_eq!(told["machine"]["pellucid"], env!("CARGO_PKG_VERSION"));
    assert_eq!((&told["frames"], &told["warmup"]), (&json!(3), &json!(1)));
    let scene = &told["scenes"][0];
    assert_eq!(
        (&scene["input"], &scene["width"], &scene["height"]),
        (&json!("sample:ball@16x16x16"), &json!(24), &json!(16))
    );
    assert_eq!(scene["volumes"], json!([{ "name": "ball", "dims": [16, 16, 16], "type": "u8" }]));
    assert!(number(&scene["load_seconds"]) > 0.0 && number(&scene["first_frame_ms"]) > 0.0);
    assert_eq!(scene["orbit"]["degrees"], json!(360.0));
    assert_sound(orbit(&told), 3);
    assert_eq!(orbit(&told)["threads"], json!(2));
}

#[test]
fn the_frames_timed_are_those_that_render_draws() {
    let folder = tempdir().unwrap();
    let path = folder.path();
    // From where the volume is framed alike on all sides: render frames every view by itself.
    let (eye, target) = ("--distance=4", "camera.view.orbit.target=[0,0,0]");
    let flags = ["sample:tubes@20x30x25", "--size=40x30", "--set=quality.step=0.7", "--quiet", eye, "--set", target];
    let bench = |args: &[&str]| {
        let output = succeed_in(path, &[&["bench"], &flags[..], &["--frames", "2", "--json", "-"], args].concat());
        let told: Value = serde_json::from_str(&output).unwrap();
        ["samples", "samples_visible", "rays_hit"].map(|key| number(&orbit(&told)[key]))
    };
    let rendered = succeed_in(path, &[&["render"], &flags[..], &["--json", "-o", "rendered.png"]].concat());
    let rendered: Value = serde_json::from_str(&rendered).unwrap();
    let counts = ["samples", "samples_visible", "rays_hit"].map(|key| number(&rendered["statistics"][key]));
    assert_eq!(bench(&["--orbit", "0"]), counts);
    // The camera's own place comes first, and is where a walk comes round to.
    bench(&["--orbit", "180", "--picture", "timed.png"]);
    let bytes = |name: &str| std::fs::read(path.join(name)).unwrap();
    assert_eq!(bytes("timed.png"), bytes("rendered.png"));
    let round = bench(&["--orbit", "720"]);
    for k in 0..3 {
        assert!((round[k] / counts[k] - 1.0).abs() < 1e-3, "{round:?} {counts:?}");
    }
    // Half way round is what render draws from there.
    let behind = succeed_in(path, &[&["render"], &flags[..], &["--azimuth", "210", "--json", "-o", "b.png"]].concat());
    let behind: Value = serde_json::from_str(&behind).unwrap();
    let behind = number(&behind["statistics"]["samples"]);
    assert!((behind / counts[0] - 1.0).abs() > 0.01, "the field should look different from behind");
    let walked = bench(&["--orbit", "360"])[0];
    assert!((walked / ((counts[0] + behind) / 2.0) - 1.0).abs() < 0.01, "{walked} {} {behind}", counts[0]);
}

#[test]
fn sweeps_vary_one_setting() {
    let folder = tempdir().unwrap();
    let names = ["step", "threads", "filter", "gradient", "view", "edit", "volume"];
    let sweeps: Vec<&str> = names.iter().flat_map(|name| ["--sweep", *name]).collect();
    let told = told(folder.path(), "2", &[&sweeps[..], &["--largest", "64", "--threads", "4"]].concat());
    let sweeps = told["scenes"][0]["sweeps"].as_array().unwrap();
    assert_eq!(sweeps.iter().map(|sweep| sweep["sweep"].as_str().unwrap()).collect::<Vec<_>>(), names);
    for sweep in sweeps {
        sweep["rows"].as_array().unwrap().iter().for_each(|row| assert_sound(&row["timing"], 2));
        assert!(number(&sweep["slowest_over_fastest"]) >= 1.0);
    }
    let rows = |sweep: usize, key: &str| -> Vec<(String, f64)> {
        let rows = sweeps[sweep]["rows"].as_array().unwrap().iter();
        rows.map(|row| (row["setting"].as_str().unwrap().to_owned(), number(&row["timing"][key]))).collect()
    };
    let labels = |sweep: usize| rows(sweep, "median_ms").into_iter().map(|(label, _)| label).collect::<Vec<_>>();

    assert_eq!(labels(0), ["4", "2", "1", "1/2", "1/4", "1/8"]);
    let all = |row: usize| rows(0, "samples")[row].1 + rows(0, "samples_skipped")[row].1;
    assert!((all(5) / all(4) - 2.0).abs() < 0.05, "half the step is twice the samples: {} {}", all(5), all(4));
    let threads: Vec<f64> = rows(1, "threads").into_iter().map(|(_, threads)| threads).collect();
    assert_eq!(threads, [1.0, 2.0, 4.0]);
    assert!(labels(2).contains(&"lanczos".into()) && labels(2).len() == 7);
    assert!(labels(3).contains(&"sobel".into()) && labels(3).len() == 8);

    assert_eq!(labels(4), ["+x", "+y", "+z", "diagonal"]);
    // The picture is as high as the cube's diagonal, sqrt(3) sides, and 16 pixels: a face takes
    // (16 / sqrt(3))^2 = 85 of them, the hexagon seen from a corner sqrt(3) times as many.
    let hit: Vec<f64> = rows(4, "rays_hit").into_iter().map(|(_, hit)| hit).collect();
    assert!(hit[..3].iter().all(|hit| (hit - 85.0).abs() < 20.0), "{hit:?}");
    assert!((hit[3] - 148.0).abs() < 20.0, "{hit:?}");

    assert_eq!(labels(5), ["unchanged", "edited"]);
    assert_eq!(labels(6), ["64^3 u8", "64^3 u16", "64^3 f32"]);
    let visible: Vec<f64> = rows(6, "samples_visible").into_iter().map(|(_, visible)| visible).collect();
    assert!(visible.iter().all(|count| (count / visible[0] - 1.0).abs() < 0.02), "not the same look: {visible:?}");
}

#[test]
fn a_speed_comes_with_its_error() {
    let folder = tempdir().unwrap();
    let path = folder.path();
    let scene = |more: &[&str]| {
        let told = told(path, "2", &[&["--backend", "cpu", "--step", "1"], more].concat());
        told["scenes"][0].clone()
    };
    let plain = scene(&["--picture", "timed.png"]);
    assert_eq!(plain["error"], Value::Null);
    // Eight voxels of one byte for every sample.
    let [gigabytes, rate, ms] =
        [&plain["voxel_gigabytes"], &plain["voxel_gigabytes_per_second"], &plain["orbit"]["timing"]["render_ms"]]
            .map(number);
    assert!((gigabytes * 1e9 / 8.0 - number(&plain["orbit"]["timing"]["samples"])).abs() < 1e-3, "{plain}");
    assert!((rate * ms / 1e3 / gigabytes - 1.0).abs() < 1e-9, "{plain}");

    // Against itself there is none; early termination is all that the same step leaves.
    let itself = scene(&["--against", "timed.png"]);
    assert_eq!((&itself["error"]["largest_difference"], &itself["error"]["psnr_db"]), (&json!(0), &Value::Null));
    let errors = ["--reference=1", "--reference"].map(|flag| scene(&[flag])["error"].clone());
    let [same, finer] = errors.each_ref().map(|error| number(&error["mean_difference"]));
    assert!(same < 0.2 && finer > same && finer < 10.0, "{errors:?}");
    assert!(number(&errors[1]["psnr_db"]) > 30.0 && number(&errors[1]["largest_difference"]) >= 1.0, "{errors:?}");
    // It is the error of a coarse step: a fine one has less.
    let fine = told(path, "1", &["--backend", "cpu", "--step", "0.25", "--reference"])["scenes"][0]["error"].clone();
    assert!(number(&fine["mean_difference"]) < finer / 2.0, "{fine} {errors:?}");

    let small = ["bench", "sample:ball@8x8x8", "--size", "8x8", "--frames", "1", "--reference"];
    let people = succeed_in(path, &small);
    assert!(people.contains("picture error: PSNR") && people.contains("8 times finer"), "{people}");
    for (args, part) in [(&["--against", "timed.png", "--size", "9x9"][..], "24x16"), (&["--reference=99"], "1..=64")] {
        let message = fail_in(path, &[&["bench", "sample:ball@8x8x8", "--frames", "1", "--quiet"], args].concat(), 2);
        assert!(message.contains(part), "{args:?}: {message}");
    }
}

#[test]
fn people_get_tables_and_remarks() {
    let folder = tempdir().unwrap();
    let path = folder.path();
    succeed_in(path, &["sample", "ball", "--dims", "8x8x8", "-o", "ball.nrrd", "--quiet"]);
    let args = [
        "bench",
        "ball.nrrd",
        "sample:ball@8x8x8",
        "--size",
        "8x8",
        "--frames",
        "2",
        "--sweep",
        "edit",
        "--json",
        "f.json",
    ];
    let output = run_in(path, &args);
    let (said, remarks) = (text(&output.stdout), text(&output.stderr));
    assert_eq!(output.status.code(), Some(0), "{remarks}");
    for part in
        ["ball.nrrd, 8x8: loaded in", "sample:ball@8x8x8, 8x8", "median ms", "Msamples/s/thread", "unchanged", "edited"]
    {
        assert!(said.contains(part), "'{part}' is not in {said}");
    }
    assert_eq!(said.matches(" cores, ").count(), 1, "{said}");
    assert!(remarks.contains("unit distance"), "{remarks}");
    let told: Value = serde_json::from_str(&std::fs::read_to_string(path.join("f.json")).unwrap()).unwrap();
    assert_eq!(told["scenes"].as_array().map(Vec::len), Some(2));
}

#[test]
fn what_cannot_be_measured_is_said_before_the_work() {
    let folder = tempdir().unwrap();
    let path = folder.path();
    succeed_in(path, &["sample", "ball", "--dims", "8x8x8", "-o", "ball.nrrd", "--quiet"]);
    let before = files(path);
    for (args, parts, code) in [
        (&["ball.nrrd", "--sweep", "wobble"][..], &["--sweep", "wobble", "step", "edit"][..], 2),
        (&["ball.nrrd", "--sweep", "volume"], &["--sweep volume", "built-in field", "sample:head"], 2),
        (&["ball.nrrd", "--frames", "0"], &["--frames", "0"], 2),
        (&["ball.nrrd", "--orbit", "far"], &["--orbit", "far"], 2),
        (&["ball.nrrd", "--largest", "32"], &["--largest", "64..=4096"], 2),
        (&["ball.nrrd", "ball.nrrd", "--picture", "a.png"], &["--picture", "2 are given"], 2),
        (&["ball.nrrd", "--picture", "a.exr"], &["a.exr", ".png"], 2),
        (&["ball.nrrd", "--json", "no/folder.json"], &["no/folder.json"], 1),
        (&["missing.nrrd"], &["missing.nrrd"], 2),
        (&["ball.nrrd", "--step", "1000"], &["quality.step", "0.01 to 100"], 2),
        (&[], &["INPUT"], 2),
    ] {
        let message = fail_in(path, &[&["bench"], args].concat(), code);
        parts.iter().for_each(|part| assert!(message.contains(part), "{args:?}: '{part}' is not in {message}"));
    }
    assert_eq!(files(path), before);
}

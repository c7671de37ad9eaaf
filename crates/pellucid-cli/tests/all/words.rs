//! What the command says: numbers, names, hints, and texts from outside.

use std::path::Path;

use crate::common::{fail_in, picture, run_in, succeed_in, text};
use serde_json::Value;
use tempfile::tempdir;

fn nrrd(fields: &str, values: &[u8]) -> Vec<u8> {
    [b"NRRD0004\ndimension: 3\nencoding: raw\nendian: little\n", fields.as_bytes(), b"\n\n", values].concat()
}

fn write(folder: &Path, name: &str, bytes: impl AsRef<[u8]>) {
    std::fs::write(folder.join(name), bytes).unwrap();
}

#[test]
fn small_and_large_numbers_are_told() {
    let folder = tempdir().unwrap();
    let path = folder.path();
    let floats = |largest: f64| -> Vec<u8> {
        (0..64).flat_map(|k| ((largest * f64::from(k) / 63.0) as f32).to_le_bytes()).collect()
    };
    let header = "type: float\nsizes: 4 4 4\nspacings: 5e-5 5e-5 1.2e-4";
    for (name, largest, said) in [("small.nrrd", 3e-27, "3e-27"), ("large.nrrd", 3e38, "3e38")] {
        write(path, name, nrrd(header, &floats(largest)));
        let draw = ["render", name, "--size", "8x8", "--backend", "cpu", "-o", "a.png", "--json"];
        let output = run_in(path, &draw);
        let told = text(&output.stderr);
        assert_eq!(output.status.code(), Some(0), "{told}");
        for part in ["spacing 5e-5 x 5e-5 x 1.2e-4", "7.33333e-5", said] {
            assert!(told.contains(part), "'{part}' is not in {told}");
        }
        let info = succeed_in(path, &["info", name]);
        for part in ["5e-5 x 5e-5 x 1.2e-4", &format!("0 to {said}"), "7.33333e-5"] {
            assert!(info.contains(part), "'{part}' is not in {info}");
        }
        for line in told.lines().chain(info.lines()).filter(|line| !line.contains('█')) {
            assert!(!line.contains("0.0000 ") && !line.contains("00000000"), "{line}");
        }
        // For programs they are numbers.
        let told: Value = serde_json::from_slice(&output.stdout).unwrap();
        let value = |setting: &str| {
            let choices = told["choices"].as_array().unwrap();
            choices.iter().find(|choice| choice["setting"] == setting).unwrap_or_else(|| panic!("{setting}"))["value"]
                .clone()
        };
        assert!((value("unit distance").as_f64().unwrap() - 220e-6 / 3.0).abs() < 1e-12);
        let window = value("window");
        assert!((window[1].as_f64().unwrap() / largest - 1.0).abs() < 0.02, "{window}");
        assert_eq!(value("preset"), "density");
        assert_eq!(value("camera")["eye"].as_array().map(Vec::len), Some(3));
    }
    let said = fail_in(path, &["render", "sample:ball", "--step", "1e300", "-o", "a.png"], 2);
    assert!(said.contains("found 1e300"), "{said}");
}

/// Every way by which a text of a file, a name or an argument reaches a terminal.
#[test]
fn texts_from_outside_do_not_steer_the_terminal() {
    let folder = tempdir().unwrap();
    let path = folder.path();
    let evil = "\u{1b}[2J\u{1b}]0;pwned\u{7}\u{9b}31m\u{202e}";
    let fields = format!(
        "type: uint8\nsizes: 4 3 2\nspace dimension: 3\n{evil}: v\nspace units: \"{evil}\" \"{evil}\" \"{evil}\"\n\
         sample units: {evil}HU"
    );
    let name = format!("a{evil}.nrrd");
    write(path, &name, nrrd(&fields, &[7; 24]));
    write(path, "bad.nrrd", nrrd(&format!("type: {evil}\nsizes: 4 3 2"), &[7; 24]));
    write(
        path,
        "gone.nhdr",
        format!("NRRD0004\ntype: uint8\ndimension: 3\nsizes: 4 3 2\nencoding: raw\ndata file: {evil}\n"),
    );
    let scene = format!("[[volumes]]\nsource.file = \"{}\"\n", "\\u001b[2J.nrrd");
    write(path, "scene.toml", scene);
    write(path, "key.toml", "\"\\u001b[2J\" = 1\n");
    write(
        path,
        "preset.json",
        "{\"volumes\": [{\"source\": {\"sample\": {\"name\": \"ball\"}}, \"preset\": \"\\u001b[2J\"}]}",
    );
    let picture = format!("b{evil}.png");
    let (name, picture) = (name.as_str(), picture.as_str());
    let small = ["--size", "4x4", "--backend", "cpu"];
    let draw = |input| [&["render", input, "-o", picture], &small[..]].concat();
    let runs: Vec<Vec<&str>> = vec![
        draw(name),
        [draw(name), vec!["--json"]].concat(),
        [draw(name), vec!["--save-scene", "saved.toml"]].concat(),
        vec!["info", name],
        vec!["info", "--json", name],
        vec!["convert", name, "-o", "c.nrrd"],
        vec!["convert", name, "-o", evil],
        vec!["compare", name, "--frames", "1", "--size", "4x4", "--backend", "cpu"],
        vec!["bench", name, "--frames", "1", "--size", "4x4", "--backend", "cpu"],
        vec!["bench", name, "--frames", "1", "--size", "4x4", "--backend", "cpu", "--json", "-"],
        draw("bad.nrrd"),
        draw("gone.nhdr"),
        draw("scene.toml"),
        draw("key.toml"),
        draw("preset.json"),
        draw(evil),
        [draw("sample:ball@8x8x8"), vec!["--preset", evil]].concat(),
        [draw("sample:ball@8x8x8"), vec!["--mode", evil]].concat(),
        [draw("sample:ball@8x8x8"), vec!["--set", evil]].concat(),
        [draw("sample:ball@8x8x8"), vec!["--adapter", evil]].concat(),
        vec!["presets", evil],
        vec![evil],
        vec!["sample", evil, "-o", "d.nrrd"],
    ];
    for run in runs {
        let output = run_in(path, &run);
        for said in [text(&output.stdout), text(&output.stderr)] {
            let steering = said.chars().find(|c| (c.is_control() && *c != '\n') || *c == '\u{202e}');
            assert_eq!(steering, None, "{run:?}: {said:?}");
            if said.starts_with(['{', '[']) {
                // Programs get the texts as they are.
                let told: Value = serde_json::from_str(&said).unwrap();
                assert!(told.to_string().contains("pwned"), "{said}");
            }
        }
    }
}

/// An input, flags, what must be said, and what must not.
type Mistake = (&'static str, &'static [&'static str], &'static [&'static str], &'static [&'static str]);

#[test]
fn mistakes_lead_to_what_is_meant() {
    let folder = tempdir().unwrap();
    let path = folder.path();
    write(path, "gone.nhdr", "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 4 3 2\nencoding: raw\ndata file: gone.raw\n");
    std::fs::create_dir(path.join("series")).unwrap();
    std::fs::create_dir(path.join("other")).unwrap();
    write(path, "series/a.nrrd", "");
    let draw = |input: &'static str, flags: &[&'static str]| {
        fail_in(path, &[&["render", input, "-o", "a.png", "-q"], flags].concat(), 2)
    };
    let ball = "sample:ball@8x8x8";
    let cases: Vec<Mistake> = vec![
        (ball, &["--mode", "mip"], &["'maximum'"], &[]),
        (ball, &["--mode", "MinIP"], &["'minimum'"], &[]),
        (ball, &["--mode", "xray"], &["'x-ray'"], &[]),
        (ball, &["--mode", "isosurface"], &["hint: --iso VALUE"], &[]),
        (ball, &["--mode", "slice"], &["hint: --slice axial"], &[]),
        (ball, &["--mode", "mpr"], &["hint: --slice axial"], &[]),
        (ball, &["--technique", "path_trace"], &["'path-trace'"], &[]),
        (ball, &["--technique", "slicing"], &["'view-aligned'"], &[]),
        (ball, &["--technique", "mip"], &["hint: maximum projections are drawn with --mode maximum"], &[]),
        (ball, &["--filter", "cubic"], &["'catmull-rom'"], &[]),
        (ball, &["--slice", "transverse"], &["did you mean axial?"], &[]),
        (ball, &["--light", "headligth"], &["did you mean headlight?"], &[]),
        (ball, &["--preset", "ct-boen"], &["did you mean ct-bone?"], &[]),
        (ball, &["--colormap", "virdis"], &["did you mean viridis?"], &[]),
        (ball, &["--opacity", "sigmoid5"], &["did you mean sigmoid_5?"], &[]),
        (ball, &["--background", "ornage"], &["did you mean orange?"], &[]),
        (ball, &["--iso", "3,ligthblue"], &["did you mean lightblue?"], &[]),
        (ball, &["--set", "technique.ray_cast.mode=mip"], &["did you mean `maximum`?"], &[]),
        (ball, &["--set", "quality.stpe=1"], &["did you mean `step`?"], &[]),
        ("sample:hed", &[], &["did you mean head?"], &[]),
        ("head", &[], &["'sample:head'"], &[]),
        ("gone.nhdr", &[], &["gone.raw", "header"], &["sample:"]),
        ("series", &[], &["folder", "series/a.nrrd"], &["regular"]),
        ("other", &[], &["folder", "name a volume file"], &["regular"]),
    ];
    for (input, flags, parts, not) in cases {
        let said = draw(input, flags);
        parts.iter().for_each(|part| assert!(said.contains(part), "{input} {flags:?}: '{part}' is not in {said}"));
        not.iter().for_each(|part| assert!(!said.contains(part), "{input} {flags:?}: '{part}' is in {said}"));
    }
    let said = fail_in(path, &["compare", ball, "--techniques", "rays"], 2);
    assert!(said.contains("did you mean ray-cast?"), "{said}");
    assert!(fail_in(path, &["presets", "bone"], 2).contains("did you mean ct-bone?"));
}

/// The library speaks of settings.
#[test]
fn advice_is_given_in_flags() {
    let folder = tempdir().unwrap();
    let path = folder.path();
    write(path, "colors.raw", (0..192).collect::<Vec<u8>>());
    let colors = ["--dims", "4x4x4", "--type", "u8", "--components", "3"];
    let values = [&colors[..], &["--mode", "maximum"]].concat();
    let cases: [(&str, &[&str], &str); 6] = [
        ("colors.raw", &colors, "--colors transfer-function draws the brightness in other colours"),
        ("colors.raw", &values, "--component 0 to 2 draws one of them"),
        ("sample:ball", &["--window", "1e6,2e6"], "--window, --preset or --opacity change that"),
        ("sample:ball", &["--unit-distance", "1e9"], "--unit-distance sets a smaller one"),
        ("sample:ball", &["--mode", "minimum"], "--crop or --clip to the inside shows what is lowest there"),
        ("sample:ball", &["--technique", "half-angle"], "--look studio, sky, skin or cloud bring others"),
    ];
    for (input, flags, advice) in cases {
        let draw = ["render", input, "--size", "8x8", "--backend", "cpu", "-o", "a.png"];
        let told = text(&run_in(path, &[&draw, flags].concat()).stderr).to_owned();
        assert!(told.contains(advice), "'{advice}' is not in {told}");
    }
}

#[test]
fn flags_without_effect_are_called_by_their_names() {
    let folder = tempdir().unwrap();
    let path = folder.path();
    let pairs: [(&[&str], &[&str], &str); 17] = [
        (&["--mode", "maximum"], &["--colors", "transfer-function"], "--colors"),
        (&["--orthographic=300"], &["--distance", "900"], "--distance"),
        (&["--shading", "off"], &["--light", "1,0,0"], "--light"),
        (&["--shading", "off"], &["--ambient", "0.9"], "--ambient"),
        (&["--shading", "off"], &["--ambient", "0.9", "--shininess", "3"], "--ambient and --shininess"),
        (&["--shading", "off"], &["--gradient", "sobel"], "--gradient"),
        (&["--mode", "maximum"], &["--shading", "on"], "--shading"),
        (&["--mode", "maximum"], &["--classification", "pre-integrated"], "--classification"),
        // What a flag says counts as said, be it the default.
        (&["--mode", "maximum"], &["--classification", "post"], "--classification"),
        (&["--slice", "axial"], &["--combine", "average"], "--combine"),
        (&["--slice", "axial"], &["--step", "0.1"], "--step"),
        (&["--technique", "path-trace"], &["--supersampling", "2"], "--supersampling"),
        (&["--technique", "path-trace"], &["--step", "0.1"], "--step"),
        (&["--iso", "300"], &["--unit-distance", "99"], "--unit-distance"),
        (&["--iso", "300,red", "--preset", "ct-bone"], &["--colormap", "hot"], "--colormap"),
        (&["--mode", "x-ray"], &["--colormap", "hot"], "--colormap"),
        (&["--mode", "maximum"], &["--step", "0.1"], "--step"),
    ];
    let draw = |flags: &[&str]| {
        let scene = ["render", "sample:head@12x16x16", "--size", "16x16", "--backend", "cpu", "-o", "a.png"];
        let quick = ["--set", "technique.path_trace.samples=1"];
        let quick = if flags.contains(&"path-trace") { &quick[..] } else { &[] };
        let output = run_in(path, &[&scene[..], flags, quick].concat());
        assert_eq!(output.status.code(), Some(0), "{flags:?}: {}", text(&output.stderr));
        (text(&output.stderr), picture(&path.join("a.png")).pixels)
    };
    for (first, second, name) in pairs {
        let (before, both) = (draw(first), draw(&[first, second].concat()));
        assert!(!before.0.contains("no effect"), "{first:?}: {}", before.0);
        let warning =
            |line: &str| line.starts_with(&format!("pellucid: warning: {name} ha")) && line.contains("no effect: ");
        assert!(both.0.lines().any(warning), "{first:?} {second:?}: {}", both.0);
        let apart = before.1.as_flattened().iter().zip(both.1.as_flattened()).map(|(a, b)| (a - b).abs());
        // Places along parallel rays are rounded anew where their eye stands elsewhere: a level or a few at edges.
        let bound = if name == "--distance" { 0.02 } else { 0.0 };
        assert!(apart.fold(0.0, f32::max) <= bound, "{first:?} {second:?}");
    }
    let exr = run_in(
        path,
        &["render", "sample:ball@8x8x8", "--size", "8x8", "--backend", "cpu", "--bits", "16", "-o", "a.exr"],
    );
    assert!(text(&exr.stderr).contains("--bits has no effect"), "{}", text(&exr.stderr));
}

#[test]
fn flags_of_another_backend_are_refused_or_told() {
    let folder = tempdir().unwrap();
    let ball = ["render", "sample:ball@8x8x8", "--size", "8x8", "-o", "a.png"];
    for flag in
        [["--adapter", "software"], ["--interpolation", "exact"], ["--passes", "wavefront"], ["--gpu-memory", "64"]]
    {
        let said = fail_in(folder.path(), &[&ball[..], &["--backend", "cpu"], &flag].concat(), 2);
        assert!(said.contains(flag[0]) && said.contains("--backend cpu"), "{said}");
    }
    for flag in [["--threads", "2"], ["--simd", "baseline"]] {
        let output = run_in(folder.path(), &[&ball[..], &["--adapter", "software"], &flag].concat());
        assert!(text(&output.stderr).contains(&format!("{} has no effect", flag[0])), "{}", text(&output.stderr));
    }
    // Without hardware the adapter on the processor is one.
    let output = run_in(folder.path(), &[&ball[..], &["--backend", "gpu"]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let slices = run_in(folder.path(), &[&ball[..], &["--technique", "view-aligned"]].concat());
    assert_eq!(slices.status.code(), Some(0), "{}", text(&slices.stderr));
}

/// A document is refused for what it says before its files are read: they need not even be there.
#[test]
fn documents_are_refused_before_their_volumes_are_loaded() {
    let folder = tempdir().unwrap();
    let gone = "[[volumes]]\nsource.file = \"gone.nrrd\"\n";
    let cases = [
        (format!("{gone}{gone}[technique.slicing]\ngeometry = \"object_aligned\"\n"), "2 volumes"),
        (
            format!(
                "{gone}{gone}[technique.slicing]\ngeometry = \"multi_texture\"\nmode.isosurface.isovalues = [{{ value = 1 }}]\n"
            ),
            "2 volumes",
        ),
        ("title = \"nothing\"\n".to_owned(), "no volume"),
        (format!("{gone}preset = \"ct-boen\"\n"), "ct-bone"),
        (format!("{gone}scattering.phase.table = {{ file = \"phase.csv\" }}\n[technique.path_trace]\n"), "phase.csv"),
        (format!("{gone}[technique.path_trace.environment.image]\nsource.file = \"sky.exr\"\n"), "sky.exr"),
    ];
    for (scene, part) in cases {
        write(folder.path(), "scene.toml", &scene);
        for command in ["render", "bench", "compare"] {
            let output: &[&str] = if command == "render" { &["-o", "a.png"] } else { &[] };
            let said = fail_in(folder.path(), &[&[command, "scene.toml"], output].concat(), 2);
            assert!(said.contains(part) && !said.contains("gone.nrrd"), "{command}: {said}\n{scene}");
        }
    }
}

#[test]
fn information_is_what_is_drawn_with_and_no_more_than_is_known() {
    let folder = tempdir().unwrap();
    let path = folder.path();
    write(path, "stack.raw", [0; 8 * 8 * 4]);
    let scene = "[[volumes]]\nsource.raw = { path = \"stack.raw\", dims = [8, 8, 4], voxel_type = \"u8\" }\n\
        spacing = [1.0, 1.0, 2.5]\n";
    write(path, "scene.toml", scene);
    let told = |input: &str| -> Value {
        serde_json::from_str::<Value>(&succeed_in(path, &["info", "--json", input])).unwrap()[0].clone()
    };
    let said = succeed_in(path, &["info", "scene.toml"]);
    assert!(said.contains("1 x 1 x 2.5") && said.contains("sides of the data are not known"), "{said}");
    assert!(!said.contains("LPS"), "{said}");
    let stack = told("scene.toml");
    assert_eq!((&stack["spacing"][2], &stack["orientation"]), (&2.5.into(), &Value::Null));
    assert_eq!(stack["choices"][2]["value"], 1.5);
    // Where a file or a field states a patient, sides are known.
    assert_eq!(told("sample:head@8x8x8")["orientation"], "LPS");
    let plain = nrrd("type: uint8\nsizes: 2 2 2\nspacings: 1 1 1", &[0; 8]);
    let placed = "type: uint8\nsizes: 2 2 2\nspace: RAS\nspace directions: (1,0,0) (0,1,0) (0,0,1)";
    write(path, "plain.nrrd", plain);
    write(path, "placed.nrrd", nrrd(placed, &[0; 8]));
    assert_eq!(
        (&told("plain.nrrd")["orientation"], &told("placed.nrrd")["orientation"]),
        (&Value::Null, &"RAS".into())
    );
}

/// A preset that is printed, saved and given back draws what its name draws; and it can be changed.
#[test]
fn presets_are_written_edited_and_given_back() {
    let folder = tempdir().unwrap();
    let path = folder.path();
    let draw = |input: &str, flags: &[&str]| {
        let fixed = ["render", input, "--size", "20x20", "--backend", "cpu", "-o", "a.png", "-q"];
        succeed_in(path, &[&fixed, flags].concat());
        picture(&path.join("a.png")).pixels
    };
    // To both sides of a background, further to one: a preset of such data chooses its window in its own way.
    let value = |k: usize| match [k % 12, k / 12 % 12, k / 144].map(|i| (2..5).contains(&i)) {
        [true, true, true] => "-3",
        _ if [k % 12, k / 12 % 12, k / 144].iter().all(|i| (7..11).contains(i)) => "2",
        _ => "0",
    };
    let values: Vec<&str> = (0..12 * 12 * 12).map(value).collect();
    let header = "NRRD0004\ntype: float\ndimension: 3\nsizes: 12 12 12\nencoding: ascii\n\n";
    write(path, "signed.nrrd", header.to_owned() + &values.join(" "));
    for preset in pellucid::optics::Preset::all() {
        let name = preset.name.as_str();
        write(path, "look.toml", succeed_in(path, &["presets", name]));
        write(path, "look.json", succeed_in(path, &["presets", name, "--json"]));
        let pictures: &[(&str, &[&str])] = if name.starts_with("ct") {
            &[("sample:head@12x16x16", &[])]
        } else {
            &[
                ("sample:wavelet@12x12x12", &[]),
                ("sample:wavelet@12x12x12", &["--window", "50,250"]),
                ("signed.nrrd", &[]),
            ]
        };
        for (input, window) in pictures {
            let named = draw(input, &[&["--preset", name], *window].concat());
            for file in ["look.toml", "look.json"] {
                let given = draw(input, &[&["--transfer-function", file], *window].concat());
                assert!(named == given, "{name} {file} {input}");
            }
        }
        // What nobody changed is no mistake of theirs.
        let again = ["render", pictures[0].0, "--size", "8x8", "-o", "a.png", "--transfer-function", "look.toml"];
        let said = run_in(path, &again);
        assert!(!text(&said.stderr).contains("no effect"), "{name}: {}", text(&said.stderr));
    }
    let bone = succeed_in(path, &["presets", "ct-bone"]);
    let edited = bone.replace("shading = true", "shading = false");
    assert_ne!(bone, edited);
    write(path, "look.toml", edited);
    let [own, named] = [["--transfer-function", "look.toml"], ["--preset", "ct-bone"]];
    assert_ne!(draw("sample:head@12x16x16", &own), draw("sample:head@12x16x16", &named));
    write(path, "look.toml", bone.replace("shading = true", "shading = 3"));
    let said = fail_in(path, &["render", "sample:ball", "-o", "a.png", "--transfer-function", "look.toml"], 2);
    assert!(said.contains("boolean"), "{said}");
}

/// The colours of a background are those of its first and its last row, in every encoding.
#[test]
fn backgrounds_reach_their_colours() {
    let folder = tempdir().unwrap();
    let path = folder.path();
    for backend in [["--backend", "cpu"], ["--adapter", "software"]] {
        for (size, bits) in [("4x8", "8"), ("4x8", "16"), ("3x2", "8"), ("1x37", "16")] {
            let fixed = ["render", "sample:ball@8x8x8", "--clip", "0,0,1,0,0,999", "--background", "red,blue", "-q"];
            let flags = ["--size", size, "--bits", bits, "-o", "a.png", backend[0], backend[1]];
            succeed_in(path, &[&fixed[..], &flags].concat());
            let rows = picture(&path.join("a.png"));
            let (first, last) = (rows.pixels[0], rows.pixels[rows.pixels.len() - 1]);
            assert_eq!((first, last), ([1.0, 0.0, 0.0, 1.0], [0.0, 0.0, 1.0, 1.0]), "{size} {bits} {backend:?}");
        }
    }
}

/// Sizes along axes are written with either mark.
#[test]
fn spacings_and_dims_take_both_marks() {
    let folder = tempdir().unwrap();
    write(folder.path(), "stack.raw", [0; 8 * 8 * 4 * 2]);
    let scene = |dims: &str, spacing: &str| {
        crate::common::scene_in(folder.path(), &["stack.raw", "--dims", dims, "--type", "u16", "--spacing", spacing])
    };
    let (a, b) = (scene("8x8x4", "1x1x2.5"), scene("8,8,4", "1,1,2.5"));
    assert_eq!(a, b);
    assert_eq!(a["volumes"][0]["spacing"], serde_json::json!([1.0, 1.0, 2.5]));

    let stack = ["stack.raw", "--dims", "8x8x4", "--type", "u16", "--spacing", "1x1x2.5", "--size", "8x8"];
    let drawn = run_in(folder.path(), &[&["render", "-o", "a.png"][..], &stack].concat());
    let words = text(&drawn.stderr);
    assert!(words.contains("stack: 8x8x4 u16, spacing 1 x 1 x 2.5 world units"), "{words}");
}

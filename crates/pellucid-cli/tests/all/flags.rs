//! Every flag changes the scene as its help says.

use crate::common::{fail_in, scene_in, succeed_in};
use serde_json::{Value, json};
use tempfile::tempdir;

const SAMPLE: &str = "sample:ball@8x8x8";

/// Flags and where their values stand in the document.
#[rustfmt::skip]
fn table() -> Vec<(&'static [&'static str], &'static str, Value)> {
    vec![
        (&["--size", "640x480"], "/image/width", json!(640)),
        (&["--size", "640x480"], "/image/height", json!(480)),
        (&["--background", "transparent"], "/image/background", json!("transparent")),
        (&["--background", "#ff8000"], "/image/background/color", json!("#ff8000")),
        (&["--background", "ffffff"], "/image/background/color", json!("#ffffff")),
        (&["--background", "white,black"], "/image/background/gradient", json!({"top": "#ffffff", "bottom": "#000000"})),
        (&["--encoding", "linear"], "/image/encoding", json!("linear")),
        (&["--exposure", "1.5"], "/image/exposure", json!(1.5)),
        (&["--azimuth", "-75"], "/camera/view/orbit/azimuth", json!(-75.0)),
        (&["--elevation", "-5"], "/camera/view/orbit/elevation", json!(-5.0)),
        (&["--roll", "90"], "/camera/view/orbit/roll", json!(90.0)),
        (&["--zoom", "2"], "/camera/view/orbit/zoom", json!(2.0)),
        (&["--distance", "7"], "/camera/view/orbit/distance", json!(7.0)),
        (&["--target", "-1,2,3"], "/camera/view/orbit/target", json!([-1.0, 2.0, 3.0])),
        (&["--eye", "-9,0,0", "--target", "1,2,3"], "/camera/view/look_at/position", json!([-9.0, 0.0, 0.0])),
        (&["--eye", "-9,0,0", "--target", "1,2,3"], "/camera/view/look_at/target", json!([1.0, 2.0, 3.0])),
        (&["--eye", "-9,0,0", "--target", "1,2,3", "--up", "0,-1,0"], "/camera/view/look_at/up", json!([0.0, -1.0, 0.0])),
        (&["--fov", "45"], "/camera/projection/perspective/vertical_fov", json!(45.0)),
        (&["--frame", "grid"], "/camera/frame", json!("grid")),
        (&["--look", "studio"], "/lighting/ambient", json!(0.25)),
        (&["--background", "environment"], "/image/background", json!("environment")),
        (&["--orthographic=12"], "/camera/projection/orthographic/height", json!(12.0)),
        (&["--preset", "ct-bone"], "/volumes/0/preset", json!("ct-bone")),
        (&["--window", "-100,900"], "/volumes/0/window", json!([-100.0, 900.0])),
        (&["--colormap", "viridis_r"], "/volumes/0/colormap", json!("viridis_r")),
        (&["--colors", "transfer-function"], "/volumes/0/colors", json!("transfer_function")),
        (&["--opacity", "sigmoid_5"], "/volumes/0/opacity", json!("sigmoid_5")),
        (&["--unit-distance", "2.5"], "/volumes/0/unit_distance", json!(2.5)),
        (&["--transfer-function", "tf.toml"], "/volumes/0/transfer_function/opacities", json!([[0.0, 0.0], [1.0, 0.5]])),
        (&["--transfer-function", "tf.json"], "/volumes/0/transfer_function/unit_distance", json!(3.0)),
        (&["--shading", "off"], "/volumes/0/shading", json!(false)),
        (&["--ambient", "0.25"], "/volumes/0/material/ambient", json!(0.25)),
        (&["--diffuse", "0.5"], "/volumes/0/material/diffuse", json!(0.5)),
        (&["--specular", "0.125"], "/volumes/0/material/specular", json!(0.125)),
        (&["--shininess", "64"], "/volumes/0/material/shininess", json!(64.0)),
        (&["--light", "0,0,-1", "--light", "1,0,0"], "/lighting/lights/1/kind/directional/direction", json!([1.0, 0.0, 0.0])),
        (&["--light", "headlight"], "/lighting/lights/0/frame", json!("camera")),
        (&["--light", "three-point"], "/lighting/ambient", json!(0.0)),
        (&["--technique", "shells", "--mode", "x-ray"], "/technique/slicing", json!({
            "mode": "x_ray", "geometry": "shells", "order": "front_to_back", "target": "f32", "colors": "associated",
            "correction": "per_sample", "proxy": "vertex_stage", "samples": 1, "termination_interval": 10,
            "occlusion_culling": true,
        })),
        (&["--technique", "path-trace"], "/technique/path_trace/samples", json!(64)),
        (&["--mode", "composite"], "/technique/ray_cast/mode", json!("composite")),
        (&["--mode", "x-ray"], "/technique/ray_cast/mode", json!("x_ray")),
        (&["--channels", "0:red"], "/volumes/0/colormap", json!("red")),
        (&["--iso", "-5,ff0000,0.5"], "/technique/ray_cast/mode/isosurface/isovalues/0", json!({"value": -5.0, "color": "#ff0000", "opacity": 0.5, "volume": null})),
        (&["--iso", "1", "--iso", "2"], "/technique/ray_cast/mode/isosurface/isovalues/1", json!({"value": 2.0, "color": null, "opacity": 1.0, "volume": null})),
        (&["--iso", "1", "--ambient-occlusion"], "/technique/ray_cast/mode/isosurface/illumination/global/bounces", json!(0)),
        (&["--iso", "1", "--ambient-occlusion=2.5"], "/technique/ray_cast/mode/isosurface/illumination/global/distance", json!(2.5)),
        (&["--iso", "1", "--global-illumination"], "/technique/ray_cast/mode/isosurface/illumination/global/bounces", json!(4)),
        (&["--slice", "axial"], "/technique/ray_cast/mode/slice/normal", json!([0.0, 0.0, 1.0])),
        (&["--slice", "0,-2,0"], "/technique/ray_cast/mode/slice/normal", json!([0.0, -2.0, 0.0])),
        (&["--slice", "axial", "--at", "1,2,-3"], "/technique/ray_cast/mode/slice/point", json!([1.0, 2.0, -3.0])),
        // Magnified, it is faced all the same.
        (&["--slice", "axial", "--zoom", "2"], "/camera/view/orbit/elevation", json!(-90.0)),
        (&["--slice", "axial", "--zoom", "2"], "/camera/view/orbit/zoom", json!(2.0)),
        (&["--slice", "axial", "--thickness", "4"], "/technique/ray_cast/mode/slice/thickness", json!(4.0)),
        (&["--slice", "axial", "--combine", "average"], "/technique/ray_cast/mode/slice/combine", json!("average")),
        (&["--step", "0.25"], "/quality/step", json!(0.25)),
        (&["--filter", "nearest"], "/quality/filter", json!("nearest")),
        (&["--gradient", "sobel"], "/quality/gradient", json!("sobel")),
        (&["--classification", "pre-integrated"], "/quality/classification", json!("pre_integrated")),
        (&["--jitter", "blue-noise=7"], "/quality/jitter/blue_noise/seed", json!(7)),
        (&["--early-termination", "1"], "/quality/early_termination", json!(1.0)),
        (&["--adaptive", "0.25"], "/quality/adaptive_tolerance", json!(0.25)),
        (&["--no-skip"], "/quality/empty_space_skipping", json!(false)),
        (&["--supersampling", "3"], "/quality/supersampling", json!(3)),
        (&["--clip", "0,-1,0,1,2,3"], "/clips/0/plane", json!({"normal": [0.0, -1.0, 0.0], "point": [1.0, 2.0, 3.0]})),
        (&["--clip-box", "-1,-2,-3,1,2,3"], "/clips/0/box", json!({"min": [-1.0, -2.0, -3.0], "max": [1.0, 2.0, 3.0]})),
        (&["--crop", "0,1,2,5,6,7"], "/volumes/0/crop", json!({"from": [0.0, 1.0, 2.0], "to": [5.0, 6.0, 7.0]})),
        (&["--component", "0"], "/volumes/0/component", json!(0)),
        (&["--spacing", "1,1,2.5"], "/volumes/0/spacing", json!([1.0, 1.0, 2.5])),
        (&["--dims", "9x8x7"], "/volumes/0/source/sample/dims", json!([9, 8, 7])),
        (&["--type", "i16"], "/volumes/0/source/sample/voxel_type", json!("i16")),
        (&["--set", "title=Two words"], "/title", json!("Two words")),
    ]
}

fn write_transfer_functions(folder: &std::path::Path) {
    let toml = "colors = [[0, \"#000000\"], [1, \"#ffffff\"]]\nopacities = [[0, 0.0], [1, 0.5]]\n";
    std::fs::write(folder.join("tf.toml"), toml).unwrap();
    let json = r##"{"colors": [[0, "#000000"]], "opacities": [[0, 1.0]], "unit_distance": 3}"##;
    std::fs::write(folder.join("tf.json"), json).unwrap();
}

#[test]
fn every_flag_reaches_its_place_in_the_document() {
    let folder = tempdir().unwrap();
    write_transfer_functions(folder.path());
    for (flags, pointer, expected) in table() {
        let scene = scene_in(folder.path(), &[&[SAMPLE], flags].concat());
        assert_eq!(scene.pointer(pointer), Some(&expected), "{flags:?} at {pointer} in {scene:#}");
    }
}

/// Flags of `render --help` that do not concern the scene.
const OUTPUT: [&str; 16] = [
    "--output",
    "--bits",
    "--aux",
    "--save-scene",
    "--backend",
    "--threads",
    "--simd",
    "--adapter",
    "--interpolation",
    "--gpu-memory",
    "--passes",
    "--accumulate",
    "--json",
    "--quiet",
    "--help",
    "--version",
];
/// Flags of headerless files, tested with one.
const RAW: [&str; 3] = ["--endian", "--skip", "--components"];
/// Flags of what files may name and cost, tested by the tests named `untrusted`.
const READING: [&str; 3] = ["--allow-outside", "--max-bytes", "--map"];

#[test]
fn the_table_knows_every_flag_in_the_help() {
    let folder = tempdir().unwrap();
    let help = succeed_in(folder.path(), &["render", "--help"]);
    let options = help.split("Settings are taken").next().unwrap().lines().filter_map(|line| {
        let line = line.trim_start();
        let line =
            line.strip_prefix("-o, ").or(line.strip_prefix("-q, ")).or(line.strip_prefix("-h, ")).unwrap_or(line);
        line.starts_with("--").then(|| line.split([' ', '[', '=']).next().unwrap().to_owned())
    });
    let tested: Vec<&str> = table().iter().flat_map(|(flags, ..)| flags.iter().copied()).collect();
    let mut count = 0;
    for option in options {
        count += 1;
        let known = OUTPUT.iter().chain(&RAW).chain(&READING).any(|known| *known == option);
        let in_table = tested.iter().any(|flag| flag.split('=').next() == Some(&option));
        assert!(known || in_table, "{option} is in the help and not in the table");
    }
    assert!(count > 50, "{count} options found in the help");
}

#[test]
fn set_and_flags_agree() {
    let folder = tempdir().unwrap();
    let pairs: [(&[&str], &[&str]); 8] = [
        (&["--step", "0.25"], &["--set", "quality.step=0.25"]),
        (&["--size", "64x32"], &["--set", "image.width=64", "--set", "image.height=32"]),
        (&["--window", "1,2"], &["--set", "volumes[0].window=[1, 2]"]),
        (&["--preset", "ct-bone"], &["--set", "volumes[0].preset=ct-bone"]),
        (&["--fov", "40"], &["--set", "camera.projection.perspective.vertical_fov=40"]),
        (
            &["--eye", "1,2,3", "--target", "0,0,0"],
            &["--set", "camera.view.look_at.position=[1,2,3]", "--set", "camera.view.look_at.target=[0,0,0]"],
        ),
        (&["--clip", "1,0,0,0,0,0"], &["--set", "clips[0]={plane={normal=[1,0,0],point=[0,0,0]}}"]),
        (&["--iso", "0.5"], &["--set", "technique.ray_cast.mode.isosurface.isovalues[0].value=0.5"]),
    ];
    for (flags, settings) in pairs {
        let [a, b] = [flags, settings].map(|args| scene_in(folder.path(), &[&[SAMPLE], args].concat()));
        assert_eq!(a, b, "{flags:?} {settings:?}");
    }
}

#[test]
fn later_layers_win() {
    let folder = tempdir().unwrap();
    let file =
        "[[volumes]]\nsource.sample.name = \"ball\"\npreset = \"ct-bone\"\n[quality]\nstep = 2.0\nsupersampling = 2\n";
    std::fs::write(folder.path().join("scene.toml"), file).unwrap();
    let scene = |args: &[&str]| scene_in(folder.path(), &[&["scene.toml"], args].concat());
    let step = |args: &[&str]| scene(args)["quality"]["step"].clone();
    assert_eq!(step(&[]), json!(2.0));
    assert_eq!(step(&["--step", "3"]), json!(3.0));
    assert_eq!(step(&["--set", "quality.step=4", "--step", "3"]), json!(4.0));
    assert_eq!(step(&["--set", "quality.step=4", "--set", "quality.step=5"]), json!(5.0));
    // Nothing at all brings the default back; what no layer mentions stays as the file has it.
    assert_eq!(step(&["--set", "quality.step="]), json!(0.5));
    assert_eq!(scene(&["--step", "3"])["quality"]["supersampling"], json!(2));
    assert_eq!(scene(&["--colormap", "gray"])["volumes"][0]["preset"], json!("ct-bone"));
    assert_eq!(scene(&["--set", "volumes[0].preset="])["volumes"][0]["preset"], json!("micro-ct"));
}

#[test]
fn one_number_of_a_material_leaves_the_rest_to_the_preset() {
    let folder = tempdir().unwrap();
    let material = |args: &[&str]| {
        let scene = scene_in(folder.path(), &[&["sample:head@8x8x8", "--ambient", "0.5"], args].concat());
        let material: pellucid::optics::Material =
            serde_json::from_value(scene["volumes"][0]["material"].clone()).unwrap();
        assert_eq!(material.ambient, 0.5);
        material
    };
    // Chosen by itself for values in HU, and by name.
    for (args, preset) in [(&[][..], "ct-bone"), (&["--preset", "ct-skin"], "ct-skin")] {
        let expected = pellucid::optics::Preset::by_name(preset).unwrap().material;
        assert_ne!(expected, pellucid::optics::Material::default());
        assert_eq!(material(args), pellucid::optics::Material { ambient: 0.5, ..expected });
    }
    assert_eq!(material(&["--set", "volumes[0].material.diffuse=0.25"]).diffuse, 0.25);
}

#[test]
fn settings_switch_between_variants_and_extend_lists() {
    let folder = tempdir().unwrap();
    let scene = |args: &[&str]| scene_in(folder.path(), &[&[SAMPLE], args].concat());
    let camera = scene(&["--set", "camera.projection.orthographic.height=5"]);
    assert_eq!(camera["camera"]["projection"], json!({"orthographic": {"height": 5.0}}));
    let mode = scene(&["--iso", "1", "--set", "technique.ray_cast.mode.slice.thickness=3"]);
    assert_eq!(mode["technique"]["ray_cast"]["mode"]["slice"]["thickness"], json!(3.0));
    let lights = scene(&["--set", "lighting.lights[1]={kind={directional={direction=[0,0,1]}}}"]);
    assert_eq!(lights["lighting"]["lights"].as_array().map(Vec::len), Some(2));
    let direction = scene(&["--light", "1,0,0", "--set", "lighting.lights[0].kind.directional.direction=[0,1,0]"]);
    assert_eq!(direction["lighting"]["lights"][0]["kind"], json!({"directional": {"direction": [0.0, 1.0, 0.0]}}));
}

#[test]
fn wrong_settings_say_where_and_what_is_expected() {
    let folder = tempdir().unwrap();
    let fail =
        |setting: &str| fail_in(folder.path(), &["render", SAMPLE, "--save-scene", "s.toml", "--set", setting], 2);
    for (setting, parts) in [
        ("quality.stepp=1", &["quality", "stepp", "expected", "supersampling"][..]),
        ("quality.step=fast", &["quality.step", "fast", "f64"]),
        ("quality.step=0", &["quality.step", "found 0", "0.01 to 100"]),
        ("quality.step", &["PATH=VALUE"]),
        ("quality..step=1", &["quality..step", "not a path"]),
        ("quality.step=[1", &["[1", "not a TOML value"]),
        ("quality.step=nan", &["nan", "finite"]),
        ("clips[2]={}", &["clips[2]", "0 elements"]),
        ("image.background=tartan", &["image.background", "tartan", "transparent"]),
        ("technique.ray_cast.mode=wobble", &["technique.ray_cast.mode", "wobble", "composite"]),
        ("volumes[0].window=[1,2,3]", &["volumes[0].window", "length 3"]),
    ] {
        let message = fail(setting);
        for part in parts {
            assert!(message.contains(part), "{setting}: '{part}' is not in {message}");
        }
    }
}

#[test]
fn wrong_flags_name_flag_value_and_what_is_expected() {
    let folder = tempdir().unwrap();
    let fail =
        |flags: &[&str]| fail_in(folder.path(), &[&["render", SAMPLE, "--save-scene", "s.toml"], flags].concat(), 2);
    for (flags, parts) in [
        (&["--size", "640"][..], &["--size", "640", "128x128"][..]),
        (&["--step", "x"], &["--step", "'x' is not a number"]),
        (&["--step", "1000"], &["quality.step", "1000", "0.01 to 100"]),
        (&["--window", "1"], &["--window", "expected 2 numbers", "found 1"]),
        (&["--mode", "wobble"], &["--mode", "wobble", "composite", "x-ray"]),
        (&["--stepp", "1"], &["--stepp", "--step"]),
        (&["--eye", "1,2,3"], &["--eye and --target"]),
        (&["--thickness", "3"], &["--thickness", "--slice"]),
        (&["--slice", "0,0,0"], &["--slice", "direction"]),
        (&["--slice", "axial", "--at", "120%"], &["--at", "0% to 100%"]),
        (&["--iso", "1", "--mode", "maximum"], &["--iso", "--mode"]),
        (&["--preset", "ct-bonne", "-o", "x.png"], &["ct-bonne", "ct-bone"]),
        (&["--transfer-function", "none.toml"], &["--transfer-function", "none.toml"]),
        (&["--endian", "big"], &["--endian", "sample"]),
        (&["--component", "3"], &["component", "3", "1"]),
        (&["--threads", "0"], &["--threads", "1..=1024"]),
        (&["--light", "sun"], &["--light", "three-point"]),
        (&["--interpolation", "fast"], &["--interpolation", "fast", "hardware", "exact"]),
        (&["--passes", "many"], &["--passes", "many", "single", "wavefront"]),
        (&["--gpu-memory", "0"], &["--gpu-memory", "1..="]),
        (&["--backend", "cuda"], &["--backend", "cuda", "auto", "cpu", "gpu"]),
        (&["--azimuth", "30", "--eye", "0,0,1"], &["--azimuth", "--eye"]),
    ] {
        let message = fail(flags);
        for part in parts {
            assert!(message.contains(part), "{flags:?}: '{part}' is not in {message}");
        }
    }
}

#[test]
fn defaults_in_the_help_are_those_of_the_code() {
    let folder = tempdir().unwrap();
    let help = succeed_in(folder.path(), &["render", "--help"]);
    let words: Vec<&str> = help.split_whitespace().collect();
    let flat = words.join(" ");
    // The default is the last thing said before the next flag.
    let default_of = |flag: &str| {
        let after = flat.split_once(&format!(" {flag} ")).unwrap_or_else(|| panic!("{flag} is not in the help")).1;
        let after = after.split(" --").next().unwrap();
        let text = after.rsplit_once("[default: ").unwrap_or_else(|| panic!("{flag} has no default in {after}")).1;
        text.split(']').next().unwrap().to_owned()
    };
    let scene: Value = serde_json::to_value(pellucid::scene::Scene::of(pellucid::scene::Source::memory())).unwrap();
    for (flag, pointer) in [
        ("--exposure", "/image/exposure"),
        ("--encoding", "/image/encoding"),
        ("--azimuth", "/camera/view/orbit/azimuth"),
        ("--elevation", "/camera/view/orbit/elevation"),
        ("--roll", "/camera/view/orbit/roll"),
        ("--zoom", "/camera/view/orbit/zoom"),
        ("--fov", "/camera/projection/perspective/vertical_fov"),
        ("--mode", "/technique/ray_cast/mode"),
        ("--step", "/quality/step"),
        ("--filter", "/quality/filter"),
        ("--gradient", "/quality/gradient"),
        ("--classification", "/quality/classification"),
        ("--jitter", "/quality/jitter"),
        ("--early-termination", "/quality/early_termination"),
        ("--adaptive", "/quality/adaptive_tolerance"),
        ("--supersampling", "/quality/supersampling"),
    ] {
        let value = scene.pointer(pointer).unwrap_or_else(|| panic!("{pointer} is not in {scene}"));
        let said = default_of(flag);
        let same = match value {
            // Single precision comes with its representation error.
            Value::Number(number) => {
                said.parse::<f64>().is_ok_and(|said| (said - number.as_f64().unwrap()).abs() < 1e-6)
            }
            Value::String(word) => *word == said,
            _ => false,
        };
        assert!(same, "{flag}: the help says {said}, the code {value}");
    }
    let image = &scene["image"];
    assert_eq!(default_of("--size"), format!("{}x{}", image["width"], image["height"]));
    let material = serde_json::to_value(pellucid::optics::Material::default()).unwrap();
    for flag in ["--ambient", "--diffuse", "--specular", "--shininess"] {
        let said: f64 = default_of(flag).rsplit(' ').next().unwrap().parse().unwrap();
        assert!((said - material[&flag[2..]].as_f64().unwrap()).abs() < 1e-6, "{flag}");
    }
    let slice = serde_json::to_value(pellucid::scene::Slice::default()).unwrap();
    assert_eq!((default_of("--combine").as_str(), slice["combine"].as_str()), ("maximum", Some("maximum")));
    assert_eq!((default_of("--thickness").as_str(), slice["thickness"].as_f64()), ("0", Some(0.0)));
}

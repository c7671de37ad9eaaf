//! Scans with automatic settings. Built-in ones are drawn always; real ones where there are any:
//! `../shared/data` beside the checkout, or the folder named by `PELLUCID_DATA`. Nothing made from
//! them is stored.

use std::path::{Path, PathBuf};

use pellucid::field::VoxelType;
use pellucid::scene::{Control, Frame, SampleSource, Scene, Source};
use pellucid::{Backend, LoadOptions, Renderer, load_with};

/// Files of real scans: all of them, or none.
fn real() -> Vec<Source> {
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data");
    let named = std::env::var_os("PELLUCID_DATA").map(PathBuf::from);
    let Some(folder) = named.clone().or_else(|| Some(beside()).filter(|folder| folder.is_dir())) else {
        println!("no real scans: there is no ../shared/data, and PELLUCID_DATA is not set");
        return Vec::new();
    };
    let file = |name| Source::File(folder.join(name).with_extension("nrrd"));
    ["bonsai", "cthead", "engine", "seg3d_mr", "tooth"].map(file).into()
}

/// Built-in fields as scanners and simulations would hand them over.
fn built_in() -> Vec<Source> {
    let fields = [("head", VoxelType::I16), ("tubes", VoxelType::U8), ("cloud", VoxelType::F32)];
    let source = |(name, voxel_type): (&str, _)| SampleSource {
        name: name.into(),
        dims: Some([64, 80, 80]),
        voxel_type: Some(voxel_type),
    };
    fields.map(|field| Source::Sample(source(field))).into()
}

fn draw(source: &Source, skipping: bool) -> Frame {
    let mut scene = Scene::of(source.clone());
    (scene.image.width, scene.image.height) = (160, 160);
    scene.quality.empty_space_skipping = skipping;
    let (volumes, _) = load_with(&scene, "", &LoadOptions { outside: true, ..LoadOptions::default() }).unwrap();
    let (stage, choices) = scene.resolve(&volumes).unwrap();
    assert!(choices.iter().any(|choice| choice.setting == "preset"), "{choices:?}");
    Renderer::new(Backend::Auto).unwrap().render(&stage, &Control::default()).unwrap()
}

/// With automatic settings every scan gives a picture of something: neither empty nor filled,
/// mostly opaque where there is anything, with light and shade, and the same with skipping off.
#[test]
fn every_scan_gives_a_picture() {
    for source in built_in().iter().chain(&real()) {
        let name = format!("{source:?}");
        let frame = draw(source, true);
        let covered: Vec<&[f32; 4]> = frame.color.iter().filter(|color| color[3] > 0.5).collect();
        let share = covered.len() as f64 / frame.color.len() as f64;
        assert!((0.05..0.8).contains(&share), "{name}: {share} of the picture is covered");
        let mut light: Vec<f32> = covered.iter().map(|[r, g, b, _]| 0.2126 * r + 0.7152 * g + 0.0722 * b).collect();
        light.sort_by(f32::total_cmp);
        let (dark, bright) = (light[light.len() / 20], light[light.len() * 19 / 20]);
        assert!(bright > 0.1 && bright < 1.0 && dark < 0.7 * bright, "{name}: from {dark} to {bright}");
        assert!(frame.warnings.is_empty(), "{name}: {:?}", frame.warnings);
        assert_eq!(frame.color, draw(source, false).color, "{name}: skipping changes the picture");
    }
}

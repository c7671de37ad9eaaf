//! Real scans, where there are any: `../shared/data` beside the checkout, or the folder named by
//! `PELLUCID_DATA`. Nothing made from them is stored.

use std::path::{Path, PathBuf};

use pellucid::scene::{Control, Frame, Scene, Source};
use pellucid::{Backend, LoadOptions, Renderer, load_with};

fn folder() -> Option<PathBuf> {
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data");
    let folder = std::env::var_os("PELLUCID_DATA").map_or_else(beside, PathBuf::from);
    folder.is_dir().then_some(folder)
}

fn draw(path: &Path, skipping: bool) -> Frame {
    let mut scene = Scene::of(Source::File(path.to_owned()));
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
    let Some(folder) = folder() else {
        println!("skipped: there is no ../shared/data and PELLUCID_DATA is not set");
        return;
    };
    for name in ["bonsai", "cthead", "engine", "seg3d_mr", "tooth"] {
        let path = folder.join(name).with_extension("nrrd");
        let frame = draw(&path, true);
        let covered: Vec<&[f32; 4]> = frame.color.iter().filter(|color| color[3] > 0.5).collect();
        let share = covered.len() as f64 / frame.color.len() as f64;
        assert!((0.05..0.8).contains(&share), "{name}: {share} of the picture is covered");
        let mut light: Vec<f32> = covered.iter().map(|[r, g, b, _]| 0.2126 * r + 0.7152 * g + 0.0722 * b).collect();
        light.sort_by(f32::total_cmp);
        let (dark, bright) = (light[light.len() / 20], light[light.len() * 19 / 20]);
        assert!(bright > 0.1 && bright < 1.0 && dark < 0.7 * bright, "{name}: from {dark} to {bright}");
        assert!(frame.warnings.is_empty(), "{name}: {:?}", frame.warnings);
        assert_eq!(frame.color, draw(&path, false).color, "{name}: skipping changes the picture");
    }
}

//! Light that is found once, saved and drawn with.

use crate::common::{fail_in, files, run_in, succeed_in, text};
use serde_json::Value;
use tempfile::tempdir;

/// A surface in all light, quickly.
const LIT: [&str; 8] = [
    "sample:bowl@24x24x24",
    "--iso",
    "0",
    "--global-illumination",
    "--set",
    "technique.ray_cast.mode.isosurface.illumination.global.samples=8",
    "--size",
    "24x24",
];
const FILE: &str = "technique.ray_cast.mode.isosurface.illumination.global.file=light.nrrd";

#[test]
fn baked_light_draws_the_same_picture() {
    let folder = tempdir().unwrap();
    let path = folder.path();
    let draw = |name: &str, flags: &[&str]| {
        succeed_in(path, &[&["render"][..], &LIT, &["--backend", "cpu", "-q", "-o", name], flags].concat());
        std::fs::read(path.join(name)).unwrap()
    };
    let baked = run_in(path, &[&["bake"][..], &LIT, &["-o", "light.nrrd", "--json"]].concat());
    let said = text(&baked.stderr);
    assert_eq!(baked.status.code(), Some(0), "{said}");
    assert!(said.contains("paths a second") && said.ends_with("pellucid: wrote light.nrrd\n"), "{said}");
    let told: Value = serde_json::from_slice(&baked.stdout).unwrap();
    let (places, lit) = (told["places"].as_u64().unwrap(), told["lit"].as_u64().unwrap());
    assert!(places % (24 * 24 * 24) == 0 && lit > 500 && lit < places, "{told}");
    assert_eq!((told["paths"].as_u64(), told["output"].as_str()), (Some(8 * lit), Some("light.nrrd")));
    // From where it was baked, and from elsewhere.
    for view in [&[][..], &["--azimuth", "70", "--elevation", "60"]] {
        let fresh = draw("a.png", view);
        assert!(fresh == draw("b.png", &[view, &["--set", FILE]].concat()), "{view:?}");
    }
    let about = succeed_in(path, &["info", "light.nrrd"]);
    assert!(about.contains("light of isosurfaces ") && about.contains("4 components"), "{about}");

    // A document names it from its own folder, and it may be baked anew when it no longer fits.
    let scene = ["--save-scene", "scene.toml", "-q", "--set", FILE];
    succeed_in(path, &[&["render"][..], &LIT, &scene].concat());
    let drawn = ["render", "scene.toml", "--backend", "cpu", "-q", "-o", "c.png"];
    succeed_in(path, &drawn);
    assert!(std::fs::read(path.join("c.png")).unwrap() == draw("a.png", &[]));
    let document = std::fs::read_to_string(path.join("scene.toml")).unwrap();
    std::fs::write(path.join("scene.toml"), document.replace("samples = 8", "samples = 9")).unwrap();
    let refused = fail_in(path, &drawn, 2);
    for part in ["light.nrrd", "pellucid bake", "isosurface.illumination.global.file"] {
        assert!(refused.contains(part), "{refused}");
    }
    succeed_in(path, &["bake", "scene.toml", "-o", "light.nrrd", "--compress", "1", "-q"]);
    succeed_in(path, &drawn);
    std::fs::remove_file(path.join("light.nrrd")).unwrap();
    assert!(fail_in(path, &drawn, 2).contains("light.nrrd"));
}

#[test]
fn what_cannot_be_baked_is_refused() {
    let folder = tempdir().unwrap();
    let path = folder.path();
    let ball = ["bake", "sample:ball@8x8x8", "--size", "8x8"];
    let light = ["--iso", "0.5", "--ambient-occlusion", "-o", "light.nrrd"];
    let cases: [(&[&str], &str); 7] = [
        (&["-o", "light.nrrd"], "--iso VALUE"),
        (&["--iso", "0.5"], "--global-illumination"),
        (&["--iso", "0.5", "--global-illumination", "-o", "light.mha"], ".nrrd"),
        (&["--iso", "0.5", "--global-illumination", "--compress", "1"], "--output"),
        (&[&light[..], &["--shading", "off"]].concat(), "shading"),
        (
            &[&light[..], &["--set", "technique.ray_cast.mode.isosurface.illumination.global.method=pixels"]].concat(),
            "method=lattice",
        ),
        (&["--iso", "1e9", "--global-illumination", "-o", "light.nrrd"], "no surface is seen"),
    ];
    for (flags, part) in cases {
        let said = fail_in(path, &[&ball, flags, &["-q"]].concat(), 2);
        assert!(said.contains(part), "{flags:?}: {said}");
    }
    assert_eq!(files(path), [""; 0]);
    // Without a file there are the figures alone.
    let said = run_in(path, &[&ball[..], &["--iso", "0.5", "--global-illumination"]].concat());
    assert!(said.status.success() && text(&said.stderr).contains("paths a second"), "{}", text(&said.stderr));
    assert_eq!(files(path), [""; 0]);
}

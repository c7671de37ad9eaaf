//! Volumes made by procedures and maps.

use pellucid::io::{PngPixels, Transfer, write_png};
use pellucid::scene::{Format, Scene};
use pellucid::{LoadError, load};

fn scene(source: &str) -> Scene {
    Scene::parse(&format!("[[volumes]]\nsource.model = {source}"), Format::Toml).unwrap_or_else(|e| panic!("{e}"))
}

/// A map that rises from the left to the right, and is low in its top row, which lies farthest along y.
#[test]
fn a_picture_becomes_land() {
    let folder = tempfile::tempdir().unwrap();
    let row = [0u8, 85, 170, 255].map(|v| [v; 3]).concat();
    let pixels = [vec![0; 12], row.clone(), row.clone(), row].concat();
    write_png(folder.path().join("land.png"), 4, 4, PngPixels::U8(&pixels), Transfer::Srgb).unwrap();
    let land = scene(
        "{ height_field = { map.file = \"land.png\", relief = 1.0, slab = [-0.2, 0.0], ramp = 0.01, dims = [4, 4, 121] } }",
    );
    let (volumes, _) = load(&land, folder.path()).unwrap();
    let volume = &volumes[0];
    let grid = volume.grid();
    // The middle of the slab in a column of voxels, in world units.
    let middle = |x: usize, y: usize| {
        let (mut sum, mut weight) = (0.0, 0.0);
        for z in 0..121 {
            let value = volume.value([x, y, z], 0);
            sum += value * grid.world_from_index().transform_point3([x as f64, y as f64, z as f64].into()).z;
            weight += value;
        }
        sum / weight
    };
    for (x, height) in [(0, 0.0), (1, 1.0 / 3.0), (2, 2.0 / 3.0), (3, 1.0)] {
        for y in [0, 1] {
            assert!((middle(x, y) + 0.1 - height).abs() < 0.06, "{x}, {y}: {}", middle(x, y));
        }
        assert!((middle(x, 3) + 0.1).abs() < 0.06, "{x}: {}", middle(x, 3));
    }
    assert!(matches!(load(&land, folder.path().join("elsewhere")), Err(LoadError::Io(_))));
}

#[test]
fn slabs_that_are_none_are_refused_with_their_key() {
    for (source, key) in [
        ("{ height_field.slab = [0.1, 0.0] }", "height_field.slab"),
        ("{ height_field.ramp = 0.04 }", "height_field.ramp"),
        ("{ height_field.relief = -1.0 }", "height_field.relief"),
        ("{ clouds.ellipsoids = 0 }", "clouds.ellipsoids"),
    ] {
        let text = format!("[[volumes]]\nsource.model = {source}");
        let error = Scene::parse(&text, Format::Toml).unwrap_err().to_string();
        assert!(error.contains(key), "{error}");
    }
}

//! What would take too long or too much memory is done more coarsely, and said; nothing else is.

use std::sync::Arc;

use glam::DVec3;
use pellucid_field::{Grid, Volume};
use pellucid_plan::cautions;
use pellucid_plan::half_angle::{LightPoints, Slabs};
use pellucid_scene::{Format, RenderWarning, Scene};
use proptest::prelude::*;

fn warnings(grid: Grid, document: &str) -> Vec<RenderWarning> {
    let values: Vec<f32> = (0..grid.len()).map(|k| (k % 5) as f32 / 4.0).collect();
    let volume = Arc::new(Volume::new(grid, values).unwrap());
    let scene = Scene::parse(&format!("[[volumes]]\nsource = \"memory\"\n{document}"), Format::Toml);
    let (stage, _) = scene.unwrap_or_else(|error| panic!("{error}")).resolve(&[volume]).unwrap();
    cautions(&stage, usize::MAX).collect()
}

fn grid(dims: [usize; 3], spacing: [f64; 3]) -> Grid {
    Grid::with_spacing(dims, spacing, [0.0; 3]).unwrap()
}

fn paths(unit: f64, opacity: f64) -> String {
    format!(
        "[volumes.transfer_function]\ncolors = [[0, \"#ffffff\"]]\nopacities = [[0, 0], [1, {opacity}]]\n\
         unit_distance = {unit}\n[technique.path_trace]\n"
    )
}

#[test]
fn a_medium_too_dense_for_paths_is_told() {
    for spacing in [1e-3, 1.0, 40.0] {
        let grid = || grid([16; 3], [spacing; 3]);
        for opacity in [0.3, 0.9, 1.0] {
            for fine in [0.2, 1.0, 10.0] {
                assert_eq!(warnings(grid(), &paths(fine * spacing, opacity)), [], "{fine} {opacity}");
            }
            // A thousand times less than anything usual.
            for coarse in [1e-3, 1e-2] {
                let found = warnings(grid(), &paths(coarse * spacing, opacity));
                let [RenderWarning::Dense { in_voxel, across, unit_distance, .. }] = found[..] else {
                    panic!("{found:?}")
                };
                let depth = if opacity < 1.0 { -(1.0f64 - opacity).ln() } else { 24.0 * std::f64::consts::LN_2 };
                assert!((in_voxel / (depth / coarse) - 1.0).abs() < 1e-5, "{in_voxel}");
                assert!((across / (in_voxel * 15.0 * 3.0f64.sqrt()) - 1.0).abs() < 1e-6, "{across}");
                assert_eq!(unit_distance, coarse * spacing);
                let said = found[0].to_string();
                assert!(said.contains("optical depth") && said.contains("unit_distance"), "{said}");
            }
        }
    }
    // Other techniques do not mind.
    let cast = paths(1e-3, 0.9).replace("path_trace", "ray_cast");
    assert_eq!(warnings(grid([16; 3], [1.0; 3]), &cast), []);
}

#[test]
fn what_is_swept_more_coarsely_is_told() {
    let volume = "shading = true\n[lighting.shadows]\nvolume = {}\n";
    let half_angle = "[technique.half_angle]\n";
    for technique in [volume, half_angle] {
        assert_eq!(warnings(grid([16, 5, 40], [1.0, 1.5, 0.8]), technique), []);
        let thin = warnings(grid([16; 3], [1.0, 1.0, 1000.0]), technique);
        let is_told = matches!(&thin[..], [RenderWarning::Fallback { reason }] if reason.contains("slabs instead of"));
        assert!(is_told, "{thin:?}");
    }
}

#[test]
fn light_volumes_are_as_large_as_they_may() {
    // 4 points for each voxel and axis of 1024 x 1024 x 512 voxels would be 128 GiB.
    let large = grid([1024, 1024, 512], [1.0; 3]);
    let points = LightPoints::new(&large, 4.0, 2, usize::MAX).unwrap();
    assert!(2 * points.grid.len() <= 1 << 28 && 2 * points.grid.len() > 1 << 27, "{:?}", points.grid.dims());
    assert!(points.resolution < 4.0 && points.texels <= 2048);
    // Of a long volume they are few, however long it is.
    let long = grid([7, 6, 32_769], [1.0; 3]);
    let points = LightPoints::new(&long, 0.5, 1, usize::MAX).unwrap();
    assert_eq!((points.grid.dims(), points.resolution), ([4, 4, 16_385], 0.5));
    // A device's textures are not.
    let points = LightPoints::new(&long, 0.5, 1, 2048).unwrap();
    assert!(points.grid.dims()[2] <= 2048 && points.grid.dims()[2] > 1900, "{:?}", points.grid.dims());
}

proptest! {
    /// Voxels that are alike are never swept more coarsely than asked for; others in as many slabs as cubes would be.
    #[test]
    fn slabs_are_as_thin_as_asked_for_or_as_many_as_of_cubes(
        dims in [1usize..900, 1usize..900, 1usize..900],
        lengths in [0.0f64..8.0, 0.0f64..8.0, 0.0f64..8.0],
        axis in [-1.0f64..1.0, -1.0f64..1.0, -1.0f64..1.0],
        step in 0.01f64..4.0,
    ) {
        let axis = DVec3::from_array(axis).try_normalize().unwrap_or(DVec3::Z);
        let alike = Slabs::new(axis, step, &grid(dims, [1.0; 3]));
        prop_assert_eq!(alike.count, alike.asked);
        prop_assert_eq!(alike.thickness, step);
        let spacing = lengths.map(|length| 10.0f64.powf(length));
        let shortest = spacing.into_iter().fold(f64::INFINITY, f64::min);
        let grid = grid(dims, spacing);
        let found = Slabs::new(axis, step * shortest, &grid);
        let cubes = (dims.iter().sum::<usize>() as f64 / step).ceil() as usize;
        prop_assert!(found.count <= cubes.max(2048) && found.count <= found.asked);
        // They reach through the box.
        let along = grid.world_corners().map(|corner| found.coordinate(corner));
        prop_assert!(along.into_iter().all(|at| at > -1e-6 && at < found.count as f64 + 1e-6));
    }
}

//! A component of several is drawn as a volume that has no other.

use std::sync::Arc;

use crate::common::{render, set_mode, transfer_function};
use pellucid_cpu::CpuRenderer;
use pellucid_field::{Filter, Grid, Volume};
use pellucid_scene::{
    Classification, Control, HalfAngle, Isosurface, Isovalue, Mode, PathTrace, Scene, Source, Stage, Technique,
    VolumeEntry,
};

const DIMS: [usize; 3] = [13, 11, 12];
const COMPONENTS: usize = 3;

/// A name, and what makes a scene so.
type Edit<'e> = (&'e str, &'e dyn Fn(&mut Scene));

/// A value of a voxel: components have the same values, each elsewhere.
fn value(voxel: usize, component: usize) -> u16 {
    let count = DIMS.iter().product::<usize>();
    let [x, y, z] = {
        let voxel = (voxel + component * count / COMPONENTS) % count;
        [voxel % DIMS[0], voxel / DIMS[0] % DIMS[1], voxel / DIMS[0] / DIMS[1]]
    };
    (1000.0 * (1.0 + (x as f64 * 0.7).sin() * (y as f64 * 0.5).cos() * (z as f64 * 0.6).sin())) as u16
}

fn volume(components: std::ops::Range<usize>) -> Arc<Volume> {
    let grid = Grid::new(DIMS).unwrap();
    let of = |voxel: usize| components.clone().map(move |component| value(voxel, component));
    let voxels: Vec<u16> = (0..grid.len()).flat_map(of).collect();
    Arc::new(Volume::with_components(grid, voxels, components.len()).unwrap())
}

fn stage(volume: &Arc<Volume>, component: Option<usize>, edit: impl Fn(&mut Scene)) -> Stage {
    let tf = transfer_function(&[(0.0, 0x2040e0), (2000.0, 0xe0a020)], &[(900.0, 0.0), (1800.0, 0.4)]);
    let entry = VolumeEntry { transfer_function: Some(tf), component, ..VolumeEntry::new(Source::memory()) };
    let mut scene = Scene { volumes: vec![entry], ..Scene::default() };
    (scene.image.width, scene.image.height) = (20, 18);
    edit(&mut scene);
    scene.resolve(std::slice::from_ref(volume)).unwrap().0
}

#[test]
fn a_component_of_several_is_drawn_as_one_alone() {
    let isovalue = Isovalue { value: 1300.0, color: None, opacity: 0.5, volume: None };
    let surfaces = Mode::Isosurface(Isosurface::new(vec![isovalue]));
    let edits: [Edit; 9] = [
        ("composite", &|_| ()),
        ("pre", &|scene| scene.quality.classification = Classification::Pre),
        ("pre-integrated", &|scene| scene.quality.classification = Classification::PreIntegrated),
        ("cubic", &|scene| scene.quality.filter = Filter::BSpline { prefilter: true }),
        ("maximum", &|scene| set_mode(scene, Mode::Maximum)),
        ("x-ray", &|scene| set_mode(scene, Mode::XRay)),
        ("isosurface", &|scene| set_mode(scene, surfaces.clone())),
        ("half-angle", &|scene| {
            scene.technique = Technique::HalfAngle(HalfAngle { resolution: 32, ..HalfAngle::default() });
        }),
        ("paths", &|scene| {
            scene.technique = Technique::PathTrace(PathTrace { samples: 2, ..PathTrace::default() });
        }),
    ];
    let whole = volume(0..COMPONENTS);
    for (name, edit) in edits {
        for component in 0..COMPONENTS {
            let alone = volume(component..component + 1);
            let expected = render(&stage(&alone, None, edit));
            let found = render(&stage(&whole, Some(component), edit));
            assert_eq!(found.color, expected.color, "{name} of component {component}");
            assert!(expected.color.iter().filter(|pixel| pixel[3] > 0.05).count() > 30, "{name} shows nothing");
        }
    }
}

/// What is kept of one component is nothing to another, and nothing to a volume of one.
#[test]
fn components_are_drawn_one_after_the_other() {
    let (whole, alone) = (volume(0..COMPONENTS), volume(1..2));
    let mut renderer = CpuRenderer::default();
    let mut draw =
        |volume, component| renderer.render(&stage(volume, component, |_| ()), &Control::default()).unwrap().color;
    let [first, second] = [0, 1].map(|component| render(&stage(&whole, Some(component), |_| ())).color);
    assert_ne!(first, second);
    for _ in 0..2 {
        assert_eq!(draw(&whole, Some(0)), first);
        assert_eq!(draw(&whole, Some(1)), second);
        assert_eq!(draw(&alone, None), second);
    }
}

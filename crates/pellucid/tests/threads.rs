//! Nothing that the library does touches rayon's global pool, which panics where the system has no threads to give and
//! whose stacks are small. A binary of its own: the pool of this process is made unusable.

mod common;

use pellucid::field::{
    Filter, Gradient, Histogram, JointHistogram, VoxelType, crop, pyramid, resample_dims, spline_coefficients,
};
use pellucid::gpu::Ceiling;
use pellucid::io::{ReadOptions, WriteOptions};
use pellucid::scene::Control;
use pellucid::{Backend, Picture, Progressive, Renderer};
use rayon::prelude::*;

#[test]
fn the_library_works_without_the_global_pool() {
    let refused = |_| Err(std::io::Error::other("no threads"));
    assert!(rayon::ThreadPoolBuilder::new().spawn_handler(refused).build_global().is_err());
    assert!(std::panic::catch_unwind(|| (0..9).into_par_iter().sum::<i32>()).is_err(), "the pool can be used");

    let folder = tempfile::tempdir().unwrap();
    let mut gpu = common::gpu(&Ceiling::default());
    let mut drawn = 0;
    for path in common::scenes() {
        let (scene, mut stage) = common::stage(&path);
        stage.viewpoint = stage.viewpoint.with_rows(12);
        if Backend::Cpu.draws(&stage) {
            let mut progressive = Progressive::new(Renderer::new(Backend::Cpu).unwrap(), stage.clone()).with_frames(2);
            while progressive.step(&Control::default()).unwrap().picture != (Picture::Full { frames: 2 }) {}
            for name in ["a.png", "a.exr"] {
                pellucid::save(folder.path().join(name), progressive.frame(), &scene.image).unwrap();
            }
            drawn += 1;
        }
        if Backend::Gpu.draws(&stage) && drawn % 6 == 0 {
            gpu.render(&stage, &Control::default()).unwrap();
        }
    }
    assert!(drawn > 20, "{drawn}");

    let ball = pellucid::field::closed_form::by_name("ball").unwrap();
    let volume = pellucid::field::closed_form::sample_field(ball.as_ref(), [20, 21, 22], VoxelType::U16).unwrap();
    let path = folder.path().join("a.nhdr");
    pellucid::io::write(&path, &volume, &WriteOptions::default()).unwrap();
    let volume = pellucid::io::read(&path, &ReadOptions::default()).unwrap().volume;
    assert!(volume.statistics().finite > 0);
    Histogram::new(&volume, 0, 16).unwrap();
    Histogram::of_levels(&volume, 0).unwrap();
    JointHistogram::new(&volume, 0, Gradient::Central, [8, 8]).unwrap();
    crop(&volume, [1; 3], [5; 3]).unwrap();
    spline_coefficients(&volume, 0).unwrap();
    assert!(pyramid(&volume, None).unwrap().len() > 1);
    resample_dims(&volume, [9, 10, 11], Filter::Linear).unwrap();
}

//! Both backends draw the same picture: every scene of `scenes/`, on whatever Vulkan driver there is
//! (one that runs on the processor will do: Debian's `mesa-vulkan-drivers`).

use pellucid::field::Filter;
use pellucid::gpu::{Ceiling, GpuRenderer, Interpolation, Passes};
use pellucid::scene::{Control, Mode, RenderWarning, Stage, Technique};
use pellucid::{Backend, CpuRenderer, Renderer};

use crate::scenes::{difference, draw, folder, gpu, name_of, scenes, stage};

/// Whether a scene must look the same on both backends. What only one of them draws (slices, all light on surfaces) is compared with its stored
/// picture, and paths of light differ by their noise, which tests of that backend know how to judge: their names tell, so
/// that a scene which a backend refuses by mistake is not passed over.
fn for_both(name: &str) -> bool {
    !["slicing-", "path-trace-", "global-illumination-"].iter().any(|technique| name.starts_with(technique))
}

/// Draws every scene on both backends; returns what exceeds the bounds.
fn compare(mut gpu: GpuRenderer, least_psnr: f64, most: u8) -> Vec<String> {
    let mut failures = Vec::new();
    for path in scenes() {
        let (scene, stage) = stage(&path);
        let name = name_of(&path);
        if !for_both(&name) {
            continue;
        }
        for backend in [Backend::Cpu, Backend::Gpu] {
            assert!(backend.draws(&stage), "{name}: {backend} refuses it");
        }
        let found = gpu.render(&stage, &Control::default()).unwrap_or_else(|error| panic!("{name}: {error}"));
        let expected = draw(&stage);
        if let Some(folder) = std::env::var_os("PELLUCID_GPU_PICTURES") {
            let path = std::path::Path::new(&folder).join(format!("{name}.png"));
            pellucid::save(&path, &found, &scene.image).unwrap();
        }
        let [found, expected] = [found, expected].map(|frame| frame.to_rgba8(&scene.image));
        let (psnr, largest) = difference(&found, &expected);
        println!("{name}: {psnr:.1} dB, largest difference {largest}");
        // Where a ray grazes a surface, rounding decides whether it meets it: a turn of the camera by 2e-5 degrees as well.
        let is_exact = stage.volumes.iter().all(|volume| stage.finds_every_surface(volume));
        let grazed = if is_exact { found.len() / 4 / 10_000 } else { 0 };
        let apart = |(a, b): (&[u8], &[u8])| a.iter().zip(b).any(|(a, b)| a.abs_diff(*b) > most);
        let beyond = found.chunks(4).zip(expected.chunks(4)).filter(|pixels| apart(*pixels)).count();
        if psnr < least_psnr || beyond > grazed {
            failures.push(format!("{name}: {psnr:.1} dB, largest difference {largest} of 255"));
        }
    }
    failures
}

#[test]
fn exact_interpolation_draws_the_pictures_of_the_processor() {
    let gpu = gpu(&Ceiling::default()).with_interpolation(Interpolation::Exact);
    let failures = compare(gpu, 50.0, 2);
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

#[test]
fn rays_that_are_followed_in_turns_draw_the_same_bits() {
    let mut single = gpu(&Ceiling::default());
    let mut wavefront = gpu(&Ceiling::default()).with_passes(Passes::Wavefront);
    let mut drawn = Vec::new();
    for path in scenes().into_iter().filter(|path| for_both(&name_of(path))) {
        let (_, mut stage) = stage(&path);
        // Cubic filters take their time on a driver without hardware.
        if !matches!(stage.technique, Technique::RayCast(_)) || stage.quality.filter != Filter::Linear {
            continue;
        }
        drawn.push(name_of(&path));
        // Rays take turns in small pictures as in large ones.
        (stage.viewpoint.width, stage.viewpoint.height) = (stage.viewpoint.width / 2, stage.viewpoint.height / 2);
        stage.quality.supersampling = 2;
        let [one, other] =
            [&mut single, &mut wavefront].map(|renderer| renderer.render(&stage, &Control::default()).unwrap());
        assert_eq!(one.color, other.color, "{}", path.display());
        assert_eq!((one.depth, one.normal), (other.depth, other.normal), "{}", path.display());
        assert_eq!(one.statistics.samples_visible, other.statistics.samples_visible, "{}", path.display());
        // A search through cells that goes on within a rounding of a plane of voxels may look at a piece again.
        let searches = matches!(stage.mode(), Mode::Maximum | Mode::Minimum | Mode::Slice(_) | Mode::Isosurface(_));
        let again = one.samples.iter().zip(&other.samples).filter(|(a, b)| a != b).count();
        assert!(again <= if searches { one.samples.len() / 20 } else { 0 }, "{}: {again}", path.display());
    }
    for mode in ["composite-", "additive-", "maximum-", "isosurface-", "slice-", "xray-", "preintegrated-", "shadow-"] {
        assert!(drawn.iter().any(|name| name.starts_with(mode)), "no {mode} scene among {drawn:?}");
    }
}

#[test]
fn the_processor_stands_in_for_what_the_adapter_lacks() {
    let mut renderer = Renderer::from(gpu(&Ceiling::default())).with_stand_in(CpuRenderer::new());
    let (name, what) = ("composite-bone", "rectangle");
    let of = |name: &str| stage(&folder().join(format!("{name}.toml"))).1;
    let shone_upon = Stage { lights: of("path-trace-head").lights, ..of(name) };
    let choices = renderer.choices(&shone_upon).unwrap();
    assert!(choices.iter().any(|choice| choice.chosen.contains(what)), "{choices:?}");
    let frame = renderer.render(&shone_upon, &Control::default()).unwrap();
    let said = |warning: &RenderWarning| matches!(warning, RenderWarning::Fallback { reason } if reason.contains(what));
    assert!(frame.warnings.iter().any(said), "{:?}", frame.warnings);
    assert_eq!(frame.color, draw(&shone_upon).color, "{name}");
    // Who asks for the adapter is told instead.
    let told = Renderer::from(gpu(&Ceiling::default())).render(&shone_upon, &Control::default()).unwrap_err();
    assert!(told.to_string().contains("use --backend cpu"), "{told}");
    let (_, plain) = stage(&folder().join("composite-tubes.toml"));
    assert!(renderer.render(&plain, &Control::default()).unwrap().warnings.is_empty());
}

#[test]
fn the_processor_stands_in_where_a_pass_takes_fewer_volumes() {
    let one = stage(&folder().join("composite-tubes.toml")).1;
    let mut many = Stage { volumes: vec![one.volumes[0].clone(); 12], ..one };
    (many.viewpoint.width, many.viewpoint.height) = (many.viewpoint.width / 8, many.viewpoint.height / 8);
    let least = || gpu(&Ceiling { guaranteed: true, ..Ceiling::default() });
    let frame = Renderer::from(least()).with_stand_in(CpuRenderer::new()).render(&many, &Control::default()).unwrap();
    let [RenderWarning::Fallback { reason }] = &frame.warnings[..] else { panic!("{:?}", frame.warnings) };
    assert!(reason.contains("12 volumes"), "{reason}");
    assert_eq!(frame.color, draw(&many).color);
    let told = Renderer::from(least()).render(&many, &Control::default()).unwrap_err();
    assert!(told.to_string().contains("12 volumes"), "{told}");
}

#[test]
fn the_processor_stands_in_for_an_adapter_that_gives_out() {
    let (_, stage) = stage(&folder().join("composite-bone.toml"));
    let expected = draw(&stage);
    let starved = || gpu(&Ceiling { memory: Some(20_000), ..Ceiling::default() });
    let lost = || {
        let mut gpu = gpu(&Ceiling::default());
        assert!(gpu.render(&stage, &Control::default()).unwrap().warnings.is_empty());
        gpu.device().device.destroy();
        gpu
    };
    for (gpu, why) in [(&lost as &dyn Fn() -> GpuRenderer, "was lost"), (&starved, "20000 are allowed")] {
        let mut renderer = Renderer::from(gpu()).with_stand_in(CpuRenderer::new());
        for _ in 0..2 {
            let frame = renderer.render(&stage, &Control::default()).unwrap();
            let [RenderWarning::Fallback { reason }] = &frame.warnings[..] else { panic!("{:?}", frame.warnings) };
            assert!(reason.contains(why) && reason.contains("the processor drew"), "{reason}");
            assert_eq!(frame.color, expected.color, "{why}");
        }
        // Who asks for the adapter is told instead.
        assert!(Renderer::from(gpu()).render(&stage, &Control::default()).unwrap_err().to_string().contains(why));
    }
    let choices = Renderer::from(starved()).with_stand_in(CpuRenderer::new()).choices(&stage).unwrap();
    assert!(choices[0].chosen.starts_with("cpu, as ") && choices[0].chosen.contains("20000"), "{choices:?}");
}

#[test]
fn the_processors_work_beside_an_adapter_has_the_threads_that_were_said() {
    use pellucid::field::{Threads, thread_count};
    let (_, stage) = stage(&folder().join("composite-bone.toml"));
    for count in [1, 3] {
        let mut renderer = Renderer::from(gpu(&Ceiling::default())).on_threads(Threads::new(count).unwrap());
        let counts = std::sync::Mutex::new(Vec::new());
        let note = |_| counts.lock().unwrap().push(thread_count());
        renderer.render(&stage, &Control { progress: Some(&note), ..Control::default() }).unwrap();
        let counts = counts.into_inner().unwrap();
        assert!(!counts.is_empty() && counts.iter().all(|found| *found == count), "{counts:?}");
    }
}

#[test]
fn what_every_device_has_is_enough() {
    let mut usual = gpu(&Ceiling::default());
    let mut least = gpu(&Ceiling { guaranteed: true, ..Ceiling::default() });
    let limits = &least.device().capabilities.limits;
    assert_eq!(limits.max_storage_buffers_per_shader_stage, 8);
    let mut drawn = Vec::new();
    for path in scenes() {
        let (_, mut stage) = stage(&path);
        if !Backend::Gpu.draws(&stage) {
            continue;
        }
        let name = name_of(&path);
        // Small and coarse pictures ask for as much of a device.
        stage.step *= 3.0;
        match &mut stage.technique {
            Technique::HalfAngle(settings) => settings.resolution = 64,
            Technique::PathTrace(settings) => settings.samples = 2,
            _ => {}
        }
        (stage.viewpoint.width, stage.viewpoint.height) = (stage.viewpoint.width / 4, stage.viewpoint.height / 4);
        let [one, other] = [&mut usual, &mut least].map(|renderer| {
            renderer.render(&stage, &Control::default()).unwrap_or_else(|error| panic!("{name}: {error}"))
        });
        assert_eq!(one.color, other.color, "{name}");
        assert_eq!((one.depth, one.normal, one.samples), (other.depth, other.normal, other.samples), "{name}");
        assert!(one.statistics.samples_visible > 0, "{name}");
        drawn.push(name);
    }
    for technique in ["composite-", "half-angle-", "path-trace-", "shadow-rays-", "shadow-volume-", "slicing-"] {
        assert!(drawn.iter().any(|name| name.starts_with(technique)), "no {technique} scene among {drawn:?}");
    }
}

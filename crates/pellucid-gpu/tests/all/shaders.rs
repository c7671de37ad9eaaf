//! Every shader that can be asked for compiles, and needs no more than every device has: no graphics processor is needed
//! to know.

use std::num::NonZero;
use std::sync::atomic::{AtomicUsize, Ordering};

use pellucid_gpu::shaders::{Constants, Linker, Pass, Traversal, Variant, resources};
use wgpu::naga::Module;
use wgpu::naga::back::spv;
use wgpu::naga::valid::{Capabilities, ValidationFlags, Validator};
use wgpu::{BindingType, BufferBindingType, Limits};

#[test]
fn every_variant_is_valid() {
    let all: Vec<_> = Variant::all().into_iter().enumerate().collect();
    let next = AtomicUsize::new(0);
    let threads = std::thread::available_parallelism().map_or(1, NonZero::get);
    std::thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                let mut linker = Linker::default();
                while let Some((number, variant)) = all.get(next.fetch_add(1, Ordering::Relaxed)) {
                    check(&mut linker, *number, variant);
                }
            });
        }
    });
}

/// Each layer of a walk has flags of its own.
#[test]
fn layers_of_any_kind_are_valid() {
    let layered =
        |variant: &Variant| [false, true].map(|exact| Variant { layered: true, exact, ..*variant }.canonical());
    let mut kinds: Vec<Variant> = Variant::all().iter().flat_map(layered).filter(|variant| variant.layered).collect();
    kinds.retain(|variant| !variant.wavefront);
    kinds.dedup();
    // What slices through all of them make of pixels looks at no volume.
    let pixels: Vec<_> = kinds.extract_if(.., |variant| variant.traversal == Traversal::SlicePixels).collect();
    assert!(!pixels.is_empty());
    let mut linker = Linker::default();
    for variant in pixels {
        let all = [variant; 3];
        check_written(&all, &linker.link(&all, Constants::Uniform).unwrap_or_else(|error| panic!("{error}")));
    }
    // Those that follow rays through each volume by itself, and what merges them.
    let (together, apart): (Vec<Variant>, Vec<Variant>) =
        kinds.into_iter().partition(|variant| variant.pass.follows_together());
    for (number, variant) in apart.iter().enumerate().filter(|(_, variant)| variant.pass != Pass::Apart) {
        check(&mut linker, number, variant);
    }
    let merge = [Variant::of(Pass::Apart).canonical(); 3];
    check_written(&merge, &linker.link(&merge, Constants::Stored).unwrap_or_else(|error| panic!("{error}")));
    assert!(together.len() > 100 && apart.len() > 100, "{} and {}", together.len(), apart.len());
    // Every kind beside another one of the same pass.
    let alike = |a: &Variant, b: &Variant| (a.pass, a.traversal) == (b.pass, b.traversal);
    let chunks = together.chunk_by(alike).flat_map(|of_pass| of_pass.chunks(13));
    for (number, pair) in chunks.map(|chunk| [chunk[0], *chunk.last().unwrap_or(&chunk[0])]).enumerate() {
        let constants = if number.is_multiple_of(2) { Constants::Uniform } else { Constants::Stored };
        let module = linker.link(&pair, constants).unwrap_or_else(|error| panic!("{error}"));
        check_written(&pair, &module);
        if constants == Constants::Uniform {
            check_limits(&pair[0], &module);
        }
        let used = resources(&module).unwrap();
        let of = |layer, name: &str| used.iter().any(|resource| resource.layer == layer && resource.name == name);
        // Classified voxels are looked up one by one.
        let reads = |layer| of(layer, "volume") || of(layer, "voxels");
        assert!(reads(0) && reads(1), "{pair:?}");
    }
}

fn check(linker: &mut Linker, number: usize, variant: &Variant) {
    // Where constants are is a matter of their declarations: a part of the shaders says enough.
    let constants = if number.is_multiple_of(8) { Constants::Uniform } else { Constants::Stored };
    let module = linker.link(std::slice::from_ref(variant), constants).unwrap_or_else(|error| panic!("{error}"));
    check_limits(variant, &module);
    check_written(&[*variant], &module);
}

fn check_written(variant: &[Variant], module: &Module) {
    // What drivers are given: writing it fails, or panics, where linking has lost an expression.
    let mut validator = Validator::new(ValidationFlags::all(), Capabilities::all());
    let info = validator.validate(module).unwrap_or_else(|error| panic!("{variant:?}: {error:?}"));
    let written = spv::write_vec(module, &info, &spv::Options::default(), None);
    written.unwrap_or_else(|error| panic!("{variant:?}: {error}"));
}

/// A stage has as many resources on every device.
fn check_limits(variant: &Variant, module: &Module) {
    let used = resources(module).unwrap_or_else(|error| panic!("{variant:?}: {error}"));
    let count = |kind: fn(&BindingType) -> bool| used.iter().filter(|resource| kind(&resource.ty)).count() as u32;
    let stored = |ty: &_| matches!(ty, BindingType::Buffer { ty: BufferBindingType::Storage { .. }, .. });
    let uniform = |ty: &_| matches!(ty, BindingType::Buffer { ty: BufferBindingType::Uniform, .. });
    let limits = Limits::default();
    let names: Vec<_> = used.iter().map(|resource| &resource.name).collect();
    for (found, most) in [
        (count(stored), limits.max_storage_buffers_per_shader_stage),
        (count(uniform), limits.max_uniform_buffers_per_shader_stage),
        (count(|ty| matches!(ty, BindingType::Texture { .. })), limits.max_sampled_textures_per_shader_stage),
        (count(|ty| matches!(ty, BindingType::StorageTexture { .. })), limits.max_storage_textures_per_shader_stage),
    ] {
        assert!(found <= most, "{variant:?} has {found} of {most}: {names:?}");
    }
    assert!(!used.is_empty(), "{variant:?}");
}

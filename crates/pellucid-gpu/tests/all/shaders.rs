//! Every shader that can be asked for compiles: no graphics processor is needed to know.

use std::num::NonZero;
use std::sync::atomic::{AtomicUsize, Ordering};

use pellucid_gpu::shaders::{Constants, Linker, Variant};
use wgpu::naga::back::spv;
use wgpu::naga::valid::{Capabilities, ValidationFlags, Validator};

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

fn check(linker: &mut Linker, number: usize, variant: &Variant) {
    // Where constants are is a matter of their declarations: a part of the shaders says enough.
    let constants = if number.is_multiple_of(8) { Constants::Stored } else { Constants::Uniform };
    let module = linker.link(variant, constants).unwrap_or_else(|error| panic!("{error}"));
    // What drivers are given: writing it fails, or panics, where linking has lost an expression.
    let mut validator = Validator::new(ValidationFlags::all(), Capabilities::all());
    let info = validator.validate(&module).unwrap_or_else(|error| panic!("{variant:?}: {error:?}"));
    let written = spv::write_vec(&module, &info, &spv::Options::default(), None);
    written.unwrap_or_else(|error| panic!("{variant:?}: {error}"));
}

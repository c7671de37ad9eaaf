//! Every shader that can be asked for compiles: no graphics processor is needed to know.

use std::num::NonZero;

use pellucid_gpu::shaders::{Constants, Variant};
use wgpu::naga::back::spv;
use wgpu::naga::valid::{Capabilities, ValidationFlags, Validator};

#[test]
fn every_variant_is_valid() {
    let all: Vec<_> = Variant::all().into_iter().enumerate().collect();
    assert!(all.len() > 100, "{}", all.len());
    let threads = std::thread::available_parallelism().map_or(1, NonZero::get);
    std::thread::scope(|scope| {
        for share in all.chunks(all.len().div_ceil(threads)) {
            scope.spawn(|| share.iter().for_each(|(number, variant)| check(*number, variant)));
        }
    });
}

fn check(number: usize, variant: &Variant) {
    // Where constants are is a matter of their declarations: a part of the shaders says enough.
    let constants = if number.is_multiple_of(8) { Constants::Stored } else { Constants::Uniform };
    let module = variant.link(constants).unwrap_or_else(|error| panic!("{error}"));
    // What drivers are given: writing it fails, or panics, where linking has lost an expression.
    if number.is_multiple_of(10) {
        let mut validator = Validator::new(ValidationFlags::all(), Capabilities::all());
        let info = validator.validate(&module).unwrap_or_else(|error| panic!("{variant:?}: {error:?}"));
        let written = spv::write_vec(&module, &info, &spv::Options::default(), None);
        written.unwrap_or_else(|error| panic!("{variant:?}: {error}"));
    }
}

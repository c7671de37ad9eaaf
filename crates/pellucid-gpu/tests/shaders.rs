//! Every shader that can be asked for compiles: no graphics processor is needed to know.

use pellucid_gpu::shaders::{Constants, Variant};
use wgpu::naga::back::spv;
use wgpu::naga::valid::{Capabilities, ValidationFlags, Validator};

#[test]
fn every_variant_is_valid() {
    let all = Variant::all();
    assert!(all.len() > 100, "{}", all.len());
    for (number, variant) in all.into_iter().enumerate() {
        // Where constants are is a matter of their declarations: a part of the shaders says enough.
        let constants = if number % 8 == 0 { Constants::Stored } else { Constants::Uniform };
        let module = variant.link(constants).unwrap_or_else(|error| panic!("{error}"));
        // What drivers are given: writing it fails, or panics, where linking has lost an expression.
        if number % 5 == 0 || variant.has_scattering() {
            let mut validator = Validator::new(ValidationFlags::all(), Capabilities::all());
            let info = validator.validate(&module).unwrap_or_else(|error| panic!("{variant:?}: {error:?}"));
            let written = spv::write_vec(&module, &info, &spv::Options::default(), None);
            written.unwrap_or_else(|error| panic!("{variant:?}: {error}"));
        }
    }
}

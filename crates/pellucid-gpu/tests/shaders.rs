//! Every shader that can be asked for compiles: no graphics processor is needed to know.

use pellucid_gpu::shaders::{Constants, Variant};

#[test]
fn every_variant_is_valid() {
    let all = Variant::all();
    assert!(all.len() > 100, "{}", all.len());
    for (number, variant) in all.into_iter().enumerate() {
        // Where constants are is a matter of their declarations: a part of the shaders says enough.
        let constants = if number % 8 == 0 { Constants::Stored } else { Constants::Uniform };
        variant.link(constants).unwrap_or_else(|error| panic!("{error}"));
    }
}

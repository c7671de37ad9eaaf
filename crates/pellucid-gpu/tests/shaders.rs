//! Every shader that can be asked for compiles: no graphics processor is needed to know.

use pellucid_gpu::shaders::Variant;

#[test]
fn every_variant_is_valid() {
    let all = Variant::all();
    assert!(all.len() > 100, "{}", all.len());
    for variant in all {
        variant.link().unwrap_or_else(|error| panic!("{error}"));
    }
}

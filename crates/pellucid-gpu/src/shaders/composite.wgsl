// Emission and absorption of classified samples (7.2-1).
#define_import_path pellucid::mode

#import pellucid::ray::{Ray, Sample}
#import pellucid::march::State
#import pellucid::surface::add_sample
#import pellucid::table::{classify_stride, over_length}
#ifdef PRECLASSIFIED
#import pellucid::preclassify::classify_voxels
#else
#import pellucid::field::field_value
#endif

fn visit(state: ptr<function, State>, ray: Ray, sample: Sample, p: vec3<f32>) -> bool {
#ifdef PRECLASSIFIED
    let classified = classify_voxels(p);
#else
    let classified = classify_stride(field_value(p), sample.level);
#endif
    let rgba = over_length(classified, sample.ratio);
    if rgba.a <= 0.0 {
        return false;
    }
    (*state).counts.y += 1u;
    return add_sample(state, ray, sample.distance, rgba);
}

fn finish(state: ptr<function, State>) {}

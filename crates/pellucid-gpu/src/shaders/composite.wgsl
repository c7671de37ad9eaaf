// Emission and absorption of classified samples (7.2-1).
#define_import_path pellucid::mode

#import pellucid::ray::{Ray, ray_ratio}
#import pellucid::march::State
#import pellucid::surface::add_sample
#import pellucid::table::{classify, over_length}
#ifdef PRECLASSIFIED
#import pellucid::preclassify::classify_voxels
#else
#import pellucid::field::field_value
#endif

fn visit(state: ptr<function, State>, ray: Ray, k: f32, distance: f32, p: vec3<f32>) -> bool {
#ifdef PRECLASSIFIED
    let classified = classify_voxels(p);
#else
    let classified = classify(field_value(p));
#endif
    let rgba = over_length(classified, ray_ratio(ray, k));
    if rgba.a <= 0.0 {
        return false;
    }
    (*state).counts.y += 1u;
    return add_sample(state, ray, distance, rgba);
}

fn finish(state: ptr<function, State>) {}

// Emission and absorption of classified samples (7.2-1).
#define_import_path pellucid::mode

#import pellucid::ray::{Ray, Sample}
#import pellucid::march::State
#import pellucid::surface::add_sample
#import pellucid::table::{classify_stride, coverage, each_opacity, over_length}
#import pellucid::vary::varied
#ifdef PRECLASSIFIED
#import pellucid::preclassify::classify_voxels
#endif
#import pellucid::field::field_value

fn visit(state: ptr<function, State>, ray: Ray, sample: Sample, p: vec3<f32>) -> bool {
#ifdef PRECLASSIFIED
    let classified = classify_voxels(p);
    var value = 0.0;
#ifdef SCATTERED
    value = field_value(p);
#endif
#else
    let value = field_value(p);
    let classified = classify_stride(value, sample.level);
#endif
    let rgba = over_length(varied(p, classified), sample.ratio);
    if rgba.a <= 0.0 {
        return false;
    }
    (*state).counts.y += 1u;
    return add_sample(state, ray, sample.distance, value, rgba);
}

fn finish(state: ptr<function, State>) {
#ifdef CHROMATIC
    // What is held back of each colour behind: nothing else has a place in a ray that is done.
    (*state).place = vec4<f32>((*state).place.x, each_opacity((*state).color.a));
#endif
    (*state).color.a = coverage((*state).color.a);
}

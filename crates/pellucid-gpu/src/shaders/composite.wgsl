// Emission and absorption of classified samples (7.2-1).
#define_import_path pellucid::mode

#import pellucid::ray::{Ray, Sample}
#import pellucid::march::State
#import pellucid::surface::add_sample
#import pellucid::table::{coverage, each_opacity, over_length}
#import pellucid::vary::varied
#import pellucid::classified::classified_at

fn visit(state: ptr<function, State>, ray: Ray, sample: Sample, p: vec3<f32>) -> bool {
    let sampled = classified_at(p, sample.level);
    let rgba = over_length(varied(p, sampled.rgba), sample.ratio);
    if rgba.a <= 0.0 {
        return false;
    }
    (*state).counts.y += 1u;
    return add_sample(state, ray, sample.distance, sampled.value, rgba);
}

fn finish(state: ptr<function, State>) {
#ifdef CHROMATIC
    // What is held back of each colour behind: nothing else has a place in a ray that is done.
    (*state).place = vec4<f32>((*state).place.x, each_opacity((*state).color.a));
#endif
    (*state).color.a = coverage((*state).color.a);
}

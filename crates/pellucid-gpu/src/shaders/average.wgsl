// The mean value along a ray (1.4-11).
#define_import_path pellucid::mode

#import pellucid::ray::{Ray, Sample}
#import pellucid::field::{field_value, is_present, ABSENT}
#import pellucid::march::{State, NOWHERE}
#import pellucid::projected::set_value

// `place` has the integral of the values in z and the length of it in w.
fn visit(state: ptr<function, State>, ray: Ray, sample: Sample, p: vec3<f32>) -> bool {
    let value = field_value(p);
    if is_present(value) {
        (*state).place.z += value * sample.ratio;
        (*state).place.w += sample.ratio;
    }
    return false;
}

fn finish(state: ptr<function, State>) {
    var mean = ABSENT;
    if (*state).place.w > 0.0 {
        mean = (*state).place.z / (*state).place.w;
    }
    set_value(state, mean, NOWHERE);
}

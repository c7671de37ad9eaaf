// The largest or the smallest value along a ray (1.4-10).
#define_import_path pellucid::mode

#import pellucid::ray::{Ray, Sample}
#import pellucid::field::{field_value, is_present, ABSENT}
#import pellucid::march::State
#import pellucid::projected::set_value

#ifdef MINIMUM
// The smallest value is the largest with its sign turned.
const SIGN: f32 = -1.0;
#else
const SIGN: f32 = 1.0;
#endif

// `place` has the best value so far in y (blocks are compared with it), and its distance in z.
fn visit(state: ptr<function, State>, ray: Ray, sample: Sample, p: vec3<f32>) -> bool {
    let value = field_value(p);
    if is_present(value) && value * SIGN > (*state).place.y {
        (*state).place.y = value * SIGN;
        (*state).place.z = sample.distance;
    }
    return false;
}

fn finish(state: ptr<function, State>) {
    set_value(state, (*state).place.y * SIGN, (*state).place.z);
}

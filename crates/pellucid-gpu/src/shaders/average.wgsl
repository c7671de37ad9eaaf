// The mean value along a ray (1.4-11).
#define_import_path pellucid::mode

#import pellucid::ray::{Ray, ray_ratio}
#import pellucid::field::{field_value, is_present, ABSENT}
#import pellucid::march::{State, NOWHERE}
#import pellucid::projected::set_value

// `place` has the integral of the values in z and the length of it in w.
fn visit(state: ptr<function, State>, ray: Ray, k: f32, distance: f32, p: vec3<f32>) -> bool {
    let value = field_value(p);
    if is_present(value) {
        let ratio = ray_ratio(ray, k);
        (*state).place.z += value * ratio;
        (*state).place.w += ratio;
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

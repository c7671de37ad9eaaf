// One value for a whole ray, classified; its opacity is not corrected for any length (1.4-10, 1.4-11).
#define_import_path pellucid::projected

#import pellucid::march::{State, NOWHERE}
#import pellucid::field::is_present
#import pellucid::table::classify

// Writes down what a ray made of its values.
fn set_value(state: ptr<function, State>, value: f32, distance: f32) {
    (*state).color = vec4<f32>(0.0);
    if !is_present(value) {
        return;
    }
    (*state).counts.y += 1u;
    var rgba = classify(value);
#ifdef OPAQUE
    // Slices have opacity 1 wherever there is a value.
    rgba.a = 1.0;
#endif
    (*state).color = vec4<f32>(rgba.rgb * rgba.a, rgba.a);
    (*state).surface = vec4<f32>(0.0, 0.0, 0.0, distance);
}

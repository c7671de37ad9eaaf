// One value for a whole ray, by blending (3.2-10): values are blended as places in the table, 0 to 1, and
// classified once all slices are there. Opacity says that there was one; for means, what they are of.
#define_import_path pellucid::mode

#import pellucid::frame::frame
#import pellucid::ray::{Ray, Sample}
#import pellucid::field::{field_value, is_present}
#import pellucid::march::State
#import pellucid::slices::slices
#import pellucid::table::even_node

fn visit(state: ptr<function, State>, ray: Ray, sample: Sample, p: vec3<f32>) -> bool {
    let value = field_value(p);
    if !is_present(value) {
        return false;
    }
    let color = (*state).color;
    let last = f32(frame.dims.w - 1u);
#ifdef MEAN
    let weight = sample.ratio * slices.strides.z;
    (*state).color = color + vec4<f32>(vec3<f32>(even_node(value) / last * weight), weight);
#else
    let place = vec3<f32>(clamp(even_node(value) / last, 0.0, 1.0));
#ifdef MINIMUM
    let best = min(select(vec3<f32>(1.0), color.rgb, color.a > 0.0), place);
#else
    let best = max(color.rgb, place);
#endif
    (*state).color = vec4<f32>(best, 1.0);
#endif
    (*state).counts.y += 1u;
    return false;
}

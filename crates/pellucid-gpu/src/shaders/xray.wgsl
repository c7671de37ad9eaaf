// A radiograph (1.2-7, model 1; 1.4-11): the share of light held back, in white.
#define_import_path pellucid::mode

#import pellucid::ray::{Ray, Sample}
#import pellucid::field::field_value
#import pellucid::march::State
#import pellucid::table::{classify, opacity_over}

fn visit(state: ptr<function, State>, ray: Ray, sample: Sample, p: vec3<f32>) -> bool {
    var alpha = classify(field_value(p)).a;
    if alpha > 0.0 {
        (*state).counts.y += 1u;
        if sample.ratio != 1.0 {
            alpha = opacity_over(alpha, sample.ratio);
        }
        (*state).color += (vec4<f32>(1.0) - (*state).color) * alpha;
    }
    return false;
}

fn finish(state: ptr<function, State>) {}

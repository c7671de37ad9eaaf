// Emission without absorption (1.2-7, model 2): the medium gives its light `kappa c` and takes none away.
#define_import_path pellucid::mode

#import pellucid::frame::frame
#import pellucid::ray::{Ray, Sample}
#import pellucid::field::field_value
#import pellucid::march::State
#import pellucid::table::{classify, extinction}

// Opacity 1 would shine infinitely; this one emits 9.2 times its colour per unit distance.
const BRIGHTEST: f32 = 0.9999;

fn visit(state: ptr<function, State>, ray: Ray, sample: Sample, p: vec3<f32>) -> bool {
    let rgba = classify(field_value(p));
    if rgba.a > 0.0 {
        (*state).counts.y += 1u;
        let depth = extinction(min(rgba.a, BRIGHTEST)) * sample.ratio * frame.limits.w;
        (*state).color += vec4<f32>(rgba.rgb * depth, 0.0);
    }
    return false;
}

fn finish(state: ptr<function, State>) {}

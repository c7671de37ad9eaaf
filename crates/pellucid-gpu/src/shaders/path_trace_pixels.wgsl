// From paths to pixels: their mean, its standard error, and the depth at which half of a ray's light has collided.
#import pellucid::frame::{frame, bounds}
#import pellucid::field::field_value
#import pellucid::march::{states, HIT, NOWHERE}
#import pellucid::pixel::{Pixel, pixels}
#import pellucid::ray::{ray_at, ray_of, sample_of}
#import pellucid::paths::{matter_at, paths}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= frame.size.x || id.y >= bounds.rows.y {
        return;
    }
    let slot = id.y * frame.size.x + id.x;
    let state = states[slot];
    let count = state.surface.z;
    var depth = NOWHERE;
    if state.color.a >= 0.5 * count {
        let ray = ray_of(id.xy + vec2<u32>(frame.size.y, bounds.rows.x), 0u);
        var thickness = 0.0;
        for (var k = 0.0; k < ray.count; k += 1.0) {
            let sample = sample_of(ray, k);
            let p = ray_at(ray, sample.distance);
            thickness += matter_at(p, field_value(p)).a * sample.ratio;
            // What is left of white light.
            if dot(exp(-paths.chroma.rgb * thickness), vec3<f32>(1.0 / 3.0)) <= 0.5 {
                depth = (ray.entry + sample.distance) * frame.picture.w;
                break;
            }
        }
    }
    var pixel: Pixel;
    pixel.color = state.color / count;
#ifdef CHROMATIC
    pixel.held_back = 1.0 - state.place / count;
#endif
    let error = sqrt(state.surface.y / (count * max(count - 1.0, 1.0)));
    pixel.surface = vec4<f32>(error, count, 0.0, depth);
    pixel.counts = state.counts;
    pixels[slot] = pixel;
}

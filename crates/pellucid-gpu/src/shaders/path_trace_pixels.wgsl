// From paths to pixels: their mean, its standard error, the depth at which half of a ray's light has collided, and the
// normal there.
#import pellucid::frame::{frame, bounds}
#import pellucid::each_path::load
#import pellucid::march::{states, HIT, NOWHERE}
#import pellucid::pixel::{Pixel, pixels}
#import pellucid::paths::paths
#import pellucid::sight::{depth_of, distance_of, normal_in, sight_of, steps_of}

// A unit vector as a point of the square from -1 to 1 (the octahedron, folded open: Cigolle et al. 2014); beyond it
// where there is none.
fn packed_normal(normal: vec3<f32>) -> vec2<f32> {
    let sum = abs(normal.x) + abs(normal.y) + abs(normal.z);
    if sum == 0.0 {
        return vec2<f32>(2.0);
    }
    let p = normal.xy / sum;
    let folded = (1.0 - abs(p.yx)) * select(vec2<f32>(-1.0), vec2<f32>(1.0), p >= vec2<f32>(0.0));
    return select(p, folded, normal.z < 0.0);
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= frame.size.x || id.y >= bounds.rows.count {
        return;
    }
    load();
    let slot = id.y * frame.size.x + id.x;
    let state = states[slot];
    let count = state.surface.z;
    var depth = NOWHERE;
    var normal = vec2<f32>(2.0);
    if state.color.a >= 0.5 * count {
        let sight = sight_of(id.xy + vec2<u32>(frame.size.y, bounds.rows.first));
        let steps = steps_of(sight);
        var thickness = 0.0;
        for (var k = 0.0; k < steps; k += 1.0) {
            thickness += depth_of(sight, k);
            // What is left of white light.
            if dot(exp(-paths.chroma.rgb * thickness), vec3<f32>(1.0 / 3.0)) <= 0.5 {
                depth = distance_of(sight, k) * frame.picture.w;
                normal = packed_normal(normal_in(sight, k));
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
    pixel.surface = vec4<f32>(error, normal, depth);
    pixel.counts = vec4<u32>(state.counts.xyz, u32(count));
    pixels[slot] = pixel;
}

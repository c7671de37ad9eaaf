// Adds what the rays of this turn found to their pixels: their share of the colour, and their surface
// if it is the nearest of the pixel.
#import pellucid::frame::{frame, bounds}
#import pellucid::march::{HIT, NOWHERE, TERMINATED, states}
#import pellucid::pixel::{Pixel, pixels}
#import pellucid::ray::{beam_of, place_of, ray_of}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= frame.size.x || id.y >= bounds.rows.count {
        return;
    }
    let slot = id.y * frame.size.x + id.x;
    let state = states[slot];
    let sub = bounds.rows.ray;
    let n = frame.size.z;
    var pixel: Pixel;
    if sub == 0u {
        // All else is 0.
        pixel.surface = vec4<f32>(0.0, 0.0, 0.0, NOWHERE);
    } else {
        pixel = pixels[slot];
    }
    pixel.color += state.color / f32(n * n);
#ifdef CHROMATIC
    pixel.held_back += vec4<f32>(state.place.yzw, 0.0) / f32(n * n);
#endif
    if state.surface.w < NOWHERE {
        let at = id.xy + vec2<u32>(frame.size.y, bounds.rows.first);
#ifdef LAYERED
        let entry = beam_of(place_of(at, sub)).to_base;
#else
        let entry = ray_of(at, sub).entry;
#endif
        let depth = (entry + state.surface.w) * frame.picture.w;
        if depth < pixel.surface.w {
            pixel.surface = vec4<f32>(state.surface.xyz, depth);
        }
    }
    let hit = select(0u, 1u, (state.counts.w & HIT) != 0u);
    let terminated = select(0u, 0x10000u, (state.counts.w & TERMINATED) != 0u);
    pixel.counts += vec4<u32>(state.counts.xyz, hit + terminated);
    pixels[slot] = pixel;
}

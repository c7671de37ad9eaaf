// What lies behind the middle of a pixel, step by step from where the first of several volumes begins.
#define_import_path pellucid::sight

#import pellucid::of0::ray::{beam_of, place_of}
#import pellucid::count::COUNT
#import pellucid::every::{densest_of, parts_ahead, thickness}
#import pellucid::flight::{Aim, Part, FAR_AWAY}

struct Sight {
    parts: array<Part, COUNT>,
    // Of all of them, in steps from the plane that the rays of all volumes count from, and how far from the eye that is.
    begin: f32,
    end: f32,
    to_base: f32,
}

fn sight_of(pixel: vec2<u32>) -> Sight {
    let at = place_of(pixel, 0u);
    let beam = beam_of(at);
    var sight = Sight(parts_ahead(Aim(at, vec3<f32>(0.0), beam.world)), FAR_AWAY, -FAR_AWAY, beam.to_base);
    for (var i = 0u; i < COUNT; i += 1u) {
        let part = sight.parts[i];
        if part.flight.length > 0.0 {
            sight.begin = min(sight.begin, part.start);
            sight.end = max(sight.end, part.start + part.flight.length);
        }
    }
    return sight;
}

fn steps_of(sight: Sight) -> f32 {
    return max(ceil(sight.end - sight.begin), 0.0);
}

// The distance of a step from the eye, in steps.
fn distance_of(sight: Sight, k: f32) -> f32 {
    return sight.to_base + sight.begin + k + 0.5;
}

// Its optical depth.
fn depth_of(sight: Sight, k: f32) -> f32 {
    return thickness(0.0, sight.parts, sight.begin + vec2<f32>(k, k + 1.0));
}

// The unit normal there; zero where there is no surface.
fn normal_in(sight: Sight, k: f32) -> vec3<f32> {
    return densest_of(vec4<f32>(0.0), sight.parts, sight.begin + k + 0.5).xyz;
}

// Rays of the eye as they cross slabs.
#define_import_path pellucid::eye

#import pellucid::ray::{Ray, ray_length}
#import pellucid::sweep::{Crossing, sweep}

struct EyeCrossing {
    crossing: Crossing,
    // Whether the ray meets the last slabs first.
    is_backward: bool,
}

fn eye_crossing(ray: Ray) -> EyeCrossing {
    // A ray that lies in a slab crosses it very slowly.
    const SLOWEST: f32 = 1e-6;
    let along = dot(sweep.slabs.xyz, ray.direction);
    let is_backward = along < 0.0;
    let speed = max(abs(along), SLOWEST);
    let length = select(0.0, ray_length(ray), ray.count > 0.0);
    let entry = ray.origin + ray.direction * select(0.0, length, is_backward);
    let begin = dot(sweep.slabs.xyz, entry) + sweep.slabs.w;
    var crossing: Crossing;
    crossing.direction = select(ray.direction, -ray.direction, is_backward) / speed;
    crossing.origin = entry - crossing.direction * begin;
    crossing.ends = vec2<f32>(max(begin, 0.0), min(begin + length * speed, f32(sweep.size.z)));
    crossing.stretch = 1.0 / speed;
    crossing.jitter = ray.jitter;
    return EyeCrossing(crossing, is_backward);
}

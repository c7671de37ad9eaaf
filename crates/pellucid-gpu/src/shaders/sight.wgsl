// What lies behind the middle of a pixel, step by step: of one volume.
#define_import_path pellucid::sight

#import pellucid::field::{field_gradient, field_value}
#import pellucid::normal::normal_of
#import pellucid::paths::{matter_at, paths}
#import pellucid::ray::{Ray, ray_at, ray_of, sample_of}

fn sight_of(pixel: vec2<u32>) -> Ray {
    return ray_of(pixel, 0u);
}

fn steps_of(sight: Ray) -> f32 {
    return sight.count;
}

// The distance of a step from the eye, in steps.
fn distance_of(sight: Ray, k: f32) -> f32 {
    return sight.entry + sample_of(sight, k).distance;
}

// Its optical depth.
fn depth_of(sight: Ray, k: f32) -> f32 {
    let sample = sample_of(sight, k);
    let p = ray_at(sight, sample.distance);
    return matter_at(p, field_value(p)).a * sample.ratio;
}

// The unit normal there; zero where there is no surface.
fn normal_in(sight: Ray, k: f32) -> vec3<f32> {
    if paths.surface.w == 0.0 {
        return vec3<f32>(0.0);
    }
    return normal_of(field_gradient(ray_at(sight, sample_of(sight, k).distance))).direction;
}

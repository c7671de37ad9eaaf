// Samples with light upon them, and the accumulation of colour along a ray, front to back (1.4-8, 7.1-2).
#define_import_path pellucid::surface

#import pellucid::frame::frame
#import pellucid::ray::{Ray, ray_at}
#import pellucid::march::{State, NOWHERE}
#import pellucid::field::{field_gradient, field_value, is_present}
#import pellucid::light::{Unlit, lit}
#import pellucid::normal::normal_of
#import pellucid::table::over
#import pellucid::cut::cut_gradient

#ifdef LIT
// The gradient, where samples may be surfaces. How long it is tells nothing at a cut.
fn gradient_of_surface(ray: Ray, p: vec3<f32>) -> vec3<f32> {
#ifdef SHADED
    return cut_gradient(ray, p, field_gradient(p));
#else
    return vec3<f32>(0.0);
#endif
}
#endif

// A sample of a value in its light, if there is any, behind an opacity.
fn shown(ray: Ray, p: vec3<f32>, value: f32, sample: vec4<f32>, front: f32) -> vec4<f32> {
#ifdef LIT
    return lit(Unlit(sample, value, p, gradient_of_surface(ray, p), ray.to_eye, front));
#else
    return sample;
#endif
}

// Adds a sample of a value behind what is there. Returns whether the ray is done.
fn add_sample(state: ptr<function, State>, ray: Ray, distance: f32, value: f32, sample: vec4<f32>) -> bool {
    let rgba = shown(ray, ray_at(ray, distance), value, sample, (*state).color.a);
    (*state).color = over((*state).color, rgba);
    if (*state).color.a >= 0.5 && (*state).surface.w == NOWHERE {
        (*state).surface.w = distance;
    }
    return (*state).color.a >= frame.limits.z;
}

// The normal where a walk has met the surface: the field there gives the picture its normals, shaded or
// not. Asked once, after the walk: within it, processors whose lanes share branches would pay for it at
// every sample.
fn add_normal(state: ptr<function, State>, ray: Ray) {
    (*state).surface = vec4<f32>(normal_at(ray_at(ray, (*state).surface.w)), (*state).surface.w);
}

// The unit normal of the field at a position in voxels; zero where there is none.
fn normal_at(p: vec3<f32>) -> vec3<f32> {
#ifdef HOLES
    if !is_present(field_value(p)) {
        return vec3<f32>(0.0);
    }
#endif
    return normal_of(field_gradient(p)).direction;
}

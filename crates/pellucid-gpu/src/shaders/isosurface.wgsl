// First surfaces of constant value, found along the ray without a mesh (5.5-8).
#define_import_path pellucid::mode

#import pellucid::frame::frame
#import pellucid::ray::{Ray, Segment, ray_at}
#import pellucid::field::{field_gradient, field_value, is_present}
#import pellucid::levels::{between, levels}
#import pellucid::light::{lit, normal_of}
#import pellucid::march::{State, NOWHERE}
#import pellucid::table::over
#ifdef KERNELS
#import pellucid::field::world_gradient
#import pellucid::pieces::is_of_nearest
#endif

// Where the field passes `level` between two distances whose values bracket it: regula falsi with the
// Illinois rule, and bisection when it stalls. What is absent on the way counts as beyond the surface,
// which then is where the field ends.
fn root(ray: Ray, segment: Segment, level: f32) -> f32 {
    // Width of the bracket, in voxels, at which a root is found.
    const ROOT_VOXELS: f32 = 2e-5;
    let way = abs(ray.direction);
    let tolerance = ROOT_VOXELS / max(max(way.x, max(way.y, way.z)), 1e-12);
    var t0 = segment.distance.x;
    var t1 = segment.distance.y;
    var f0 = segment.value.x - level;
    var f1 = segment.value.y - level;
    var found = t0;
    var there = true;
    var kept = 0;
    for (var round = 0; round < 32; round += 1) {
        let middle = (t0 + t1) * 0.5;
        let secant = t0 + (t1 - t0) * (f0 / (f0 - f1));
        // Never outside the bracket: rounding, or both ends on the level.
        found = select(middle, secant, round % 3 != 2 && secant >= t0 && secant <= t1);
        let value = field_value(ray_at(ray, found));
        let f = value - level;
        there = is_present(value);
        // An end that stays twice counts half, or it would stay for ever.
        if there && (f < 0.0) == (f0 < 0.0) {
            if kept == 1 {
                f1 *= 0.5;
            }
            kept = 1;
            t0 = found;
            f0 = f;
        } else {
            if kept == -1 {
                f0 *= 0.5;
            }
            kept = -1;
            t1 = found;
            f1 = select(f1, f, there);
        }
        // An exact value ends the search, too.
        if t1 - t0 <= tolerance || f == 0.0 {
            break;
        }
    }
    return select(t0, found, there);
}

// The gradient where a ray meets a surface: of nearest voxels, whose surfaces are faces, the jump from one to the other.
fn gradient_at(ray: Ray, p: vec3<f32>, jump: f32) -> vec3<f32> {
#ifdef KERNELS
    if is_of_nearest() {
        // Which of the planes half way between voxels is passed here, in steps off.
        let off = abs((p + 0.5 - floor(p + 1.0)) * ray.inverse);
        let rise = select(vec3<f32>(-jump), vec3<f32>(jump), ray.inverse > vec3<f32>(0.0));
        let nearest = min(off.x, min(off.y, off.z));
        if off.x <= nearest {
            return world_gradient(vec3<f32>(rise.x, 0.0, 0.0));
        }
        if off.y <= nearest {
            return world_gradient(vec3<f32>(0.0, rise.y, 0.0));
        }
        return world_gradient(vec3<f32>(0.0, 0.0, rise.z));
    }
#endif
    return field_gradient(p);
}

// Whether a segment crosses any surface.
fn visit_segment(state: ptr<function, State>, ray: Ray, segment: Segment) -> bool {
    var crosses = false;
    for (var i = 0u; i < frame.level_count; i += 1u) {
        crosses = crosses || between(segment.value.x, segment.value.y, levels[i].value.x);
    }
    return crosses;
}

// Adds the surfaces that a segment crosses, nearest first. Returns whether the ray is done.
fn meet_segment(state: ptr<function, State>, ray: Ray, segment: Segment) -> bool {
    let front = segment.value.x;
    let back = segment.value.y;
    let count = frame.level_count;
    for (var i = 0u; i < count; i += 1u) {
        // A ray leaves the value at the segment's start and meets levels in the order of value.
        let level = levels[select(count - 1u - i, i, back > front)];
        if !between(front, back, level.value.x) {
            continue;
        }
        (*state).counts.y += 1u;
        var distance = segment.distance.x;
        // Faces of nearest voxels are where they are.
        if segment.distance.y > segment.distance.x {
            distance = root(ray, segment, level.value.x);
        }
        let p = ray_at(ray, distance);
        let gradient = gradient_at(ray, p, back - front);
        var rgba = vec4<f32>(level.color.rgb * level.color.a, level.color.a);
#ifdef SHADED
        rgba = lit(rgba, level.value.x, p, gradient, ray.to_eye);
#endif
        (*state).color = over((*state).color, rgba);
        if (*state).surface.w == NOWHERE {
            let normal = normal_of(gradient).direction;
            (*state).surface = vec4<f32>(normal, distance);
        }
        if (*state).color.a >= frame.limits.z {
            return true;
        }
    }
    return false;
}


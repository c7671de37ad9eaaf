// Where rays cross surfaces of constant value, and what they meet there (5.5-8).
#define_import_path pellucid::crossing

#import pellucid::frame::frame
#import pellucid::ray::{Ray, Segment, ray_at}
#import pellucid::field::{field_gradient, field_value, is_present}
#import pellucid::levels::{between, levels}
#import pellucid::light::{Unlit, lit}
#ifdef KERNELS
#import pellucid::field::world_gradient
#import pellucid::pieces::is_of_nearest
#endif

// Whether any surface lies between two values.
fn crosses(values: vec2<f32>) -> bool {
    var found = false;
    for (var i = 0u; i < frame.level_count; i += 1u) {
        found = found || between(values.x, values.y, levels[i].value.x);
    }
    return found;
}

// The level that is the next to be met between two values: a ray leaves the first of them and meets levels in their
// order.
fn level_of(values: vec2<f32>, rank: u32) -> u32 {
    return select(frame.level_count - 1u - rank, rank, values.y > values.x);
}

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

// Where a segment crosses a level that lies between its values.
fn place_in(ray: Ray, segment: Segment, number: u32) -> f32 {
    // Faces of nearest voxels are where they are.
    if segment.distance.y > segment.distance.x {
        return root(ray, segment, levels[number].value.x);
    }
    return segment.distance.x;
}

// A surface that a ray has met: its associated colour, and the gradient.
struct Met {
    rgba: vec4<f32>,
    gradient: vec3<f32>,
}

// What a ray meets where a level lies at a distance, behind an opacity, the values rising by `jump` there.
fn met_at(ray: Ray, distance: f32, number: u32, jump: f32, front: f32) -> Met {
    let level = levels[number];
    let p = ray_at(ray, distance);
    let gradient = gradient_at(ray, p, jump);
    var rgba = vec4<f32>(level.color.rgb * level.color.a, level.color.a);
#ifdef SHADED
    rgba = lit(Unlit(rgba, level.value.x, p, gradient, ray.to_eye, front));
#endif
    return Met(rgba, gradient);
}

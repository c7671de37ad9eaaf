// What is left of lights on their way to samples (6.1-1, K-03): rays to them through the medium, or through
// isosurfaces, of which the first opaque one holds all light back. As `shadow/` of the CPU backend.
#define_import_path pellucid::shadow

#import pellucid::frame::{frame, world_of}
#import pellucid::ray::{exit_of, span_of}
#import pellucid::field::{field_value, is_present}
#ifdef SURFACES
#import pellucid::levels::{between, levels}
#ifdef EXACT
#import pellucid::field::ABSENT
#import pellucid::monotone::{Walk, next_piece}
#import pellucid::pieces::cells_at
#import pellucid::ray::{Ray, Segment, nonzeros}
#ifdef SKIP
#import pellucid::skip::leap_faces
#endif
#endif
#else
#import pellucid::table::{homogeneous, opacity_over}
#import pellucid::vary::varied
#ifdef SKIP
#import pellucid::skip::clear_steps
#import pellucid::ray::nonzeros
#endif
#endif

// Light of which so little is left is not followed to its end: a tenth of an 8-bit step.
const DARK: f32 = 1.0 / 2560.0;

#ifdef SURFACES
// What the surfaces between two values leave.
fn through_levels(values: vec2<f32>) -> f32 {
    var transmittance = 1.0;
    for (var i = 0u; i < frame.level_count; i += 1u) {
        if between(values.x, values.y, levels[i].value.x) {
            transmittance *= 1.0 - levels[i].color.a;
        }
    }
    return transmittance;
}
#endif

// The share that comes to a position from a light at `place`: a unit vector to it, or its position if `w` is 1.
fn transmittance_to(place: vec4<f32>, p: vec3<f32>) -> f32 {
    let step = frame.shadows.x;
    var to_light = place.xyz;
    var most = 1e30;
    if place.w != 0.0 {
        let path = place.xyz - world_of(p);
        let distance = max(length(path), 1e-6 * step);
        to_light = path / distance;
        most = distance / step;
    }
    // Gradients turn into those of the world by the transpose of what turns the world into voxels.
    let direction =
        (frame.gradient_x.xyz * to_light.x + frame.gradient_y.xyz * to_light.y + frame.gradient_z.xyz * to_light.z) * step;
    // Away from the surface that is lit: how it is turned is what `n . l` tells.
    let away = frame.shadows.z;
#ifdef LAYERED
    // Where this volume is on the way, which may begin outside of it.
    let span = span_of(p, direction, away, most);
    let length = span.y - span.x;
    let origin = p + direction * span.x;
#else
    let length = min(exit_of(p, direction), most) - away;
    let origin = p + direction * away;
#endif
    if !(length > 0.0) {
        return 1.0;
    }
    // A remainder below the precision of positions is no segment.
    let count = max(ceil(length - 1e-4), 1.0);
    let last = min(length - (count - 1.0), 1.0);
    var transmittance = 1.0;
#ifdef EXACT
    let ray = Ray(origin, direction, 1.0 / nonzeros(direction), to_light, 0.5, count, last, 0.0);
    var walk = Walk(cells_at(ray, 0.0), 0.0, ABSENT);
    var segment: Segment;
    while walk.cells.ends.x < walk.cells.length && transmittance > 0.0 {
#ifdef SKIP
        var cells = walk.cells;
        if leap_faces(ray, &cells) > 0.0 {
            walk = Walk(cells, 0.0, ABSENT);
        }
#endif
        if walk.cells.ends.x < walk.cells.length && next_piece(ray, &walk, &segment) {
            transmittance *= through_levels(segment.value);
        }
    }
#else
#ifdef SURFACES
    var front = field_value(origin);
    for (var node = 1.0; node <= count + 1.0 && transmittance > 0.0; node += 1.0) {
        let inner = node - 1.0 + 0.5 * select(1.0, last, node >= count);
        let back = field_value(origin + direction * select(inner, length, node > count));
        transmittance *= through_levels(vec2<f32>(front, back));
        front = back;
    }
#else
    // Samples between two looks at the blocks.
    const RUN: u32 = 8u;
#ifdef SKIP
    let inverse = 1.0 / nonzeros(direction);
#endif
    var k = 0.0;
    while k < count && transmittance >= DARK {
#ifdef SKIP
        let clear = clear_steps(origin + direction * (k + 0.5 * select(1.0, last, k >= count - 1.0)), inverse);
        k += clear;
        if clear > 0.0 {
            continue;
        }
#endif
        for (var i = 0u; i < RUN && k < count && transmittance >= DARK; i += 1u) {
            let ratio = select(1.0, last, k >= count - 1.0);
            let at = origin + direction * (k + 0.5 * ratio);
            let value = field_value(at);
            if is_present(value) {
                let alpha = varied(at, vec4<f32>(0.0, 0.0, 0.0, homogeneous(value))).a;
                transmittance *= 1.0 - opacity_over(alpha, ratio * frame.shadows.y);
            }
            k += 1.0;
        }
    }
#endif
#endif
    return transmittance;
}

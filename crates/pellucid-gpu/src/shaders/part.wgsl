// A volume that paths go through among others: what it makes of what those before it have told.
#define_import_path pellucid::part

#import pellucid::field::{field_gradient, field_value}
#import pellucid::flight::{Encounter, Part, FAR_AWAY}
#import pellucid::normal::normal_of
#import pellucid::paths::{collide, matter_at, part_from, paths, transmittance}

// The nearer one of what was met and of what this volume, number `layer`, has in front of it.
fn nearer(met: Encounter, layer: u32, part: Part) -> Encounter {
    var flight = part.flight;
    flight.length = min(flight.length, met.collision.distance - part.start);
    if !(flight.length > 0.0) {
        return met;
    }
    var found = met;
    let collision = collide(flight, met.collision.carried);
    if collision.distance < FAR_AWAY {
        found = Encounter(collision, layer, flight.origin + flight.direction * collision.distance);
        found.collision.distance += part.start;
    }
    found.collision.evaluations = met.collision.evaluations + collision.evaluations;
    return found;
}

// What is left of light from a position in the first volume on for so many steps, and the evaluations so far.
fn lessened(left: vec4<f32>, first: vec3<f32>, forward: vec3<f32>, most: f32) -> vec4<f32> {
    let part = part_from(first, forward);
    var flight = part.flight;
    flight.length = min(flight.length, most - part.start);
    if !(flight.length > 0.0) || all(left.rgb <= vec3<f32>(0.0)) {
        return left;
    }
    let own = transmittance(flight);
    return vec4<f32>(left.rgb * own.rgb, left.a + own.a);
}

// The optical depth between two distances of a way.
fn thicker(depth: f32, part: Part, ends: vec2<f32>) -> f32 {
    let inside = clamp(ends - part.start, vec2<f32>(0.0), vec2<f32>(max(part.flight.length, 0.0)));
    if !(inside.y > inside.x) {
        return depth;
    }
    let p = part.flight.origin + part.flight.direction * (inside.x + inside.y) * 0.5;
    return depth + matter_at(p, field_value(p)).a * (inside.y - inside.x);
}

// The normal of the densest one so far at a distance of a way, zero if it has no surfaces; and how dense that is.
fn denser(found: vec4<f32>, part: Part, distance: f32) -> vec4<f32> {
    let inside = distance - part.start;
    if !(inside >= 0.0 && inside <= part.flight.length) {
        return found;
    }
    let p = part.flight.origin + part.flight.direction * inside;
    let extinction = matter_at(p, field_value(p)).a;
    if !(extinction > found.a) {
        return found;
    }
    if paths.surface.w == 0.0 {
        return vec4<f32>(0.0, 0.0, 0.0, extinction);
    }
    return vec4<f32>(normal_of(field_gradient(p)).direction, extinction);
}

// One volume that paths go through: `Alone` of the CPU backend. Its number tells nothing.
#define_import_path pellucid::surroundings

#import pellucid::flight::{Aim, Encounter, Flight, FAR_AWAY}
#import pellucid::paths as matter

// The way of a ray from the eye.
fn enter(aim: Aim) -> Flight {
    return matter::part_ahead(aim).flight;
}

// The way from a position inside, along a unit vector of the world.
fn leave(layer: u32, p: vec3<f32>, forward: vec3<f32>) -> Flight {
    return matter::leave_along(p, forward, FAR_AWAY);
}

// Whether a way meets anything.
fn meets(way: Flight) -> bool {
    return way.length > 0.0;
}

// The next collision on a way.
fn encounter(way: Flight, carried: vec3<f32>) -> Encounter {
    let collision = matter::collide(way, carried);
    return Encounter(collision, 0u, way.origin + way.direction * collision.distance);
}

// The share of each colour that gets through from a position along a unit vector of the world for so many steps, and the
// evaluations that it took.
fn transmittance_from(layer: u32, p: vec3<f32>, forward: vec3<f32>, most: f32) -> vec4<f32> {
    return matter::transmittance(matter::leave_along(p, forward, most));
}

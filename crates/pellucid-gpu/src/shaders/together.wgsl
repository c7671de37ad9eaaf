// Several volumes that paths go through, whose extinctions add: the first collision with any of them is one with all, as
// the processes that bring them are independent. `Together` of the CPU backend.
#define_import_path pellucid::surroundings

#import pellucid::count::COUNT
#import pellucid::each_path::in_first
#import pellucid::every::{transmittance_through, nearest, parts_ahead, parts_from}
#import pellucid::flight::{Aim, Collision, Encounter, Part, FAR_AWAY}

// The way of a ray from the eye.
fn enter(aim: Aim) -> array<Part, COUNT> {
    return parts_ahead(aim);
}

// The way from a position in a volume, along a unit vector of the world.
fn leave(layer: u32, p: vec3<f32>, forward: vec3<f32>) -> array<Part, COUNT> {
    return parts_from(in_first(layer, p), forward);
}

// Whether a way meets anything.
fn meets(way: array<Part, COUNT>) -> bool {
    var parts = way;
    var longest = 0.0;
    for (var i = 0u; i < COUNT; i += 1u) {
        longest = max(longest, parts[i].flight.length);
    }
    return longest > 0.0;
}

// The next collision on a way.
fn encounter(way: array<Part, COUNT>, carried: vec3<f32>) -> Encounter {
    let none = Collision(FAR_AWAY, 0.0, vec4<f32>(0.0), carried, 0u);
    return nearest(Encounter(none, 0u, vec3<f32>(0.0)), way);
}

// The share of each colour that gets through from a position in a volume along a unit vector of the world for so many
// steps, and the evaluations that it took.
fn transmittance_from(layer: u32, p: vec3<f32>, forward: vec3<f32>, most: f32) -> vec4<f32> {
    return transmittance_through(vec4<f32>(1.0, 1.0, 1.0, 0.0), in_first(layer, p), forward, most);
}

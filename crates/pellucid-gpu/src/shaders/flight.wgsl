// Straight ways of paths, and what they come to: whatever volumes they go through. Distances are in steps.
#define_import_path pellucid::flight

const FAR_AWAY: f32 = 1e30;

// A ray from the eye: the place of the picture that it goes through, in pixels; where it leaves the lens, from the middle
// of that and in the world; and a unit vector of the world.
struct Aim {
    at: vec2<f32>,
    across: vec3<f32>,
    forward: vec3<f32>,
}

// A straight way through a volume, in voxels per step.
struct Flight {
    origin: vec3<f32>,
    direction: vec3<f32>,
    length: f32,
}

// What of a way is in a volume, and where on the way it begins; no length if the way misses the volume.
struct Part {
    flight: Flight,
    start: f32,
}

struct Collision {
    // Steps from the flight's origin; FAR_AWAY if there is none.
    distance: f32,
    value: f32,
    // Colour, and extinction per step.
    matter: vec4<f32>,
    // What the path carries after it.
    carried: vec3<f32>,
    evaluations: u32,
}

// A collision, the number of the volume that it is one with, and where in that, in voxels.
struct Encounter {
    collision: Collision,
    layer: u32,
    p: vec3<f32>,
}

// How light leaves a collision.
struct Vertex {
    // Scattering albedo, or the surface's colour; the anisotropy.
    color: vec4<f32>,
    // The way the path goes, away from the eye; the surface's normal on the eye's side.
    forward: vec3<f32>,
    normal: vec3<f32>,
    is_surface: bool,
}

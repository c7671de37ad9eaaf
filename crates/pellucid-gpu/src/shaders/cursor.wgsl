// How far a ray has been followed through the surfaces of one of several volumes.
#define_import_path pellucid::cursor

// The distance of what is not met.
const BEYOND: f32 = 1e30;

struct Cursor {
    // Steps from the eye between which surfaces are looked for.
    reach: vec2<f32>,
    // Steps from the eye to the next surface.
    ahead: f32,
    // Whether the ray meets the volume.
    is_in: bool,
    // Samples taken, seen, leapt over.
    counts: vec3<u32>,
    // The next node; or the next cell, and how far in it. The value there or, of nearest voxels, in the cell before, if it
    // is known.
    next: f32,
    cell: vec3<f32>,
    front: f32,
    is_known: bool,
    // The segment that was looked at last, its values, and how many of its levels.
    ends: vec2<f32>,
    values: vec2<f32>,
    rank: u32,
    // The surface ahead: its level, and its distance from where the ray enters the volume.
    number: u32,
    distance: f32,
}

// A surface that was met: its associated colour, and its unit normal.
struct Hit {
    rgba: vec4<f32>,
    normal: vec3<f32>,
}

// How far a ray has been followed through the surfaces of one of several volumes.
#define_import_path pellucid::cursor

// The distance of what is not met.
const BEYOND: f32 = 1e30;

struct Cursor {
    // Steps from the eye to the next surface, or to a place before which there is none: whether it is told.
    ahead: f32,
    is_told: bool,
    // Whether the ray meets the volume.
    is_in: bool,
    // How many more looks at the blocks there may be.
    looks: u32,
    // Samples taken, seen, leapt over.
    counts: vec3<u32>,
    // The next node or, between nearest voxels, the distance of the next face; the value there, if it is known.
    next: f32,
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

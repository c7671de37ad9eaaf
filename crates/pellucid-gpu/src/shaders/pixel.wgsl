// Pixels as they come back: the structure of `uniforms.rs`.
#define_import_path pellucid::pixel

struct Pixel {
    // Associated linear RGBA.
    color: vec4<f32>,
    // Unit world normal and distance from the eye, FAR if nothing was met.
    surface: vec4<f32>,
    // Samples taken, seen, leapt over; rays that met the volume in the lower half, rays that stopped
    // early in the upper.
    counts: vec4<u32>,
#ifdef CHROMATIC
    // What is held back of red, green and blue from behind.
    held_back: vec4<f32>,
#endif
}

@group(0) @binding(7) var<storage, read_write> pixels: array<Pixel>;

// A ray in a volume, which may be one of several.
#define_import_path pellucid::way

struct Way {
    // Where it enters the volume, and its way of a step, in voxels.
    origin: vec3<f32>,
    direction: vec3<f32>,
    // Unit vector in the world.
    to_eye: vec3<f32>,
    // Where it enters and leaves, in steps from the plane that the rays of all volumes count from; in no order if it
    // misses the volume.
    ends: vec2<f32>,
}

// Lists that all volumes of a pass share; each of them begins its own where `Frame.lists` says.
#define_import_path pellucid::lists

// What shines around the middle of a light.
struct Extent {
    // What it is; 1 if paths that were scattered find it as well; 1 if a face shines to both sides.
    kind: vec4<u32>,
    // The edges of a face.
    first: vec4<f32>,
    second: vec4<f32>,
    // Out of the side of a face that shines, and its area; else the squared sine of a disc's angle, or a ball's radius.
    normal: vec4<f32>,
}

struct Light {
    // Unit vector to it, or its position; `w` is 1 for a position.
    place: vec4<f32>,
    // Linear RGB; 1 if it makes highlights.
    radiance: vec4<f32>,
    // Where a cone points; 1 if there is one.
    axis: vec4<f32>,
    // Cosines of the cone's inner and outer angle; distance at which the radiance holds, 0 if anywhere.
    cone: vec4<f32>,
    extent: Extent,
}

// Half-spaces that are kept, in voxels of their volume: normal and offset.
@group(0) @binding(2) var<storage, read> planes: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read> lights: array<Light>;
// What tables hold.
@group(2) @binding(0) var<storage, read> entries: array<vec4<f32>>;

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

// What shaders are told of paths (`path_trace/numbers.rs`).
struct Paths {
    // Seeds; paths per pixel; most scatterings.
    counts: vec4<u32>,
    // Scatterings after which dim paths end at random; blocks.
    more: vec4<u32>,
    // The standard error that is aimed at, radius of the lens and distance in focus, both in steps; cells per
    // block.
    numbers: vec4<f32>,
    // The sky from above and below; how much brighter than the mean it is above; 1 if there is one.
    top: vec4<f32>,
    bottom: vec4<f32>,
    // Of a sky that is a picture: cosine and sine of its turn around z, factor of its light, one over its flux; its
    // columns and rows, 0 of another sky.
    picture: vec4<f32>,
    picture_size: vec4<u32>,
    // How far in front of its collision a surface is lit: in mean free paths, and at most in steps; how bright a path
    // may be; 1 if there are surfaces.
    surface: vec4<f32>,
    // Factors of the extinction for each colour; 1 if they differ (K-13).
    chroma: vec4<f32>,
    // Rows of the matrix from steps of the world to voxels.
    index_x: vec4<f32>,
    index_y: vec4<f32>,
    index_z: vec4<f32>,
    // Unit vectors of the world across the view.
    lens_right: vec4<f32>,
    lens_up: vec4<f32>,
    // Rows of the matrix from voxels to those of the first volume, and back.
    first_x: vec4<f32>,
    first_y: vec4<f32>,
    first_z: vec4<f32>,
    own_x: vec4<f32>,
    own_y: vec4<f32>,
    own_z: vec4<f32>,
}

// Half-spaces that are kept, in voxels of their volume: normal and offset.
@group(0) @binding(2) var<storage, read> planes: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read> lights: array<Light>;
// What tables hold.
@group(2) @binding(0) var<storage, read> entries: array<vec4<f32>>;
#ifdef LAYERED
// What paths are told of each volume.
@group(0) @binding(19) var<storage, read> paths: array<Paths>;
#endif

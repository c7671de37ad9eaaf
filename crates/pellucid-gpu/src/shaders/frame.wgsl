// What a frame is drawn with. `uniforms.rs` has the same structures; a test compares their layouts.
#define_import_path pellucid::frame

// A noise in a sum.
struct Term {
    // Texels of the noise per voxel along each axis; the factor in w.
    scale: vec4<f32>,
    // The texel at voxel 0.
    start: vec4<f32>,
}

// What moves and varies a volume.
struct Noise {
    // Voxels that a noise of 1 moves by, and that nothing moves further than.
    amplitude: vec4<f32>,
    reach: vec4<f32>,
    // Voxels between a position and the taps of its gradient.
    spacing: vec4<f32>,
    // Data values at which nothing and everything moves; 1 if that depends on them.
    between: vec4<f32>,
    // How much extinction, colour and transport vary.
    weights: vec4<f32>,
    // Terms that displace, and that vary: they are behind the former.
    counts: vec4<u32>,
    terms: array<Term, 16>,
}

// How samples scatter light (`scattering.rs`).
struct Scattering {
    // Where the entries of a table are: node = (value - x) * y; the first entry's place, and how many there are.
    // Anisotropy and surfaces; transport colours, for paths the albedo; the phase function by its angle.
    properties: vec4<f32>,
    transport: vec4<f32>,
    angles: vec4<f32>,
    // Which formula the phase function has; 1 if its weights are relative to its peak; the anisotropy; 1 if that
    // is the same everywhere.
    phase: vec4<f32>,
    // What is thrown back, over the forward lobe's peak, integrated over all directions.
    back: vec4<f32>,
    // Cosines between which directions are equally likely, of a phase function that is listed: the first one's
    // place, and how many there are; factor of its weights that makes them shares per steradian.
    cosines: vec4<f32>,
    shares: vec4<f32>,
    // Gradient magnitude where surfaces begin, one over the width of their rise; 1 if values tell of anisotropy or
    // surfaces.
    surfaces: vec4<f32>,
}

struct Frame {
    // Where rays cross the base plane, in voxels from the grid's first: at the picture's middle, and
    // per unit to the right and up. `w` of the first is the base plane's distance from the eye, in steps.
    origin_middle: vec4<f32>,
    origin_right: vec4<f32>,
    origin_up: vec4<f32>,
    // Directions in voxels per step, not yet divided by their world length.
    direction_middle: vec4<f32>,
    direction_right: vec4<f32>,
    direction_up: vec4<f32>,
    world_middle: vec4<f32>,
    world_right: vec4<f32>,
    world_up: vec4<f32>,
    // The grid's box in voxels.
    low: vec4<f32>,
    high: vec4<f32>,
    // Rows of the matrix from gradients per voxel to gradients per world length.
    gradient_x: vec4<f32>,
    gradient_y: vec4<f32>,
    gradient_z: vec4<f32>,
    // Rows of world_from_index, for lights that stand somewhere.
    world_x: vec4<f32>,
    world_y: vec4<f32>,
    world_z: vec4<f32>,
    // Middle of the picture in pixels, side of a pixel, step in world lengths.
    picture: vec4<f32>,
    // Data value = stored * x + y; even node of a table = (value - z) * w.
    values: vec4<f32>,
    // Unlit part, diffuse, specular, shininess.
    material: vec4<f32>,
    // Gradient magnitude where light begins, one over the width of its rise; opacity where rays stop;
    // step in unit distances.
    limits: vec4<f32>,
    // A slice: normal in voxels and offset; its world normal.
    plane: vec4<f32>,
    plane_normal: vec4<f32>,
    // A step of a shadow ray in world lengths and in steps of rays; how many of them off the sample it begins; points
    // of a light volume across its last axis, 0 for rays.
    shadows: vec4<f32>,
    // Rows of the matrix from voxels to parts of the box of light volumes.
    points_x: vec4<f32>,
    points_y: vec4<f32>,
    points_z: vec4<f32>,
    // Extinctions of each colour over that of the one that is lost least, whose opacities all opacities are.
    chroma: vec4<f32>,
    // Data values of the table's first and last node; how many rows behind its entries tell where the others are, 0 if
    // they are even, and the place of the first.
    table: vec4<f32>,
    // Columns that are drawn, the first of them, rays per pixel and axis, 1 for a perspective.
    size: vec4<u32>,
    // Voxels of the whole grid; nodes of the table.
    dims: vec4<u32>,
    // Blocks and voxels per block.
    blocks: vec4<u32>,
    // How many lights, clip planes and isosurfaces there are.
    light_count: u32,
    plane_count: u32,
    level_count: u32,
    // 1 if surfaces are lit on both sides.
    two_sided: u32,
    // Shift of the blue noise; 1 if rays are jittered by it.
    jitter: vec4<u32>,
    // The axis across which a stack of 2D textures lies.
    stack: vec4<u32>,
    // Where this volume begins its entries, planes and lights, in lists that all volumes of a pass share.
    lists: vec4<u32>,
    // What lies where volumes overlap: which rule, and two volumes by their place among the layers.
    overlap: vec4<u32>,
    scattering: Scattering,
    noise: Noise,
}

// Rows of the picture, and one of the rays of each of their pixels; 1 if rays start here.
struct Rows {
    first: u32,
    count: u32,
    ray: u32,
    begin: u32,
}

// Slabs from the first to the end; how many layers light is kept in by turns, and the first slab's.
struct Run {
    first: u32,
    end: u32,
    layers: u32,
    layer: u32,
}

// What a pass is told of its part of the frame (`bounds.rs`).
struct Bounds {
#ifdef OF_LIGHT
    // Texels from and to.
    low: vec2<u32>,
    high: vec2<u32>,
    // The first tap of the blur.
    tap: vec2<f32>,
    // Coordinates of the slab's near side and of its middle.
    slab: vec2<f32>,
#else ifdef OF_POINTS
    // The box of the points, in voxels of its grid.
    low: vec4<f32>,
    high: vec4<f32>,
    run: Run,
    // Points of a light, and where they begin along the last axis.
    size: vec3<u32>,
    first: u32,
#else ifdef OF_SLABS
    rows: Rows,
    run: Run,
    // 1 if the sweep of a light begins.
    begin_sweep: u32,
#else ifdef OF_PATHS
    rows: Rows,
#else
    rows: Rows,
    // First voxel of the volume's texture; most looks at the blocks.
    texture_low: vec3<u32>,
    most_looks: u32,
    // Cells whose samples are taken here: from, to. The list of rays that is read, and how long lists are.
    core_low: vec3<u32>,
    list: u32,
    core_high: vec3<u32>,
    list_length: u32,
#endif
}

#ifdef LOADED_CONSTANTS
@group(0) @binding(0) var<storage, read> stored_frame: Frame;
@group(0) @binding(1) var<storage, read> stored_bounds: Bounds;
var<private> frame: Frame;
var<private> bounds: Bounds;
#else
#ifdef STORED_CONSTANTS
@group(0) @binding(0) var<storage, read> frame: Frame;
@group(0) @binding(1) var<storage, read> bounds: Bounds;
#else
@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<uniform> bounds: Bounds;
#endif
#endif

// Reads constants before anything branches: behind a branch, Mesa's software driver reads them once for every lane,
// each time they are needed.
fn load_frame() {
#ifdef LOADED_CONSTANTS
    frame = stored_frame;
#endif
}

// Likewise; several volumes have the bounds of the first.
fn load_bounds() {
#ifdef LOADED_CONSTANTS
    bounds = stored_bounds;
#endif
}

// A position of the world in voxels: gradients turn into those of the world by the transpose of what turns the world
// into voxels.
fn index_of(world: vec3<f32>) -> vec3<f32> {
    let away = world - vec3<f32>(frame.world_x.w, frame.world_y.w, frame.world_z.w);
    return frame.gradient_x.xyz * away.x + frame.gradient_y.xyz * away.y + frame.gradient_z.xyz * away.z;
}

// A position in voxels in the world.
fn world_of(p: vec3<f32>) -> vec3<f32> {
    let here = vec4<f32>(p, 1.0);
    return vec3<f32>(dot(frame.world_x, here), dot(frame.world_y, here), dot(frame.world_z, here));
}

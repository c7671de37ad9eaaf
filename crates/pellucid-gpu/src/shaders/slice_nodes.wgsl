// Slices through several volumes: nodes of the rays, from a place before all volumes on.
#define_import_path pellucid::slice_nodes

#import pellucid::of0::frame::frame
#import pellucid::of0::ray::beam_of
#import pellucid::of0::slices::slices

// Where the first slice is, and how far it is to the next: in steps from where rays count.
var<private> first: f32;
var<private> stride: f32;

// Finds the nodes of the ray through a place of the picture, in pixels.
fn find_nodes(at: vec2<f32>) {
    let beam = beam_of(at);
    if slices.counts.z != 0u {
        // Shells are a step apart on every ray.
        first = -beam.to_base - slices.plane.w;
        stride = 1.0;
    } else {
        // Rays count from the first slice.
        first = 0.0;
        stride = 1.0 / dot(beam.world, frame.world_middle.xyz);
    }
}

// The distance of a slice.
fn node(k: f32) -> f32 {
    return first + k * stride;
}

// How many slabs the volumes reach through.
fn slabs_in(length: f32) -> u32 {
    return u32(max(ceil(length / stride), 0.0));
}

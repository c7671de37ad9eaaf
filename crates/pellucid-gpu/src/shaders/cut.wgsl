// Cut faces: where clips, and the box of the data, cut through matter (C-28): as `cut.rs` of the CPU backend.
#define_import_path pellucid::cut

#import pellucid::frame::frame
#import pellucid::lists::planes
#import pellucid::ray::Ray
#import pellucid::field::world_gradient

// Voxels beyond which a face is not felt, and how far rounding may take an entry off it.
const DEEPEST: f32 = 8.0;
const OFF: f32 = 2e-3;

// The gradient at a position, behind the face that a ray entered by.
fn cut_gradient(ray: Ray, p: vec3<f32>, gradient: vec3<f32>) -> vec3<f32> {
    var normal = vec3<f32>(0.0);
    var offset = 0.0;
    var least = OFF;
    for (var axis = 0u; axis < 3u; axis += 1u) {
        let ascends = ray.direction[axis] > 0.0;
        let side = select(-1.0, 1.0, ascends);
        let at = select(-frame.high[axis], frame.low[axis], ascends);
        let off = abs(side * ray.origin[axis] - at);
        if off < least && ray.direction[axis] != 0.0 {
            normal = vec3<f32>(0.0);
            normal[axis] = side;
            offset = at;
            least = off;
        }
    }
    for (var i = 0u; i < frame.plane_count; i += 1u) {
        let plane = planes[frame.lists.y + i];
        let off = abs(dot(plane.xyz, ray.origin) - plane.w);
        if off < least && dot(plane.xyz, ray.direction) > 0.0 {
            normal = plane.xyz;
            offset = plane.w;
            least = off;
        }
    }
    let depth = dot(normal, p) - offset;
    if least == OFF || depth >= DEEPEST || frame.gradient_x.w == 0.0 {
        return gradient;
    }
    let deep = max(depth, 1.0);
    return gradient * clamp(depth - 1.0, 0.0, 1.0) + world_gradient(normal) * (frame.gradient_x.w / (deep * deep));
}

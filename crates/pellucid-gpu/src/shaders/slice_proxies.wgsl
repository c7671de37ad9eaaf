// What slices are drawn as: the polygons in which they cut boxes, all boxes and slices in one draw (3.5-3).
#import pellucid::slices::{slices, boxes}
#import pellucid::polygon::polygon_corner

struct Corner {
    @builtin(position) position: vec4<f32>,
    @location(0) @interpolate(flat) box: u32,
    @location(1) @interpolate(flat) slice: u32,
}

#ifdef GIVEN
// Six corners a polygon, of which the first two tell box and slice.
@group(0) @binding(11) var<storage, read> instances: array<vec4<f32>>;
#else
// Box and slice.
@group(0) @binding(11) var<storage, read> instances: array<vec2<u32>>;
#endif
// Which boxes may be seen.
@group(0) @binding(12) var<storage, read> visible: array<u32>;

// Outside of what is drawn.
const NOWHERE: vec4<f32> = vec4<f32>(0.0, 0.0, 2.0, 1.0);

fn projected(p: vec3<f32>) -> vec4<f32> {
    let v = vec4<f32>(p, 1.0);
    let w = dot(slices.clip_w, v);
    return vec4<f32>(dot(slices.clip_x, v), dot(slices.clip_y, v), 0.5 * w, w);
}

#ifdef GIVEN
@vertex
fn vertex(@builtin(vertex_index) corner: u32, @builtin(instance_index) instance: u32) -> Corner {
    let box = u32(instances[6u * instance].w);
    let slice = u32(instances[6u * instance + 1u].w);
    var position = NOWHERE;
    if visible[box] != 0u {
        position = projected(instances[6u * instance + corner].xyz);
    }
    return Corner(position, box, slice);
}
#else
fn low_of(box: u32) -> vec3<f32> {
    return vec3<f32>(boxes[box].low.xyz) - slices.margin.xyz;
}

fn high_of(box: u32) -> vec3<f32> {
    return vec3<f32>(boxes[box].high.xyz) + slices.margin.xyz;
}

#ifdef SHELLS
// Shells are drawn as the far faces of their box: a ray meets the box where it meets one of those.
@vertex
fn vertex(@builtin(vertex_index) number: u32, @builtin(instance_index) instance: u32) -> Corner {
    let box = instances[instance].x;
    let slice = instances[instance].y;
    let low = low_of(box);
    let high = high_of(box);
    let axis = number / 8u;
    let upper = (number / 4u) % 2u == 1u;
    let corner = number % 4u;
    let far = select(slices.eye[axis] >= low[axis], slices.eye[axis] <= high[axis], upper);
    if !far || visible[box] == 0u {
        return Corner(NOWHERE, box, slice);
    }
    var p = vec3<f32>(0.0);
    p[axis] = select(low[axis], high[axis], upper);
    let u = (axis + 1u) % 3u;
    let v = (axis + 2u) % 3u;
    p[u] = select(low[u], high[u], corner == 1u || corner == 2u);
    p[v] = select(low[v], high[v], corner >= 2u);
    return Corner(projected(p), box, slice);
}
#else
@vertex
fn vertex(@builtin(vertex_index) corner: u32, @builtin(instance_index) instance: u32) -> Corner {
    let box = instances[instance].x;
    let slice = instances[instance].y;
    let plane = slices.plane - vec4<f32>(0.0, 0.0, 0.0, f32(slice * slices.counts.x) + slices.margin.w);
    let p = polygon_corner(low_of(box), high_of(box), plane, corner);
    if p.w == 0.0 || visible[box] == 0u {
        return Corner(NOWHERE, box, slice);
    }
    return Corner(projected(p.xyz), box, slice);
}
#endif
#endif

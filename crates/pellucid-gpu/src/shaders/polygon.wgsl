// The polygon in which a plane cuts a box: three to six corners, one on each of six paths along the box's edges
// (3.5-2).
#define_import_path pellucid::polygon

// The edges on which each corner is looked for in turn, as pairs of the box's corners; the first one is the
// nearest and 7 the farthest.
var<private> EDGES: array<vec2<u32>, 24> = array<vec2<u32>, 24>(
    vec2(0u, 1u), vec2(1u, 4u), vec2(4u, 7u), vec2(4u, 7u),
    vec2(1u, 5u), vec2(0u, 1u), vec2(1u, 4u), vec2(4u, 7u),
    vec2(0u, 2u), vec2(2u, 5u), vec2(5u, 7u), vec2(5u, 7u),
    vec2(2u, 6u), vec2(0u, 2u), vec2(2u, 5u), vec2(5u, 7u),
    vec2(0u, 3u), vec2(3u, 6u), vec2(6u, 7u), vec2(6u, 7u),
    vec2(3u, 4u), vec2(0u, 3u), vec2(3u, 6u), vec2(6u, 7u),
);
// The axes along which a corner is away from the nearest, a bit each.
var<private> OFFSETS: array<u32, 8> = array<u32, 8>(0u, 1u, 4u, 2u, 3u, 5u, 6u, 7u);

fn box_corner(low: vec3<f32>, high: vec3<f32>, nearest: u32, number: u32) -> vec3<f32> {
    var offset = OFFSETS[number];
    if countOneBits(nearest) % 2u == 1u {
        // Mirrored boxes keep their winding.
        offset = (offset & 1u) | ((offset & 2u) << 1u) | ((offset & 4u) >> 1u);
    }
    let bits = nearest ^ offset;
    return select(low, high, (vec3<u32>(bits) & vec3<u32>(1u, 2u, 4u)) != vec3<u32>(0u));
}

// Corner 0 to 5 of the polygon where `dot(plane.xyz, p) + plane.w` is 0, in `xyz`; `w` is 0 if the plane does not
// meet the box. Polygons of fewer corners have some of them twice.
fn polygon_corner(low: vec3<f32>, high: vec3<f32>, plane: vec4<f32>, corner: u32) -> vec4<f32> {
    let bits = select(vec3<u32>(0u), vec3<u32>(1u, 2u, 4u), plane.xyz < vec3<f32>(0.0));
    let nearest = bits.x | bits.y | bits.z;
    for (var i = 0u; i < 4u; i += 1u) {
        let edge = EDGES[4u * corner + i];
        let start = box_corner(low, high, nearest, edge.x);
        let end = box_corner(low, high, nearest, edge.y);
        // Heights and not their difference decide, so that edges that meet agree about their common corner.
        let below = dot(plane.xyz, start) + plane.w;
        let above = dot(plane.xyz, end) + plane.w;
        if below <= 0.0 && above >= 0.0 && above > below {
            return vec4<f32>(mix(start, end, -below / (above - below)), 1.0);
        }
    }
    return vec4<f32>(0.0);
}

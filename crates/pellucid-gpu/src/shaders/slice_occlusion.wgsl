// Which boxes may still be seen: those with a pixel in front of them that is not done (8.5-1).
#import pellucid::frame::{frame, bounds}
#import pellucid::slices::{slices, boxes}

@group(0) @binding(15) var<storage, read_write> tiles: array<f32>;
@group(0) @binding(16) var<storage, read_write> visible: array<u32>;

const SIDE: f32 = 16.0;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= arrayLength(&boxes) || visible[id.x] == 0u {
        return;
    }
    let low = vec3<f32>(boxes[id.x].low.xyz) - slices.margin.xyz;
    let high = vec3<f32>(boxes[id.x].high.xyz) + slices.margin.xyz;
    let size = vec2<u32>(frame.size.x, bounds.rows.count);
    let count = (size + u32(SIDE) - 1u) / u32(SIDE);
    var least = vec2<f32>(1e9);
    var most = vec2<f32>(-1e9);
    for (var corner = 0u; corner < 8u; corner += 1u) {
        let is_high = (vec3<u32>(corner) & vec3<u32>(1u, 2u, 4u)) != vec3<u32>(0u);
        let p = vec4<f32>(select(low, high, is_high), 1.0);
        let w = dot(slices.clip_w, p);
        if w <= 0.0 {
            // The eye is among its corners.
            return;
        }
        let at = vec2<f32>(dot(slices.clip_x, p), -dot(slices.clip_y, p)) / w;
        let pixel = (at * 0.5 + 0.5) * vec2<f32>(size);
        least = min(least, pixel);
        most = max(most, pixel);
    }
    let last = vec2<f32>(count - 1u);
    let from_tile = vec2<u32>(clamp(floor(least / SIDE), vec2<f32>(0.0), last));
    let to_tile = vec2<u32>(clamp(floor(most / SIDE), vec2<f32>(0.0), last));
    for (var y = from_tile.y; y <= to_tile.y; y += 1u) {
        for (var x = from_tile.x; x <= to_tile.x; x += 1u) {
            if tiles[y * count.x + x] < slices.strides.w {
                return;
            }
        }
    }
    visible[id.x] = 0u;
}

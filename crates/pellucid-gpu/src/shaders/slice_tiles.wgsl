// The least opacity of every square of pixels: what boxes are compared with (8.5-1).
#import pellucid::frame::{frame, bounds}

@group(0) @binding(13) var colors: texture_2d<f32>;
@group(0) @binding(15) var<storage, read_write> tiles: array<f32>;

const SIDE: u32 = 16u;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let size = vec2<u32>(frame.size.x, bounds.rows.count);
    let count = (size + SIDE - 1u) / SIDE;
    if any(id.xy >= count) {
        return;
    }
    let low = id.xy * SIDE;
    let high = min(low + SIDE, size);
    var least = 1.0;
    for (var y = low.y; y < high.y; y += 1u) {
        for (var x = low.x; x < high.x; x += 1u) {
            least = min(least, textureLoad(colors, vec2<u32>(x, y), 0).a);
        }
    }
    tiles[id.y * count.x + id.x] = least;
}

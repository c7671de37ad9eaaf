// The surfaces of several volumes in the order in which a ray meets them.
#define_import_path pellucid::ahead

#import pellucid::count::COUNT
#import pellucid::cursor::Cursor
#import pellucid::each_hit::first_hit

// How far the ray was followed in each volume.
var<private> cursors: array<Cursor, COUNT>;

// Looks for the first surface in each, between two distances in steps from the eye.
fn look_ahead(pixel: vec2<u32>, sub: u32, reach: vec2<f32>) {
    for (var i = 0u; i < COUNT; i += 1u) {
        cursors[i] = first_hit(i, pixel, sub, reach);
    }
}

// The volume whose surface is ahead.
fn nearest() -> u32 {
    var found = 0u;
    for (var i = 1u; i < COUNT; i += 1u) {
        if cursors[i].ahead < cursors[found].ahead {
            found = i;
        }
    }
    return found;
}

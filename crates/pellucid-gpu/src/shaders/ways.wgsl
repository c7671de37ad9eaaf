// Several volumes along a ray: where it is in each of them, and what they send of a piece of it. Distances count from where
// it enters the first.
#define_import_path pellucid::ways

#import pellucid::way::Way
#import pellucid::count::COUNT
#import pellucid::each::{clear, element, way_of}

// Nodes and borders that are less apart are one, in steps: positions are rounded by about as much.
const CLOSE: f32 = 1e-4;
const FAR: f32 = 1e30;

var<private> ways: array<Way, COUNT>;
// Where the ray enters the first volume, as ways count, and how far from there it leaves the last.
var<private> begin: f32;
var<private> whole: f32;

fn find_ways(at: vec2<f32>) {
    begin = FAR;
    var end = -FAR;
    for (var i = 0u; i < COUNT; i += 1u) {
        ways[i] = way_of(i, at);
        if ways[i].ends.x < ways[i].ends.y {
            begin = min(begin, ways[i].ends.x);
            end = max(end, ways[i].ends.y);
        }
    }
    whole = end - begin;
}

// The distance up to which one look at the blocks finds nothing; below a distance that stays.
fn clear_until(distance: f32) -> f32 {
    var free = FAR;
    for (var i = 0u; i < COUNT; i += 1u) {
        let ends = ways[i].ends - begin;
        if distance < ends.x && ends.x < ends.y {
            free = min(free, ends.x);
        } else if distance < ends.y {
            free = min(free, distance + clear(i, ways[i], distance + begin));
        }
    }
    // A ray that has left all volumes, or passes between two.
    return min(free, whole);
}

// Where the piece ends that begins at a distance: at the next node, or the border of a volume before it.
fn end_of(distance: f32, node: f32) -> f32 {
    let beyond = distance + CLOSE;
    var end = node;
    for (var i = 0u; i < COUNT; i += 1u) {
        for (var side = 0u; side < 2u; side += 1u) {
            let border = ways[i].ends[side] - begin;
            if border > beyond && border < end - CLOSE {
                end = border;
            }
        }
    }
    return end;
}

fn is_in(way: Way, ends: vec2<f32>) -> bool {
    let middle = (ends.x + ends.y) * 0.5;
    return middle > way.ends.x && middle < way.ends.y;
}

// What volumes send of a piece, behind an opacity; nothing where they are not.
fn each_of(ends: vec2<f32>, jitter: f32, front: f32) -> array<vec4<f32>, COUNT> {
    var elements: array<vec4<f32>, COUNT>;
    for (var i = 0u; i < COUNT; i += 1u) {
        if is_in(ways[i], ends + begin) {
            elements[i] = element(i, ways[i], ends + begin, jitter, front);
        }
    }
    return elements;
}

// Several volumes along rays, on one lattice that begins where a ray enters the first of them: as `ways.rs` of the CPU
// backend. Its pieces end at its nodes and at the borders of volumes, so that every volume is covered exactly.
#import pellucid::of0::frame::{frame, bounds}
#import pellucid::of0::ray::{jitter_of, place_of}
#import pellucid::of0::march::{Turn, begin_turn, end_turn, DONE, HIT, NOWHERE, TERMINATED}
#import pellucid::of0::table::over
#import pellucid::way::Way
#import pellucid::count::COUNT
#import pellucid::each::{clear, element, normal, way_of}
#import pellucid::merge::{densest, merged}

// How many pieces are looked at between two looks at the blocks.
const RUN: u32 = 8u;
// Nodes and borders that are less apart are one, in steps: positions are rounded by about as much.
const CLOSE: f32 = 1e-4;
const FAR: f32 = 1e30;

var<private> ways: array<Way, COUNT>;
// Where the lattice begins, and how long it is.
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

// The last node that a look at the blocks leads to without passing anything; below a distance that stays.
fn clear_node(distance: f32) -> f32 {
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
    return floor(min(free, whole));
}

// The last node before which nothing can be seen, or the distance itself.
fn leap(from_distance: f32) -> f32 {
    var distance = from_distance;
    var node = clear_node(distance);
    while node > distance {
        distance = node;
        node = clear_node(distance);
    }
    return distance;
}

// Where the piece ends that begins at a distance: at the next node, or the border of a volume before it.
fn end_of(distance: f32) -> f32 {
    let beyond = distance + CLOSE;
    var end = floor(beyond) + 1.0;
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

// What volumes send of a piece; nothing where they are not.
fn each_of(ends: vec2<f32>, jitter: f32) -> array<vec4<f32>, COUNT> {
    var elements: array<vec4<f32>, COUNT>;
    for (var i = 0u; i < COUNT; i += 1u) {
        if is_in(ways[i], ends) {
            elements[i] = element(i, ways[i], ends, jitter);
        }
    }
    return elements;
}

fn follow(turn: ptr<function, Turn>, jitter: f32) {
    var state = (*turn).state;
    var distance = state.place.x;
    var looks = bounds.most_looks;
    // The volume whose surface a ray meets.
    var met = 0u;
    while looks > 0u && distance + CLOSE < whole {
        looks -= 1u;
        let to = leap(distance);
        state.counts.z += u32(min(to, whole) - distance);
        distance = to;
        for (var i = 0u; i < RUN && distance + CLOSE < whole; i += 1u) {
            let ends = vec2<f32>(distance, end_of(distance));
            distance = ends.y;
            state.counts.x += 1u;
            var elements = each_of(ends + begin, jitter);
            let rgba = merged(&elements);
            if rgba.a <= 0.0 {
                continue;
            }
            state.counts.y += 1u;
            state.color = over(state.color, rgba);
            if state.color.a >= 0.5 && state.surface.w == NOWHERE {
                state.surface.w = begin + ends.x + jitter * (ends.y - ends.x);
                met = densest(&elements);
            }
            if state.color.a >= frame.limits.z {
                state.counts.w |= TERMINATED | DONE;
                looks = 0u;
                break;
            }
        }
    }
    if state.surface.w < NOWHERE && (*turn).state.surface.w == NOWHERE {
        state.surface = vec4<f32>(normal(met, ways[met], state.surface.w), state.surface.w);
    }
    state.place.x = distance;
    if !(distance + CLOSE < whole) {
        state.counts.w |= DONE;
    }
    (*turn).state = state;
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    var turn = begin_turn(id.xy);
    if turn.open {
        find_ways(place_of(turn.pixel, bounds.rows.ray));
        if whole > 0.0 {
            turn.state.counts.w |= HIT;
        }
        follow(&turn, jitter_of(turn.pixel, bounds.rows.ray));
        end_turn(turn);
    }
}

// What a ray has found so far, and how passes take turns at it: a ray may be followed over several
// passes, each for so many looks at the blocks, or for the samples of one brick (7.4-1).
#define_import_path pellucid::march

#import pellucid::frame::{frame, bounds}
#import pellucid::ray::{Ray, ray_of}

struct State {
    // Associated linear RGBA.
    color: vec4<f32>,
    // Unit world normal, and the depth in steps, FAR where nothing was met.
    surface: vec4<f32>,
    // Next sample or node; the rest is the walk's or the mode's.
    place: vec4<f32>,
    // Samples taken, seen, leapt over; flags.
    counts: vec4<u32>,
}

const HIT: u32 = 1u;
const TERMINATED: u32 = 2u;
const DONE: u32 = 4u;
// No value yet: below all values.
const FIRST: f32 = -3.4028234e38;
const NOWHERE: f32 = 1e30;

@group(0) @binding(5) var<storage, read_write> states: array<State>;

fn new_state() -> State {
    return State(vec4<f32>(0.0), vec4<f32>(0.0, 0.0, 0.0, NOWHERE), vec4<f32>(0.0, FIRST, 0.0, 0.0), vec4<u32>(0u));
}

// A ray whose turn it is.
struct Turn {
    ray: Ray,
    state: State,
    slot: u32,
    // Whether there is anything to do.
    open: bool,
}

// The ray of an invocation.
fn turn_of(id: vec2<u32>) -> Turn {
    var turn: Turn;
    turn.open = false;
    if id.x >= frame.size.x || id.y >= bounds.rows.y {
        return turn;
    }
    turn.slot = id.y * frame.size.x + id.x;
    if bounds.texture_low.w != 0u {
        turn.state = new_state();
    } else {
        turn.state = states[turn.slot];
        if (turn.state.counts.w & DONE) != 0u {
            return turn;
        }
    }
    turn.ray = ray_of(vec2<u32>(id.x, id.y + bounds.rows.x), bounds.rows.z);
    turn.open = true;
    if turn.ray.count > 0.0 {
        turn.state.counts.w |= HIT;
    }
    return turn;
}

// Writes a ray's state down.
fn end_turn(turn: Turn) {
    states[turn.slot] = turn.state;
}

// What a ray has found so far, and how passes take turns at it: a ray may be followed over several
// passes, each for so many looks at the blocks, or for the samples of one brick (7.4-1).
#define_import_path pellucid::march

#import pellucid::frame::{frame, bounds}
#import pellucid::ray::{Ray, ray_of}
#ifdef APART
#import pellucid::ray::{beam_of, place_of}
#endif

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

#ifdef WAVEFRONT
// The rays that are not done, in two lists: a pass reads one and writes the other, so that no invocation
// is spent on a ray that has ended (7.4-1).
struct Front {
    // Rays in each list.
    counts: array<atomic<u32>, 4>,
    // One list after the other, each as long as there are rays.
    slots: array<u32>,
}

@group(0) @binding(8) var<storage, read_write> front: Front;
#endif

// A ray whose turn it is.
struct Turn {
    ray: Ray,
    state: State,
    pixel: vec2<u32>,
    slot: u32,
    // Whether there is anything to do.
    open: bool,
}

// The ray of an invocation.
fn turn_of(id: vec2<u32>) -> Turn {
    var turn = begin_turn(id);
    if turn.open {
        turn.ray = ray_of(turn.pixel, bounds.rows.ray);
        if turn.ray.count > 0.0 {
            turn.state.counts.w |= HIT;
        }
    }
    return turn;
}

// Whose turn it is, and what was found so far.
fn begin_turn(id: vec2<u32>) -> Turn {
    var turn: Turn;
    turn.open = false;
    let is_first = bounds.rows.begin != 0u;
    var pixel = id;
#ifdef WAVEFRONT
    if !is_first {
        // Workgroups of 8 x 8 in one row.
        let number = (id.x / 8u) * 64u + id.y * 8u + id.x % 8u;
        let list = bounds.list;
        if number >= atomicLoad(&front.counts[list]) {
            return turn;
        }
        let slot = front.slots[list * bounds.list_length + number];
        pixel = vec2<u32>(slot % frame.size.x, slot / frame.size.x);
    }
#endif
    if pixel.x >= frame.size.x || pixel.y >= bounds.rows.count {
        return turn;
    }
    turn.slot = pixel.y * frame.size.x + pixel.x;
    if is_first {
        turn.state = new_state();
    } else {
        turn.state = states[turn.slot];
        if (turn.state.counts.w & DONE) != 0u {
            return turn;
        }
    }
    turn.pixel = pixel + vec2<u32>(frame.size.y, bounds.rows.first);
    turn.open = true;
    return turn;
}

// Writes a ray's state down.
fn end_turn(turn: Turn) {
    states[turn.slot] = turn.state;
#ifdef APART
    if (turn.state.counts.w & DONE) != 0u && turn.state.surface.w < NOWHERE {
        // As the rays of all volumes count: from a plane that they have in common.
        states[turn.slot].surface.w += turn.ray.entry - beam_of(place_of(turn.pixel, bounds.rows.ray)).to_base;
    }
#endif
#ifdef WAVEFRONT
    if (turn.state.counts.w & DONE) == 0u {
        let list = 1u - bounds.list;
        front.slots[list * bounds.list_length + atomicAdd(&front.counts[list], 1u)] = turn.slot;
    }
#endif
}

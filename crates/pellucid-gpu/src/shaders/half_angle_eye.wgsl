// The eye looks at a run of slabs in the light that has come to each (Eq. 6.9, 6.10, K-05).
#import pellucid::constants::load_constants
#import pellucid::frame::{frame, bounds}
#import pellucid::line::{Lines, clear_slabs, lines_of}
#import pellucid::look::look
#import pellucid::march::{begin_turn, states, HIT}
#import pellucid::table::over

// The first slab from one on whose sample may contribute, or the end.
fn leap(lines: ptr<function, Lines>, first: u32, end: u32) -> u32 {
    var slab = first;
    while slab < end {
        let clear = clear_slabs(lines, f32(slab));
        if clear == 0.0 {
            break;
        }
        slab += u32(min(clear, 1e6));
    }
    return min(slab, end);
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    load_constants();
    // How many slabs are looked at between two looks at the blocks.
    const RUN: u32 = 4u;
    var turn = begin_turn(id.xy);
    if !turn.open {
        return;
    }
    var lines = lines_of(turn.pixel);
    if lines.is_met {
        turn.state.counts.w |= HIT;
    }
    let is_first = bounds.rows.begin != 0u;
    // A new state, and one that another sweep has left, has another use of it.
    var color = select(turn.state.place, vec4<f32>(0.0), bounds.begin_sweep != 0u);
    var counts = turn.state.counts;
    let end = min(bounds.run.end, u32(max(ceil(lines.ends.y), 0.0)));
    var slab = max(bounds.run.first, u32(max(lines.ends.x, 0.0)));
    while slab < end && (lines.is_backward || color.a < frame.limits.z) {
        let next = leap(&lines, slab, end);
        counts.z += next - slab;
        slab = next;
        for (var i = 0u; i < RUN && slab < end; i += 1u) {
            let found = look(&lines, slab, lines.is_backward || color.a < frame.limits.z);
            counts.x += select(0u, 1u, found.is_met);
            if found.is_seen {
                counts.y += 1u;
                // In front of what is there (over), or behind it (under).
                let front = select(color, found.color, lines.is_backward);
                let behind = select(found.color, color, lines.is_backward);
                color = over(front, behind);
            }
            slab += 1u;
        }
    }
    if is_first {
        states[turn.slot] = turn.state;
    }
    // Of all others nothing else has changed.
    states[turn.slot].place = color;
    states[turn.slot].counts = counts;
}

// Rays as they cross slabs, of the light and of the eye, and what they pass there: the same in all volumes.
#define_import_path pellucid::passage

#import pellucid::way::Way

// Less of a slab is lost in the rounding of coordinates.
const SHORTEST: f32 = 1e-6;

// A ray as it crosses slabs, in the order of their numbers.
struct Crossing {
    // Voxels at coordinate 0 of the slabs, and per slab.
    origin: vec3<f32>,
    direction: vec3<f32>,
    // Coordinates between which it is in the field.
    ends: vec2<f32>,
    // Steps per slab.
    stretch: f32,
    // Where in a segment its sample lies.
    jitter: f32,
}

// A ray of the eye.
struct Line {
    way: Way,
    crossing: Crossing,
    // Whether it meets the last slabs first.
    is_backward: bool,
}

// What a ray passes of a slab, or of a piece of it.
struct Passage {
    // Coordinate of the sample, its position in voxels, and the segment's length in steps; 0 if there is none.
    place: f32,
    position: vec3<f32>,
    ratio: f32,
}

// What is there: its value, and its associated colour and opacity for one step. Nothing if it has no opacity.
struct Matter {
    value: f32,
    color: vec4<f32>,
}

// Shares of direct light, and of each colour of indirect light.
struct Shares {
    direct: f32,
    indirect: vec3<f32>,
}

// What the eye sees of a slab.
struct Look {
    // What is seen, if anything is.
    color: vec4<f32>,
    is_seen: bool,
    // Whether there is a sample.
    is_met: bool,
}

fn passage_of(crossing: Crossing, slab: f32) -> Passage {
    return passage_between(crossing, vec2<f32>(slab, slab + 1.0));
}

// What it passes between two coordinates of a slab.
fn passage_between(crossing: Crossing, ends: vec2<f32>) -> Passage {
    let enter = max(ends.x, crossing.ends.x);
    let leave = min(ends.y, crossing.ends.y);
    let length = max(leave - enter, 0.0);
    let place = min(enter, crossing.ends.y) + crossing.jitter * length;
    let position = crossing.origin + crossing.direction * place;
    return Passage(place, position, select(0.0, length * crossing.stretch, length > SHORTEST));
}

// How many steps a ray of the eye has gone from its entry to a coordinate.
fn steps_to(line: Line, place: f32) -> f32 {
    let ends = line.crossing.ends;
    return select(place - ends.x, ends.y - place, line.is_backward) * line.crossing.stretch;
}

// What is held back of light that passes both of two.
fn joined(a: Shares, b: Shares) -> Shares {
    return Shares(a.direct + (b.direct - a.direct * b.direct), a.indirect + (b.indirect - a.indirect * b.indirect));
}

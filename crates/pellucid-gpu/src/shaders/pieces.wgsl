// The walk over the pieces of rays between planes of voxels, on each of which the field is smooth, and what is
// largest there: as `cells.rs`, `knots.rs` and `trilinear.rs` of the CPU backend have it.
#define_import_path pellucid::pieces

#import pellucid::frame::frame
#import pellucid::ray::{Ray, ray_at, ray_length}
#import pellucid::field::{ABSENT, cell_of, data_value, field_value, inside_grid, is_present, last_voxel, stored_voxel, voxel_or}
#ifdef KERNELS
#import pellucid::kernel::kernels
#endif
#ifdef PERTURBED
#import pellucid::noise::displaces
#endif

// No value: below all values.
const NONE: f32 = -3.4028234e38;

struct Cells {
    // The ray's entry and its way of a step, counted in cells.
    origin: vec3<f32>,
    direction: vec3<f32>,
    inverse: vec3<f32>,
    // 1 along axes on which the ray ascends, else 0.
    ascends: vec3<f32>,
    cell: vec3<f32>,
    // Distances of the piece's ends, in steps.
    ends: vec2<f32>,
    // Distance of the ray's exit.
    length: f32,
}

// Whether the field is that of nearest voxels, which change half way between them.
fn is_of_nearest() -> bool {
#ifdef PERTURBED
    if displaces() {
        return false;
    }
#endif
#ifdef KERNELS
    return kernels.taps.x == 0u;
#else
    return false;
#endif
}

// The piece of a ray at a distance.
fn cells_at(ray: Ray, distance: f32) -> Cells {
    var per_voxel = 1.0;
    var shift = 0.0;
#ifdef HOLES
    // The nearest voxel stands for absent ones.
    per_voxel = 2.0;
#endif
    if is_of_nearest() {
        per_voxel = 1.0;
        shift = 0.5;
    }
    var cells: Cells;
    cells.origin = ray.origin * per_voxel + shift;
    cells.direction = ray.direction * per_voxel;
    cells.inverse = ray.inverse / per_voxel;
    cells.ascends = select(vec3<f32>(0.0), vec3<f32>(1.0), ray.inverse > vec3<f32>(0.0));
    cells.cell = floor(cells.origin + cells.direction * distance);
    cells.length = select(-1.0, ray_length(ray), ray.count > 0.0);
    meet_cell(&cells);
    return cells;
}

fn exits_of(cells: ptr<function, Cells>) -> vec3<f32> {
    return ((*cells).cell + (*cells).ascends - (*cells).origin) * (*cells).inverse;
}

// Where the piece lies between the planes around it.
fn meet_cell(cells: ptr<function, Cells>) {
    let entries = ((*cells).cell + 1.0 - (*cells).ascends - (*cells).origin) * (*cells).inverse;
    let exits = exits_of(cells);
    let start = max(max(entries.x, entries.y), max(entries.z, 0.0));
    let end = min(min(exits.x, exits.y), min(exits.z, (*cells).length));
    (*cells).ends = vec2<f32>(start, max(end, start));
}

fn next_cell(cells: ptr<function, Cells>) {
    let exits = exits_of(cells);
    let next = min(exits.x, min(exits.y, exits.z));
    let way = select(vec3<f32>(0.0), (*cells).ascends * 2.0 - 1.0, exits <= vec3<f32>(next));
    (*cells).cell += way;
    meet_cell(cells);
}

// The cell at a distance ahead; never back, wherever rounding puts it.
fn leap_to(cells: ptr<function, Cells>, distance: f32) {
    let there = floor((*cells).origin + (*cells).direction * distance);
    let cell = (*cells).cell;
    (*cells).cell = select(min(there, cell), max(there, cell), (*cells).ascends > vec3<f32>(0.0));
    meet_cell(cells);
}

// The polynomial `p (1 - u) + q u`, where `u` is `start + way t`; lowest coefficient first.
fn between_two(p: vec4<f32>, q: vec4<f32>, start: f32, way: f32) -> vec4<f32> {
    let step = q - p;
    return p + start * step + way * vec4<f32>(0.0, step.xyz);
}

fn polynomial(c: vec4<f32>, t: f32) -> f32 {
    return ((c.w * t + c.z) * t + c.y) * t + c.x;
}

// Where the slope of a cubic is 0; there may be fewer such places.
fn turns_of(c: vec4<f32>) -> vec2<f32> {
    let square = c.z * c.z - 3.0 * c.w * c.y;
    if square < 0.0 {
        return vec2<f32>(-1.0);
    }
    let root = sqrt(square);
    let sum = select(-root - c.z, root - c.z, c.z < 0.0);
    let first = select(-1.0, sum / (3.0 * c.w), c.w != 0.0);
    let second = select(-1.0, c.y / sum, sum != 0.0);
    return vec2<f32>(first, second);
}

fn larger(a: vec2<f32>, b: vec2<f32>) -> vec2<f32> {
    return select(a, b, b.x > a.x);
}

// The stored voxels around a piece: those below and above along x, at (y, z) fastest along y; those that are absent have
// the value of the nearest.
struct Edges {
    voxel: vec3<f32>,
    low: vec4<f32>,
    high: vec4<f32>,
    is_there: bool,
}

fn edges_around(start: vec3<f32>, end: vec3<f32>) -> Edges {
    let middle = inside_grid((start + end) * 0.5);
    let a = cell_of(middle);
    let b = min(a + 1, last_voxel());
    var nearest = 0.0;
#ifdef HOLES
    nearest = stored_voxel(min(vec3<i32>(floor(middle + 0.5)), last_voxel()));
    if !is_present(nearest) {
        return Edges(vec3<f32>(a), vec4<f32>(0.0), vec4<f32>(0.0), false);
    }
#endif
    let low = vec4<f32>(
        voxel_or(a, nearest),
        voxel_or(vec3<i32>(a.x, b.y, a.z), nearest),
        voxel_or(vec3<i32>(a.x, a.y, b.z), nearest),
        voxel_or(vec3<i32>(a.x, b.y, b.z), nearest),
    );
    let high = vec4<f32>(
        voxel_or(vec3<i32>(b.x, a.y, a.z), nearest),
        voxel_or(vec3<i32>(b.x, b.y, a.z), nearest),
        voxel_or(vec3<i32>(b.x, a.y, b.z), nearest),
        voxel_or(b, nearest),
    );
    return Edges(vec3<f32>(a), low, high, true);
}

// The interpolation along a piece, a cubic in the part of the way; lowest coefficient first.
fn cubic_along(edges: Edges, start: vec3<f32>, end: vec3<f32>) -> vec4<f32> {
    let from_u = clamp(start - edges.voxel, vec3<f32>(0.0), vec3<f32>(1.0));
    let way = clamp(end - edges.voxel, vec3<f32>(0.0), vec3<f32>(1.0)) - from_u;
    let constant = edges.low + from_u.x * (edges.high - edges.low);
    let linear = way.x * (edges.high - edges.low);
    let nought = vec2<f32>(0.0);
    let near = between_two(vec4<f32>(constant.x, linear.x, nought), vec4<f32>(constant.y, linear.y, nought), from_u.y, way.y);
    let far = between_two(vec4<f32>(constant.z, linear.z, nought), vec4<f32>(constant.w, linear.w, nought), from_u.y, way.y);
    return between_two(near, far, from_u.z, way.z);
}

fn largest_of(v: vec4<f32>) -> f32 {
    return max(max(v.x, v.y), max(v.z, v.w));
}

// The largest value of the cubic along a piece is known; none is more than the largest voxel.
fn highest_between_voxels(start: vec3<f32>, end: vec3<f32>, sign: f32, above: f32) -> vec2<f32> {
    var edges = edges_around(start, end);
    if !edges.is_there {
        return vec2<f32>(NONE, 0.0);
    }
    if sign * frame.values.x < 0.0 {
        edges.low = -edges.low;
        edges.high = -edges.high;
    }
    let scale = abs(frame.values.x);
    let shift = sign * frame.values.y;
    let top = largest_of(max(edges.low, edges.high));
    if top * scale + shift <= above {
        return vec2<f32>(NONE, 0.0);
    }
    let cubic = cubic_along(edges, start, end);
    var best = larger(vec2<f32>(cubic.x, 0.0), vec2<f32>(polynomial(cubic, 1.0), 1.0));
    let turns = turns_of(cubic);
    for (var i = 0; i < 2; i += 1) {
        let t = turns[i];
        if t > 0.0 && t < 1.0 {
            best = larger(best, vec2<f32>(polynomial(cubic, t), t));
        }
    }
    return vec2<f32>(min(best.x, top) * scale + shift, best.y);
}

// What is known of the field on a piece.
struct Course {
    // Whether it may pass a range of values, and how it does.
    passes: bool,
    cubic: vec4<f32>,
    // Any of its values; ABSENT where there is none.
    value: f32,
}

fn course_between_voxels(start: vec3<f32>, end: vec3<f32>, low: f32, high: f32) -> Course {
    let edges = edges_around(start, end);
    if !edges.is_there {
        return Course(false, vec4<f32>(0.0), ABSENT);
    }
    let stored = vec2<f32>(-largest_of(max(-edges.low, -edges.high)), largest_of(max(edges.low, edges.high)));
    let values = stored * frame.values.x + frame.values.y;
    if min(values.x, values.y) > high || max(values.x, values.y) < low {
        return Course(false, vec4<f32>(0.0), values.x);
    }
    let cubic = cubic_along(edges, start, end) * frame.values.x;
    return Course(true, cubic + vec4<f32>(frame.values.y, 0.0, 0.0, 0.0), values.x);
}

fn look(start: vec3<f32>, way: vec3<f32>, part: f32, sign: f32) -> vec2<f32> {
    let value = field_value(start + way * part);
    return vec2<f32>(select(NONE, value * sign, is_present(value)), part);
}

// The largest of the values of a piece times a sign, and which part of the way it is on: of four looks, and where the
// cubic through these is largest.
fn highest_sampled(start: vec3<f32>, end: vec3<f32>, sign: f32) -> vec2<f32> {
    let way = end - start;
    if is_of_nearest() {
        return look(start, way, 0.5, sign);
    }
    var first = 0.0;
#ifdef HOLES
    // A voxel that is absent ends the field: rounding must not decide on which side a look is.
    first = 1e-3;
#endif
    let third = (1.0 - 2.0 * first) / 3.0;
    let a = look(start, way, first, sign);
    let b = look(start, way, first + third, sign);
    let c = look(start, way, first + third * 2.0, sign);
    let d = look(start, way, first + third * 3.0, sign);
    var best = larger(larger(a, b), larger(c, d));
    if min(min(a.x, b.x), min(c.x, d.x)) == NONE {
        return best;
    }
    // Newton's differences, and from them the powers.
    let one = b.x - a.x;
    let two = (c.x - b.x) - one;
    let three = ((d.x - c.x) - (c.x - b.x)) - two;
    let cubed = three / 6.0;
    let squared = two * 0.5 - cubed * 3.0;
    let turns = turns_of(vec4<f32>(a.x, one - squared - cubed, squared, cubed));
    for (var i = 0; i < 2; i += 1) {
        let place = turns[i];
        if place > 0.0 && place < 3.0 {
            best = larger(best, look(start, way, first + third * place, sign));
        }
    }
    return best;
}

// The largest of the values between two positions of one piece, times a sign, and the part of the way.
fn highest(start: vec3<f32>, end: vec3<f32>, sign: f32, above: f32) -> vec2<f32> {
    var is_trilinear = true;
#ifdef KERNELS
    is_trilinear = kernels.taps.x == 2u;
#endif
#ifdef PERTURBED
    is_trilinear = is_trilinear && !displaces();
#endif
    if is_trilinear {
        return highest_between_voxels(start, end, sign, above);
    }
    return highest_sampled(start, end, sign);
}

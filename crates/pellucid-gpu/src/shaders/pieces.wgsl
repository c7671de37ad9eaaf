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

// Along a ray the interpolation in a cell is a cubic, whose largest value is known; none is more than the largest
// voxel.
fn highest_between_voxels(start: vec3<f32>, end: vec3<f32>, sign: f32, above: f32) -> vec2<f32> {
    let middle = inside_grid((start + end) * 0.5);
    let a = cell_of(middle);
    let b = min(a + 1, last_voxel());
    var nearest = 0.0;
#ifdef HOLES
    nearest = stored_voxel(min(vec3<i32>(floor(middle + 0.5)), last_voxel()));
    if !is_present(nearest) {
        return vec2<f32>(NONE, 0.0);
    }
#endif
    var low = vec4<f32>(
        voxel_or(a, nearest),
        voxel_or(vec3<i32>(a.x, b.y, a.z), nearest),
        voxel_or(vec3<i32>(a.x, a.y, b.z), nearest),
        voxel_or(vec3<i32>(a.x, b.y, b.z), nearest),
    );
    var high = vec4<f32>(
        voxel_or(vec3<i32>(b.x, a.y, a.z), nearest),
        voxel_or(vec3<i32>(b.x, b.y, a.z), nearest),
        voxel_or(vec3<i32>(b.x, a.y, b.z), nearest),
        voxel_or(b, nearest),
    );
    if sign * frame.values.x < 0.0 {
        low = -low;
        high = -high;
    }
    let scale = abs(frame.values.x);
    let shift = sign * frame.values.y;
    let most = max(low, high);
    let top = max(max(most.x, most.y), max(most.z, most.w));
    if top * scale + shift <= above {
        return vec2<f32>(NONE, 0.0);
    }
    let from_u = clamp(start - vec3<f32>(a), vec3<f32>(0.0), vec3<f32>(1.0));
    let way = clamp(end - vec3<f32>(a), vec3<f32>(0.0), vec3<f32>(1.0)) - from_u;
    let constant = low + from_u.x * (high - low);
    let linear = way.x * (high - low);
    let nought = vec2<f32>(0.0);
    let near = between_two(vec4<f32>(constant.x, linear.x, nought), vec4<f32>(constant.y, linear.y, nought), from_u.y, way.y);
    let far = between_two(vec4<f32>(constant.z, linear.z, nought), vec4<f32>(constant.w, linear.w, nought), from_u.y, way.y);
    let cubic = between_two(near, far, from_u.z, way.z);
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

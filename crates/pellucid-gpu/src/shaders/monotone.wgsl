// The walk over the pieces of rays on which a field only rises or only falls, of one that is a cubic between the planes of its
// voxels (5.5-8, G-03): no surface is missed, whatever the step. As `monotone.rs` of the CPU backend.
#define_import_path pellucid::monotone

#import pellucid::frame::frame
#import pellucid::levels::levels
#import pellucid::ray::{Ray, Segment, ray_at}
#import pellucid::field::{ABSENT, is_present}
#import pellucid::pieces::{Cells, course_between_voxels, next_cell, polynomial, turns_of}

struct Walk {
    cells: Cells,
    // How far in the cell, and the value there, or any on the same side of all levels; ABSENT where it is not known.
    part: f32,
    front: f32,
}

// What a ray was at the end of a piece it is at the beginning of the next: rounding of the values on a plane of voxels,
// which are computed from both sides, puts no hole into a surface.
fn beginning(front: f32, here: f32, low: f32, high: f32) -> f32 {
    if !is_present(front) {
        return here;
    }
    let is_far = front < low || front > high;
    let is_alike = (front < low) == (here < low) && (front < high) == (here < high);
    return select(front, here, is_far && is_alike);
}

// Looks at the piece at hand, and goes on to the next. Whether the field may pass any level on it.
fn next_piece(ray: Ray, walk: ptr<function, Walk>, segment: ptr<function, Segment>) -> bool {
    let low = levels[0].value.x;
    // A volume among others may have no surface of its own.
    let high = levels[max(frame.level_count, 1u) - 1u].value.x;
    var cells = (*walk).cells;
    let ends = cells.ends;
    let found = course_between_voxels(ray_at(ray, ends.x), ray_at(ray, ends.y), low, high);
    var next = 1.0;
    var back = found.value;
    if found.passes {
        let part = (*walk).part;
        let turns = turns_of(found.cubic);
        for (var i = 0; i < 2; i += 1) {
            if turns[i] > part && turns[i] < next {
                next = turns[i];
            }
        }
        back = polynomial(found.cubic, next);
        let begin = beginning((*walk).front, polynomial(found.cubic, part), low, high);
        let distance = vec2<f32>(mix(ends.x, ends.y, part), mix(ends.x, ends.y, next));
        *segment = Segment(distance, vec2<f32>(begin, back), next - part);
    }
    (*walk).front = back;
    (*walk).part = select(next, 0.0, next >= 1.0);
    if next >= 1.0 {
        next_cell(&cells);
        (*walk).cells = cells;
    }
    return found.passes;
}

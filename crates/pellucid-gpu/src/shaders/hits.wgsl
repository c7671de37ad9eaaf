// The surfaces of a volume among others, one after the other along a ray: each volume has the lattice that it has alone.
#define_import_path pellucid::hits

#import pellucid::cursor::{Cursor, Hit, BEYOND}
#import pellucid::frame::frame
#import pellucid::ray::{Ray, Segment, ray_at, ray_length, ray_node, ray_of}
#import pellucid::field::field_value
#import pellucid::crossing::{crosses, level_of, met_at, place_in}
#import pellucid::levels::{between, levels}
#import pellucid::normal::normal_of
#import pellucid::field::ABSENT
#import pellucid::pieces::{cells_at, is_of_nearest, meet_cell, next_cell}
#ifdef EXACT
#import pellucid::monotone::{Walk, next_piece}
#endif
#ifdef SKIP
#import pellucid::skip::leap_faces
#endif
#ifdef SKIP
#import pellucid::skip::leap_segments
#endif

// How many segments are looked at between two looks at the blocks.
const RUN: u32 = 4u;

// Whether there is another segment that crosses a surface: it is looked at.
fn next_segment(ray: Ray, cursor: ptr<function, Cursor>) -> bool {
#ifdef EXACT
    return next_crossed_piece(ray, cursor);
#else
#ifdef KERNELS
    if is_of_nearest() {
        return next_face(ray, cursor);
    }
#endif
    var n = (*cursor).next;
    var front = (*cursor).front;
    var is_known = (*cursor).is_known;
    var is_found = false;
    // The last segment that begins within reach.
    let last = min(ray.count, floor((*cursor).reach.y - ray.entry) + 1.0);
    while !is_found && n <= last {
#ifdef SKIP
        let to = leap_segments(ray, n);
        (*cursor).counts.z += u32(min(to, ray.count) - min(n, ray.count));
        is_known = is_known && to == n;
        n = to;
#endif
        for (var i = 0u; i < RUN && n <= last && !is_found; i += 1u) {
            let start = ray_node(ray, n);
            if !is_known {
                front = field_value(ray_at(ray, start));
                is_known = true;
                (*cursor).counts.x += 1u;
            }
            let end = ray_node(ray, n + 1.0);
            let back = field_value(ray_at(ray, end));
            (*cursor).counts.x += 1u;
            (*cursor).ends = vec2<f32>(start, end);
            (*cursor).values = vec2<f32>(front, back);
            front = back;
            n += 1.0;
            is_found = crosses((*cursor).values);
        }
    }
    (*cursor).next = n;
    (*cursor).front = front;
    (*cursor).is_known = is_known;
    return is_found;
#endif
}

#ifdef EXACT
// The same over the pieces on which the field only rises or only falls.
fn next_crossed_piece(ray: Ray, cursor: ptr<function, Cursor>) -> bool {
    const PIECES: u32 = 2u;
    // With the cell before the reach: what the ray was at its end it is at the beginning of the next.
    var cells = cells_at(ray, max((*cursor).reach.x - ray.entry - 0.5, 0.0));
    var walk = Walk(cells, 0.0, ABSENT);
    if (*cursor).is_known {
        cells.cell = (*cursor).cell;
        meet_cell(&cells);
        walk = Walk(cells, (*cursor).next, (*cursor).front);
    }
    let length = min(cells.length, (*cursor).reach.y - ray.entry);
    var segment: Segment;
    var is_found = false;
    while !is_found && walk.cells.ends.x < length {
#ifdef SKIP
        cells = walk.cells;
        let leapt = leap_faces(ray, &cells);
        if leapt > 0.0 {
            walk = Walk(cells, 0.0, ABSENT);
            (*cursor).counts.z += u32(leapt);
        }
#endif
        for (var i = 0u; i < PIECES && walk.cells.ends.x < length && !is_found; i += 1u) {
            (*cursor).counts.x += 1u;
            is_found = next_piece(ray, &walk, &segment) && crosses(segment.value);
        }
    }
    (*cursor).ends = segment.distance;
    (*cursor).values = segment.value;
    (*cursor).cell = walk.cells.cell;
    (*cursor).next = walk.part;
    (*cursor).front = walk.front;
    (*cursor).is_known = true;
    return is_found;
}
#endif

#ifdef KERNELS
// The same over the faces between nearest voxels: segments of no length.
fn next_face(ray: Ray, cursor: ptr<function, Cursor>) -> bool {
    const FACES: u32 = 8u;
    // The face by which a ray comes into reach is that of the cell before.
    var cells = cells_at(ray, max((*cursor).reach.x - ray.entry - 0.5, 0.0));
    if (*cursor).is_known {
        cells.cell = (*cursor).cell;
        meet_cell(&cells);
    }
    // There is no face at the entry, nor behind what is leapt over.
    var front = select(ABSENT, (*cursor).front, (*cursor).is_known);
    var is_found = false;
    let length = min(cells.length, (*cursor).reach.y - ray.entry);
    while !is_found && cells.ends.x < length {
#ifdef SKIP
        let leapt = leap_faces(ray, &cells);
        if leapt > 0.0 {
            front = ABSENT;
            (*cursor).counts.z += u32(leapt);
        }
#endif
        for (var i = 0u; i < FACES && cells.ends.x < length && !is_found; i += 1u) {
            let back = field_value(ray_at(ray, (cells.ends.x + cells.ends.y) * 0.5));
            (*cursor).counts.x += 1u;
            (*cursor).ends = vec2<f32>(cells.ends.x);
            (*cursor).values = vec2<f32>(front, back);
            front = back;
            next_cell(&cells);
            is_found = crosses((*cursor).values);
        }
    }
    (*cursor).cell = cells.cell;
    (*cursor).front = front;
    (*cursor).is_known = true;
    return is_found;
}
#endif

// At the first surface between two distances, in steps from the eye.
fn first_hit(pixel: vec2<u32>, sub: u32, reach: vec2<f32>) -> Cursor {
    let ray = ray_of(pixel, sub);
    var cursor: Cursor;
    cursor.reach = reach;
    cursor.is_in = ray.count > 0.0;
    cursor.rank = frame.level_count;
    // Samples lie in the steps that they are numbered by.
    cursor.next = max(floor(reach.x - ray.entry), 0.0);
    return next_hit(pixel, sub, cursor);
}

// At the next surface.
fn next_hit(pixel: vec2<u32>, sub: u32, last: Cursor) -> Cursor {
    let ray = ray_of(pixel, sub);
    var cursor = last;
    cursor.ahead = BEYOND;
    var is_looking = cursor.is_in;
    while is_looking {
        if cursor.rank >= frame.level_count {
            is_looking = next_segment(ray, &cursor);
            cursor.rank = select(frame.level_count, 0u, is_looking);
        } else {
            let number = level_of(cursor.values, cursor.rank);
            cursor.rank += 1u;
            if between(cursor.values.x, cursor.values.y, levels[number].value.x) {
                cursor.number = number;
                cursor.distance = place_in(ray, Segment(cursor.ends, cursor.values, 0.0), number);
                let ahead = ray.entry + cursor.distance;
                if ahead >= cursor.reach.y {
                    is_looking = false;
                } else if ahead >= cursor.reach.x {
                    cursor.ahead = ahead;
                    is_looking = false;
                }
            }
        }
    }
    return cursor;
}

// What is met at the surface ahead, behind an opacity.
fn hit(pixel: vec2<u32>, sub: u32, cursor: Cursor, front: f32) -> Hit {
    let jump = cursor.values.y - cursor.values.x;
    let met = met_at(ray_of(pixel, sub), cursor.distance, cursor.number, jump, front);
    return Hit(met.rgba, normal_of(met.gradient).direction);
}

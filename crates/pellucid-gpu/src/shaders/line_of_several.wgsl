// A ray of the eye through the slabs around several volumes.
#define_import_path pellucid::line

#import pellucid::of0::frame::bounds
#import pellucid::of0::ray::{jitter_of, place_of}
#import pellucid::of0::table::opacity_over
#import pellucid::count::COUNT
#import pellucid::each::normal
#import pellucid::every_line::{all_clear, all_lines, all_ways}
#import pellucid::every_slab::all_matter
#import pellucid::merge::densest
#import pellucid::passage::{Line, Matter, Passage, passage_between, steps_to}
#import pellucid::slab_pieces::{end_of_piece, settled}

struct Lines {
    // In each of the volumes.
    each: array<Line, COUNT>,
    // Coordinates between which it is in each.
    borders: array<vec2<f32>, COUNT>,
    // Coordinates between which it is in any of them.
    ends: vec2<f32>,
    is_backward: bool,
    // Whether it meets any.
    is_met: bool,
}

fn lines_of(pixel: vec2<u32>) -> Lines {
    let sub = bounds.rows.ray;
    let ways = all_ways(place_of(pixel, sub));
    var lengths: array<f32, COUNT>;
    for (var i = 0u; i < COUNT; i += 1u) {
        lengths[i] = max(ways[i].ends.y - ways[i].ends.x, 0.0);
    }
    var lines: Lines;
    lines.each = all_lines(ways, lengths, jitter_of(pixel, sub));
    for (var i = 0u; i < COUNT; i += 1u) {
        if !(lengths[i] > 0.0) {
            // Where it misses a volume is no place at all.
            lines.each[i].crossing.ends = vec2<f32>(0.0);
            continue;
        }
        let ends = lines.each[i].crossing.ends;
        lines.borders[i] = ends;
        lines.ends = select(ends, vec2<f32>(min(lines.ends.x, ends.x), max(lines.ends.y, ends.y)), lines.is_met);
        lines.is_backward |= lines.each[i].is_backward;
        lines.is_met = true;
    }
    return lines;
}

// How many slabs from one on certainly add nothing in any volume.
fn clear_slabs(lines: ptr<function, Lines>, slab: f32) -> f32 {
    let each = all_clear((*lines).each, slab);
    var least = each[0];
    for (var i = 1u; i < COUNT; i += 1u) {
        least = min(least, each[i]);
    }
    // Samples of the pieces of slabs that are cut are elsewhere.
    for (var i = 0u; i < COUNT; i += 1u) {
        let border = (*lines).borders[i];
        least = select(least, min(least, floor(border.x) - slab), border.x > slab);
        least = select(least, min(least, floor(border.y) - slab), border.y > slab);
    }
    return least;
}

// Where the piece of a slab ends that begins at a coordinate.
fn piece_end(lines: ptr<function, Lines>, begin: f32, slab: f32) -> f32 {
    var borders = (*lines).borders;
    return end_of_piece(&borders, begin, slab);
}

// What it passes of a piece of a slab in each volume.
fn passages_between(lines: ptr<function, Lines>, ends: vec2<f32>) -> array<Passage, COUNT> {
    var passages: array<Passage, COUNT>;
    for (var i = 0u; i < COUNT; i += 1u) {
        passages[i] = passage_between((*lines).each[i].crossing, ends);
    }
    return passages;
}

// The opacity of what it crosses in a slab, and a coordinate of that.
fn opacity_in(lines: ptr<function, Lines>, slab: f32) -> vec2<f32> {
    var transmittance = 1.0;
    var place = slab;
    var begin = slab;
    while begin < slab + 1.0 {
        let ends = vec2<f32>(begin, piece_end(lines, begin, slab));
        begin = ends.y;
        let passages = passages_between(lines, ends);
        let matter = settled(all_matter(passages));
        for (var i = 0u; i < COUNT; i += 1u) {
            if matter[i].color.a > 0.0 {
                transmittance *= 1.0 - opacity_over(matter[i].color.a, passages[i].ratio);
                place = passages[i].place;
            }
        }
    }
    return vec2<f32>(1.0 - transmittance, place);
}

// The normal of the volume that has most opacity at a coordinate, and the distance.
fn surface_at(lines: ptr<function, Lines>, place: f32) -> vec4<f32> {
    var passages: array<Passage, COUNT>;
    for (var i = 0u; i < COUNT; i += 1u) {
        let crossing = (*lines).each[i].crossing;
        let is_in = place >= crossing.ends.x && place < crossing.ends.y;
        passages[i] = Passage(place, crossing.origin + crossing.direction * place, select(0.0, 1.0, is_in));
    }
    let matter = settled(all_matter(passages));
    var colors: array<vec4<f32>, COUNT>;
    for (var i = 0u; i < COUNT; i += 1u) {
        colors[i] = matter[i].color;
    }
    let met = densest(&colors);
    let line = (*lines).each[met];
    let distance = line.way.ends.x + steps_to(line, place);
    return vec4<f32>(normal(met, line.way, distance), distance);
}

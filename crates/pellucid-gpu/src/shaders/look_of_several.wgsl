// What the eye sees of a slab through several volumes: as `Eye::together` of the CPU backend. Light comes to the samples of
// each through all that is there.
#define_import_path pellucid::look

#import pellucid::of0::frame::bounds
#import pellucid::of0::sweep::{layer_of, loss, sweep}
#import pellucid::of0::table::{opacity_over, over}
#import pellucid::count::COUNT
#import pellucid::every_slab::all_matter
#import pellucid::every_slab_light::{all_passing, all_seen, all_steps_inside, all_texels}
#import pellucid::line::{Lines, passages_between, piece_end}
#import pellucid::merge::added
#import pellucid::passage::{Look, Matter, Passage, Shares}
#import pellucid::slab_pieces::settled
#import pellucid::way::Way

// What of light gets through to a sample of each volume: of matter of so many steps, what holds back light in any.
fn all_shares(passages: array<Passage, COUNT>, matter: array<Matter, COUNT>, slab: f32) -> array<Shares, COUNT> {
    var left: array<Shares, COUNT>;
    if sweep.counts.y != 0u {
        for (var i = 0u; i < COUNT; i += 1u) {
            left[i] = Shares(1.0, vec3<f32>(1.0));
        }
        return left;
    }
    // Of one step.
    let passing = all_passing(passages, matter, 1.0);
    var transmittance = 1.0;
    var indirect = vec3<f32>(1.0);
    for (var i = 0u; i < COUNT; i += 1u) {
        transmittance *= 1.0 - matter[i].color.a;
        indirect *= passing[i].indirect;
    }
    let steps = all_steps_inside(passages, slab);
    for (var i = 0u; i < COUNT; i += 1u) {
        // Logarithms of 0 are no numbers.
        let through = select(vec3<f32>(0.0), pow(indirect, vec3<f32>(steps[i])), indirect > vec3<f32>(0.0));
        left[i] = Shares(1.0 - opacity_over(1.0 - transmittance, steps[i]), through);
    }
    return left;
}

fn look(lines: ptr<function, Lines>, slab: u32, is_open: bool) -> Look {
    var found = Look(vec4<f32>(0.0), false, false);
    var begin = f32(slab);
    while begin < f32(slab) + 1.0 {
        let ends = vec2<f32>(begin, piece_end(lines, begin, f32(slab)));
        begin = ends.y;
        let piece = look_between(lines, slab, ends, is_open);
        found.is_met |= piece.is_met;
        found.is_seen |= piece.is_seen;
        // Rays that travel against the order of slabs meet the last pieces first.
        let nearer = select(found.color, piece.color, (*lines).is_backward);
        let farther = select(piece.color, found.color, (*lines).is_backward);
        found.color = over(nearer, farther);
    }
    return found;
}

fn look_between(lines: ptr<function, Lines>, slab: u32, ends: vec2<f32>, is_open: bool) -> Look {
    let passages = passages_between(lines, ends);
    let matter = settled(all_matter(passages));
    var found = Look(vec4<f32>(0.0), false, false);
    for (var i = 0u; i < COUNT; i += 1u) {
        found.is_met |= is_open && passages[i].ratio > 0.0;
        found.is_seen |= is_open && matter[i].color.a > 0.0;
    }
    var is_asked = found.is_seen;
    // As in `matter_of`.
    while is_asked {
        let texels = all_texels(passages);
        var ways: array<Way, COUNT>;
        var lost: array<vec4<f32>, COUNT>;
        for (var i = 0u; i < COUNT; i += 1u) {
            ways[i] = (*lines).each[i].way;
            if matter[i].color.a > 0.0 {
                lost[i] = loss(layer_of(bounds.run, slab), texels[i]);
            }
        }
        var elements = all_seen(ways, passages, matter, lost, all_shares(passages, matter, f32(slab)));
        found.color = added(&elements);
        is_asked = false;
    }
    return found;
}

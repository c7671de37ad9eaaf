// What the eye sees of a slab through a volume.
#define_import_path pellucid::look

#import pellucid::frame::bounds
#import pellucid::line::Lines
#import pellucid::passage::{Look, Shares, passage_of}
#import pellucid::slab_light::{passing, seen, steps_inside, texel_of}
#import pellucid::slab::matter_of
#import pellucid::sweep::{layer_of, loss, sweep}

fn look(lines: ptr<function, Lines>, slab: u32, is_open: bool) -> Look {
    let line = (*lines).each;
    let passage = passage_of(line.crossing, f32(slab));
    let matter = matter_of(passage);
    let is_met = is_open && passage.ratio > 0.0;
    var found = Look(vec4<f32>(0.0), is_met && matter.color.a > 0.0, is_met);
    var is_asked = found.is_seen;
    // As in `matter_of`.
    while is_asked {
        let lost = loss(layer_of(bounds.run, slab), texel_of(passage));
        var left = Shares(1.0, vec3<f32>(1.0));
        if sweep.counts.y == 0u {
            left = passing(passage, matter, steps_inside(passage, f32(slab)));
        }
        found.color = seen(line.way, passage, matter, lost, left);
        is_asked = false;
    }
    return found;
}

// What a slab holds where a ray crosses it.
#define_import_path pellucid::slab

#import pellucid::field::field_value
#import pellucid::passage::{Matter, Passage, Shares}
#import pellucid::table::{classify, each_opacity, opacity_over}
#import pellucid::vary::varied
#ifdef SKIP
#import pellucid::skip::is_empty
#endif
#ifdef TRANSPORT
#import pellucid::scatter::transported
#endif

fn matter_of(passage: Passage) -> Matter {
    var matter = Matter(0.0, vec4<f32>(0.0));
    var is_asked = passage.ratio > 0.0;
#ifdef SKIP
    is_asked = is_asked && !is_empty(passage.position);
#endif
    // A loop, because processors whose lanes share branches may jump over it where all of them are empty.
    while is_asked {
        matter.value = field_value(passage.position);
        matter.color = varied(passage.position, classify(matter.value));
        is_asked = false;
    }
    return matter;
}

// What matter holds back of light that passes it.
fn held_by(passage: Passage, matter: Matter) -> Shares {
    let alpha = opacity_over(matter.color.a, passage.ratio);
    var indirect = each_opacity(alpha);
#ifdef TRANSPORT
    if matter.color.a > 0.0 {
        indirect = 1.0 - transported(passage.position, matter.value, passage.ratio);
    }
#endif
    return Shares(alpha, indirect);
}

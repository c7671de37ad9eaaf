// What a slab holds where a ray crosses it.
#define_import_path pellucid::slab

#import pellucid::field::field_value
#import pellucid::passage::{Matter, Passage, Shares, passage_of}
#import pellucid::sweep::light_ray
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

// What of light through a texel's middle a slab holds back.
fn held_back(texel: vec2<u32>, slab: f32) -> Shares {
    let passage = passage_of(light_ray(texel), slab);
    let matter = matter_of(passage);
    let alpha = opacity_over(matter.color.a, passage.ratio);
    var indirect = each_opacity(alpha);
#ifdef TRANSPORT
    if matter.color.a > 0.0 {
        indirect = 1.0 - transported(passage.position, matter.value, passage.ratio);
    }
#endif
    return Shares(alpha, indirect);
}

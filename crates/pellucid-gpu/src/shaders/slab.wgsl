// What a slab holds where a ray crosses it.
#define_import_path pellucid::slab

#import pellucid::frame::frame
#import pellucid::field::field_value
#import pellucid::sweep::Passage
#import pellucid::table::classify
#import pellucid::vary::varied
#ifdef SKIP
#import pellucid::skip::is_empty
#endif

// What is there: its value, and its associated colour and opacity for one step. Nothing if it has no opacity.
struct Matter {
    value: f32,
    color: vec4<f32>,
}

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

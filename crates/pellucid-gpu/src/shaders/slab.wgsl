// What a slab holds where a ray crosses it.
#define_import_path pellucid::slab

#import pellucid::frame::frame
#import pellucid::field::field_value
#import pellucid::sweep::Passage
#import pellucid::table::classify
#ifdef SKIP
#import pellucid::skip::is_empty
#endif

// What is there: its value, and its associated colour and opacity for one step. Nothing if it has no opacity.
struct Matter {
    value: f32,
    color: vec4<f32>,
}

fn matter_of(passage: Passage) -> Matter {
    if passage.ratio <= 0.0 {
        return Matter(0.0, vec4<f32>(0.0));
    }
#ifdef SKIP
    if is_empty(passage.position) {
        return Matter(0.0, vec4<f32>(0.0));
    }
#endif
    let value = field_value(passage.position);
    return Matter(value, classify(value));
}

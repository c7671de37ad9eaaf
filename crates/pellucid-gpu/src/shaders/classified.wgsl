// Samples of the field and what they look like, classified by their value or between classified voxels.
#define_import_path pellucid::classified

#import pellucid::field::field_value
#import pellucid::table::classify_stride
#ifdef PRECLASSIFIED
#import pellucid::preclassify::classify_voxels
#endif

struct Classified {
    // The data value; 0 where it tells nothing.
    value: f32,
    // Associated, of a stride.
    rgba: vec4<f32>,
}

// The sample at a position in voxels, of a stride of 2^level steps.
fn classified_at(p: vec3<f32>, level: u32) -> Classified {
#ifdef PRECLASSIFIED
    let rgba = classify_voxels(p);
    var value = 0.0;
#ifdef SCATTERED
    value = field_value(p);
#endif
    return Classified(value, rgba);
#else
    let value = field_value(p);
    return Classified(value, classify_stride(value, level));
#endif
}

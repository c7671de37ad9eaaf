// Where a slab holds something: a layer beside those of the light, 1 in a where it does.
#define_import_path pellucid::presence

#import pellucid::sweep::loss

fn presence_at(layer: u32, place: vec2<f32>) -> f32 {
    return loss(layer, place).a;
}

// What slabs hold back of light in a volume.
#define_import_path pellucid::slabs

#import pellucid::passage::{Shares, passage_of}
#import pellucid::slab::{held_by, matter_of}
#import pellucid::sweep::light_ray

// What of light through a texel's middle a slab holds back.
fn held_back(texel: vec2<u32>, slab: f32) -> Shares {
    let passage = passage_of(light_ray(texel), slab);
    return held_by(passage, matter_of(passage));
}

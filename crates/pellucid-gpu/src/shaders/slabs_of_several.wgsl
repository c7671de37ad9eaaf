// What slabs hold back of light in several volumes.
#define_import_path pellucid::slabs

#import pellucid::count::COUNT
#import pellucid::every_slab::{all_held, all_matter, all_rays}
#import pellucid::passage::{Passage, Shares, joined, passage_between}
#import pellucid::slab_pieces::{end_of_piece, settled}

// What of light through a texel's middle a slab holds back.
fn held_back(texel: vec2<u32>, slab: f32) -> Shares {
    let rays = all_rays(texel);
    var borders: array<vec2<f32>, COUNT>;
    for (var i = 0u; i < COUNT; i += 1u) {
        borders[i] = rays[i].ends;
    }
    var held = Shares(0.0, vec3<f32>(0.0));
    var begin = slab;
    while begin < slab + 1.0 {
        let ends = vec2<f32>(begin, end_of_piece(&borders, begin, slab));
        begin = ends.y;
        var passages: array<Passage, COUNT>;
        for (var i = 0u; i < COUNT; i += 1u) {
            passages[i] = passage_between(rays[i], ends);
        }
        let each = all_held(passages, settled(all_matter(passages)));
        for (var i = 0u; i < COUNT; i += 1u) {
            held = joined(held, each[i]);
        }
    }
    return held;
}

// Slabs as several volumes cut them: as `pieces.rs` of the CPU backend. Their pieces end at the borders of volumes, so that
// constant matter is exact wherever volumes begin and whatever the rule of their overlap.
#define_import_path pellucid::slab_pieces

#import pellucid::count::COUNT
#import pellucid::merge::settle
#import pellucid::passage::Matter

// Where the piece of a slab ends that begins at a coordinate; rays are in volumes between borders.
fn end_of_piece(borders: ptr<function, array<vec2<f32>, COUNT>>, begin: f32, slab: f32) -> f32 {
    var end = slab + 1.0;
    for (var i = 0u; i < COUNT; i += 1u) {
        let border = (*borders)[i];
        if border.x < border.y {
            end = select(end, min(end, border.x), border.x > begin);
            end = select(end, min(end, border.y), border.y > begin);
        }
    }
    return end;
}

// Matter of volumes as the rule of their overlap leaves it.
fn settled(matter: array<Matter, COUNT>) -> array<Matter, COUNT> {
    var left = matter;
    var colors: array<vec4<f32>, COUNT>;
    for (var i = 0u; i < COUNT; i += 1u) {
        colors[i] = left[i].color;
    }
    settle(&colors);
    for (var i = 0u; i < COUNT; i += 1u) {
        left[i].color = colors[i];
    }
    return left;
}

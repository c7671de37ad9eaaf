// Compositing of pre-integrated segments between the nodes of the lattice (4.6-7, 7.2-3): one fetch a
// step, and the first segment starts at the entry, not at a made-up value of 0.
#define_import_path pellucid::mode

#import pellucid::ray::{Ray, Segment, ray_at}
#import pellucid::vary::varied
#import pellucid::march::State
#import pellucid::surface::add_sample
#import pellucid::integrals::{between, value_of}

// Returns whether the ray is done.
fn visit_segment(state: ptr<function, State>, ray: Ray, segment: Segment) -> bool {
    let middle = (segment.distance.x + segment.distance.y) * 0.5;
    let rgba = varied(ray_at(ray, middle), between(segment.value.x, segment.value.y, segment.length));
    if rgba.a <= 0.0 {
        return false;
    }
    (*state).counts.y += 1u;
    return add_sample(state, ray, middle, value_of(segment.value), rgba);
}

fn meet_segment(state: ptr<function, State>, ray: Ray, segment: Segment) -> bool {
    return true;
}

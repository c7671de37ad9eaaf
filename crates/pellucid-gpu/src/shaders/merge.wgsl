// What lies where volumes overlap, or what they send together: as `merge.rs` and `apart.rs` of the CPU backend.
#define_import_path pellucid::merge

#import pellucid::of0::frame::frame
#import pellucid::of0::table::{extinction, opacity_of}
#import pellucid::count::COUNT

// The rules, as `uniforms.rs` numbers them.
const ADD: u32 = 0u;
const MAXIMUM: u32 = 1u;
const PRIORITY: u32 = 2u;
const FUSED: u32 = 3u;
const SUM: u32 = 4u;

// The largest opacity below 1: full opacity has no depth that a number could tell.
const OPAQUE: f32 = 1.0 - 6e-8;

// Extinctions add, and so does emission, weighted by them: `C = A sum(tau c) / sum(tau)` with `A = 1 - e^-sum(tau)`.
fn added(elements: ptr<function, array<vec4<f32>, COUNT>>) -> vec4<f32> {
    var only = vec4<f32>(0.0);
    var color = vec3<f32>(0.0);
    var depth = 0.0;
    var count = 0u;
    for (var i = 0u; i < COUNT; i += 1u) {
        let own = (*elements)[i];
        if own.a > 0.0 {
            only = own;
            count += 1u;
            let own_depth = extinction(min(own.a, OPAQUE));
            depth += own_depth;
            color += own.rgb * (own_depth / own.a);
        }
    }
    if count < 2u {
        return only;
    }
    let alpha = opacity_of(depth);
    return vec4<f32>(color * (alpha / depth), alpha);
}

// Light of all, each as if it were alone.
fn sum(elements: ptr<function, array<vec4<f32>, COUNT>>) -> vec4<f32> {
    var color = vec3<f32>(0.0);
    var transmittance = 1.0;
    for (var i = 0u; i < COUNT; i += 1u) {
        color += (*elements)[i].rgb;
        transmittance *= 1.0 - (*elements)[i].a;
    }
    return vec4<f32>(color, 1.0 - transmittance);
}

// More opacity or, where that is the same, the brighter colour: a choice that no order decides.
fn is_more(own: vec4<f32>, other: vec4<f32>) -> bool {
    if own.a != other.a {
        return own.a > other.a;
    }
    for (var channel = 0u; channel < 3u; channel += 1u) {
        if own[channel] != other[channel] {
            return own[channel] > other[channel];
        }
    }
    return false;
}

// Of the visible ones the first, or the one with the largest opacity.
fn best(elements: ptr<function, array<vec4<f32>, COUNT>>) -> u32 {
    var found = 0u;
    for (var i = 1u; i < COUNT; i += 1u) {
        let other = (*elements)[found];
        let is_taken = other.a > 0.0 && frame.overlap.x == PRIORITY;
        if (*elements)[i].a > 0.0 && !is_taken && is_more((*elements)[i], other) {
            found = i;
        }
    }
    return found;
}

fn chosen(elements: ptr<function, array<vec4<f32>, COUNT>>) -> vec4<f32> {
    let own = (*elements)[best(elements)];
    return select(vec4<f32>(0.0), own, own.a > 0.0);
}

// Light of one volume, whose colours are white, times the opaque colours of the other, where that has any.
fn fused(elements: ptr<function, array<vec4<f32>, COUNT>>) -> vec4<f32> {
    let color = (*elements)[frame.overlap.y];
    let own = (*elements)[frame.overlap.z];
    if color.a > 0.0 {
        return vec4<f32>(own.rgb * (color.rgb / color.a), own.a);
    }
    return own;
}

// What all volumes send together.
fn merged(elements: ptr<function, array<vec4<f32>, COUNT>>) -> vec4<f32> {
    switch frame.overlap.x {
        case ADD: { return added(elements); }
        case FUSED: { return fused(elements); }
        case SUM: { return sum(elements); }
        default: { return chosen(elements); }
    }
}

// Leaves of elements over the same length those that hold light back, in the colours in which they are seen: extinctions
// of what is left add.
fn settle(elements: ptr<function, array<vec4<f32>, COUNT>>) {
    if frame.overlap.x == ADD {
        return;
    }
    var left = best(elements);
    if frame.overlap.x == FUSED {
        left = frame.overlap.z;
        (*elements)[left] = fused(elements);
    }
    for (var i = 0u; i < COUNT; i += 1u) {
        if i != left {
            (*elements)[i] = vec4<f32>(0.0);
        }
    }
}

// The volume with most opacity.
fn densest(elements: ptr<function, array<vec4<f32>, COUNT>>) -> u32 {
    var found = 0u;
    for (var i = 1u; i < COUNT; i += 1u) {
        if (*elements)[i].a > (*elements)[found].a {
            found = i;
        }
    }
    return found;
}

// What a volume sends to the eye from a slab, in the light that has come to it (Eq. 6.9, 6.10, K-05).
#define_import_path pellucid::slab_light

#import pellucid::arriving::incident
#import pellucid::light::{Unlit, lit_by}
#import pellucid::passage::{Matter, Passage, Shares}
#import pellucid::ray::ray_along
#import pellucid::surface::gradient_of_surface
#import pellucid::sweep::{in_picture, on_plane, sweep}
#import pellucid::table::{each_color, opacity_over, over_length}
#import pellucid::way::Way
#ifdef TRANSPORT
#import pellucid::scatter::transported
#endif

// How many steps light has come within the slab to a sample.
fn steps_inside(passage: Passage, slab: f32) -> f32 {
    let part = passage.place - slab;
    if sweep.ways.w == 0.0 {
        return part * sweep.ways.x;
    }
    let seen = in_picture(passage.position);
    let at = on_plane(seen.xy);
    let distance = seen.z * sqrt(1.0 + dot(at, at));
    return part * distance / ((passage.place - sweep.ways.y) * sweep.ways.z);
}

// Where a sample is in the light's picture, in texels.
fn texel_of(passage: Passage) -> vec2<f32> {
    return in_picture(passage.position).xy;
}

// What gets through so many steps of what is at a sample.
fn passing(passage: Passage, matter: Matter, steps: f32) -> Shares {
    let transmittance = 1.0 - opacity_over(matter.color.a, steps);
    var indirect = each_color(transmittance);
#ifdef TRANSPORT
    if matter.color.a > 0.0 {
        indirect = transported(passage.position, matter.value, steps);
    }
#endif
    return Shares(transmittance, indirect);
}

// What is seen of a sample, and its opacity: of what is lost in front of the slab, and what gets through to it there.
fn seen(way: Way, passage: Passage, matter: Matter, lost: vec4<f32>, left: Shares) -> vec4<f32> {
    let p = passage.position;
    let rgba = over_length(matter.color, passage.ratio);
    let direct = (1.0 - lost.a) * left.direct;
    var indirect = (vec3<f32>(sweep.scales.z) - lost.rgb) * left.indirect;
#ifdef SCATTERS_DIRECT
    // As light does that passes the slab.
    indirect += max(left.indirect - each_color(left.direct), vec3<f32>(0.0)) * sweep.cone.rgb * each_color(1.0 - lost.a);
#endif
    let light = sweep.light;
    // Rays that meet the last slabs first do not know what is in front.
    let sample = Unlit(rgba, matter.value, p, gradient_of_surface(ray_along(way), p), way.to_eye, 0.0);
    var color = lit_by(sample, light, each_color(direct) * sweep.scales.x);
#ifdef INDIRECT
    let factor = indirect * incident(light, p).radiance * sweep.scales.y;
    color += vec4<f32>(rgba.rgb * factor, 0.0);
#endif
    return color;
}

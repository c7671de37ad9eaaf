// Light passes a slab (Eq. 6.6, 6.7, K-06, K-09): a texel loses what its ray crosses, and gathers what is scattered
// into its cone. The pass: the slab; the first tap of the blur; from which texel on to which light is passed, as it
// is lost in there and matters to anything.
#import pellucid::constants::load_constants
#import pellucid::frame::bounds
#import pellucid::slabs::held_back
#import pellucid::sweep::{light_ray, loss, loss_at, in_picture, sweep}
#ifdef GATED
#import pellucid::sweep::between
#endif
#import pellucid::table::{each_color, each_opacity}

// What is lost behind the slab.
@group(0) @binding(21) var next: texture_storage_2d<rgba32float, write>;
#ifdef GATED
// 1 where the slab holds something.
@group(0) @binding(22) var held: texture_2d<f32>;
#endif

// The next corner of the polygon of taps.
fn turned(tap: vec2<f32>) -> vec2<f32> {
    let turn = sweep.taps.xy;
    return vec2<f32>(tap.x * turn.x - tap.y * turn.y, tap.x * turn.y + tap.y * turn.x);
}

#ifdef GATED
// The part of four texels around a place that hold something.
fn held_at(place: vec2<f32>) -> f32 {
    let four = between(place);
    let texel = four.texel + 1;
    let near = mix(textureLoad(held, texel, 0).x, textureLoad(held, texel + vec2<i32>(1, 0), 0).x, four.part.x);
    let far =
        mix(textureLoad(held, texel + vec2<i32>(0, 1), 0).x, textureLoad(held, texel + vec2<i32>(1, 1), 0).x, four.part.x);
    return mix(near, far, four.part.y);
}
#endif

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) invocation: vec3<u32>) {
    load_constants();
    let id = invocation.xy + bounds.low;
    if any(id >= bounds.high) {
        return;
    }
    let opacity = held_back(id, bounds.slab.x);
    let lost = loss_at(0u, vec2<i32>(id));
    var left = vec4<f32>(vec3<f32>(sweep.scales.z), 1.0) - lost;
    let direct = left.a * (1.0 - opacity.direct);
#ifdef INDIRECT
    var middle = vec2<f32>(id) + 0.5;
    var radius = sweep.blur.xy;
    if sweep.ways.w != 0.0 {
        // The way grows towards the picture's rim, and texels with the distance.
        let ray = light_ray(id);
        let p = ray.origin + ray.direction * bounds.slab.y;
        var path = ray.stretch * sweep.ways.z;
        if sweep.blur.y != 0.0 {
            path = sqrt(path);
        }
        radius = path * sweep.blur.x * sweep.blur.zw / in_picture(p).z;
    }
    // As a difference from the middle: what is even stays exactly even.
    let count = max(f32(sweep.counts.x), 1.0);
    var tap = bounds.tap;
#ifdef GATED
    var mean = vec4<f32>(0.0);
    for (var i = 0u; i < max(sweep.counts.x, 1u); i += 1u) {
        let place = middle + radius * tap;
        let gate = held_at(place);
        let arriving = vec4<f32>(vec3<f32>(sweep.scales.z), 1.0) - loss(0u, place);
        // Indirect light crosses gaps unless all light comes from matter.
        mean += arriving * vec4<f32>(vec3<f32>(select(1.0, gate, sweep.counts.z == 2u)), gate) / count;
        tap = turned(tap);
    }
    left = mean;
#else
    var difference = vec4<f32>(0.0);
    for (var i = 0u; i < sweep.counts.x; i += 1u) {
        difference += lost - loss(0u, middle + radius * tap);
        tap = turned(tap);
    }
    left += difference / count;
#endif
    var indirect = left.rgb * (1.0 - opacity.indirect);
#ifdef SCATTERS_DIRECT
    // What becomes indirect light on the way loses the rest of it as such.
    indirect += max(each_opacity(opacity.direct) - opacity.indirect, vec3<f32>(0.0)) * sweep.cone.rgb * each_color(left.a);
#endif
    let behind = vec4<f32>(vec3<f32>(sweep.scales.z) - indirect, 1.0 - direct);
#else
    let behind = vec4<f32>(0.0, 0.0, 0.0, 1.0 - direct);
#endif
    textureStore(next, id + 1u, behind);
}

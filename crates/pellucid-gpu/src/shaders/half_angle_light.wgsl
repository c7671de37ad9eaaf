// Light passes a slab (Eq. 6.6, 6.7, K-06, K-09): a texel loses what its ray crosses, and gathers what is scattered
// into its cone. The pass: the slab, the layers of light in front of it and behind it; turn and radius of the taps;
// from which texel on to which light is passed, as it is lost in there and matters to anything.
#import pellucid::frame::bounds
#import pellucid::sweep::{light_ray, lost, loss, loss_at, passage_of, in_picture, sweep}
#import pellucid::slab::matter_of
#import pellucid::table::opacity_over
#ifdef TRANSPORT
#import pellucid::scatter::transported
#endif

const TAU: f32 = 6.2831853;

// The taps, as places in the light's picture.
fn tap(number: u32, middle: vec2<f32>, radius: vec2<f32>) -> vec2<f32> {
    let angle = (f32(number) + bitcast<f32>(bounds.texture_low.x)) / f32(sweep.counts.x) * TAU;
    return middle + radius * bitcast<f32>(bounds.texture_low.y) * vec2<f32>(cos(angle), sin(angle));
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) invocation: vec3<u32>) {
    let id = invocation.xy + bounds.core_low.xy;
    if any(id >= bounds.core_high.xy) {
        return;
    }
    let layer = bounds.rows.y;
    let here = vec2<i32>(id);
    let ray = light_ray(id);
    let passage = passage_of(ray, f32(bounds.rows.x));
    let matter = matter_of(passage);
    let alpha = opacity_over(matter.color.a, passage.ratio);
    var left = vec4<f32>(vec3<f32>(sweep.scales.z), 1.0) - loss_at(layer, here);
    let direct = left.a * (1.0 - alpha);
#ifdef INDIRECT
    var opacity = vec3<f32>(alpha);
#ifdef TRANSPORT
    if matter.color.a > 0.0 {
        opacity = 1.0 - transported(passage.position, matter.value, passage.ratio);
    }
#endif
    var middle = vec2<f32>(id) + 0.5;
    var radius = sweep.blur.xy;
    if sweep.ways.w != 0.0 {
        // The way grows towards the picture's rim, and texels with the distance.
        let p = ray.origin + ray.direction * (f32(bounds.rows.x) + 0.5);
        var path = ray.stretch * sweep.ways.z;
        if sweep.blur.y != 0.0 {
            path = sqrt(path);
        }
        radius = path * sweep.blur.x * sweep.blur.zw / in_picture(p).z;
    }
    // As a difference from the middle: what is even stays exactly even.
    let count = max(f32(sweep.counts.x), 1.0);
#ifdef GATED
    var mean = vec4<f32>(0.0);
    for (var i = 0u; i < max(sweep.counts.x, 1u); i += 1u) {
        let place = select(middle, tap(i, middle, radius), sweep.counts.x > 0u);
        // Where the slab holds something, in a layer of its own.
        let held = loss(bounds.rows.w, place).a;
        let arriving = vec4<f32>(vec3<f32>(sweep.scales.z), 1.0) - loss(layer, place);
        // Indirect light crosses gaps unless all light comes from matter.
        mean += arriving * vec4<f32>(vec3<f32>(select(1.0, held, sweep.counts.z == 2u)), held) / count;
    }
    left = mean;
#else
    var difference = vec4<f32>(0.0);
    for (var i = 0u; i < sweep.counts.x; i += 1u) {
        difference += loss_at(layer, here) - loss(layer, tap(i, middle, radius));
    }
    left += difference / count;
#endif
    var indirect = left.rgb;
#ifdef SCATTERS_DIRECT
    indirect += max(vec3<f32>(alpha) - opacity, vec3<f32>(0.0)) * sweep.cone.rgb * left.a;
#endif
    indirect *= 1.0 - opacity;
    let next = vec4<f32>(vec3<f32>(sweep.scales.z) - indirect, 1.0 - direct);
#else
    let next = vec4<f32>(0.0, 0.0, 0.0, 1.0 - direct);
#endif
    lost[(bounds.rows.z * sweep.size.y + id.y) * sweep.size.x + id.x] = next;
}

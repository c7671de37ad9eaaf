// The transfer function: the tables of `pellucid-optics`, the same numbers that the CPU backend uses.
#define_import_path pellucid::table

#import pellucid::frame::frame
#import pellucid::field::is_present
#import pellucid::lists::entries

// Where a value would be among as many even nodes.
fn even_node(value: f32) -> f32 {
    return (value - frame.values.z) * frame.values.w;
}

#ifdef KNOTS
// The row `step` rows on, if it is not above a value.
fn not_above(at: u32, step: u32, value: f32) -> u32 {
    return select(at, at + step, value >= entries[at + step].x);
}

// The position of a value among the nodes: by the last of the rows of value, node and slope that is not above it.
fn node_of(value: f32) -> f32 {
    let knots = u32(frame.table.z);
    let half = knots / 2u;
    var at = frame.lists.x + u32(frame.table.w);
    // Written out for up to 64 rows: drivers that run on the processor (llvmpipe) end all loops of a shader after
    // 65,535 rounds, which rays to lights would use up.
    at = not_above(at, half, value);
    at = not_above(at, half / 2u, value);
    at = not_above(at, half / 4u, value);
    at = not_above(at, half / 8u, value);
    at = not_above(at, half / 16u, value);
    at = not_above(at, half / 32u, value);
    for (var step = half / 64u; step > 0u; step /= 2u) {
        at = not_above(at, step, value);
    }
    let knot = entries[at];
    return (value - knot.x) * knot.z + knot.y;
}
#else
fn node_of(value: f32) -> f32 {
    return even_node(value);
}
#endif

fn clamped_node(value: f32) -> f32 {
    return clamp(node_of(value), 0.0, f32(frame.dims.w - 1u));
}

// The entry at a data value; zero where there is none.
fn classify(value: f32) -> vec4<f32> {
    return classify_stride(value, 0u);
}

// The entry for a stride of 2^level steps: the tables of longer strides follow that of one step.
fn classify_stride(value: f32, level: u32) -> vec4<f32> {
    if !is_present(value) {
        return vec4<f32>(0.0);
    }
    let position = clamped_node(value);
    let node = min(u32(position), frame.dims.w - 2u);
    let entry = frame.lists.x + node + level * frame.dims.w;
    return mix(entries[entry], entries[entry + 1u], position - f32(node));
}

// `1 - (1 - alpha)^ratio`, without loss where alpha is small.
fn opacity_over(alpha: f32, ratio: f32) -> f32 {
    if alpha >= 1.0 {
        return 1.0;
    }
    return opacity_of(extinction(alpha) * ratio);
}

// `1 - e^-depth`.
fn opacity_of(depth: f32) -> f32 {
    if depth < 1e-2 {
        return depth * (1.0 - depth * (0.5 - depth * (1.0 / 6.0 - depth / 24.0)));
    }
    return 1.0 - exp(-depth);
}

// `-ln(1 - alpha)`.
fn extinction(alpha: f32) -> f32 {
    if alpha < 1e-2 {
        return alpha * (1.0 + alpha * (0.5 + alpha * (1.0 / 3.0 + alpha * (0.25 + alpha / 5.0))));
    }
    return -log(1.0 - alpha);
}

// What is left of each colour where a share of the one that is lost least is left (K-13).
fn each_color(transmittance: f32) -> vec3<f32> {
#ifdef CHROMATIC
    let ratios = frame.chroma.rgb;
    // Logarithms of 0 are no numbers, and what is not held back at all passes what lets nothing else through.
    let each = select(vec3<f32>(0.0), pow(vec3<f32>(max(transmittance, 1e-37)), ratios), transmittance > 0.0);
    return select(each, vec3<f32>(1.0), ratios == vec3<f32>(0.0));
#else
    return vec3<f32>(transmittance);
#endif
}

// What is held back of each colour at an opacity of the one that is lost least.
fn each_opacity(alpha: f32) -> vec3<f32> {
#ifdef CHROMATIC
    let ratios = frame.chroma.rgb;
    return vec3<f32>(opacity_over(alpha, ratios.r), opacity_over(alpha, ratios.g), opacity_over(alpha, ratios.b))
        * vec3<f32>(ratios > vec3<f32>(0.0));
#else
    return vec3<f32>(alpha);
#endif
}

// What is held back of all colours, in the mean.
fn coverage(alpha: f32) -> f32 {
#ifdef CHROMATIC
    return dot(each_opacity(alpha), vec3<f32>(1.0 / 3.0));
#else
    return alpha;
#endif
}

// An associated colour over `ratio` times the length it holds for (1.4-14).
fn over_length(rgba: vec4<f32>, ratio: f32) -> vec4<f32> {
    if ratio == 1.0 {
        return rgba;
    }
    let corrected = opacity_over(rgba.a, ratio);
#ifdef CHROMATIC
    const THINNEST: vec3<f32> = vec3<f32>(1.1754944e-38);
    let one_step = each_opacity(rgba.a);
    let scale = each_opacity(corrected) / max(one_step, THINNEST);
    return vec4<f32>(rgba.rgb * select(vec3<f32>(ratio), scale, one_step >= THINNEST), corrected);
#else
    if rgba.a < 1.1754944e-38 {
        return vec4<f32>(rgba.rgb * ratio, corrected);
    }
    return vec4<f32>(rgba.rgb * (corrected / rgba.a), corrected);
#endif
}

// How far in front of the middle the light of an optical depth comes from: `advance` of `pellucid-optics`.
fn advance(depth: f32) -> f32 {
    if depth < 1.0 {
        let squared = depth * depth;
        return depth * (1.0 / 12.0 - squared * (1.0 / 720.0 - squared * (1.0 / 30240.0 - squared / 1209600.0)));
    }
    return 1.0 / (1.0 - exp(-depth)) - 0.5 - 1.0 / depth;
}

// The colour of a segment over `ratio` times the length it holds for, by that of the segment seen from its other end
// (7.3-4): `correct_segment` of `pellucid-optics`.
fn segment_over(rgba: vec4<f32>, reversed: vec4<f32>, ratio: f32) -> vec4<f32> {
    if ratio == 1.0 {
        return rgba;
    }
    // Full opacity is a depth that f32 does not tell from more.
    let depth = extinction(min(rgba.a, 1.0 - 6e-8));
    var share = 0.5 * (1.0 - ratio);
    if depth >= 1e-3 {
        share = 0.5 * (1.0 - advance(depth * ratio) / advance(depth));
    }
    return over_length(vec4<f32>(mix(rgba.rgb, reversed.rgb, share), rgba.a), ratio);
}

// What is behind comes to what is in front (1.4-8).
fn over(front: vec4<f32>, behind: vec4<f32>) -> vec4<f32> {
    let transmittance = 1.0 - front.a;
    return front + behind * vec4<f32>(each_color(transmittance), transmittance);
}

// The opacity of a step through a medium of one value.
fn homogeneous(value: f32) -> f32 {
#ifdef SEGMENTS
    // The diagonal of the integrals over segments.
    let position = clamped_node(value);
    let node = min(u32(position), frame.dims.w - 2u);
    let next = frame.dims.w + 1u;
    let entry = frame.lists.x + node * next;
    return mix(entries[entry].a, entries[entry + next].a, position - f32(node));
#else
    return classify(value).a;
#endif
}

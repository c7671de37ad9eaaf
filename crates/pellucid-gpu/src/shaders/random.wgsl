// Random numbers: a stream of its own for every path (xoroshiro64**, Blackman and Vigna 2018).
#define_import_path pellucid::random

var<private> stream: vec2<u32>;

// The finalizer of a 32-bit hash with low bias (Wellons 2018).
fn mixed(v: u32) -> u32 {
    var x = (v ^ (v >> 16u)) * 0x7feb352du;
    x = (x ^ (x >> 15u)) * 0x846ca68bu;
    return x ^ (x >> 16u);
}

// The stream of a path: number `path` of a pixel, in a picture with these seeds.
fn begin_stream(seeds: vec2<u32>, pixel: u32, path: u32) {
    let a = mixed(mixed(mixed(mixed(seeds.x + 0x9e3779b9u) ^ seeds.y) ^ pixel) ^ path);
    // Never both 0.
    stream = vec2<u32>(a, mixed(a ^ 0x85ebca6bu) | 1u);
}

fn rotated(v: u32, by: u32) -> u32 {
    return (v << by) | (v >> (32u - by));
}

// A number in 0..1, never 1.
fn random() -> f32 {
    let result = rotated(stream.x * 0x9e3779bbu, 5u) * 5u;
    let both = stream.x ^ stream.y;
    stream = vec2<u32>(rotated(stream.x, 26u) ^ both ^ (both << 9u), rotated(both, 13u));
    return f32(result >> 8u) * (1.0 / 16777216.0);
}

// The optical depth at which light next collides: exponentially distributed. Halfway between two numbers, so that the
// logarithm is finite.
fn random_depth() -> f32 {
    return -log(random() + 0.5 / 16777216.0);
}

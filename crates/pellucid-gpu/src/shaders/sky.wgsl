// Light from far away, all around: `environment` of `pellucid-optics`.
#define_import_path pellucid::sky

#import pellucid::paths::paths
#import pellucid::random::random
#import pellucid::scatter::PI
#import pellucid::vertex::turned

// Of a picture: every texel's colour, rows from the top, and the share of its row's light left of its end; then, of
// every row, the heights of its upper and its lower side, and the share of all light above its end.
@group(0) @binding(22) var sky: texture_2d<f32>;

fn texel_at(number: u32) -> vec4<f32> {
    let width = paths.picture_size.x;
    return textureLoad(sky, vec2<u32>(number % width, number / width), 0);
}

// Relative luminance of linear sRGB.
fn luminance(color: vec3<f32>) -> f32 {
    return dot(color, vec3<f32>(0.2126, 0.7152, 0.0722));
}

// The sky in a direction.
struct SkyLight {
    direction: vec3<f32>,
    radiance: vec3<f32>,
    // Per steradian, with which `sample_sky` chooses the direction: proportional to the luminance.
    density: f32,
}

fn has_sky() -> bool {
    return paths.bottom.w != 0.0;
}

// Whether it is a picture.
fn is_picture() -> bool {
    return paths.picture_size.x != 0u;
}

fn gradient_in(direction: vec3<f32>) -> SkyLight {
    let radiance = mix(paths.bottom.rgb, paths.top.rgb, 0.5 + 0.5 * direction.z);
    return SkyLight(direction, radiance, (1.0 + paths.top.w * direction.z) / (4.0 * PI));
}

fn texel_in(direction: vec3<f32>, texel: u32) -> SkyLight {
    let color = texel_at(texel).rgb;
    let density = luminance(color) * paths.picture.w;
    return SkyLight(direction, color * paths.picture.z, density);
}

// The sky in a direction, a unit vector of the world that points away from the scene.
fn sky_in(direction: vec3<f32>) -> SkyLight {
    if !is_picture() {
        return gradient_in(direction);
    }
    let size = paths.picture_size.xy;
    // As the picture is turned around z, the other way round.
    let x = direction.x * paths.picture.x + direction.y * paths.picture.y;
    let y = direction.y * paths.picture.x - direction.x * paths.picture.y;
    let place = vec2<f32>(atan2(x, y) / (2.0 * PI) + 0.5, acos(clamp(direction.z, -1.0, 1.0)) / PI);
    let texel = min(vec2<u32>(max(place, vec2<f32>(0.0)) * vec2<f32>(size)), size - 1u);
    return texel_in(direction, texel.y * size.x + texel.x);
}

// An entry of a table of shares, and how far in it.
struct Place {
    entry: u32,
    within: f32,
}

// The first of so many entries whose share reaches beyond `u`.
fn invert(first: u32, count: u32, u: f32) -> Place {
    var low = 0u;
    var high = count - 1u;
    while low < high {
        let middle = (low + high) / 2u;
        if texel_at(first + middle).a <= u {
            low = middle + 1u;
        } else {
            high = middle;
        }
    }
    var start = 0.0;
    if low > 0u {
        start = texel_at(first + low - 1u).a;
    }
    let width = texel_at(first + low).a - start;
    return Place(low, select(0.5, min((u - start) / width, 1.0), width > 0.0));
}

// A direction that light comes from.
fn sample_sky() -> SkyLight {
    let u = vec2<f32>(random(), random());
    if !is_picture() {
        let s = paths.top.w;
        let t = 2.0 * u.x - 1.0;
        let z = (2.0 * t + s) / (1.0 + sqrt(max(1.0 + s * (2.0 * t + s), 0.0)));
        return gradient_in(turned(vec3<f32>(0.0, 0.0, 1.0), clamp(z, -1.0, 1.0), u.y));
    }
    let size = paths.picture_size.xy;
    let row = invert(size.x * size.y, size.y, u.x);
    let column = invert(row.entry * size.x, size.x, u.y);
    // Places are even in the solid angle, which is the turn times the height.
    let sides = texel_at(size.x * size.y + row.entry).xy;
    let z = mix(sides.x, sides.y, row.within);
    let turn = ((f32(column.entry) + column.within) / f32(size.x) - 0.5) * (2.0 * PI);
    let across = sqrt(max(1.0 - z * z, 0.0));
    let x = sin(turn) * across;
    let y = cos(turn) * across;
    let cosine = paths.picture.x;
    let sine = paths.picture.y;
    let direction = vec3<f32>(x * cosine - y * sine, x * sine + y * cosine, z);
    // Of the texel that was chosen: at its sides rounding would find others.
    return texel_in(direction, row.entry * size.x + column.entry);
}

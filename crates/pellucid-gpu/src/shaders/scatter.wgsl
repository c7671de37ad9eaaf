// How samples scatter the light of sources once (6.2, K-07): the tables of `frame.scattering.rs`.
#define_import_path pellucid::scatter

#import pellucid::frame::frame
#import pellucid::lists::entries
#ifdef PERTURBED
#import pellucid::noise::{variation_at, varied_transport}
#endif

const PI: f32 = 3.14159265;

// The lobe of Henyey and Greenstein, that of Schlick, the former with what is thrown back; all others are tables.
const HENYEY_GREENSTEIN: f32 = 1.0;
const SCHLICK: f32 = 2.0;
const HYBRID: f32 = 3.0;

struct Scatterer {
    // Anisotropy.
    g: f32,
    // The part that is a surface, but for what gradients make one.
    surface: f32,
}

// A table at a position among its nodes.
fn entry(table: vec4<f32>, position: f32) -> vec4<f32> {
    let place = clamp(position, 0.0, table.w - 1.0);
    let node = min(u32(place), u32(table.w) - 2u);
    let first = frame.lists.x + u32(table.z) + node;
    return mix(entries[first], entries[first + 1u], place - f32(node));
}

// What a sample of a value is.
fn scatterer_of(value: f32) -> Scatterer {
    if frame.scattering.surfaces.z == 0.0 {
        return Scatterer(frame.scattering.phase.z, 0.0);
    }
    let table = frame.scattering.properties;
    let found = entry(table, (value - table.x) * table.y);
    return Scatterer(select(found.x, frame.scattering.phase.z, frame.scattering.phase.w != 0.0), found.y);
}

// The part of a sample that its gradient makes a surface.
fn gradient_share(magnitude: f32) -> f32 {
    return smoothstep(0.0, 1.0, (magnitude - frame.scattering.surfaces.x) * frame.scattering.surfaces.y);
}

// What gets through of indirect light over so many steps of a value at a position (K-08).
fn transported(p: vec3<f32>, value: f32, steps: f32) -> vec3<f32> {
    let table = frame.scattering.transport;
    let one = entry(table, (value - table.x) * table.y).rgb;
    var lengths = vec3<f32>(steps);
#ifdef PERTURBED
    if frame.noise.counts.y > 0u {
        lengths *= varied_transport(variation_at(p));
    }
#endif
    return select(vec3<f32>(0.0), pow(one, lengths), one > vec3<f32>(0.0));
}

fn henyey_greenstein(g: f32, mu: f32) -> f32 {
    let rest = 1.0 - abs(g);
    let squared = rest * rest + 2.0 * (abs(g) - g * mu);
    return (1.0 - g * g) / (4.0 * PI * squared * sqrt(squared));
}

fn schlick(g: f32, mu: f32) -> f32 {
    let k = clamp(g * (1.55 - 0.55 * g * g), -0.998, 0.998);
    let rest = 1.0 - k * mu;
    return (1.0 - k * k) / (4.0 * PI * rest * rest);
}

// The share of light per steradian that turns by an angle of cosine `mu`: `Phase::eval`.
fn phase_value(g: f32, mu: f32) -> vec3<f32> {
    switch u32(frame.scattering.phase.x) {
        case 1u: { return vec3<f32>(henyey_greenstein(g, mu)); }
        case 2u: { return vec3<f32>(schlick(g, mu)); }
        default: { return listed_value(mu) * frame.scattering.shares.rgb; }
    }
}

fn cosine_at(number: u32) -> f32 {
    return entries[frame.lists.x + u32(frame.scattering.cosines.x) + number].x;
}

// The density per steradian with which `phase_cosine` chooses directions.
fn phase_density(g: f32, mu: f32) -> f32 {
    switch u32(frame.scattering.phase.x) {
        case 1u: { return henyey_greenstein(g, mu); }
        case 2u: { return schlick(g, mu); }
        default: {}
    }
    // Cosines ascend; those between two neighbours are equally likely.
    var low = 0u;
    var high = u32(frame.scattering.cosines.y) - 1u;
    while high - low > 1u {
        let middle = (low + high) / 2u;
        if cosine_at(middle) <= mu {
            low = middle;
        } else {
            high = middle;
        }
    }
    let width = max(cosine_at(high) - cosine_at(low), 1e-9);
    return 1.0 / (2.0 * PI * width * (frame.scattering.cosines.y - 1.0));
}

// A cosine distributed as `phase_density`, from a number in 0..1.
fn phase_cosine(g: f32, u: f32) -> f32 {
    let t = 2.0 * u - 1.0;
    switch u32(frame.scattering.phase.x) {
        case 1u: {
            let numerator = 2.0 * t + g * (3.0 + t * t + g * (2.0 * t + g * (t * t - 1.0)));
            let rest = 1.0 + g * t;
            return clamp(numerator / (2.0 * rest * rest), -1.0, 1.0);
        }
        case 2u: {
            let k = clamp(g * (1.55 - 0.55 * g * g), -0.998, 0.998);
            return clamp((t + k) / (1.0 + k * t), -1.0, 1.0);
        }
        default: {
            let place = u * (frame.scattering.cosines.y - 1.0);
            let node = min(u32(place), u32(frame.scattering.cosines.y) - 2u);
            return mix(cosine_at(node), cosine_at(node + 1u), place - f32(node));
        }
    }
}

// What is listed by angle.
fn listed_value(mu: f32) -> vec3<f32> {
    let table = frame.scattering.angles;
    return entry(table, acos(clamp(mu, -1.0, 1.0)) / PI * (table.w - 1.0)).rgb;
}

// The factor of a light's radiance where its way turns by an angle of cosine `mu`: `Phase::weight`.
fn phase_weight(g: f32, mu: f32) -> vec3<f32> {
    let kind = frame.scattering.phase.x;
    let is_renormalised = frame.scattering.phase.y != 0.0;
    let forward = select(-1.0, 1.0, g >= 0.0);
    if kind == SCHLICK {
        let lobe = schlick(g, mu);
        return vec3<f32>(select(lobe * PI, lobe / schlick(g, forward), is_renormalised));
    }
    var listed = vec3<f32>(0.0);
    if kind != HENYEY_GREENSTEIN {
        listed = listed_value(mu);
    }
    if kind == 0.0 {
        return listed;
    }
    let lobe = henyey_greenstein(g, mu);
    let peak = henyey_greenstein(g, forward);
    if is_renormalised {
        return vec3<f32>(lobe / peak) + listed;
    }
    // What is thrown back is listed over the peak: 0 but for hybrids.
    let share = 1.0 / (1.0 + frame.scattering.back.rgb * peak);
    return share * PI * (lobe + peak * listed);
}

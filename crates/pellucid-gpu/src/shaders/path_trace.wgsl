// A path of light for each pixel, from the eye to where its light came from: `path.rs` of the CPU backend. The pass:
// rows of the picture, the number of the path; 1 if it is the first.
#import pellucid::frame::{frame, bounds}
#import pellucid::each_path::{emission, in_first, in_front, load, vertex_density, vertex_light, vertex_of, vertex_sample, vertex_value}
#import pellucid::extent::{light_seen, sample_light}
#import pellucid::flight::{Aim, Vertex, FAR_AWAY}
#import pellucid::lists::lights
#import pellucid::march::{new_state, states, DONE, HIT}
#import pellucid::paths::paths
#import pellucid::random::{begin_stream, random}
#import pellucid::ray::beam_of
#import pellucid::scatter::PI
#import pellucid::sky::{has_sky, luminance, sample_sky, sky_in}
#import pellucid::surroundings::{encounter, enter, leave, transmittance_from, meets}

// Fewest paths before a pixel may be done, and paths between two looks: as in the CPU backend.
const FEWEST: f32 = 64.0;
const BATCH: u32 = 16u;
const DARK: f32 = 1e-3;

// Through a random point of a pixel, and of the lens.
fn aim_of(pixel: vec2<u32>) -> Aim {
    let at = vec2<f32>(pixel) + vec2<f32>(random(), random());
    var aim = Aim(at, vec3<f32>(0.0), beam_of(at).world);
    if paths.numbers.y > 0.0 {
        let radius = paths.numbers.y * sqrt(random());
        let turn = 2.0 * PI * random();
        aim.across = (paths.lens_right.xyz * cos(turn) + paths.lens_up.xyz * sin(turn)) * radius;
        // From the eye, all in steps.
        let focus = aim.forward * (paths.numbers.z / dot(aim.forward, frame.world_middle.xyz));
        aim.forward = normalize(focus - aim.across);
    }
    return aim;
}

struct Light {
    radiance: vec3<f32>,
    evaluations: u32,
}

// Light that comes straight from a light or from the sky, of which one is asked.
fn direct(layer: u32, p: vec3<f32>, vertex: Vertex, sources: u32) -> Light {
    if sources == 0u {
        return Light(vec3<f32>(0.0), 0u);
    }
    let chosen = min(u32(random() * f32(sources)), sources - 1u);
    var direction = vec3<f32>(0.0);
    var distance = FAR_AWAY;
    var light = vec3<f32>(0.0);
    if chosen < frame.light_count {
        let found = sample_light(chosen, in_first(layer, p));
        direction = found.arriving.to_light;
        distance = found.distance;
        let has_highlight = lights[chosen].radiance.w != 0.0;
        light = vertex_light(layer, vertex, direction, found.arriving.radiance, has_highlight);
        if lights[chosen].extent.kind.y != 0u {
            light /= 1.0 + vertex_density(layer, vertex, direction) * f32(sources) / found.density;
        }
    } else {
        let sky = sample_sky();
        direction = sky.direction;
        let density = sky.density / f32(sources);
        // The balance heuristic (Veach and Guibas 1995): the sky is found by scattering as well.
        let share = 1.0 / (density + vertex_density(layer, vertex, direction));
        light = vertex_value(layer, vertex, direction) * sky.radiance * share / f32(sources);
    }
    if all(light <= vec3<f32>(0.0)) {
        return Light(vec3<f32>(0.0), 0u);
    }
    let left = transmittance_from(layer, p, direction, distance);
    return Light(light * left.rgb * f32(sources), u32(left.a));
}

// The lights that a scattered path meets before its next collision, which is `way` off, from a position in the first
// volume on, with the share that `direct` leaves them. Nothing hides behind a light.
fn lights_met(p: vec3<f32>, direction: vec3<f32>, way: f32, density: f32, sources: u32) -> vec3<f32> {
    var radiance = vec3<f32>(0.0);
    for (var i = 0u; i < frame.light_count; i += 1u) {
        if lights[i].extent.kind.y != 0u {
            let seen = light_seen(i, p, direction);
            if seen.distance <= way {
                radiance += seen.radiance * (density / (density + seen.density / f32(sources)));
            }
        }
    }
    return radiance;
}

// What a path brought.
struct Found {
    radiance: vec3<f32>,
    evaluations: u32,
    // Whether it came to any volume, and to matter there.
    is_met: bool,
    has_collided: bool,
    // What it carries of each colour of light from behind, all of which has come through.
    passed: vec3<f32>,
}

fn follow(aim: Aim) -> Found {
    var found = Found(vec3<f32>(0.0), 0u, false, false, vec3<f32>(1.0));
    var way = enter(aim);
    if !meets(way) {
        return found;
    }
    found.is_met = true;
    var forward = aim.forward;
    // The last collision: in which volume, and where in it.
    var layer = 0u;
    var p = vec3<f32>(0.0);
    var throughput = vec3<f32>(1.0);
    // Density with which the last scattering chose the direction.
    var density = 0.0;
    let sources = frame.light_count + select(0u, 1u, has_sky());
    for (var scatterings = 0u; ; scatterings += 1u) {
        let next = encounter(way, throughput);
        let collision = next.collision;
        throughput = collision.carried;
        found.evaluations += collision.evaluations;
        if scatterings > 0u {
            let met = lights_met(in_first(layer, p), forward, collision.distance, density, sources);
            found.radiance += throughput * met;
        }
        if collision.distance >= FAR_AWAY {
            if scatterings > 0u && has_sky() {
                let sky = sky_in(forward);
                let share = density / (density + sky.density / f32(sources));
                found.radiance += throughput * sky.radiance * share;
            }
            if scatterings == 0u {
                found.passed = throughput;
            }
            return found;
        }
        found.has_collided = true;
        found.passed = vec3<f32>(0.0);
        layer = next.layer;
        p = next.p;
        let color = collision.matter.rgb;
        found.radiance += throughput * color * emission(layer);
        if scatterings == paths.counts.w {
            return found;
        }
        let vertex = vertex_of(layer, p, collision.value, color, forward);
        if vertex.is_surface && paths.surface.x > 0.0 {
            p = in_front(layer, p, vertex.normal, collision.matter.a);
        }
        let light = direct(layer, p, vertex, sources);
        found.radiance += throughput * light.radiance;
        found.evaluations += light.evaluations;
        forward = vertex_sample(layer, vertex);
        density = vertex_density(layer, vertex, forward);
        if !(density > 0.0) {
            return found;
        }
        throughput *= vertex_value(layer, vertex, forward) / density;
        let brightest = max(throughput.x, max(throughput.y, throughput.z));
        if !(brightest > 0.0) {
            return found;
        }
        if scatterings >= paths.more.x && brightest < 1.0 {
            if random() >= brightest {
                return found;
            }
            throughput /= brightest;
        }
        way = leave(layer, p, forward);
    }
    return found;
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= frame.size.x || id.y >= bounds.rows.count {
        return;
    }
    load();
    let slot = id.y * frame.size.x + id.x;
    let path = bounds.rows.ray;
    var state = new_state();
    if bounds.rows.begin == 0u {
        state = states[slot];
    } else {
        state.surface = vec4<f32>(0.0);
        state.place = vec4<f32>(0.0);
    }
    if (state.counts.w & DONE) != 0u {
        return;
    }
    let pixel = id.xy + vec2<u32>(frame.size.y, bounds.rows.first);
    begin_stream(paths.counts.xy, pixel.y * 65536u + pixel.x, path);
    var found = follow(aim_of(pixel));
    if found.is_met {
        state.counts.w |= HIT;
        state.counts.z += 1u;
    }
    // Held back in its own colour, as the CPU backend does.
    let held = paths.surface.z / max(luminance(found.radiance), 1e-30);
    if paths.surface.z > 0.0 && held < 1.0 {
        found.radiance *= held;
    }
    state.color += vec4<f32>(found.radiance, select(0.0, 1.0, found.has_collided));
    state.place += vec4<f32>(found.passed, 0.0);
    state.counts.x += found.evaluations;
    state.counts.y += select(0u, 1u, found.has_collided);
    // Mean and variance as they come (Welford 1962).
    let brightness = luminance(found.radiance);
    let count = state.surface.z + 1.0;
    let difference = brightness - state.surface.x;
    let mean = state.surface.x + difference / count;
    let squares = state.surface.y + difference * (brightness - mean);
    state.surface = vec4<f32>(mean, squares, count, 0.0);
    let error = sqrt(squares / (count * max(count - 1.0, 1.0)));
    let is_looked_at = paths.numbers.x > 0.0 && u32(count) % BATCH == 0u && count >= FEWEST;
    if is_looked_at && error <= paths.numbers.x * max(mean, DARK) {
        state.counts.w |= DONE;
    }
    states[slot] = state;
}

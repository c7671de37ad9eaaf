// The medium that paths cross: where they collide and how much light gets through, as in the CPU backend's
// `path_trace/medium.rs`. Distances are in steps, and so are extinctions.
#define_import_path pellucid::paths

#import pellucid::frame::frame
#import pellucid::flight::{Aim, Collision, Flight, Part, FAR_AWAY}
#import pellucid::lists::Paths
#ifdef LAYERED
#import pellucid::lists::paths as all_paths
#endif
#import pellucid::ray::{beam_of, exit_of, nonzeros, span_of}
#import pellucid::field::field_value
#import pellucid::random::{random, random_depth}
#import pellucid::table::classify
#ifdef PERTURBED
#import pellucid::noise::{variation_at, varied_color, varied_extinction}
#endif

#ifdef LAYERED
var<private> paths: Paths;
#else ifdef STORED_CONSTANTS
@group(0) @binding(19) var<storage, read> paths: Paths;
#else
@group(0) @binding(19) var<uniform> paths: Paths;
#endif
// The largest extinction of every block, and how many blocks away the next one is where there is some.
@group(0) @binding(20) var majorants: texture_3d<f32>;

// Reads the numbers of volume `layer`, if it is one of several.
fn load_paths(layer: u32) {
#ifdef LAYERED
    paths = all_paths[layer];
#endif
}

// A direction of the world in voxels per step.
fn to_voxels(v: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(dot(paths.index_x.xyz, v), dot(paths.index_y.xyz, v), dot(paths.index_z.xyz, v));
}

// The way from a position inside, along a unit vector of the world, to where the medium ends or to `most` steps.
fn leave_along(origin: vec3<f32>, forward: vec3<f32>, most: f32) -> Flight {
    let direction = to_voxels(forward);
    return Flight(origin, direction, min(exit_of(origin, direction), most));
}

// What of a line, from a distance on, is in the volume.
fn part_of(origin: vec3<f32>, direction: vec3<f32>, from_t: f32) -> Part {
    let span = span_of(origin, direction, from_t, FAR_AWAY);
    return Part(Flight(origin + direction * span.x, direction, span.y - span.x), span.x);
}

// What of a ray from the eye is in the volume: from the plane on that the rays of all volumes count from.
fn part_ahead(aim: Aim) -> Part {
    let ray = beam_of(aim.at);
    var origin = ray.origin;
    if paths.numbers.y > 0.0 {
        // From the eye, all in steps.
        let eye = origin - to_voxels(ray.world) * ray.to_base;
        origin = eye + to_voxels(aim.across) + to_voxels(aim.forward) * ray.to_base;
    }
    return part_of(origin, to_voxels(aim.forward), -ray.to_base);
}

// A position in voxels of the first volume: the place that all have in common, as far from the world's origin single
// precision would blur.
fn in_first(p: vec3<f32>) -> vec3<f32> {
#ifdef LAYERED
    let here = vec4<f32>(p, 1.0);
    return vec3<f32>(dot(paths.first_x, here), dot(paths.first_y, here), dot(paths.first_z, here));
#else
    return p;
#endif
}

// What is in the volume of the way from a position in the first one along a unit vector of the world.
fn part_from(first: vec3<f32>, forward: vec3<f32>) -> Part {
    let there = vec4<f32>(first, 1.0);
    let origin = vec3<f32>(dot(paths.own_x, there), dot(paths.own_y, there), dot(paths.own_z, there));
    return part_of(origin, to_voxels(forward), 0.0);
}

// Where a surface is lit: in front of the matter that belongs to it, which is so many mean free paths deep.
fn in_front(p: vec3<f32>, normal: vec3<f32>, extinction: f32) -> vec3<f32> {
    let way = leave_along(p, normal, min(paths.surface.x / extinction, paths.surface.y));
    return way.origin + way.direction * way.length;
}

// A walk from block to block (Amanatides and Woo 1987).
struct Walk {
    block: vec3<i32>,
    // Where the flight leaves the block along each axis.
    exits: vec3<f32>,
}

fn exits_of(flight: Flight, block: vec3<i32>, beyond: i32) -> vec3<f32> {
    // Along the sides of blocks there is a way, too, or a flight would be behind its exit.
    let direction = nonzeros(flight.direction);
    let is_forward = direction > vec3<f32>(0.0);
    let last = vec3<i32>(paths.more.yzw) - 1;
    let room = select(block, last - block, is_forward);
    let side = select(block - beyond, block + (beyond + 1), is_forward);
    let exits = (vec3<f32>(side) * paths.numbers.w - flight.origin) / direction;
    return select(exits, vec3<f32>(FAR_AWAY), vec3<i32>(beyond) >= room);
}

fn walk_of(flight: Flight) -> Walk {
    let last = vec3<i32>(paths.more.yzw) - 1;
    let block = min(vec3<i32>(max(flight.origin / paths.numbers.w, vec3<f32>(0.0))), last);
    return Walk(block, exits_of(flight, block, 0));
}

fn block_of(walk: Walk) -> vec2<f32> {
    return textureLoad(majorants, walk.block, 0).xy;
}

// Goes on to the next block, or over all those that are known to be empty, and tells where the flight enters; FAR_AWAY
// if it ends before.
fn advance(walk: ptr<function, Walk>, flight: Flight, distance_to_next: f32) -> f32 {
    let beyond = max(i32(distance_to_next) - 1, 0);
    let old = (*walk).block;
    let exits = exits_of(flight, old, beyond);
    let exit = min(exits.x, min(exits.y, exits.z));
    if exit >= flight.length {
        return FAR_AWAY;
    }
    let step = select(vec3<i32>(-1), vec3<i32>(1), nonzeros(flight.direction) > vec3<f32>(0.0)) * (beyond + 1);
    // Rounding must not lead out of the cube, nor out of the grid.
    let at = vec3<i32>(floor((flight.origin + flight.direction * exit) / paths.numbers.w));
    let last = vec3<i32>(paths.more.yzw) - 1;
    var block = clamp(clamp(at, old - beyond, old + beyond), vec3<i32>(0), last);
    if exits.x <= exits.y && exits.x <= exits.z {
        block.x = old.x + step.x;
    } else if exits.y <= exits.z {
        block.y = old.y + step.y;
    } else {
        block.z = old.z + step.z;
    }
    *walk = Walk(block, exits_of(flight, block, 0));
    return exit;
}

// Colour, and extinction per step, of a value at a position.
fn matter_at(p: vec3<f32>, value: f32) -> vec4<f32> {
    let matter = classify(value);
#ifdef PERTURBED
    if frame.noise.counts.y > 0u {
        let variation = variation_at(p);
        return vec4<f32>(varied_color(variation, matter.rgb, 1.0), matter.a * varied_extinction(variation));
    }
#endif
    return matter;
}

// A way through a medium as dense as the majorants, from one collision with that to the next.
struct Tracking {
    walk: Walk,
    // Of the last collision, in steps.
    distance: f32,
    // What is left of the optical depth to the next.
    depth: f32,
}

fn begin_tracking(flight: Flight) -> Tracking {
    return Tracking(walk_of(flight), 0.0, random_depth());
}

// Goes on to the next collision. Returns the majorant there, or 0 if the flight ends before.
fn next_collision(tracking: ptr<function, Tracking>, flight: Flight) -> f32 {
    var walk = (*tracking).walk;
    var distance = (*tracking).distance;
    var depth = (*tracking).depth;
    var majorant = 0.0;
    while distance < flight.length {
        let block = block_of(walk);
        let exit = min(min(walk.exits.x, walk.exits.y), min(walk.exits.z, flight.length));
        if block.x > 0.0 {
            let next = distance + depth / block.x;
            if next < exit {
                distance = next;
                depth = random_depth();
                majorant = block.x;
                break;
            }
            depth -= block.x * max(exit - distance, 0.0);
        }
        distance = advance(&walk, flight, block.y);
    }
    *tracking = Tracking(walk, distance, depth);
    return majorant;
}

// Whether colours collide that do so with these chances: together, by what they carry, which changes while its sum stays
// (Kutz et al. 2017).
fn decide(carried: ptr<function, vec3<f32>>, chances: vec3<f32>) -> bool {
    let before = *carried;
    let chance = dot(before, chances) / dot(before, vec3<f32>(1.0));
    let is_real = random() < chance;
    *carried = before * select((1.0 - chances) / (1.0 - chance), chances / chance, is_real);
    return is_real;
}

// The next collision along a flight, by delta tracking (Woodcock et al. 1965): a collision with a medium as dense as
// the majorant is one with the medium as often as that is as dense.
fn collide(flight: Flight, carried: vec3<f32>) -> Collision {
    var found = Collision(FAR_AWAY, 0.0, vec4<f32>(0.0), carried, 0u);
    var left = carried;
    var tracking = begin_tracking(flight);
    loop {
        let majorant = next_collision(&tracking, flight);
        if majorant == 0.0 {
            break;
        }
        found.evaluations += 1u;
        let p = flight.origin + flight.direction * tracking.distance;
        let value = field_value(p);
        let matter = matter_at(p, value);
        let chance = matter.a / majorant;
        var is_real = false;
        if paths.chroma.w == 0.0 {
            is_real = random() < chance;
        } else {
            is_real = decide(&left, min(paths.chroma.rgb * chance, vec3<f32>(1.0)));
        }
        if is_real {
            return Collision(tracking.distance, value, matter, left, found.evaluations);
        }
    }
    found.carried = left;
    return found;
}

// An estimate of the share of each colour that gets through, by ratio tracking (Novak et al. 2014), and the evaluations it
// took.
fn transmittance(flight: Flight) -> vec4<f32> {
    // Below this, a transmittance is left to chance: what gets through is rare and worth as much more.
    const FAINT: f32 = 0.05;
    var tracking = begin_tracking(flight);
    var share = vec3<f32>(1.0);
    var evaluations = 0.0;
    while any(share > vec3<f32>(0.0)) {
        let majorant = next_collision(&tracking, flight);
        if majorant == 0.0 {
            break;
        }
        evaluations += 1.0;
        let p = flight.origin + flight.direction * tracking.distance;
        let matter = matter_at(p, field_value(p));
        share *= 1.0 - min(paths.chroma.rgb * (matter.a / majorant), vec3<f32>(1.0));
        let most = max(share.x, max(share.y, share.z));
        if most < FAINT {
            share *= select(FAINT / most, 0.0, random() * FAINT >= most);
        }
    }
    return vec4<f32>(share, evaluations);
}

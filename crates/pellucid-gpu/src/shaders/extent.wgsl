// Lights that have a size, as paths of light meet them: `extent.rs` of `pellucid-optics`. Distances are in steps.
#define_import_path pellucid::extent

#import pellucid::frame::{frame, world_of}
#import pellucid::arriving::{Incident, incident}
#import pellucid::normal::normalized
#import pellucid::lists::{Extent, lights}
#import pellucid::flight::FAR_AWAY
#import pellucid::random::random
#import pellucid::scatter::PI
#import pellucid::vertex::turned_by

const DISC: u32 = 1u;
const BALL: u32 = 2u;
const FACE: u32 = 3u;

// Lights whose sine is smaller than this, squared, are points: single precision has no directions between.
const SMALLEST: f32 = 1e-12;

// Light from one place of a light.
struct LightSample {
    // As bright as a light of no extent would be that stands for all of this one.
    arriving: Incident,
    distance: f32,
    // Per steradian, with which the direction was chosen; FAR_AWAY if there is but one.
    density: f32,
}

// A light as it is seen in some direction.
struct LightSeen {
    radiance: vec3<f32>,
    distance: f32,
    // Per steradian, with which `sample_light` chooses the direction.
    density: f32,
}

// The way to the middle of a light that is somewhere.
fn way_to(number: u32, p: vec3<f32>) -> vec3<f32> {
    return lights[number].place.xyz - world_of(p);
}

// How much of a face is seen by light that goes along `to_light` to it.
fn face_cosine(extent: Extent, to_light: vec3<f32>) -> f32 {
    let cosine = -dot(extent.normal.xyz, to_light);
    return select(max(cosine, 0.0), abs(cosine), extent.kind.z != 0u);
}

// Radiance per radiance of a light at the face's middle, which is `way` off.
fn face_brightness(extent: Extent, way: vec3<f32>) -> f32 {
    return PI * dot(way, way) / extent.normal.w;
}

// The directions in which a disc or a ball is seen: the squared sine of the angle from the middle to the edge, 0 if they
// are but one, and one less its cosine.
fn cap_of(number: u32, p: vec3<f32>) -> vec2<f32> {
    let extent = lights[number].extent;
    var sine_squared = 0.0;
    if extent.kind.x == DISC {
        sine_squared = extent.normal.w;
    } else if extent.kind.x == BALL {
        let way = way_to(number, p);
        sine_squared = min(extent.normal.w * extent.normal.w / dot(way, way), 1.0);
    }
    if !(sine_squared >= SMALLEST) {
        return vec2<f32>(0.0);
    }
    return vec2<f32>(sine_squared, sine_squared / (1.0 + sqrt(1.0 - sine_squared)));
}

// Steps to the near side of a ball, in a direction in which it is seen; a disc is far away.
fn cap_distance(number: u32, p: vec3<f32>, direction: vec3<f32>) -> f32 {
    let extent = lights[number].extent;
    if extent.kind.x != BALL {
        return FAR_AWAY;
    }
    let way = way_to(number, p);
    let beside = cross(way, direction);
    let radius = extent.normal.w;
    return max(dot(way, direction) - sqrt(max(radius * radius - dot(beside, beside), 0.0)), 0.0) / frame.picture.w;
}

// Light from a random place of a light, were nothing in between.
fn sample_light(number: u32, p: vec3<f32>) -> LightSample {
    let middle = incident(lights[number], p);
    let extent = lights[number].extent;
    if extent.kind.x == 0u {
        let distance = select(FAR_AWAY, length(way_to(number, p)) / frame.picture.w, lights[number].place.w != 0.0);
        return LightSample(middle, distance, FAR_AWAY);
    }
    let u = vec2<f32>(random(), random());
    if extent.kind.x == FACE {
        let to_middle = way_to(number, p);
        let way = to_middle + extent.first.xyz * (u.x - 0.5) + extent.second.xyz * (u.y - 0.5);
        // On the face itself there is no direction.
        let squared = max(dot(way, way), 1e-30);
        let to_light = normalized(way);
        let seen = face_cosine(extent, to_light) * extent.normal.w / squared;
        let radiance = middle.radiance * (face_brightness(extent, to_middle) * seen / PI);
        return LightSample(Incident(to_light, radiance), sqrt(squared) / frame.picture.w, 1.0 / max(seen, 1e-30));
    }
    let cap = cap_of(number, p);
    if cap.x == 0.0 {
        return LightSample(middle, cap_distance(number, p, middle.to_light), FAR_AWAY);
    }
    // By its height, since small angles have cosines that round to 1.
    let height = u.x * cap.y;
    let to_light = turned_by(middle.to_light, 1.0 - height, sqrt(height * (2.0 - height)), u.y);
    // Its radiance over the density is 2 / (1 + cosine of the edge).
    let arriving = Incident(to_light, middle.radiance * (2.0 / (2.0 - cap.y)));
    return LightSample(arriving, cap_distance(number, p, to_light), 1.0 / (2.0 * PI * cap.y));
}

// The light where a ray in some direction, a unit vector of the world, meets it; no radiance beside it.
fn light_seen(number: u32, p: vec3<f32>, direction: vec3<f32>) -> LightSeen {
    let beside = LightSeen(vec3<f32>(0.0), FAR_AWAY, 1.0);
    let middle = incident(lights[number], p);
    let extent = lights[number].extent;
    if extent.kind.x == FACE {
        let to_middle = way_to(number, p);
        let cosine = face_cosine(extent, direction);
        if !(cosine > 0.0) {
            return beside;
        }
        let distance = dot(to_middle, extent.normal.xyz) / dot(direction, extent.normal.xyz);
        // From the middle to where the ray meets its plane, in shares of the edges.
        let place = direction * distance - to_middle;
        let across = vec2<f32>(
            dot(cross(place, extent.second.xyz), extent.normal.xyz),
            dot(cross(extent.first.xyz, place), extent.normal.xyz)
        );
        if !(distance > 0.0 && all(abs(across) <= vec2<f32>(0.5 * extent.normal.w))) {
            return beside;
        }
        let radiance = middle.radiance * face_brightness(extent, to_middle);
        return LightSeen(radiance, distance / frame.picture.w, distance * distance / (extent.normal.w * cosine));
    }
    let cap = cap_of(number, p);
    let across = cross(middle.to_light, direction);
    if cap.x == 0.0 || !(dot(middle.to_light, direction) > 0.0 && dot(across, across) <= cap.x) {
        return beside;
    }
    return LightSeen(middle.radiance / cap.x, cap_distance(number, p, direction), 1.0 / (2.0 * PI * cap.y));
}

// What happens to light where a path collides with the medium: `vertex.rs` of the CPU backend, and `reflection.rs` of
// `pellucid-optics`.
#define_import_path pellucid::vertex

#import pellucid::frame::frame
#import pellucid::flight::Vertex
#import pellucid::normal::normalized
#import pellucid::random::random
#import pellucid::table::node_of
#ifdef PERTURBED
#import pellucid::noise::{variation_at, varied_color}
#endif
#import pellucid::scatter::{PI, entry, scatterer_of, phase_value, phase_weight, phase_density, phase_cosine}
#ifdef SHADED
#import pellucid::field::field_gradient
#import pellucid::normal::normal_of
#import pellucid::scatter::gradient_share
#endif

// The unit vector at an angle of cosine `mu` from the unit vector `axis`, a share `turn` of a full turn around it.
fn turned(axis: vec3<f32>, mu: f32, turn: f32) -> vec3<f32> {
    return turned_by(axis, mu, sqrt(max(1.0 - mu * mu, 0.0)), turn);
}

// The same with the angle's sine, which its cosine does not tell where it is small.
fn turned_by(axis: vec3<f32>, mu: f32, across: f32, turn: f32) -> vec3<f32> {
    // Duff et al. 2017.
    let sign = select(-1.0, 1.0, axis.z >= 0.0);
    let a = -1.0 / (sign + axis.z);
    let b = axis.x * axis.y * a;
    let side = vec3<f32>(1.0 + sign * axis.x * axis.x * a, sign * b, -sign * axis.x);
    let up = vec3<f32>(b, sign + axis.y * axis.y * a, -axis.y);
    let angle = 2.0 * PI * turn;
    return normalize(axis * mu + (side * cos(angle) + up * sin(angle)) * across);
}

// How a sample of the medium scatters.
fn cloud_vertex(p: vec3<f32>, value: f32, forward: vec3<f32>) -> Vertex {
    // Albedos are at the nodes of the transfer function's table.
    var albedo = entry(frame.scattering.transport, node_of(value)).rgb;
#ifdef PERTURBED
    if frame.noise.counts.y > 0u {
        albedo = varied_color(variation_at(p), albedo, 1.0);
    }
#endif
    return Vertex(vec4<f32>(albedo, scatterer_of(value).g), forward, vec3<f32>(0.0), false);
}

// The surface at a collision, as often as the collision is one with a surface (K-11).
fn vertex_of(p: vec3<f32>, value: f32, color: vec3<f32>, forward: vec3<f32>) -> Vertex {
#ifdef SHADED
    let surface = normal_of(field_gradient(p));
#ifdef WEIGHTED
    let share = gradient_share(surface.magnitude);
#else
    let share = scatterer_of(value).surface;
#endif
    let is_met = random() < share && surface.magnitude > 0.0;
    let facing = -dot(surface.direction, forward);
    if is_met && (facing >= 0.0 || frame.two_sided != 0u) && frame.material.y + frame.material.z > 0.0 {
        let normal = select(surface.direction, -surface.direction, facing < 0.0);
        return Vertex(vec4<f32>(color, 0.0), forward, normal, true);
    }
#endif
    return cloud_vertex(p, value, forward);
}

// What of its colour the matter shines by itself.
fn emission() -> f32 {
    return frame.material.x;
}

// The share of a surface's light that is diffuse, as samples are taken.
fn diffuse_share() -> f32 {
    let specular = frame.material.z * min(8.0 / (frame.material.w + 2.0), 1.0);
    return frame.material.y / max(frame.material.y + specular, 1e-20);
}

// What is seen of a light by local reflection, with its cosine (5.4).
fn reflected(vertex: Vertex, to_light: vec3<f32>, has_highlight: bool) -> vec3<f32> {
    let facing = max(dot(vertex.normal, to_light), 0.0);
    if facing == 0.0 {
        return vec3<f32>(0.0);
    }
    var light = vertex.color.rgb * (facing * frame.material.y);
    let tilt = clamp(dot(vertex.normal, normalized(to_light - vertex.forward)), 0.0, 1.0);
    if has_highlight && tilt > 0.0 && frame.material.z > 0.0 {
        light += vec3<f32>(pow(tilt, frame.material.w) * frame.material.z);
    }
    return light;
}

// The share of the light from a direction that goes to the eye, per steradian.
fn vertex_value(vertex: Vertex, direction: vec3<f32>) -> vec3<f32> {
    if vertex.is_surface {
        return reflected(vertex, direction, true) / PI;
    }
    return vertex.color.rgb * phase_value(vertex.color.a, dot(vertex.forward, direction));
}

// The density per steradian with which `vertex_sample` chooses a direction.
fn vertex_density(vertex: Vertex, direction: vec3<f32>) -> f32 {
    if !vertex.is_surface {
        return phase_density(vertex.color.a, dot(vertex.forward, direction));
    }
    let diffuse = max(dot(vertex.normal, direction), 0.0) / PI;
    let halfway = normalized(direction - vertex.forward);
    let tilt = max(dot(vertex.normal, halfway), 0.0);
    let seen = dot(-vertex.forward, halfway);
    var specular = 0.0;
    if seen > 0.0 && tilt > 0.0 {
        // Directions lie four times as densely around their own middle as halves around theirs.
        specular = (frame.material.w + 1.0) / (2.0 * PI) * pow(tilt, frame.material.w) / (4.0 * seen);
    }
    let share = diffuse_share();
    return share * diffuse + (1.0 - share) * specular;
}

// Where the path goes on.
fn vertex_sample(vertex: Vertex) -> vec3<f32> {
    let choice = random();
    let u = random();
    let turn = random();
    if !vertex.is_surface {
        return turned(vertex.forward, phase_cosine(vertex.color.a, u), turn);
    }
    if choice < diffuse_share() {
        return turned(vertex.normal, sqrt(1.0 - u), turn);
    }
    let halfway = turned(vertex.normal, pow(1.0 - u, 1.0 / (frame.material.w + 1.0)), turn);
    let seen = dot(-vertex.forward, halfway);
    // What is turned away from the eye reflects nothing.
    if seen > 0.0 {
        return normalize(halfway * (2.0 * seen) + vertex.forward);
    }
    return -vertex.normal;
}

// What goes to the eye of a light of no extent.
fn vertex_light(vertex: Vertex, to_light: vec3<f32>, radiance: vec3<f32>, has_highlight: bool) -> vec3<f32> {
    if vertex.is_surface {
        return reflected(vertex, to_light, has_highlight) * radiance;
    }
    return phase_weight(vertex.color.a, dot(vertex.forward, to_light)) * vertex.color.rgb * radiance;
}

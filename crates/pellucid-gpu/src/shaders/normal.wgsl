// Unit normals out of surfaces (5.3).
#define_import_path pellucid::normal

struct Normal {
    // Unit, out of the surface towards lower values; zero where there is no gradient.
    direction: vec3<f32>,
    // The gradient's.
    magnitude: f32,
}

fn normal_of(gradient: vec3<f32>) -> Normal {
    let scale = max(max(abs(gradient.x), abs(gradient.y)), abs(gradient.z));
    if scale < 1.1754944e-38 || scale > 3.0e38 {
        return Normal(vec3<f32>(0.0), 0.0);
    }
    // Squares of very short and very long gradients leave the range of numbers.
    let scaled = gradient / scale;
    let size = length(scaled);
    return Normal(-scaled / size, size * scale);
}

fn normalized(v: vec3<f32>) -> vec3<f32> {
    let squared = dot(v, v);
    if squared <= 1e-24 {
        return vec3<f32>(0.0);
    }
    return v / sqrt(squared);
}

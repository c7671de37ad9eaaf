// Integrals over segments between two values (4.6-7): the tables of `pellucid-optics`.
#define_import_path pellucid::integrals

#import pellucid::frame::frame
#import pellucid::field::is_present
#import pellucid::lists::entries
#import pellucid::table::{clamped_node, over, over_length, segment_over}

// The entry between two nodes of the table: front + count * back.
fn bilinear(front: f32, back: f32) -> vec4<f32> {
    let count = frame.dims.w;
    let x = min(u32(front), count - 2u);
    let y = min(u32(back), count - 2u);
    let corner = frame.lists.x + x + y * count;
    let u = front - f32(x);
    let near = mix(entries[corner], entries[corner + 1u], u);
    let far = mix(entries[corner + count], entries[corner + count + 1u], u);
    return mix(near, far, back - f32(y));
}

// A segment within the table.
fn within(at: vec2<f32>, length: f32) -> vec4<f32> {
    if length == 1.0 {
        return bilinear(at.x, at.y);
    }
    return segment_over(bilinear(at.x, at.y), bilinear(at.y, at.x), length);
}

// So many steps from one value to another. The parts beyond the table, where the medium is constant, are composed with
// the part within, each with its own share of the length.
fn integral(values: vec2<f32>, length: f32) -> vec4<f32> {
    let inside = clamp(values, frame.table.xx, frame.table.yy);
    let at = vec2<f32>(clamped_node(inside.x), clamped_node(inside.y));
    if all(values == inside) || inside.x == inside.y {
        return within(at, length);
    }
    let shares = abs(values - inside) / abs(values.y - values.x);
    let first = over_length(bilinear(at.x, at.x), shares.x * length);
    let middle = within(at, (1.0 - shares.x - shares.y) * length);
    let last = over_length(bilinear(at.y, at.y), shares.y * length);
    return over(over(first, middle), last);
}

// A segment; where one end is absent the field reaches half way with the value of the other.
fn between(front: f32, back: f32, length: f32) -> vec4<f32> {
    let has_front = is_present(front);
    let has_back = is_present(back);
    if has_front && has_back {
        return integral(vec2<f32>(front, back), length);
    }
    if !has_front && !has_back {
        return vec4<f32>(0.0);
    }
    let value = select(back, front, has_front);
    return integral(vec2<f32>(value), length * 0.5);
}

// The value that stands for a segment.
fn value_of(segment: vec2<f32>) -> f32 {
    let front = select(segment.y, segment.x, is_present(segment.x));
    let back = select(segment.x, segment.y, is_present(segment.y));
    return (front + back) * 0.5;
}

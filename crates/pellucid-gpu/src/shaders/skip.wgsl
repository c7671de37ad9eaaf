// Empty-space skipping over blocks (7.3-6). Leaps go from sample to sample, and only over samples that
// add exactly nothing.
#define_import_path pellucid::skip

#import pellucid::frame::frame
#import pellucid::ray::{Ray, ray_at, ray_sample, ray_node}
#import pellucid::pieces::{Cells, leap_to}
#ifdef EXTREMES
#import pellucid::pieces::next_cell
#endif

#ifdef EXTREMES
// The largest value of every block, or the smallest with its sign turned.
@group(1) @binding(2) var blocks: texture_3d<f32>;
#else
// How many blocks away the next one is that can contribute; 0 if this one can. Where steps adapt to
// the data, the level of the stride that the block allows is in y.
@group(1) @binding(2) var blocks: texture_3d<u32>;
#endif

fn block_at(p: vec3<f32>) -> vec3<i32> {
    let last = vec3<i32>(frame.blocks.xyz) - 1;
    // As floats, because processors divide integers one by one: the middle of a cell is far from where rounding
    // could put it into the next block.
    let middle = max(floor(p), vec3<f32>(0.0)) + 0.5;
    return min(vec3<i32>(middle / f32(frame.blocks.w)), last);
}

// Steps from a position to the surface of the cube around its block that reaches `reach` blocks to
// every side, its own included: a little short of it, so that rounding leaps over no sample beyond.
fn leave(inverse: vec3<f32>, p: vec3<f32>, block: vec3<i32>, reach: f32) -> f32 {
    const MARGIN: f32 = 2e-3;
    let size = f32(frame.blocks.w);
    let high = (vec3<f32>(block) + reach) * size - MARGIN;
    let low = (vec3<f32>(block) - reach + 1.0) * size + MARGIN;
    let steps = (select(low, high, inverse > vec3<f32>(0.0)) - p) * inverse;
    return min(min(steps.x, steps.y), steps.z);
}

#ifdef EXTREMES
// Goes on to the first piece that may exceed `best`.
fn leap_cells(ray: Ray, cells: ptr<function, Cells>, best: f32) {
    while (*cells).ends.x < (*cells).length {
        let middle = ((*cells).ends.x + (*cells).ends.y) * 0.5;
        let p = ray_at(ray, middle);
        let block = block_at(p);
        if textureLoad(blocks, block, 0).x > best {
            break;
        }
        // To the last cell inside, and over it.
        leap_to(cells, middle + max(leave(ray.inverse, p, block, 1.0), 0.0));
        next_cell(cells);
    }
}
#else
// The first sample from k on that may contribute, or one beyond the last.
fn leap_samples(ray: Ray, from_k: f32) -> f32 {
    var k = from_k;
    while k < ray.count {
        let p = ray_at(ray, ray_sample(ray, k));
        let block = block_at(p);
        let reach = f32(textureLoad(blocks, block, 0).x);
        if reach == 0.0 {
            break;
        }
        k += max(ceil(leave(ray.inverse, p, block, reach)), 1.0);
    }
    return k;
}
#endif

#ifdef STRIDES
// The level of the stride at sample k (7.3-3).
fn stride_level(ray: Ray, k: f32) -> u32 {
    return textureLoad(blocks, block_at(ray_at(ray, ray_sample(ray, k))), 0).y;
}
#endif

#ifndef EXTREMES
// The node in front of the first segment from n on that may contribute.
fn leap_segments(ray: Ray, from_n: f32) -> f32 {
    var n = from_n;
    while n <= ray.count {
        let p = ray_at(ray, ray_node(ray, n));
        let block = block_at(p);
        let reach = textureLoad(blocks, block, 0).x;
        if reach == 0u {
            break;
        }
        // To the last node inside the cube.
        let far = ceil(leave(ray.inverse, p, block, f32(reach))) - 1.0;
        if far <= 0.0 {
            break;
        }
        n += far;
    }
    return n;
}

// How many steps lead from a position to where something may be, or a little less; 0 where something may be here.
fn way_to_matter(ray: Ray, p: vec3<f32>) -> f32 {
    let block = block_at(p);
    let reach = textureLoad(blocks, block, 0).x;
    return select(max(leave(ray.inverse, p, block, f32(reach)), 0.0), 0.0, reach == 0u);
}

// Leaps from the face by which a cell is entered, which is not looked at if the cell is left. How many steps.
fn leap_faces(ray: Ray, cells: ptr<function, Cells>) -> f32 {
    let before = (*cells).ends.x;
    let to = before + way_to_matter(ray, ray_at(ray, before));
    if to <= (*cells).ends.y {
        return 0.0;
    }
    leap_to(cells, to);
    return max(min((*cells).ends.x, (*cells).length) - before, 0.0);
}

// Whether the block of a position contributes nothing.
fn is_empty(p: vec3<f32>) -> bool {
    return textureLoad(blocks, block_at(p), 0).x != 0u;
}

// How many steps from a position on certainly contribute nothing, those that are taken there included.
fn clear_steps(p: vec3<f32>, inverse: vec3<f32>) -> f32 {
    let block = block_at(p);
    let reach = textureLoad(blocks, block, 0).x;
    return select(max(ceil(leave(inverse, p, block, f32(reach))), 1.0), 0.0, reach == 0u);
}
#endif

//! The polygons that the vertex stage cuts out of boxes, against what planes and boxes are (3.5-2).

use crate::common::device;
use naga_oil::compose::{ComposableModuleDescriptor, Composer, NagaModuleDescriptor};
use pellucid_gpu::Ceiling;
use wgpu::util::{BufferInitDescriptor, DeviceExt};
use wgpu::{
    BindGroupDescriptor, BindGroupEntry, BufferDescriptor, BufferUsages, ComputePipelineDescriptor, MapMode,
    ShaderModuleDescriptor, ShaderSource,
};

const CASES: usize = 100_000;

/// Runs the vertex stage's function for every case: low and high corner, and the plane.
const SHADER: &str = "
#import pellucid::polygon::polygon_corner

struct Case { low: vec4<f32>, high: vec4<f32>, plane: vec4<f32> }

@group(0) @binding(0) var<storage, read> cases: array<Case>;
@group(0) @binding(1) var<storage, read_write> corners: array<vec4<f32>>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= arrayLength(&cases) {
        return;
    }
    let it = cases[id.x];
    for (var k = 0u; k < 6u; k += 1u) {
        corners[6u * id.x + k] = polygon_corner(it.low.xyz, it.high.xyz, it.plane, k);
    }
}
";

type Four = [f32; 4];

fn corners(cases: &[[Four; 3]]) -> Vec<[Four; 6]> {
    let device = device(&Ceiling::default());
    let mut composer = Composer::default();
    let source = include_str!("../../src/shaders/polygon.wgsl");
    let module = ComposableModuleDescriptor { source, file_path: "polygon", ..Default::default() };
    composer.add_composable_module(module).unwrap();
    let module = NagaModuleDescriptor { source: SHADER, file_path: "test", ..Default::default() };
    let source = ShaderSource::Naga(std::borrow::Cow::Owned(composer.make_naga_module(module).unwrap()));
    let module = device.device.create_shader_module(ShaderModuleDescriptor { label: None, source });
    let pipeline = device.device.create_compute_pipeline(&ComputePipelineDescriptor {
        label: None,
        layout: None,
        module: &module,
        entry_point: Some("main"),
        compilation_options: Default::default(),
        cache: None,
    });
    let contents = bytemuck::cast_slice(cases);
    let given = BufferInitDescriptor { label: None, contents, usage: BufferUsages::STORAGE };
    let given = device.device.create_buffer_init(&given);
    let size = (size_of::<[Four; 6]>() * cases.len()) as u64;
    let buffer =
        |usage| device.device.create_buffer(&BufferDescriptor { label: None, size, usage, mapped_at_creation: false });
    let found = buffer(BufferUsages::STORAGE | BufferUsages::COPY_SRC);
    let read = buffer(BufferUsages::MAP_READ | BufferUsages::COPY_DST);
    let group = device.device.create_bind_group(&BindGroupDescriptor {
        label: None,
        layout: &pipeline.get_bind_group_layout(0),
        entries: &[
            BindGroupEntry { binding: 0, resource: given.as_entire_binding() },
            BindGroupEntry { binding: 1, resource: found.as_entire_binding() },
        ],
    });
    let mut encoder = device.device.create_command_encoder(&Default::default());
    let mut pass = encoder.begin_compute_pass(&Default::default());
    pass.set_pipeline(&pipeline);
    pass.set_bind_group(0, &group, &[]);
    pass.dispatch_workgroups(cases.len().div_ceil(64) as u32, 1, 1);
    drop(pass);
    encoder.copy_buffer_to_buffer(&found, 0, &read, 0, size);
    device.queue.submit([encoder.finish()]);
    read.map_async(MapMode::Read, .., |result| result.unwrap());
    device.wait().unwrap();
    let mapped = read.get_mapped_range(..).unwrap();
    bytemuck::cast_slice(&mapped).to_vec()
}

/// Numbers between 0 and 1 that are the same every time (SplitMix64).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ z >> 31) >> 11) as f64 / (1u64 << 53) as f64
    }

    fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }
}

type Three = [f64; 3];

fn dot(a: Three, b: Three) -> f64 {
    (0..3).map(|k| a[k] * b[k]).sum()
}

fn minus(a: Three, b: Three) -> Three {
    [0, 1, 2].map(|k| a[k] - b[k])
}

fn cross(a: Three, b: Three) -> Three {
    [0, 1, 2].map(|k| a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3])
}

/// Twice the area of a polygon, as a vector.
fn area(corners: &[Three]) -> Three {
    let mut sum = [0.0; 3];
    for k in 1..corners.len().max(1) - 1 {
        let part = cross(minus(corners[k], corners[0]), minus(corners[k + 1], corners[0]));
        sum = [0, 1, 2].map(|axis| sum[axis] + part[axis]);
    }
    sum
}

/// Twice the area in which a plane cuts a box: its points on all edges, sorted by their angle.
fn reference(low: Three, high: Three, normal: Three, offset: f64) -> f64 {
    let mut points: Vec<Three> = Vec::new();
    for axis in 0..3 {
        for corner in 0..4 {
            let mut p = low;
            p[(axis + 1) % 3] = if corner & 1 == 0 { low } else { high }[(axis + 1) % 3];
            p[(axis + 2) % 3] = if corner & 2 == 0 { low } else { high }[(axis + 2) % 3];
            p[axis] = 0.0;
            let at = -(dot(normal, p) + offset) / normal[axis];
            if normal[axis] != 0.0 && at >= low[axis] && at <= high[axis] {
                p[axis] = at;
                points.push(p);
            }
        }
    }
    if points.len() < 3 {
        return 0.0;
    }
    let middle = [0, 1, 2].map(|k| points.iter().map(|p| p[k]).sum::<f64>() / points.len() as f64);
    let along = minus(points[0], middle);
    let across = cross(normal, along);
    points.sort_by(|a, b| {
        let angle = |p: &Three| {
            dot(minus(*p, middle), across).atan2(dot(minus(*p, middle), along) * dot(normal, normal).sqrt())
        };
        angle(a).total_cmp(&angle(b))
    });
    let vector = area(&points);
    dot(vector, vector).sqrt()
}

#[test]
fn polygons_of_the_vertex_stage_are_those_of_the_planes() {
    let mut random = Random(7);
    let cases: Vec<[Four; 3]> = (0..CASES)
        .map(|number| {
            let low = [0; 3].map(|_| random.within(-20.0, 20.0) as f32);
            let high = low.map(|v| v + random.within(0.1, 30.0) as f32);
            let mut normal = [0; 3].map(|_| random.within(-1.0, 1.0) as f32);
            // Planes along an axis or two, too.
            for axis in 0..2 {
                if number % (5 + axis) == 0 {
                    normal[(number + axis) % 3] = 0.0;
                }
            }
            let through = [0, 1, 2].map(|k| low[k] + (high[k] - low[k]) * random.within(-0.1, 1.1) as f32);
            let offset = -(0..3).map(|k| normal[k] * through[k]).sum::<f32>();
            let four = |[x, y, z]: [f32; 3], w| [x, y, z, w];
            [four(low, 0.0), four(high, 0.0), four(normal, offset)]
        })
        .collect();
    let found = corners(&cases);
    let mut met = 0;
    for (case, six) in cases.iter().zip(&found) {
        let [low, high, normal] = case.map(|v| [v[0], v[1], v[2]].map(f64::from));
        let offset = f64::from(case[2][3]);
        let expected = reference(low, high, normal, offset);
        let there = six.iter().filter(|corner| corner[3] != 0.0).count();
        let size = (0..3).map(|k| high[k] - low[k]).fold(0.0, f64::max);
        if there == 0 {
            // Rounding decides about planes that touch a corner.
            assert!(expected < 1e-3 * size * size, "{case:?} is missed: {expected}");
            continue;
        }
        assert_eq!(there, 6, "{case:?}: {six:?}");
        met += 1;
        let corners = six.map(|v| [v[0], v[1], v[2]].map(f64::from));
        let length = dot(normal, normal).sqrt();
        for p in corners {
            assert!((dot(normal, p) + offset).abs() / length < 1e-4 * size, "{case:?}: {p:?} is beside the plane");
            for axis in 0..3 {
                assert!(p[axis] > low[axis] - 1e-4 && p[axis] < high[axis] + 1e-4, "{case:?}: {p:?} is outside");
            }
        }
        // One winding: the area's vector is against the normal, wherever the nearest corner is.
        let vector = area(&corners);
        let turned = -dot(vector, normal) / length;
        assert!((turned.abs() - expected).abs() < 1e-3 * size * size, "{case:?}: {turned} for {expected}");
        assert!(turned.abs() < 1e-4 * size * size || turned > 0.0, "{case:?} winds the other way");
        for k in 0..6 {
            let [a, b, c] = [k, (k + 1) % 6, (k + 2) % 6].map(|k| corners[k]);
            let turn = -dot(cross(minus(b, a), minus(c, b)), normal) / length;
            assert!(turn > -1e-3 * size * size, "{case:?} is not convex at corner {k}");
        }
    }
    assert!(met > CASES / 2, "{met}");
}

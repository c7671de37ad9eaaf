//! What is drawn of a frame: which boxes, cut by which slices, in which order.

use std::ops::Range;

use bytemuck::cast_slice;
use glam::DVec3;
use pellucid_field::Grid;
use pellucid_scene::{BlendOrder, Proxy, Slicing, Stage};
use wgpu::{Buffer, BufferUsages};

use super::boxes::{SliceBox, boxes};
use super::lattice::Lattice;
use super::polygon::polygon;
use crate::bricks::{self, Brick};
use crate::optics::{Optics, is_of_segments};
use crate::shaders::Pass;
use crate::texture::Part;
use crate::uploads::storage;
use crate::{Device, GpuError};

/// Proxies on the device.
pub struct Geometry {
    /// Bricks in the order in which they are drawn, each with its share of the instances.
    pub shares: Vec<(Brick, Range<u32>)>,
    /// Boxes.
    pub boxes: Buffer,
    /// How many there are.
    pub box_count: u32,
    /// Box and slice of each proxy, or its polygon.
    pub instances: Buffer,
    /// Triangles of a proxy.
    pub indices: Buffer,
    /// How many indices they have.
    pub index_count: u32,
    /// Slices of the whole volume.
    pub slices: u32,
    /// The pass that makes proxies.
    pub pass: Pass,
}

impl Geometry {
    /// Finds what is to be drawn. Boxes are drawn larger by `margin` voxels.
    ///
    /// # Errors
    /// [`GpuError::Budget`] if there are more proxies than a buffer holds.
    pub fn new(
        device: &Device,
        (stage, grid): (&Stage, &Grid),
        (slicing, lattice): (&Slicing, &Lattice),
        optics: &Optics,
        bricks: &[Brick],
        margin: DVec3,
    ) -> Result<Self, GpuError> {
        let mut bricks = bricks.to_vec();
        bricks::sort(&mut bricks, stage, grid);
        // A segment ends beyond the cell in which it begins.
        let reach = (stage.step * lattice.longest.min(MOST_STRIDE) / grid.smallest_spacing()).ceil() as usize;
        let reach = if is_of_segments(stage) { reach } else { 0 };
        let (mut all, mut instances, mut shares) = (Vec::new(), Vec::<[u32; 2]>::new(), Vec::new());
        for brick in bricks {
            let first = instances.len() as u32;
            for part in boxes(&brick, optics.blocks, reach, stage, grid) {
                let (low, high) = corners(&part, grid);
                let [from, to] = lattice.slices(stage, grid, low, high);
                instances.extend((from..to).map(|slice| [all.len() as u32, slice]));
                all.push(part);
            }
            shares.push((brick, first..instances.len() as u32));
        }
        if slicing.order == BlendOrder::BackToFront {
            let count = instances.len() as u32;
            instances.reverse();
            shares.reverse();
            for (_, range) in &mut shares {
                *range = count - range.end..count - range.start;
            }
        }
        let (pass, indices) = match slicing.proxy {
            _ if lattice.has_shells() => (Pass::SliceShells, faces()),
            Proxy::VertexStage => (Pass::SlicePolygons, fan()),
            Proxy::Processor => (Pass::SliceGivenPolygons, fan()),
        };
        let cut = |&[number, slice]: &[u32; 2]| {
            let (low, high) = corners(&all[number as usize], grid);
            let (normal, offset) = lattice.plane();
            let at = f64::from(slice * lattice.samples) + lattice.drawn_at - offset;
            hexagon(&polygon(low - margin, high + margin, normal, at), number, slice)
        };
        let boxes: Vec<SliceBox> = all.iter().map(|&part| part.into()).collect();
        let bytes: Vec<u8> = match pass {
            Pass::SliceGivenPolygons => {
                let corners: Vec<[[f32; 4]; 6]> = instances.iter().map(cut).collect();
                cast_slice(&corners).to_vec()
            }
            _ => cast_slice(&instances).to_vec(),
        };
        let most = device.capabilities.limits.max_storage_buffer_binding_size;
        if bytes.len() as u64 > most {
            let (what, advice) = ("the slices".to_owned(), "take a longer step or let the vertex stage cut them");
            return Err(GpuError::Budget { what, needed: bytes.len() as u64, budget: most, advice });
        }
        let (low, high) = grid.index_bounds();
        let [first, last] = lattice.slices(stage, grid, low, high);
        Ok(Self {
            shares,
            boxes: storage(device, "boxes", &boxes),
            box_count: boxes.len() as u32,
            instances: storage(device, "instances", &bytes),
            index_count: indices.len() as u32,
            indices: device.buffer("indices", cast_slice(&indices), BufferUsages::INDEX),
            slices: last - first,
            pass,
        })
    }

    /// As many slices through several volumes, each of which is one brick; `asked` are those of the setting.
    pub fn windows(device: &Device, [count, asked]: [u32; 2], slicing: &Slicing, brick: Brick) -> Self {
        let mut instances: Vec<u32> = (0..count).collect();
        if slicing.order == BlendOrder::BackToFront {
            instances.reverse();
        }
        Self {
            shares: vec![(brick, 0..count)],
            boxes: storage::<SliceBox>(device, "boxes", &[]),
            box_count: 0,
            instances: storage(device, "instances", &instances),
            index_count: 3,
            indices: device.buffer("indices", cast_slice(&[0u16, 1, 2, 0]), BufferUsages::INDEX),
            slices: asked,
            pass: Pass::SliceWindows,
        }
    }

    /// All proxies.
    pub fn count(&self) -> u32 {
        self.shares.iter().map(|(_, range)| range.end).max().unwrap_or(0)
    }
}

/// Strides beyond this belong to rays along the slices, which meet next to none.
pub const MOST_STRIDE: f64 = 4.0;

/// The corners of the cells of a part; where there is one voxel only, the box is thicker than the grid.
fn corners(part: &Part, grid: &Grid) -> (DVec3, DVec3) {
    let (low, high) = grid.index_bounds();
    let corner = |v: [usize; 3]| DVec3::from_array(v.map(|v| v as f64));
    let thin = |axis: usize| grid.dims()[axis] == 1;
    let flat = glam::BVec3::new(thin(0), thin(1), thin(2));
    (DVec3::select(flat, low, corner(part.low)), DVec3::select(flat, high, corner(part.high)))
}

/// A polygon of six corners around its first.
fn fan() -> Vec<u16> {
    vec![0, 1, 2, 0, 2, 3, 0, 3, 4, 0, 4, 5]
}

/// Six faces of four corners each.
fn faces() -> Vec<u16> {
    (0..6).flat_map(|face| [0, 1, 2, 0, 2, 3].map(|corner| 4 * face + corner)).collect()
}

/// A polygon with its last corner repeated, and its box and slice with the first two.
fn hexagon(corners: &[DVec3], number: u32, slice: u32) -> [[f32; 4]; 6] {
    let mut six = [[0.0; 4]; 6];
    for (k, place) in six.iter_mut().enumerate() {
        let p = corners.get(k).or(corners.last()).copied().unwrap_or(DVec3::NAN);
        *place = p.extend(0.0).as_vec4().to_array();
    }
    (six[0][3], six[1][3]) = (number as f32, slice as f32);
    six
}

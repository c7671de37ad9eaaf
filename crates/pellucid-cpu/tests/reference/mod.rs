//! The readable statement of what the ray caster computes: plain f64 code straight from the
//! definitions, slow and without any acceleration, one file per mode. It shares the camera, the
//! control points of the transfer function, the voxel values, the light that a lamp sends to a point
//! and the weights of wide filters with the engine, and nothing else: no tables, no samplers, no
//! blocks, no lattice, no vectors.

mod composite;
mod field;
mod isosurface;
mod light;
mod path;
mod projection;

use std::sync::Arc;

use glam::DVec3;
use pellucid_optics::{PreIntegration, TransferFunction, extinction};
use pellucid_plan::blue_noise;
use pellucid_scene::{Combine, Jitter, Mode, Slice, Stage, StageVolume};

pub use field::{Field, Reading};
use path::Path;

/// How closely a depth is compared, in steps.
pub const DEPTH: f64 = 1e-3;
/// How closely a coordinate of a normal is compared.
pub const NORMAL: f64 = 1e-3;

/// What a ray or a pixel sees.
#[derive(Clone, Copy, Debug)]
pub struct Seen {
    /// Associated linear RGBA.
    pub color: [f64; 4],
    /// How much of each channel rounding decides.
    pub doubt: [f64; 4],
    /// Distance from the eye; infinite where there is nothing. `None` if rounding decides which of
    /// two it is.
    pub depth: Option<f64>,
    /// World normal at that depth, or zero. `None` if rounding decides.
    pub normal: Option<DVec3>,
}

impl Seen {
    const NOTHING: Self =
        Self { color: [0.0; 4], doubt: [0.0; 4], depth: Some(f64::INFINITY), normal: Some(DVec3::ZERO) };

    fn colored(color: [f64; 4]) -> Self {
        Self { color, ..Self::NOTHING }
    }
}

/// A stage, under one reading of what the definition leaves to rounding.
pub struct Reference<'a> {
    stage: &'a Stage,
    staged: &'a StageVolume,
    tf: &'a TransferFunction,
    field: Field<'a>,
    mode: &'a Mode,
    /// Integrals of segments, where they are not computed anew.
    table: Option<Arc<PreIntegration>>,
}

impl<'a> Reference<'a> {
    /// The only volume of a stage.
    pub fn new(stage: &'a Stage, reading: Reading) -> Self {
        let staged = &stage.volumes[0];
        let mode = stage.mode();
        Self { stage, staged, tf: &staged.transfer_function, field: Field::new(stage, reading), mode, table: None }
    }

    /// The same with a table for the definition of a pre-integrated segment: the one of
    /// [`PreIntegration`], whose tests hold it to the integral.
    pub fn with_table(self, table: Option<Arc<PreIntegration>>) -> Self {
        Self { table, ..self }
    }

    /// What the pixel in column x and row y sees: the mean of its rays' colours and the nearest of
    /// their surfaces. `None` if a ray meets a surface where rounding decides what it sees.
    pub fn pixel(&self, x: usize, y: usize) -> Option<Seen> {
        let n = self.stage.quality.supersampling as usize;
        let mut seen = Seen::NOTHING;
        for sub in 0..n * n {
            let inside = |cell: usize| (cell as f64 + 0.5) / n as f64;
            let ray = self.stage.viewpoint.ray(x as f64 + inside(sub % n), y as f64 + inside(sub / n));
            let jitter = match self.stage.quality.jitter {
                Jitter::Centered => 0.5,
                Jitter::BlueNoise { seed } => (blue_noise(x, y, seed) + sub as f64 * 0.618_033_988_749_894_9).fract(),
            };
            let Some(path) = Path::new(ray, self.stage, self.slab(), jitter) else { continue };
            let found = self.trace(&path)?;
            for channel in 0..4 {
                seen.color[channel] += found.color[channel] / (n * n) as f64;
                seen.doubt[channel] += found.doubt[channel] / (n * n) as f64;
            }
            (seen.depth, seen.normal) = match (seen.depth, found.depth) {
                (Some(a), Some(b)) if a.is_finite() && (a - b).abs() < 1e-5 * self.stage.step => (seen.depth, None),
                (Some(a), Some(b)) if a <= b => (seen.depth, seen.normal),
                (Some(_), Some(_)) => (found.depth, found.normal),
                _ => (None, None),
            };
        }
        Some(seen)
    }

    fn trace(&self, path: &Path) -> Option<Seen> {
        Some(match self.mode {
            Mode::Composite => return self.composite(path),
            Mode::Maximum => self.extreme(path, 1.0, false),
            Mode::Minimum => self.extreme(path, -1.0, false),
            Mode::Average => self.average(path, false),
            Mode::Additive => self.additive(path),
            Mode::XRay => self.x_ray(path),
            Mode::Isosurface(surfaces) => return self.surfaces(path, surfaces),
            Mode::Slice(slice) if slice.thickness == 0.0 => return self.cut(path, slice),
            Mode::Slice(slice) => match slice.combine {
                Combine::Maximum => self.extreme(path, 1.0, true),
                Combine::Minimum => self.extreme(path, -1.0, true),
                Combine::Average => self.average(path, true),
            },
        })
    }

    /// The middle of the voxels that a crop leaves, or of all of them.
    fn middle(&self) -> DVec3 {
        let grid = self.staged.volume.grid();
        let middle = |axis: usize| {
            let last = (grid.dims()[axis] - 1) as f64;
            let [from, to] = self.staged.crop.map_or([0.0, last], |crop| [crop.from[axis], crop.to[axis]]);
            (from.max(0.0) + to.min(last)) / 2.0
        };
        grid.world_from_index().transform_point3(DVec3::from_array([0, 1, 2].map(middle)))
    }

    /// Point and unit normal of a slice.
    fn plane(&self, slice: &Slice) -> [DVec3; 2] {
        let point = slice.point.map_or_else(|| self.middle(), DVec3::from_array);
        let normal = slice.normal.map_or(-self.stage.viewpoint.forward, DVec3::from_array);
        [point, normal.normalize()]
    }

    /// The half-spaces of a thick slice: unit normals and offsets.
    fn slab(&self) -> Vec<(DVec3, f64)> {
        match self.mode {
            Mode::Slice(slice) if slice.thickness > 0.0 => {
                let [point, normal] = self.plane(slice);
                let (middle, half) = (normal.dot(point), slice.thickness / 2.0);
                vec![(normal, middle - half), (-normal, -middle - half)]
            }
            _ => Vec::new(),
        }
    }

    /// The opacity of a length at a value.
    fn opacity(&self, value: f64, length: f64) -> f64 {
        over_length(f64::from(self.tf.opacity(value)), length / self.unit())
    }

    /// Extinction per world unit at a value.
    fn extinction(&self, value: f64) -> f64 {
        extinction(f64::from(self.tf.opacity(value)), self.unit())
    }

    fn color(&self, value: f64) -> [f64; 3] {
        self.tf.color(value).map(f64::from)
    }

    fn unit(&self) -> f64 {
        self.tf.unit_distance().expect("a stage has it set")
    }
}

/// The opacity over `ratio` times the length it holds for (1.4-13).
fn over_length(opacity: f64, ratio: f64) -> f64 {
    1.0 - (1.0 - opacity).powf(ratio)
}

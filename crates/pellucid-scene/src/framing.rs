//! What a camera frames: the support function of what can be seen, the largest `p . d` over its points p for a
//! direction d. It is all that [`Camera::framing`](crate::Camera::framing) asks, so that a silhouette is as tight as
//! the data and not as blocks or boxes around them.

use glam::{DMat3, DVec3};
use pellucid_field::{Blocks, Grid, Volume};
use pellucid_optics::{DataRange, Perturbation, Table, Visibility};

use crate::auto::shows_values;
use crate::population::Population;
use crate::{Framing, Mode, Region, StageVolume};

/// What is framed of one volume.
pub struct Framed<'v> {
    /// Corners of what clips, crops and the slice leave of the grid, or of the grid.
    corners: Vec<DVec3>,
    /// What the transfer function or the isovalues show of that, if they hide anything.
    seen: Option<SeenCells<'v>>,
}

impl<'v> Framed<'v> {
    pub fn new(volume: &'v StageVolume, mode: &Mode, framing: Framing) -> Self {
        let grid = volume.volume.grid();
        let whole = || grid.world_corners().to_vec();
        if framing == Framing::Grid {
            return Self { corners: whole(), seen: None };
        }
        let mut region = volume.region.clone();
        if let Mode::Slice(slice) = mode
            && let Some(normal) = slice.normal
        {
            let (normal, point) = (DVec3::from_array(normal).normalize(), volume.slice_point(slice));
            // A plane without a thickness has no corners of its own.
            let half = normal * (slice.thickness / 2.0).max(1e-6 * grid.smallest_spacing());
            region.keep(normal, point - half);
            region.keep(-normal, point + half);
        }
        let corners = region.corners_in(grid);
        if corners.is_empty() {
            return Self { corners: whole(), seen: None };
        }
        Self { corners, seen: SeenCells::new(volume, mode) }
    }

    /// The support function. What is seen is no more than what is left.
    pub fn support(&self, direction: DVec3) -> f64 {
        let left = self.corners.iter().map(|corner| corner.dot(direction)).fold(f64::NEG_INFINITY, f64::max);
        self.seen.as_ref().map_or(left, |seen| seen.support(direction).min(left))
    }
}

/// The cells of a grid whose values can be seen, found in blocks.
struct SeenCells<'v> {
    volume: &'v Volume,
    component: usize,
    region: &'v Region,
    /// Whether anything between two values is seen.
    seen: Box<dyn Fn(f64, f64) -> bool + 'v>,
    /// First cells of the blocks that hold something to see.
    blocks: Vec<[usize; 3]>,
    /// How far noise can move what is seen, in world units.
    moved: f64,
    /// Beyond these a voxel that stands alone is a fault of the data.
    credible: [f64; 2],
}

impl<'v> SeenCells<'v> {
    /// `None` if nothing can be seen, or everything.
    fn new(staged: &'v StageVolume, mode: &Mode) -> Option<Self> {
        let (volume, component) = (&*staged.volume, staged.component);
        let grid = volume.grid();
        let seen: Box<dyn Fn(f64, f64) -> bool> = match mode {
            Mode::Isosurface(surfaces) => {
                let values: Vec<f64> =
                    surfaces.isovalues.iter().filter(|iso| iso.opacity > 0.0).map(|iso| iso.value).collect();
                Box::new(move |low, high| values.iter().any(|value| (low..=high).contains(value)))
            }
            mode if shows_values(mode) => return None,
            _ => {
                let table = Table::for_data(&staged.transfer_function, &DataRange::of(volume)).ok()?;
                let visibility = Visibility::of_table(&table);
                let least = least_opacity(grid, staged.unit_distance());
                Box::new(move |low, high| visibility.max_opacity(low as f32, high as f32) > least)
            }
        };
        let blocks = Blocks::new(volume, component, Blocks::CELLS, 0).ok()?;
        let [nx, ny, _] = blocks.dims();
        let mut found = Vec::new();
        for (b, [low, high]) in blocks.ranges().iter().enumerate() {
            let first = [b % nx, b / nx % ny, b / (nx * ny)].map(|b| b * Blocks::CELLS);
            if low <= high && seen(f64::from(*low), f64::from(*high)) {
                found.push(first);
            }
        }
        let moved = farthest_shift(&staged.perturbation, grid);
        let credible = credible(volume, component);
        let mut cells = Self { volume, component, region: &staged.region, seen, blocks: found, moved, credible };
        // Blocks may be seen that no cell is: on the far side of a clip, say.
        if !cells.support(DVec3::X).is_finite() {
            cells.credible = [f64::NEG_INFINITY, f64::INFINITY];
        }
        cells.support(DVec3::X).is_finite().then_some(cells)
    }

    /// Whether a voxel is hot or dead: far from what others are, and none beside it as far. It would draw the camera
    /// to it.
    fn is_fault(&self, voxel: [usize; 3]) -> bool {
        let [low, high] = self.credible;
        let is_beyond = |voxel| {
            let value = self.volume.value(voxel, self.component);
            value < low || value > high
        };
        let dims = self.volume.grid().dims();
        let beside = (0..3).flat_map(|axis| {
            let moved = move |to: usize| [0, 1, 2].map(|a| if a == axis { to } else { voxel[a] });
            [voxel[axis].checked_sub(1), Some(voxel[axis] + 1).filter(|i| *i < dims[axis])].map(|i| i.map(moved))
        });
        is_beyond(voxel) && !beside.flatten().any(is_beyond)
    }

    fn support(&self, direction: DVec3) -> f64 {
        let grid = self.volume.grid();
        let affine = grid.world_from_index();
        // The support in index space: one dot product and the place of the first voxel.
        let slope = affine.matrix3.transpose() * direction;
        let mut search = Search { cells: self, slope, best: f64::NEG_INFINITY };
        let mut blocks: Vec<(f64, [usize; 3])> =
            self.blocks.iter().map(|first| (bound(slope, self.bounds(*first, Blocks::CELLS)), *first)).collect();
        // Few are looked into: those that reach beyond what was found in others.
        let by_bound = |a: &(f64, [usize; 3]), b: &(f64, [usize; 3])| b.0.total_cmp(&a.0);
        let mut rest = blocks.as_mut_slice();
        while !rest.is_empty() {
            const AT_A_TIME: usize = 64;
            let few = rest.len().min(AT_A_TIME);
            if few < rest.len() {
                rest.select_nth_unstable_by(few - 1, by_bound);
            }
            let (now, later) = rest.split_at_mut(few);
            now.sort_unstable_by(by_bound);
            for (bound, first) in now.iter() {
                if *bound <= search.best {
                    return search.found(direction);
                }
                search.block(*first);
            }
            rest = later;
        }
        search.found(direction)
    }

    /// The box of so many cells per axis in index space.
    fn bounds(&self, first: [usize; 3], cells: usize) -> (DVec3, DVec3) {
        let (grid, start) = (self.volume.grid(), DVec3::from_array(first.map(|i| i as f64)));
        let (low, high) = grid.index_bounds();
        // A single voxel reaches to both sides of its sample.
        let flat = grid.dims().map(|n| n == 1);
        let start = DVec3::from_array([0, 1, 2].map(|axis| if flat[axis] { low[axis] } else { start[axis] }));
        (start, (start + cells as f64).min(high))
    }
}

/// The search for what reaches farthest in a direction.
struct Search<'s, 'v> {
    cells: &'s SeenCells<'v>,
    /// The direction, in index space.
    slope: DVec3,
    best: f64,
}

impl Search<'_, '_> {
    fn found(&self, direction: DVec3) -> f64 {
        let shift = self.cells.volume.grid().world_from_index().translation.dot(direction);
        self.best + shift + self.cells.moved * direction.length()
    }

    /// The cells of a block, from the corner that reaches farthest.
    fn block(&mut self, first: [usize; 3]) {
        let dims = self.cells.volume.grid().dims();
        let count = [0, 1, 2].map(|axis| (dims[axis].max(2) - 1 - first[axis]).min(Blocks::CELLS));
        let order = |axis: usize, k: usize| first[axis] + if self.slope[axis] > 0.0 { count[axis] - 1 - k } else { k };
        let places: [Vec<usize>; 3] = [0, 1, 2].map(|axis| (0..count[axis]).map(|k| order(axis, k)).collect());
        for &z in &places[2] {
            for &y in &places[1] {
                for &x in &places[0] {
                    self.cell([x, y, z]);
                }
            }
        }
    }

    fn cell(&mut self, first: [usize; 3]) {
        let SeenCells { volume, component, region, .. } = *self.cells;
        let grid = volume.grid();
        let bounds = self.cells.bounds(first, 1);
        if bound(self.slope, bounds) <= self.best || region.excludes(grid, bounds) {
            return;
        }
        let dims = grid.dims();
        let voxel = |k: usize| [0, 1, 2].map(|axis| (first[axis] + (k >> axis & 1)).min(dims[axis] - 1));
        let values: [f64; 8] = std::array::from_fn(|k| volume.value(voxel(k), component));
        let [low, high] = self.cells.credible;
        // Absent values are neither.
        let strange = |value: &f64| *value < low || *value > high;
        if values.iter().any(strange) && (0..8).any(|k| strange(&values[k]) && self.cells.is_fault(voxel(k))) {
            return;
        }
        self.part(bounds, values, FINEST);
    }

    /// A part of a cell and the values in its corners. Values between them are interpolated, so that none lies
    /// outside of theirs.
    fn part(&mut self, bounds: (DVec3, DVec3), values: [f64; 8], halvings: u32) {
        let reach = bound(self.slope, bounds);
        let finite = values.iter().filter(|value| value.is_finite());
        let (low, high) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(*v), b.max(*v)));
        if reach <= self.best || low > high || !(self.cells.seen)(low, high) {
            return;
        }
        if halvings == 0 || !values.iter().all(|value| value.is_finite()) {
            self.best = reach;
            return;
        }
        let at = |place: [f64; 3]| {
            (0..8)
                .map(|k| {
                    let weight: f64 =
                        (0..3).map(|axis| if k >> axis & 1 == 1 { place[axis] } else { 1.0 - place[axis] }).product();
                    weight * values[k]
                })
                .sum::<f64>()
        };
        let farthest = (0..3).fold(0, |octant, axis| octant | usize::from(self.slope[axis] > 0.0) << axis);
        let (low, high) = bounds;
        for octant in (0..8).map(|k| k ^ farthest) {
            let start = DVec3::from_array(std::array::from_fn(|axis| 0.5 * (octant >> axis & 1) as f64));
            let part = (low + (high - low) * start, low + (high - low) * (start + 0.5));
            let values = std::array::from_fn(|k| at(std::array::from_fn(|a| start[a] + 0.5 * (k >> a & 1) as f64)));
            self.part(part, values, halvings - 1);
        }
    }
}

/// The values of a component but for outliers, and as far again on either side.
fn credible(volume: &Volume, component: usize) -> [f64; 2] {
    /// Enough to find the ends of the thousandths; the search for them is short beside that through the blocks.
    const SOME: usize = 1 << 16;
    let ends = Population::of_some(volume, component, SOME).ends();
    let [low, high] = ends.filter(|[low, high]| low < high).unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
    [low - (high - low), high + (high - low)]
}

/// How often a cell is halved on each axis: what is seen is known to an eighth of a voxel.
const FINEST: u32 = 3;

/// The support function of a box in index space.
fn bound(slope: DVec3, (low, high): (DVec3, DVec3)) -> f64 {
    (slope * low).max(slope * high).element_sum()
}

/// The opacity of a unit distance that stays below half a step of 8 bits however far a ray goes through it.
fn least_opacity(grid: &Grid, unit_distance: f64) -> f32 {
    let (low, high) = grid.index_bounds();
    let size = DMat3::from_diagonal(DVec3::from_array(grid.spacing())) * (high - low);
    (1.0 - (1.0 - 1.0 / 512.0f64).powf(unit_distance / size.length())) as f32
}

/// How far noise moves what is drawn, in world units: octaves are independent, and hardly ever does their sum exceed
/// the root of the sum of their squares.
fn farthest_shift(perturbation: &Perturbation, grid: &Grid) -> f64 {
    let displacement = &perturbation.displacement;
    let (low, high) = grid.index_bounds();
    let longest = (DVec3::from_array(grid.spacing()) * (high - low)).max_element();
    let squares: f32 = displacement.octaves.iter().map(|octave| octave.weight.powi(2)).sum();
    f64::from(displacement.amplitude * squares.sqrt()) * longest
}

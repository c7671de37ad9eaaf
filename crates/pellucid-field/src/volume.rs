//! A grid with values.

use std::sync::OnceLock;

use rayon::prelude::*;

use crate::{FieldError, Grid, Voxel, Voxels, for_voxels, parallel};

/// The affine from stored numbers to data values: `value = stored * scale + offset` (a CT file
/// that stores Hounsfield units + 1024, a NIfTI slope and intercept). Voxels keep their stored
/// type; everything a user sees or sets is in data values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ValueMap {
    /// Data units per stored unit; not zero.
    pub scale: f64,
    /// Data value of a stored 0.
    pub offset: f64,
}

impl ValueMap {
    /// Stored numbers are the values.
    pub const IDENTITY: Self = Self { scale: 1.0, offset: 0.0 };

    /// The data value of a stored number.
    pub fn value(&self, stored: f64) -> f64 {
        stored * self.scale + self.offset
    }

    /// The stored number of a data value.
    pub fn stored(&self, value: f64) -> f64 {
        (value - self.offset) / self.scale
    }
}

/// What a pass over all values tells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Statistics {
    /// Smallest finite data value over all components (0 if there is none).
    pub min: f64,
    /// Largest finite data value (0 if there is none).
    pub max: f64,
    /// Mean of the finite data values (0 if there is none).
    pub mean: f64,
    /// Finite values.
    pub finite: u64,
    /// NaN values.
    pub nan: u64,
    /// Infinite values.
    pub infinite: u64,
}

/// A sampled field: a [`Grid`], its [`Voxels`] with 1 to 4 interleaved components, and what the
/// numbers mean. Cloning shares the voxels.
#[derive(Clone, Debug)]
pub struct Volume {
    grid: Grid,
    voxels: Voxels,
    components: usize,
    value_map: ValueMap,
    /// Short name for messages, usually the file's.
    pub name: String,
    /// What it is, in its own words, where a file or its maker says so.
    pub description: Option<String>,
    /// Unit of the data values ("HU", "K"), if known.
    pub value_unit: Option<String>,
    /// Unit of world lengths ("mm"), if known.
    pub length_unit: Option<String>,
    /// Whether the world is a patient's, with x to the left, y to the back and z to the head: where a file states no
    /// such frame, nobody knows its sides.
    pub is_anatomical: bool,
    statistics: OnceLock<Statistics>,
}

impl Volume {
    /// A volume of one component per voxel.
    ///
    /// # Errors
    /// [`FieldError::Length`] if the values do not fill the grid.
    pub fn new(grid: Grid, voxels: impl Into<Voxels>) -> Result<Self, FieldError> {
        Self::with_components(grid, voxels, 1)
    }

    /// A volume of `components` (1 to 4) interleaved values per voxel.
    ///
    /// # Errors
    /// [`FieldError::Components`] and [`FieldError::Length`].
    pub fn with_components(grid: Grid, voxels: impl Into<Voxels>, components: usize) -> Result<Self, FieldError> {
        let voxels = voxels.into();
        if !(1..=4).contains(&components) {
            return Err(FieldError::Components { found: components });
        }
        let expected = grid.len() * components;
        if voxels.len() != expected {
            return Err(FieldError::Length { found: voxels.len(), expected });
        }
        Ok(Self {
            grid,
            voxels,
            components,
            value_map: ValueMap::IDENTITY,
            name: String::new(),
            description: None,
            value_unit: None,
            length_unit: None,
            is_anatomical: false,
            statistics: OnceLock::new(),
        })
    }

    /// The same volume with another meaning of its stored numbers.
    ///
    /// # Errors
    /// [`FieldError::Parameter`] if the scale is zero or either number is not finite.
    pub fn with_value_map(mut self, map: ValueMap) -> Result<Self, FieldError> {
        if map.scale == 0.0 || !map.scale.is_finite() {
            return Err(FieldError::Parameter { name: "value scale", found: map.scale, expected: "finite and not 0" });
        }
        if !map.offset.is_finite() {
            return Err(FieldError::Parameter { name: "value offset", found: map.offset, expected: "finite" });
        }
        self.value_map = map;
        self.statistics = OnceLock::new();
        Ok(self)
    }

    /// The same volume under another name.
    pub fn with_name(mut self, name: impl Into<String>) -> Self {
        self.name = name.into();
        self
    }

    /// The same values on another grid of the same dims (a corrected spacing, a new origin).
    ///
    /// # Errors
    /// [`FieldError::Length`] if the dims differ.
    pub fn with_grid(mut self, grid: Grid) -> Result<Self, FieldError> {
        if grid.dims() != self.grid.dims() {
            return Err(FieldError::Length { found: self.grid.len(), expected: grid.len() });
        }
        self.grid = grid;
        Ok(self)
    }

    /// Makes sure that there is a component of that number.
    pub(crate) fn check_component(&self, component: usize) -> Result<(), FieldError> {
        if component < self.components {
            return Ok(());
        }
        let expected = "below the number of components (the first is 0)";
        Err(FieldError::Parameter { name: "component", found: component as f64, expected })
    }

    /// Other samples of the same thing, so many to a voxel: same value map, name and units.
    pub(crate) fn with_samples(
        &self,
        grid: Grid,
        voxels: impl Into<Voxels>,
        components: usize,
    ) -> Result<Self, FieldError> {
        let volume = Self::with_components(grid, voxels, components)?;
        Ok(Self {
            value_map: self.value_map,
            name: self.name.clone(),
            value_unit: self.value_unit.clone(),
            length_unit: self.length_unit.clone(),
            is_anatomical: self.is_anatomical,
            ..volume
        })
    }

    /// Where the samples are.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// The stored values.
    pub fn voxels(&self) -> &Voxels {
        &self.voxels
    }

    /// Values per voxel, 1 to 4.
    pub fn components(&self) -> usize {
        self.components
    }

    /// What stored numbers mean.
    pub fn value_map(&self) -> ValueMap {
        self.value_map
    }

    /// The data value of component `component` at voxel (x, y, z).
    ///
    /// # Panics
    /// If the voxel or the component is out of range.
    pub fn value(&self, voxel: [usize; 3], component: usize) -> f64 {
        assert!((0..3).all(|axis| voxel[axis] < self.grid.dims()[axis]) && component < self.components);
        let index = self.grid.linear_index(voxel) * self.components + component;
        self.value_map.value(self.voxels.get(index))
    }

    /// Range, mean and absent values over all components; computed on first use, in parallel.
    pub fn statistics(&self) -> &Statistics {
        self.statistics.get_or_init(|| {
            let part = for_voxels!(&self.voxels, data => scan(data));
            let (a, b) = (self.value_map.value(part.min), self.value_map.value(part.max));
            if part.finite == 0 {
                return Statistics { min: 0.0, max: 0.0, mean: 0.0, ..part };
            }
            Statistics {
                min: a.min(b),
                max: a.max(b),
                mean: self.value_map.value(part.mean / part.finite as f64),
                ..part
            }
        })
    }
}

/// Statistics of stored numbers, with the sum in `mean`. Chunks are summed in order, so the result
/// does not depend on the number of threads.
fn scan<T: Voxel>(data: &[T]) -> Statistics {
    let empty = Statistics { min: f64::INFINITY, max: f64::NEG_INFINITY, mean: 0.0, finite: 0, nan: 0, infinite: 0 };
    let of_chunk = |chunk: &[T]| {
        chunk.iter().fold(empty, |mut s, v| {
            let v = v.to_f64();
            if v.is_finite() {
                s.min = s.min.min(v);
                s.max = s.max.max(v);
                s.mean += v;
                s.finite += 1;
            } else if v.is_nan() {
                s.nan += 1;
            } else {
                s.infinite += 1;
            }
            s
        })
    };
    let parts: Vec<Statistics> = parallel(|| data.par_chunks(1 << 16).map(of_chunk).collect());
    parts.into_iter().fold(empty, |a, b| Statistics {
        min: a.min.min(b.min),
        max: a.max.max(b.max),
        mean: a.mean + b.mean,
        finite: a.finite + b.finite,
        nan: a.nan + b.nan,
        infinite: a.infinite + b.infinite,
    })
}

//! Errors and warnings about data.

use std::fmt;

use crate::{Short, VoxelType};

/// Why a grid or a volume cannot be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FieldError {
    /// An axis has no voxels, or the voxels do not fit into the address space.
    #[error("dims {0}x{1}x{2}: every axis needs at least 1 voxel and their product must fit in memory", dims[0], dims[1], dims[2])]
    Dims {
        /// The dims found, x, y, z.
        dims: [usize; 3],
    },
    /// The affine has a zero, infinite or NaN volume.
    #[error(
        "the index-to-world affine is singular or not finite (determinant {}): spacing must be positive and the directions independent",
        Short(*determinant)
    )]
    Affine {
        /// Determinant of the linear part, in world units cubed.
        determinant: f64,
    },
    /// Voxels so small, so large or so far away that single precision, in which light and gradients are computed,
    /// has no numbers for them.
    #[error(
        "{what} is {} world units: {} to {} can be drawn; state lengths in another unit or correct the spacing",
        Short(*found), Short(*least), Short(*most)
    )]
    Extent {
        /// What is too small or too large.
        what: &'static str,
        /// Its length.
        found: f64,
        /// The smallest allowed.
        least: f64,
        /// The largest allowed.
        most: f64,
    },
    /// Unsupported number of components.
    #[error("{found} components per voxel: 1 to 4 are supported")]
    Components {
        /// The number found.
        found: usize,
    },
    /// The voxel buffer does not match the grid.
    #[error("{found} voxel values for a grid that needs {expected} (dims x components)")]
    Length {
        /// Values found.
        found: usize,
        /// Values expected.
        expected: usize,
    },
    /// A region lies outside the grid or is empty.
    #[error("region from {from:?} of size {size:?} does not lie inside a grid of {dims:?}")]
    Region {
        /// First voxel.
        from: [usize; 3],
        /// Voxels per axis.
        size: [usize; 3],
        /// Dims of the grid.
        dims: [usize; 3],
    },
    /// A numeric setting is outside its range.
    #[error("{name} is {}: {expected}", Short(*found))]
    Parameter {
        /// The setting.
        name: &'static str,
        /// Its value.
        found: f64,
        /// What is allowed.
        expected: &'static str,
    },
}

/// Something about the data that a user should hear of although work goes on. Nothing is lost
/// silently: readers and converters return these beside the volume.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Warning {
    /// The stored type is not kept: values were converted.
    Converted {
        /// Name of the type in the file.
        from: String,
        /// The type the voxels have now.
        to: VoxelType,
        /// Largest absolute difference between a value before and after, in data units.
        largest_error: f64,
    },
    /// Values that are NaN or infinite; they are treated as absent.
    NotFinite {
        /// NaN values.
        nan: u64,
        /// Infinite values.
        infinite: u64,
    },
    /// Anything a file says that was ignored or guessed, in one line.
    File(String),
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Converted { from, to, largest_error } if *largest_error == 0.0 => {
                write!(f, "{from} values are kept as {to}, without loss")
            }
            Self::Converted { from, to, largest_error } => {
                write!(f, "{from} values are kept as {to}: the largest change of a value is {}", Short(*largest_error))
            }
            Self::NotFinite { nan, infinite } => {
                write!(f, "{nan} NaN and {infinite} infinite values are treated as absent")
            }
            Self::File(line) => f.write_str(line),
        }
    }
}

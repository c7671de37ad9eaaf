//! What has to be said of values without a header.

use crate::{Endian, StoredType};

/// What a file without a header cannot say: x is fastest, components are interleaved.
#[derive(Clone, Debug, PartialEq)]
pub struct RawLayout {
    /// Voxels per axis, x, y, z.
    pub dims: [usize; 3],
    /// Type of the values.
    pub stored: StoredType,
    /// Values per voxel, 1 to 4.
    pub components: usize,
    /// Distance between voxels per axis, in world units.
    pub spacing: [f64; 3],
    /// Byte order of the values.
    pub endian: Endian,
    /// Bytes before the values. `None` says that there are none, and that the file must have
    /// exactly the size of its values; with a number, what follows the values is ignored.
    pub skip: Option<u64>,
}

impl RawLayout {
    /// One component, unit spacing, little-endian, and nothing but values in the file.
    pub fn new(dims: [usize; 3], stored: impl Into<StoredType>) -> Self {
        let (components, spacing, endian, skip) = (1, [1.0; 3], Endian::Little, None);
        Self { dims, stored: stored.into(), components, spacing, endian, skip }
    }
}

//! The types of values in files.

use std::fmt;
use std::str::FromStr;

use pellucid_field::VoxelType;

/// The types of values that files hold: those of [`VoxelType`] and the 64-bit ones, which are
/// narrowed when they are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum StoredType {
    /// A type that voxels can have; kept.
    Voxel(VoxelType),
    /// Signed 64 bit; becomes `i32` or `u32` if all values fit, `u32` counted from the smallest if their differences
    /// fit, else `f32`.
    I64,
    /// Unsigned 64 bit; becomes what signed ones become.
    U64,
    /// IEEE 754 double; becomes `f32`.
    F64,
}

impl StoredType {
    /// Every type, smallest first.
    pub const ALL: [Self; 11] = [
        Self::Voxel(VoxelType::U8),
        Self::Voxel(VoxelType::I8),
        Self::Voxel(VoxelType::U16),
        Self::Voxel(VoxelType::I16),
        Self::Voxel(VoxelType::F16),
        Self::Voxel(VoxelType::U32),
        Self::Voxel(VoxelType::I32),
        Self::Voxel(VoxelType::F32),
        Self::U64,
        Self::I64,
        Self::F64,
    ];

    /// Bytes per value.
    pub fn size(self) -> usize {
        match self {
            Self::Voxel(voxel) => voxel.size(),
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }

    /// The short name: `u8`, `i16`, `f64`, ...
    pub fn name(self) -> &'static str {
        match self {
            Self::Voxel(voxel) => voxel.name(),
            Self::I64 => "i64",
            Self::U64 => "u64",
            Self::F64 => "f64",
        }
    }
}

impl From<VoxelType> for StoredType {
    fn from(voxel: VoxelType) -> Self {
        Self::Voxel(voxel)
    }
}

impl fmt::Display for StoredType {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for StoredType {
    type Err = String;

    /// Parses a short name.
    fn from_str(name: &str) -> Result<Self, String> {
        let names = || Self::ALL.map(Self::name).join(", ");
        let found = Self::ALL.into_iter().find(|stored| stored.name() == name);
        found.ok_or_else(|| format!("'{name}' is not a type of values, expected one of {}", names()))
    }
}

/// Byte order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Endian {
    /// Least significant byte first.
    Little,
    /// Most significant byte first.
    Big,
}

impl Endian {
    /// The order of this machine.
    pub const NATIVE: Self = if cfg!(target_endian = "little") { Self::Little } else { Self::Big };
}

//! Voxel values in their own type, owned or borrowed from a mapped file.

use std::fmt;
use std::ops::Deref;
use std::sync::Arc;

use half::f16;

/// The types voxels are stored in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema))]
#[cfg_attr(feature = "serde", serde(rename_all = "lowercase"))]
pub enum VoxelType {
    /// Unsigned 8 bit.
    U8,
    /// Signed 8 bit.
    I8,
    /// Unsigned 16 bit.
    U16,
    /// Signed 16 bit.
    I16,
    /// Unsigned 32 bit.
    U32,
    /// Signed 32 bit.
    I32,
    /// IEEE 754 half.
    F16,
    /// IEEE 754 single.
    F32,
}

impl VoxelType {
    /// Every type, smallest first.
    pub const ALL: [Self; 8] = [Self::U8, Self::I8, Self::U16, Self::I16, Self::F16, Self::U32, Self::I32, Self::F32];

    /// Bytes per value.
    pub fn size(self) -> usize {
        match self {
            Self::U8 | Self::I8 => 1,
            Self::U16 | Self::I16 | Self::F16 => 2,
            Self::U32 | Self::I32 | Self::F32 => 4,
        }
    }

    /// The short name used on the command line and in reports: `u8`, `i16`, `f32`, ...
    pub fn name(self) -> &'static str {
        match self {
            Self::U8 => "u8",
            Self::I8 => "i8",
            Self::U16 => "u16",
            Self::I16 => "i16",
            Self::U32 => "u32",
            Self::I32 => "i32",
            Self::F16 => "f16",
            Self::F32 => "f32",
        }
    }

    /// Whether values are integers, so that a table can hold one entry per level.
    pub fn is_integer(self) -> bool {
        !matches!(self, Self::F16 | Self::F32)
    }
}

impl fmt::Display for VoxelType {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A type voxels can have.
pub trait Voxel: bytemuck::Pod + PartialOrd + Send + Sync {
    /// Its name at run time.
    const TYPE: VoxelType;
    /// The value; exact for all types but 32-bit integers beyond 2^24.
    fn to_f32(self) -> f32;
    /// The value, exact.
    fn to_f64(self) -> f64;
    /// The nearest representable value: rounded and saturated for integers (NaN becomes 0).
    fn from_f64(value: f64) -> Self;
    /// Wraps a buffer of this type.
    fn wrap(buffer: Buffer<Self>) -> Voxels;
}

macro_rules! voxel {
    ($type:ty, $variant:ident, $to32:expr, $to64:expr, $from:expr) => {
        impl Voxel for $type {
            const TYPE: VoxelType = VoxelType::$variant;
            #[inline(always)]
            fn to_f32(self) -> f32 {
                $to32(self)
            }
            #[inline(always)]
            fn to_f64(self) -> f64 {
                $to64(self)
            }
            fn from_f64(value: f64) -> Self {
                $from(value)
            }
            fn wrap(buffer: Buffer<Self>) -> Voxels {
                Voxels::$variant(buffer)
            }
        }
    };
    ($type:ty, $variant:ident) => {
        voxel!($type, $variant, |v| v as f32, |v| v as f64, |v: f64| v.round() as $type);
    };
}

voxel!(u8, U8);
voxel!(i8, I8);
voxel!(u16, U16);
voxel!(i16, I16);
voxel!(u32, U32);
voxel!(i32, I32);
voxel!(f16, F16, f16::to_f32, f16::to_f64, f16::from_f64);
voxel!(f32, F32, |v| v, |v| v as f64, |v: f64| v as f32);

/// A shared, read-only run of values: owned, or a view into bytes somebody else keeps alive (a
/// mapped file). Cloning shares the memory.
#[derive(Clone)]
pub struct Buffer<T>(Storage<T>);

#[derive(Clone)]
enum Storage<T> {
    Owned(Arc<Vec<T>>),
    Bytes { source: Arc<dyn AsRef<[u8]> + Send + Sync>, start: usize, end: usize },
}

impl<T: Voxel> Buffer<T> {
    /// A view of `count` values that begin `offset` bytes into `source`, in native byte order.
    /// `None` if they do not lie inside it or are not aligned for `T`.
    pub fn from_bytes(source: Arc<dyn AsRef<[u8]> + Send + Sync>, offset: usize, count: usize) -> Option<Self> {
        let end = offset.checked_add(count.checked_mul(size_of::<T>())?)?;
        let bytes = (*source).as_ref().get(offset..end)?;
        bytemuck::try_cast_slice::<u8, T>(bytes).ok()?;
        Some(Self(Storage::Bytes { source, start: offset, end }))
    }
}

impl<T> From<Vec<T>> for Buffer<T> {
    fn from(values: Vec<T>) -> Self {
        Self(Storage::Owned(Arc::new(values)))
    }
}

impl<T: Voxel> Deref for Buffer<T> {
    type Target = [T];
    fn deref(&self) -> &[T] {
        match &self.0 {
            Storage::Owned(values) => values,
            Storage::Bytes { source, start, end } => bytemuck::cast_slice(&(**source).as_ref()[*start..*end]),
        }
    }
}

impl<T: Voxel> fmt::Debug for Buffer<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Buffer<{}>({})", T::TYPE, self.len())
    }
}

/// The values of a volume, x fastest, components interleaved.
#[derive(Clone, Debug)]
pub enum Voxels {
    /// Unsigned 8 bit.
    U8(Buffer<u8>),
    /// Signed 8 bit.
    I8(Buffer<i8>),
    /// Unsigned 16 bit.
    U16(Buffer<u16>),
    /// Signed 16 bit.
    I16(Buffer<i16>),
    /// Unsigned 32 bit.
    U32(Buffer<u32>),
    /// Signed 32 bit.
    I32(Buffer<i32>),
    /// IEEE 754 half.
    F16(Buffer<f16>),
    /// IEEE 754 single.
    F32(Buffer<f32>),
}

/// Runs an expression with the typed slice of a [`Voxels`]: `for_voxels!(voxels, data => expr)`,
/// where `data` is a `&Buffer<T>` of whichever type it holds.
#[macro_export]
macro_rules! for_voxels {
    ($voxels:expr, $data:ident => $body:expr) => {
        match $voxels {
            $crate::Voxels::U8($data) => $body,
            $crate::Voxels::I8($data) => $body,
            $crate::Voxels::U16($data) => $body,
            $crate::Voxels::I16($data) => $body,
            $crate::Voxels::U32($data) => $body,
            $crate::Voxels::I32($data) => $body,
            $crate::Voxels::F16($data) => $body,
            $crate::Voxels::F32($data) => $body,
        }
    };
}

impl Voxels {
    /// The type of the values.
    pub fn voxel_type(&self) -> VoxelType {
        match self {
            Self::U8(_) => VoxelType::U8,
            Self::I8(_) => VoxelType::I8,
            Self::U16(_) => VoxelType::U16,
            Self::I16(_) => VoxelType::I16,
            Self::U32(_) => VoxelType::U32,
            Self::I32(_) => VoxelType::I32,
            Self::F16(_) => VoxelType::F16,
            Self::F32(_) => VoxelType::F32,
        }
    }

    /// Number of values (voxels times components).
    pub fn len(&self) -> usize {
        for_voxels!(self, data => data.len())
    }

    /// Whether there are no values.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The stored value at a position in memory.
    ///
    /// # Panics
    /// If `index` is out of range.
    pub fn get(&self, index: usize) -> f64 {
        for_voxels!(self, data => data[index].to_f64())
    }

    /// The values as bytes in native order.
    pub fn as_bytes(&self) -> &[u8] {
        for_voxels!(self, data => bytemuck::cast_slice(data))
    }
}

impl<T: Voxel> From<Vec<T>> for Voxels {
    fn from(values: Vec<T>) -> Self {
        T::wrap(values.into())
    }
}

//! The fields of both headers, at the offsets of the standard.

use std::io::Read;

use flate2::bufread::GzDecoder;

use crate::encoding::GZIP;
use crate::source::Source;
use crate::{Endian, IoError, StoredType};
use pellucid_field::VoxelType;

/// Bytes of a NIfTI-1 header.
pub(super) const SIZE_1: usize = 348;
/// Bytes of a NIfTI-2 header.
const SIZE_2: usize = 540;

/// What both versions say, in the wider types of the second.
pub(super) struct NiftiHeader {
    pub endian: Endian,
    /// Whether the data follow in the same file.
    pub is_single: bool,
    /// Where the data begin at the earliest if they do: the header and four bytes of extension.
    pub earliest: u64,
    pub dim: [i64; 8],
    pub datatype: i16,
    pub bitpix: i16,
    pub pixdim: [f64; 8],
    pub vox_offset: f64,
    pub scl_slope: f64,
    pub scl_inter: f64,
    pub xyzt_units: i32,
    pub qform_code: i32,
    pub sform_code: i32,
    /// b, c, d; a follows from them.
    pub quatern: [f64; 3],
    pub qoffset: [f64; 3],
    pub srow: [[f64; 4]; 3],
}

/// Whether a file, unpacked if need be, begins like a NIfTI header.
pub(crate) fn is_nifti(head: &[u8]) -> bool {
    let bytes = first_bytes(head);
    let magic = |at: usize, tail: u8| {
        let found = bytes.get(at..at + 4);
        found.is_some_and(|magic| matches!(magic, [b'n', b'+' | b'i', version, 0] if *version == tail))
    };
    magic(344, b'1') || magic(4, b'2')
}

/// As many bytes as the longer header has, or fewer if the file is short or damaged.
fn first_bytes(head: &[u8]) -> Vec<u8> {
    if !is_gzip(head) {
        return head[..head.len().min(SIZE_2)].to_vec();
    }
    let mut bytes = Vec::new();
    // What can be decoded is enough to tell, or to complain about.
    let _ = GzDecoder::new(head).take(SIZE_2 as u64).read_to_end(&mut bytes);
    bytes
}

/// Whether the content is gzip, whatever the name says.
pub(super) fn is_gzip(head: &[u8]) -> bool {
    head.starts_with(&GZIP)
}

impl NiftiHeader {
    pub fn parse(source: &Source, head: &[u8]) -> Result<Self, IoError> {
        let path = &source.path;
        let bytes = first_bytes(head);
        let truncated = |expected: usize| IoError::Truncated {
            path: path.clone(),
            what: "the header",
            found: bytes.len() as u64,
            expected: expected as u64,
        };
        let size: [u8; 4] = bytes.get(..4).and_then(|bytes| bytes.try_into().ok()).ok_or_else(|| truncated(SIZE_1))?;
        let (endian, size) = match (i32::from_le_bytes(size), i32::from_be_bytes(size)) {
            (348 | 540, _) => (Endian::Little, i32::from_le_bytes(size) as usize),
            (_, 348 | 540) => (Endian::Big, i32::from_be_bytes(size) as usize),
            (found, _) => {
                return Err(IoError::malformed(path, "sizeof_hdr", found, "348 or 540, in either byte order"));
            }
        };
        if bytes.len() < size {
            return Err(truncated(size));
        }
        let magic = if size == SIZE_1 { &bytes[344..348] } else { &bytes[4..8] };
        let is_single = match magic {
            b"n+1\0" | b"n+2\0" => true,
            b"ni1\0" | b"ni2\0" => false,
            [0, ..] => {
                let advice = "it says nothing of orientation; convert it to NIfTI";
                return Err(IoError::unsupported(path, "format", "ANALYZE 7.5", advice));
            }
            _ => return Err(IoError::malformed(path, "magic", magic.escape_ascii(), "n+1, ni1, n+2 or ni2")),
        };
        let fields = Fields { bytes: &bytes, endian };
        Ok(if size == SIZE_1 { fields.version_1(is_single) } else { fields.version_2(is_single) })
    }

    /// The type of the values, and how many of them a voxel has.
    pub fn stored(&self, source: &Source) -> Result<(StoredType, usize), IoError> {
        let stored = match self.datatype {
            2 | 128 | 2304 => VoxelType::U8.into(),
            4 => VoxelType::I16.into(),
            8 => VoxelType::I32.into(),
            16 => VoxelType::F32.into(),
            64 => StoredType::F64,
            256 => VoxelType::I8.into(),
            512 => VoxelType::U16.into(),
            768 => VoxelType::U32.into(),
            1024 => StoredType::I64,
            1280 => StoredType::U64,
            code => {
                let name = match code {
                    1 => "1 (binary)",
                    32 => "32 (complex64)",
                    1536 => "1536 (float128)",
                    1792 => "1792 (complex128)",
                    2048 => "2048 (complex256)",
                    _ => return Err(IoError::malformed(&source.path, "datatype", code, "a code of the standard")),
                };
                let advice = "integers of 8 to 64 bit, float, double, RGB24 and RGBA32 are";
                return Err(IoError::unsupported(&source.path, "datatype", name, advice));
            }
        };
        let components = match self.datatype {
            128 => 3,
            2304 => 4,
            _ => 1,
        };
        Ok((stored, components))
    }
}

/// Numbers at offsets into a header that is known to be long enough.
struct Fields<'a> {
    bytes: &'a [u8],
    endian: Endian,
}

macro_rules! number {
    ($name:ident, $type:ty) => {
        fn $name(&self, at: usize) -> $type {
            let mut bytes = [0; size_of::<$type>()];
            bytes.copy_from_slice(&self.bytes[at..at + size_of::<$type>()]);
            match self.endian {
                Endian::Little => <$type>::from_le_bytes(bytes),
                Endian::Big => <$type>::from_be_bytes(bytes),
            }
        }
    };
}

impl Fields<'_> {
    number!(i16, i16);
    number!(i32, i32);
    number!(i64, i64);
    number!(f32, f32);
    number!(f64, f64);

    /// An array of singles, exactly as doubles.
    fn singles<const N: usize>(&self, at: usize) -> [f64; N] {
        std::array::from_fn(|k| self.f32(at + 4 * k).into())
    }

    fn doubles<const N: usize>(&self, at: usize) -> [f64; N] {
        std::array::from_fn(|k| self.f64(at + 8 * k))
    }

    fn version_1(&self, is_single: bool) -> NiftiHeader {
        NiftiHeader {
            endian: self.endian,
            is_single,
            earliest: SIZE_1 as u64 + 4,
            dim: std::array::from_fn(|k| self.i16(40 + 2 * k).into()),
            datatype: self.i16(70),
            bitpix: self.i16(72),
            pixdim: self.singles(76),
            vox_offset: self.f32(108).into(),
            scl_slope: self.f32(112).into(),
            scl_inter: self.f32(116).into(),
            xyzt_units: self.bytes[123].into(),
            qform_code: self.i16(252).into(),
            sform_code: self.i16(254).into(),
            quatern: self.singles(256),
            qoffset: self.singles(268),
            srow: std::array::from_fn(|row| self.singles(280 + 16 * row)),
        }
    }

    fn version_2(&self, is_single: bool) -> NiftiHeader {
        NiftiHeader {
            endian: self.endian,
            is_single,
            earliest: SIZE_2 as u64 + 4,
            dim: std::array::from_fn(|k| self.i64(16 + 8 * k)),
            datatype: self.i16(12),
            bitpix: self.i16(14),
            pixdim: self.doubles(104),
            vox_offset: self.i64(168) as f64,
            scl_slope: self.f64(176),
            scl_inter: self.f64(184),
            xyzt_units: self.i32(500),
            qform_code: self.i32(344),
            sform_code: self.i32(348),
            quatern: self.doubles(352),
            qoffset: self.doubles(376),
            srow: std::array::from_fn(|row| self.doubles(400 + 32 * row)),
        }
    }
}

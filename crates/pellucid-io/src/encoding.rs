//! How values are encoded in a file: byte streams over compressed and textual data.

use std::io::{self, Cursor, Read};

use bzip2::bufread::MultiBzDecoder;
use flate2::bufread::{GzDecoder, ZlibDecoder};
use half::f16;
use pellucid_field::VoxelType;

use crate::StoredType;
use crate::source::Bytes;

/// How values are encoded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Encoding {
    Raw,
    Gzip,
    /// A zlib stream, or gzip if it begins like one, as the MetaIO library reads it.
    Zlib,
    Bzip2,
    Hex,
    /// Decimal numbers between white space or commas.
    Text,
}

/// Deflate cannot do better than one bit for a match of 258 bytes.
const DEFLATE_RATIO: u64 = 1032;

impl Encoding {
    pub fn name(self) -> &'static str {
        match self {
            Self::Raw => "raw",
            Self::Gzip => "gzip",
            Self::Zlib => "zlib",
            Self::Bzip2 => "bzip2",
            Self::Hex => "hex",
            Self::Text => "text",
        }
    }

    pub fn is_compressed(self) -> bool {
        matches!(self, Self::Gzip | Self::Zlib | Self::Bzip2)
    }

    /// The most bytes of values that `encoded` bytes can hold, or `None` where there is no
    /// useful bound (bzip2 packs 45 MB of zeros into 45 bytes).
    pub fn most(self, encoded: u64, stored: StoredType) -> Option<u64> {
        match self {
            Self::Raw => Some(encoded),
            Self::Gzip | Self::Zlib => Some(encoded.saturating_mul(DEFLATE_RATIO)),
            Self::Bzip2 => None,
            Self::Hex => Some(encoded / 2),
            // One digit and one separator for each value but the last.
            Self::Text => Some(encoded.div_ceil(2).saturating_mul(stored.size() as u64)),
        }
    }

    /// The decoded bytes; those of [`Encoding::Text`] are in native order.
    pub fn reader(self, window: Window, stored: StoredType) -> Box<dyn Read> {
        let is_gzip = window.as_ref().starts_with(&[0x1f, 0x8b]);
        let cursor = Cursor::new(window);
        match self {
            Self::Raw => Box::new(cursor),
            Self::Gzip => Box::new(GzipMembers { member: Some(GzDecoder::new(cursor)) }),
            Self::Zlib if is_gzip => Box::new(GzipMembers { member: Some(GzDecoder::new(cursor)) }),
            Self::Zlib => Box::new(ZlibDecoder::new(cursor)),
            Self::Bzip2 => Box::new(MultiBzDecoder::new(cursor)),
            Self::Hex => Box::new(Hex { cursor }),
            Self::Text => Box::new(Text { cursor, stored, pending: Vec::new(), taken: 0 }),
        }
    }
}

/// A stretch of shared bytes.
pub(crate) struct Window {
    bytes: Bytes,
    start: usize,
    end: usize,
}

impl Window {
    /// Everything from `start` on.
    pub fn from(bytes: Bytes, start: usize) -> Self {
        let end = (*bytes).as_ref().len();
        Self { bytes, start: start.min(end), end }
    }
}

impl AsRef<[u8]> for Window {
    fn as_ref(&self) -> &[u8] {
        &(*self.bytes).as_ref()[self.start..self.end]
    }
}

/// Gzip members one after the other. Whatever follows the last member is no part of the data, as
/// for the gzip program (files padded with zeros are common).
struct GzipMembers {
    member: Option<GzDecoder<Cursor<Window>>>,
}

impl Read for GzipMembers {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        while let Some(member) = &mut self.member {
            let n = member.read(out)?;
            if n > 0 || out.is_empty() {
                return Ok(n);
            }
            self.member = self.member.take().map(GzDecoder::into_inner).and_then(|cursor| {
                let rest = &cursor.get_ref().as_ref()[cursor.position() as usize..];
                rest.starts_with(&[0x1f, 0x8b]).then(|| GzDecoder::new(cursor))
            });
        }
        Ok(0)
    }
}

/// Two hexadecimal digits per byte; white space anywhere.
struct Hex {
    cursor: Cursor<Window>,
}

impl Read for Hex {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        let mut position = self.cursor.position() as usize;
        let text = self.cursor.get_ref().as_ref();
        let mut digit = || {
            while text.get(position).is_some_and(u8::is_ascii_whitespace) {
                position += 1;
            }
            let &byte = text.get(position)?;
            position += 1;
            Some((byte as char).to_digit(16).ok_or_else(|| invalid(format!("'{}' is no digit", byte.escape_ascii()))))
        };
        let mut written = 0;
        while written < out.len()
            && let Some(high) = digit()
        {
            let low = digit().ok_or_else(|| invalid("the last byte has one digit".to_owned()))?;
            out[written] = (high? << 4 | low?) as u8;
            written += 1;
        }
        self.cursor.set_position(position as u64);
        Ok(written)
    }
}

/// Decimal numbers, handed on as bytes of the stored type in native order.
struct Text {
    cursor: Cursor<Window>,
    stored: StoredType,
    pending: Vec<u8>,
    taken: usize,
}

impl Text {
    /// Parses the next numbers.
    fn refill(&mut self) -> io::Result<()> {
        const VALUES: usize = 4096;
        self.pending.clear();
        self.taken = 0;
        let mut position = self.cursor.position() as usize;
        let text = self.cursor.get_ref().as_ref();
        let separates = |byte: &u8| byte.is_ascii_whitespace() || *byte == b',';
        for _ in 0..VALUES {
            position += text[position..].iter().take_while(|byte| separates(byte)).count();
            let length = text[position..].iter().take_while(|byte| !separates(byte)).count();
            if length == 0 {
                break;
            }
            let word = &text[position..position + length];
            position += length;
            let parsed = str::from_utf8(word).ok().and_then(|word| push_number(&mut self.pending, self.stored, word));
            parsed.ok_or_else(|| {
                let shown = &word[..word.len().min(40)];
                invalid(format!("'{}' is not a value of type {}", shown.escape_ascii(), self.stored))
            })?;
        }
        self.cursor.set_position(position as u64);
        Ok(())
    }
}

impl Read for Text {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        if self.taken == self.pending.len() {
            self.refill()?;
        }
        let rest = &self.pending[self.taken..];
        let n = rest.len().min(out.len());
        out[..n].copy_from_slice(&rest[..n]);
        self.taken += n;
        Ok(n)
    }
}

/// Appends the bytes of a number; `None` if the text is not one of the type.
fn push_number(out: &mut Vec<u8>, stored: StoredType, word: &str) -> Option<()> {
    macro_rules! push {
        ($type:ty) => {
            out.extend_from_slice(&word.parse::<$type>().ok()?.to_ne_bytes())
        };
    }
    match stored {
        StoredType::Voxel(VoxelType::U8) => push!(u8),
        StoredType::Voxel(VoxelType::I8) => push!(i8),
        StoredType::Voxel(VoxelType::U16) => push!(u16),
        StoredType::Voxel(VoxelType::I16) => push!(i16),
        StoredType::Voxel(VoxelType::U32) => push!(u32),
        StoredType::Voxel(VoxelType::I32) => push!(i32),
        StoredType::Voxel(VoxelType::F16) => {
            out.extend_from_slice(&f16::from_f64(word.parse().ok()?).to_ne_bytes());
        }
        StoredType::Voxel(VoxelType::F32) => push!(f32),
        StoredType::I64 => push!(i64),
        StoredType::U64 => push!(u64),
        StoredType::F64 => push!(f64),
    }
    Some(())
}

fn invalid(reason: String) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, reason)
}

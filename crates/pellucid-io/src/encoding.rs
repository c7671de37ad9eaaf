//! How values are encoded in a file: byte streams over compressed and textual data.

use std::io::{self, BufRead, Read};

use bzip2::bufread::MultiBzDecoder;
use flate2::bufread::{GzDecoder, ZlibDecoder};
use half::f16;
use pellucid_field::VoxelType;

use crate::StoredType;
use crate::lookahead::Lookahead;

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
pub(crate) const DEFLATE_RATIO: u64 = 1032;

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

    /// The decoded bytes; those of [`Encoding::Text`] are in native order. Errors tell places, not content: a header
    /// may name a file that its author could not read.
    pub fn reader(self, mut encoded: Lookahead, stored: StoredType) -> io::Result<Box<dyn Read>> {
        Ok(match self {
            Self::Raw => Box::new(encoded),
            Self::Gzip => Box::new(GzipMembers { member: Some(GzDecoder::new(encoded)) }),
            Self::Zlib if encoded.peek(2)?.starts_with(&GZIP) => {
                Box::new(GzipMembers { member: Some(GzDecoder::new(encoded)) })
            }
            Self::Zlib => Box::new(ZlibDecoder::new(encoded)),
            Self::Bzip2 => Box::new(MultiBzDecoder::new(encoded)),
            Self::Hex => Box::new(Hex { encoded, position: 0 }),
            Self::Text => Box::new(Text { encoded, stored, values: 0, pending: Vec::new(), taken: 0 }),
        })
    }
}

/// How gzip data begin.
pub(crate) const GZIP: [u8; 2] = [0x1f, 0x8b];

/// Gzip members one after the other. Whatever follows the last member is no part of the data, as
/// for the gzip program (files padded with zeros are common).
struct GzipMembers {
    member: Option<GzDecoder<Lookahead>>,
}

impl Read for GzipMembers {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        while let Some(member) = &mut self.member {
            let n = member.read(out)?;
            if n > 0 || out.is_empty() {
                return Ok(n);
            }
            if let Some(mut rest) = self.member.take().map(GzDecoder::into_inner)
                && rest.peek(2)?.starts_with(&GZIP)
            {
                self.member = Some(GzDecoder::new(rest));
            }
        }
        Ok(0)
    }
}

/// Two hexadecimal digits per byte; white space anywhere.
struct Hex {
    encoded: Lookahead,
    /// Bytes read.
    position: u64,
}

impl Hex {
    fn digit(&mut self) -> io::Result<Option<u8>> {
        loop {
            let Some(&byte) = self.encoded.fill_buf()?.first() else { return Ok(None) };
            self.encoded.consume(1);
            self.position += 1;
            if !byte.is_ascii_whitespace() {
                let digit = char::from(byte).to_digit(16).map(|digit| digit as u8);
                return digit.map(Some).ok_or_else(|| invalid(format!("character {} is no digit", self.position)));
            }
        }
    }
}

impl Read for Hex {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        for (written, byte) in out.iter_mut().enumerate() {
            let Some(high) = self.digit()? else { return Ok(written) };
            let low = self.digit()?.ok_or_else(|| invalid("the last byte has one digit".to_owned()))?;
            *byte = high << 4 | low;
        }
        Ok(out.len())
    }
}

/// Decimal numbers, handed on as bytes of the stored type in native order.
struct Text {
    encoded: Lookahead,
    stored: StoredType,
    /// Numbers read.
    values: u64,
    pending: Vec<u8>,
    taken: usize,
}

impl Text {
    /// Parses the next numbers.
    fn refill(&mut self) -> io::Result<()> {
        const VALUES: usize = 4096;
        /// Characters of a number; the longest exact `f64` has about as many.
        const LONGEST: usize = 1100;
        self.pending.clear();
        self.taken = 0;
        let separates = |byte: &u8| byte.is_ascii_whitespace() || *byte == b',';
        for _ in 0..VALUES {
            let text = loop {
                let text = self.encoded.peek(LONGEST + 1)?;
                let blanks = text.iter().take_while(|byte| separates(byte)).count();
                if blanks == 0 {
                    break text;
                }
                self.encoded.consume(blanks);
            };
            let length = text.iter().take_while(|byte| !separates(byte)).count();
            if length == 0 {
                break;
            }
            self.values += 1;
            let word = Some(&text[..length]).filter(|word| word.len() <= LONGEST);
            let word = word.and_then(|word| str::from_utf8(word).ok());
            word.and_then(|word| push_number(&mut self.pending, self.stored, word))
                .ok_or_else(|| invalid(format!("value {} is none of type {}", self.values, self.stored)))?;
            self.encoded.consume(length);
        }
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

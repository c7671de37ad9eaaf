//! The bytes of a volume's values, decoded in order across its files.

use std::io::{self, Read};

use pellucid_field::{Buffer, Voxel, Warning};

use crate::IoError;
use crate::encoding::{Encoding, Window};
use crate::payload::{Parts, Payload, Skip};
use crate::source::Source;

/// One file of values, opened at the first wanted one.
pub(crate) struct Part {
    pub source: Source,
    /// Where its encoded values begin.
    pub start: usize,
    /// Decoded bytes still to come.
    pub left: u64,
    reader: Box<dyn Read>,
    encoding: Encoding,
    /// Whether the size of the file has been shown to allow for its values.
    bounded: bool,
}

impl Part {
    /// Opens file `index` of a payload and leaves out its first `inner` bytes of values. Fails
    /// before anything is decoded if the file is too short for its values.
    pub fn open(payload: &Payload, index: usize, inner: u64, warnings: &mut Vec<Warning>) -> Result<Self, IoError> {
        let (source, offset) = match &payload.parts {
            Parts::Attached(source, offset) => (source.clone(), *offset),
            Parts::Files(files) => (Source::open(&files[index])?, 0),
        };
        let (encoding, needed) = (payload.encoding, payload.part_bytes());
        let length = source.bytes().len() as u64;
        let truncated = |found, expected| truncated(&source, found, expected);
        let mut start = offset.min(length);
        // Decoded bytes in front of the wanted values.
        let mut prefix = 0;
        match payload.skip {
            Skip::FromEnd => start = length.checked_sub(needed).ok_or_else(|| truncated(length, needed))?,
            Skip::Forward { lines, bytes } => {
                for _ in 0..lines {
                    let rest = &source.bytes()[start as usize..];
                    let line = rest.iter().position(|&byte| byte == b'\n').ok_or_else(|| truncated(0, needed))?;
                    start += line as u64 + 1;
                }
                if encoding.is_compressed() {
                    prefix = bytes;
                } else {
                    start = start.saturating_add(bytes).min(length);
                }
            }
        }
        let most = encoding.most(length - start, payload.stored);
        if let Some(most) = most.filter(|&most| most < needed.saturating_add(prefix)) {
            return Err(truncated(most, needed.saturating_add(prefix)));
        }
        if encoding == Encoding::Raw {
            let trailing = length - start - needed;
            if trailing > 0 {
                let name = source.path.display();
                warnings.push(Warning::File(format!("{name}: {trailing} bytes after the values are ignored")));
            }
            start += inner;
        } else {
            prefix = prefix.saturating_add(inner);
        }
        let start = start as usize;
        let reader = encoding.reader(Window::from(source.shared(), start), payload.stored);
        let mut part = Self { source, start, left: needed - inner, reader, encoding, bounded: most.is_some() };
        part.discard(prefix)?;
        Ok(part)
    }

    /// Reads until `out` is full or the file ends; the number of bytes read.
    fn read(&mut self, out: &mut [u8]) -> Result<usize, IoError> {
        let mut done = 0;
        while done < out.len() {
            match self.reader.read(&mut out[done..]) {
                Ok(0) => break,
                Ok(n) => done += n,
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => break,
                Err(error) => return Err(self.damaged(error.to_string())),
            }
        }
        Ok(done)
    }

    fn discard(&mut self, mut count: u64) -> Result<(), IoError> {
        let mut scratch = [0; 1 << 13];
        while count > 0 {
            let n = count.min(scratch.len() as u64) as usize;
            if self.read(&mut scratch[..n])? < n {
                return Err(truncated(&self.source, 0, self.left));
            }
            count -= n as u64;
        }
        Ok(())
    }

    /// After the last value: a checksum must match, and more values are worth a warning.
    fn finish(&mut self, warnings: &mut Vec<Warning>) -> Result<(), IoError> {
        if self.encoding == Encoding::Raw {
            return Ok(());
        }
        match self.reader.read(&mut [0]) {
            Ok(0) => Ok(()),
            Ok(_) => {
                let name = self.source.path.display();
                warnings.push(Warning::File(format!("{name}: more values than the header needs are ignored")));
                Ok(())
            }
            Err(error) => Err(self.damaged(error.to_string())),
        }
    }

    fn damaged(&self, reason: String) -> IoError {
        IoError::Damaged { path: self.source.path.clone(), encoding: self.encoding.name(), reason }
    }
}

/// The wanted bytes of a payload, in the order they are stored.
pub(crate) struct Stream<'a> {
    payload: &'a Payload,
    next: usize,
    /// Bytes to leave out of the next file.
    inner: u64,
    part: Option<Part>,
    /// Bytes of the whole stream still to come.
    left: u64,
    warnings: &'a mut Vec<Warning>,
}

impl<'a> Stream<'a> {
    /// The wanted time point of a payload.
    pub fn new(payload: &'a Payload, warnings: &'a mut Vec<Warning>) -> Self {
        let first = payload.frame * payload.frame_bytes();
        let next = (first / payload.part_bytes()) as usize;
        let inner = first % payload.part_bytes();
        Self { payload, next, inner, part: None, left: payload.frame_bytes(), warnings }
    }

    /// The values as a view of their file, if they lie there as they are in memory: plain, in
    /// native order, aligned and in one piece.
    pub fn map<T: Voxel>(&mut self) -> Result<Option<Buffer<T>>, IoError> {
        let payload = self.payload;
        if payload.encoding != Encoding::Raw || payload.is_foreign() || payload.planes > 1 {
            return Ok(None);
        }
        let left = self.left;
        let part = self.part()?;
        if part.left < left {
            return Ok(None);
        }
        Ok(Buffer::from_bytes(part.source.shared(), part.start, payload.count as usize))
    }

    /// How many bytes may be allocated now because the files seen so far vouch for them.
    pub fn vouched(&mut self) -> Result<u64, IoError> {
        /// What a compressed file may claim without proof.
        const UNPROVED: u64 = 1 << 24;
        let part = self.part()?;
        let vouched = if part.bounded { part.left } else { part.left.min(UNPROVED) };
        Ok(vouched.min(self.left))
    }

    /// Fills `out` with the next bytes, or with as many as there are; the number of bytes.
    pub fn fill(&mut self, out: &mut [u8]) -> Result<usize, IoError> {
        let wanted = self.left.min(out.len() as u64) as usize;
        let mut done = 0;
        while done < wanted {
            let part = self.part()?;
            let n = part.left.min((wanted - done) as u64) as usize;
            let found = part.read(&mut out[done..done + n])?;
            part.left -= found as u64;
            if found < n {
                let (left, source) = (part.left, part.source.clone());
                let expected = self.payload.part_bytes();
                return Err(truncated(&source, expected - left, expected));
            }
            let is_over = part.left == 0;
            done += n;
            self.left -= n as u64;
            if is_over && let Some(mut part) = self.part.take() {
                part.finish(self.warnings)?;
            }
        }
        Ok(done)
    }

    fn part(&mut self) -> Result<&mut Part, IoError> {
        let part = match self.part.take() {
            Some(part) => part,
            None => {
                let part = Part::open(self.payload, self.next, self.inner, self.warnings)?;
                self.next += 1;
                self.inner = 0;
                part
            }
        };
        Ok(self.part.insert(part))
    }
}

fn truncated(source: &Source, found: u64, expected: u64) -> IoError {
    IoError::Truncated { path: source.path.clone(), what: "the part with the values", found, expected }
}

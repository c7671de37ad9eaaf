//! The bytes of a volume's values, decoded in order across its files.

use std::collections::HashSet;
use std::io::{self, BufRead, Read};
use std::path::{Path, PathBuf};

use pellucid_field::{Buffer, Voxel, Warning};

use crate::encoding::Encoding;
use crate::payload::{Parts, Payload, Skip};
use crate::source::Source;
use crate::{IoError, Limits, ReadOptions, locate};

/// What has been agreed to read of the files so far.
#[derive(Default)]
struct Account {
    /// Files, which a header may name several times.
    seen: HashSet<PathBuf>,
    stored: u64,
    decoded: u64,
}

impl Account {
    /// Refuses what all files together must not decode to.
    fn add(&mut self, source: &Source, decoded: u64, limits: &Limits) -> Result<(), IoError> {
        if self.seen.insert(source.path.canonicalize().unwrap_or_else(|_| source.path.clone())) {
            self.stored = self.stored.saturating_add(source.length);
        }
        self.decoded = self.decoded.saturating_add(decoded);
        limits.check_bytes(&source.path, self.decoded, self.stored)
    }
}

/// One file of values, opened at the first wanted one.
struct Part {
    source: Source,
    /// Where its encoded values begin.
    start: u64,
    /// Decoded bytes still to come.
    left: u64,
    reader: Box<dyn Read>,
    encoding: Encoding,
    /// Whether the size of the file has been shown to allow for its values.
    bounded: bool,
}

impl<'a> Stream<'a> {
    /// Opens the next file and leaves out its first `inner` bytes of values. Fails before anything is decoded if the
    /// file is too short for its values, or they are more than the limits allow.
    fn open(&mut self) -> Result<Part, IoError> {
        let (payload, inner) = (self.payload, std::mem::take(&mut self.inner));
        let (source, offset) = match &payload.parts {
            Parts::Attached(source, offset) => (source.clone(), *offset),
            Parts::Files(files) => {
                let folder = payload.header.parent().unwrap_or(Path::new(""));
                let path = locate(folder, files.get(self.next), self.options.outside)?;
                (Source::open(&path, self.options.map)?, 0)
            }
        };
        self.next += 1;
        let failed = |error| IoError::io(&source.path)(error);
        let (encoding, needed) = (payload.encoding, payload.part_bytes());
        let truncated = |found, expected| truncated(&source, found, expected);
        let mut start = offset.min(source.length);
        // Decoded bytes in front of the wanted values.
        let mut prefix = 0;
        match payload.skip {
            Skip::FromEnd => {
                start = source.length.checked_sub(needed).ok_or_else(|| truncated(source.length, needed))?;
            }
            Skip::Forward { lines, bytes } => {
                if lines > 0 {
                    let skipped = skip_lines(source.reader(start)?, lines).map_err(failed)?;
                    start = (start + skipped.ok_or_else(|| truncated(0, needed))?).min(source.length);
                }
                if encoding.is_compressed() {
                    prefix = bytes;
                } else {
                    start = start.saturating_add(bytes).min(source.length);
                }
            }
        }
        let most = encoding.most(source.length - start, payload.stored);
        if let Some(most) = most.filter(|&most| most < needed.saturating_add(prefix)) {
            return Err(truncated(most, needed.saturating_add(prefix)));
        }
        if encoding == Encoding::Raw {
            let trailing = source.length - start - needed;
            if trailing > 0 {
                let name = source.path.display();
                self.warnings.push(Warning::File(format!("{name}: {trailing} bytes after the values are ignored")));
            }
            start += inner;
        } else {
            prefix = prefix.saturating_add(inner);
        }
        let wanted = self.left.min(needed - inner);
        self.account.add(&source, prefix.saturating_add(wanted), &self.options.limits)?;
        let reader = encoding.reader(source.reader(start)?, payload.stored).map_err(failed)?;
        let left = needed - inner;
        let mut part = Part { source, start, left, reader, encoding, bounded: most.is_some() };
        part.discard(prefix)?;
        Ok(part)
    }
}

impl Part {
    /// Reads until `out` is full or the file ends; the number of bytes read.
    fn read(&mut self, out: &mut [u8]) -> Result<usize, IoError> {
        let mut done = 0;
        while done < out.len() {
            match self.reader.read(&mut out[done..]) {
                Ok(0) => break,
                Ok(n) => done += n,
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => break,
                Err(error) => return Err(self.failed(error)),
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
            Err(error) => Err(self.failed(error)),
        }
    }

    /// What the system says, or the decoder.
    fn failed(&self, error: io::Error) -> IoError {
        let path = self.source.path.clone();
        match error.raw_os_error() {
            Some(_) => IoError::Io { path, source: error },
            None => IoError::Damaged { path, encoding: self.encoding.name(), reason: error.to_string() },
        }
    }
}

/// The wanted bytes of a payload, in the order they are stored.
pub(crate) struct Stream<'a> {
    payload: &'a Payload,
    options: &'a ReadOptions,
    next: u64,
    /// Bytes to leave out of the next file.
    inner: u64,
    part: Option<Part>,
    /// Bytes of the whole stream still to come.
    left: u64,
    account: Account,
    warnings: &'a mut Vec<Warning>,
}

impl<'a> Stream<'a> {
    /// The wanted time point of a payload.
    pub fn new(payload: &'a Payload, options: &'a ReadOptions, warnings: &'a mut Vec<Warning>) -> Self {
        let first = payload.frame * payload.frame_bytes();
        let (next, inner) = (first / payload.part_bytes(), first % payload.part_bytes());
        let (left, account) = (payload.frame_bytes(), Account::default());
        Self { payload, options, next, inner, part: None, left, account, warnings }
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
        let Some(bytes) = part.source.shared() else { return Ok(None) };
        Ok(Buffer::from_bytes(bytes, part.start as usize, payload.count as usize))
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
            None => self.open()?,
        };
        Ok(self.part.insert(part))
    }
}

/// Bytes of so many lines; `None` if there are fewer.
fn skip_lines(mut reader: impl BufRead, lines: u64) -> io::Result<Option<u64>> {
    let mut skipped = 0;
    for _ in 0..lines {
        match reader.skip_until(b'\n')? {
            0 => return Ok(None),
            line => skipped += line as u64,
        }
    }
    Ok(Some(skipped))
}

fn truncated(source: &Source, found: u64, expected: u64) -> IoError {
    IoError::Truncated { path: source.path.clone(), what: "the part with the values", found, expected }
}

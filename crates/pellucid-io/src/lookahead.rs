//! A reader that can be looked into.

use std::io::{self, BufRead, ErrorKind, Read};

/// Bytes read at a time.
const CAPACITY: usize = 1 << 16;

/// A buffered reader whose next bytes can be seen before they are taken.
pub(crate) struct Lookahead {
    reader: Box<dyn Read>,
    buffer: Box<[u8]>,
    /// What was read and not yet taken.
    start: usize,
    end: usize,
}

impl Lookahead {
    pub fn new(reader: impl Read + 'static) -> Self {
        Self { reader: Box::new(reader), buffer: vec![0; CAPACITY].into(), start: 0, end: 0 }
    }

    /// The next bytes, at least `count` (which must not exceed some thousands) or as many as are left.
    pub fn peek(&mut self, count: usize) -> io::Result<&[u8]> {
        if self.end - self.start < count {
            self.buffer.copy_within(self.start..self.end, 0);
            (self.start, self.end) = (0, self.end - self.start);
            while self.end < count.min(CAPACITY) {
                match self.reader.read(&mut self.buffer[self.end..]) {
                    Ok(0) => break,
                    Ok(n) => self.end += n,
                    Err(error) if error.kind() == ErrorKind::Interrupted => {}
                    Err(error) => return Err(error),
                }
            }
        }
        Ok(&self.buffer[self.start..self.end])
    }
}

impl Read for Lookahead {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        // Large reads go straight to their destination.
        if self.start == self.end && out.len() >= CAPACITY {
            return self.reader.read(out);
        }
        let next = self.peek(1)?;
        let n = next.len().min(out.len());
        out[..n].copy_from_slice(&next[..n]);
        self.start += n;
        Ok(n)
    }
}

impl BufRead for Lookahead {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        self.peek(1)
    }

    fn consume(&mut self, count: usize) {
        self.start = (self.start + count).min(self.end);
    }
}

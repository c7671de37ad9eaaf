//! Reading text headers: lines, words, numbers.

use std::path::Path;
use std::str::FromStr;

use crate::IoError;
use crate::source::Source;

/// The longest text header that is read; real ones have a few kilobytes.
pub(crate) const LONGEST_HEADER: usize = 1 << 20;

/// The lines of a text header. Ends of lines may be `\n` or `\r\n`.
pub(crate) struct Lines<'a> {
    path: &'a Path,
    /// The first [`LONGEST_HEADER`] bytes of the file, or all of them.
    head: &'a [u8],
    position: usize,
}

impl<'a> Lines<'a> {
    pub fn new(source: &'a Source, head: &'a [u8]) -> Self {
        Self { path: &source.path, head, position: 0 }
    }

    /// Where the next line begins.
    pub fn position(&self) -> usize {
        self.position
    }

    /// The next line without its end, or `None` at the end of the file.
    pub fn next_line(&mut self) -> Result<Option<String>, IoError> {
        let rest = &self.head[self.position..];
        let is_whole = self.head.len() < LONGEST_HEADER;
        if rest.is_empty() && is_whole {
            return Ok(None);
        }
        let length = match rest.iter().position(|&byte| byte == b'\n') {
            Some(length) => length,
            None if is_whole => rest.len(),
            None => {
                let expected = format!("a header of at most {LONGEST_HEADER} bytes");
                return Err(IoError::malformed(self.path, "header", "longer", expected));
            }
        };
        self.position = (self.position + length + 1).min(self.head.len());
        let line = &rest[..length];
        Ok(Some(String::from_utf8_lossy(line.strip_suffix(b"\r").unwrap_or(line)).into_owned()))
    }
}

/// A field of a text header, for parsing with messages that name it.
#[derive(Clone, Copy)]
pub(crate) struct Field<'a> {
    pub path: &'a Path,
    pub name: &'a str,
    pub text: &'a str,
}

impl<'a> Field<'a> {
    /// The error that this field is not what it should be.
    pub fn error(&self, expected: impl Into<String>) -> IoError {
        IoError::malformed(self.path, self.name, self.text, expected)
    }

    /// The only word, as a number.
    pub fn number<T: FromStr>(&self, expected: &str) -> Result<T, IoError> {
        self.text.trim().parse().map_err(|_| self.error(expected))
    }

    /// All words, as exactly `count` numbers; `why` tells where the count comes from.
    pub fn numbers<T: FromStr>(&self, count: usize, why: &str) -> Result<Vec<T>, IoError> {
        let words = self.words(count, why)?;
        let numbers: Option<Vec<T>> = words.iter().map(|word| word.parse().ok()).collect();
        numbers.ok_or_else(|| self.error(format!("{count} numbers")))
    }

    /// All words, of which there must be `count`.
    pub fn words(&self, count: usize, why: &str) -> Result<Vec<&'a str>, IoError> {
        let words: Vec<_> = self.text.split_whitespace().collect();
        if words.len() != count {
            return Err(self.error(format!("{count} values to match {why}")));
        }
        Ok(words)
    }

    /// Strings in double quotes, such as units.
    pub fn quoted(&self) -> Vec<&'a str> {
        self.text.split('"').skip(1).step_by(2).collect()
    }
}

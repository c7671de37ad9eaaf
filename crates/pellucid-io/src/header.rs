//! Reading text headers: lines, words, numbers, names of data files.

use std::path::Path;
use std::str::FromStr;

use crate::IoError;
use crate::payload::Parts;
use crate::source::Source;

/// The longest text header that is read; real ones have a few kilobytes.
const LONGEST_HEADER: usize = 1 << 20;

/// The longest series of numbered files; one file per slice needs some thousands.
const MOST_FILES: i64 = 1 << 17;

/// The lines of a text header. Ends of lines may be `\n` or `\r\n`.
pub(crate) struct Lines<'a> {
    source: &'a Source,
    position: usize,
}

impl<'a> Lines<'a> {
    pub fn new(source: &'a Source) -> Self {
        Self { source, position: 0 }
    }

    /// Where the next line begins.
    pub fn position(&self) -> usize {
        self.position
    }

    /// The next line without its end, or `None` at the end of the file.
    pub fn next_line(&mut self) -> Result<Option<String>, IoError> {
        let bytes = self.source.bytes();
        let rest = &bytes[self.position..bytes.len().min(LONGEST_HEADER)];
        if rest.is_empty() && self.position == bytes.len() {
            return Ok(None);
        }
        let length = match rest.iter().position(|&byte| byte == b'\n') {
            Some(length) => length,
            None if bytes.len() <= LONGEST_HEADER => rest.len(),
            None => {
                let expected = format!("a header of at most {LONGEST_HEADER} bytes");
                return Err(IoError::malformed(&self.source.path, "header", "longer", expected));
            }
        };
        self.position = (self.position + length + 1).min(bytes.len());
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

    /// The numbered data files of a pattern, `slice%03d.raw 1 100 1`; `None` if the field is not
    /// of that form.
    pub fn numbered_files(&self, source: &Source) -> Option<Result<Parts, IoError>> {
        let words: Vec<_> = self.text.split_whitespace().collect();
        // A name may hold spaces, so the numbers are counted from the end; there may be a fourth,
        // the dimension of each file, which the sizes tell as well.
        let percent = words.iter().position(|word| word.contains('%'))?;
        let numbers: Option<Vec<i64>> = words[percent + 1..].iter().map(|word| word.parse().ok()).collect();
        let numbers = numbers.filter(|numbers| (3..=4).contains(&numbers.len()))?;
        let pattern = words[..=percent].join(" ");
        let (first, last, step) = (numbers[0], numbers[1], numbers[2]);
        let steps = last.checked_sub(first).and_then(|span| span.checked_div(step)).filter(|&steps| steps >= 0);
        let Some(steps) = steps.filter(|&steps| steps < MOST_FILES) else {
            return Some(Err(
                self.error(format!("a range of at most {MOST_FILES} files with a step that leads through it"))
            ));
        };
        let files: Option<Vec<_>> =
            (0..=steps).map(|k| numbered(&pattern, first + k * step).map(|name| source.sibling(name))).collect();
        Some(files.map(Parts::Files).ok_or_else(|| self.error("a name with one %d, such as slice%03d.raw")))
    }
}

/// Replaces the one `%d`, `%5d` or `%05d` of a pattern, as `printf` would.
fn numbered(pattern: &str, number: i64) -> Option<String> {
    let (before, rest) = pattern.split_once('%')?;
    let end = rest.find(|c: char| !c.is_ascii_digit())?;
    let (width, rest) = rest.split_at(end);
    let after = rest.strip_prefix(['d', 'i', 'u'])?;
    let digits: usize = if width.is_empty() { 0 } else { width.parse().ok().filter(|&width| width <= 32)? };
    let text = if width.starts_with('0') { format!("{number:0digits$}") } else { format!("{number:digits$}") };
    (!after.contains('%')).then(|| format!("{before}{text}{after}"))
}

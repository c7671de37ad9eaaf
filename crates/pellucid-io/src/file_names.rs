//! The data files that a header names.

use std::path::{Path, PathBuf};

use crate::IoError;
use crate::header::Field;

/// The longest name of a file; systems allow 255 bytes, and paths of some thousands.
const LONGEST_NAME: usize = 1024;

/// Names as the header gives them, made one at a time: a range of numbers is short to write and long to spell out.
pub(crate) enum FileNames {
    Listed(Vec<PathBuf>),
    Numbered { pattern: Pattern, first: i64, step: i64, count: u64 },
}

impl FileNames {
    /// Names, each on a line of its own.
    pub fn listed(header: &Path, names: Vec<String>) -> Result<Self, IoError> {
        if let Some(name) = names.iter().find(|name| name.len() > LONGEST_NAME) {
            return Err(IoError::malformed(
                header,
                "data file",
                name,
                format!("a name of at most {LONGEST_NAME} bytes"),
            ));
        }
        Ok(Self::Listed(names.into_iter().map(PathBuf::from).collect()))
    }

    /// The file or the numbered files of a field.
    pub fn parse(field: &Field) -> Result<Self, IoError> {
        if field.text.len() > LONGEST_NAME {
            return Err(field.error(format!("a name of at most {LONGEST_NAME} bytes")));
        }
        Self::numbered(field).unwrap_or_else(|| Ok(Self::Listed(vec![field.text.into()])))
    }

    /// The numbered data files of a pattern, `slice%03d.raw 1 100 1`; `None` if the field is not of that form.
    fn numbered(field: &Field) -> Option<Result<Self, IoError>> {
        let words: Vec<_> = field.text.split_whitespace().collect();
        // A name may hold spaces, so the numbers are counted from the end; there may be a fourth,
        // the dimension of each file, which the sizes tell as well.
        let percent = words.iter().position(|word| word.contains('%'))?;
        let numbers: Option<Vec<i64>> = words[percent + 1..].iter().map(|word| word.parse().ok()).collect();
        let numbers = numbers.filter(|numbers| (3..=4).contains(&numbers.len()))?;
        let Some(pattern) = Pattern::parse(&words[..=percent].join(" ")) else {
            return Some(Err(field.error("a name with one %d, such as slice%03d.raw")));
        };
        let (first, last, step) = (numbers[0], numbers[1], numbers[2]);
        let steps = last.checked_sub(first).and_then(|span| span.checked_div(step));
        let count = steps.and_then(|steps| u64::try_from(steps).ok()).map(|steps| steps + 1);
        let count = count.ok_or_else(|| field.error("a range of numbers with a step that leads through it"));
        Some(count.map(|count| Self::Numbered { pattern, first, step, count }))
    }

    pub fn count(&self) -> u64 {
        match self {
            Self::Listed(names) => names.len() as u64,
            Self::Numbered { count, .. } => *count,
        }
    }

    /// The name of a file, which must be one of [`FileNames::count`].
    pub fn get(&self, index: u64) -> PathBuf {
        match self {
            Self::Listed(names) => names[index as usize].clone(),
            Self::Numbered { pattern, first, step, .. } => pattern.name(first + index as i64 * step).into(),
        }
    }
}

/// A name with one `%d`, `%5d` or `%05d`, to be filled in as `printf` would.
pub(crate) struct Pattern {
    before: String,
    width: usize,
    zeros: bool,
    after: String,
}

impl Pattern {
    fn parse(text: &str) -> Option<Self> {
        let (before, rest) = text.split_once('%')?;
        let end = rest.find(|c: char| !c.is_ascii_digit())?;
        let (width, rest) = rest.split_at(end);
        let after = rest.strip_prefix(['d', 'i', 'u'])?;
        let zeros = width.starts_with('0');
        let width = if width.is_empty() { 0 } else { width.parse().ok().filter(|&width| width <= 32)? };
        (!after.contains('%')).then(|| Self { before: before.to_owned(), width, zeros, after: after.to_owned() })
    }

    fn name(&self, number: i64) -> String {
        let Self { before, width, zeros, after } = self;
        if *zeros { format!("{before}{number:0width$}{after}") } else { format!("{before}{number:width$}{after}") }
    }
}

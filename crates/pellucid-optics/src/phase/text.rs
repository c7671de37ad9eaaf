//! Phase functions as text: tables as programs for Mie scattering write them.

use super::PhaseEntries;

/// Why a text is no table. It tells places, not content: a scene may name a file that its author could not read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("line {line}: {problem}")]
pub struct PhaseTextError {
    /// The line, from 1.
    pub line: usize,
    /// What is wrong with it and what is expected.
    pub problem: String,
}

/// Most entries of a table.
const MOST_ENTRIES: usize = 65_536;

impl PhaseEntries {
    /// The entries of a text: an angle in degrees, or its cosine if none is beyond -1 to 1, and one number or three,
    /// between commas, semicolons or blanks. A first line of words, empty lines and those after `#` say nothing.
    ///
    /// # Errors
    /// [`PhaseTextError`] for the first line that cannot be used.
    pub fn from_text(text: &str) -> Result<Self, PhaseTextError> {
        // With their lines.
        let mut rows: Vec<(usize, f64, [f32; 3])> = Vec::new();
        let mut columns = None;
        let mut headed = false;
        for (number, line) in text.lines().enumerate() {
            let refused = |problem: String| PhaseTextError { line: number + 1, problem };
            let line = line.split('#').next().unwrap_or_default().trim();
            if line.is_empty() {
                continue;
            }
            let words = line.split(|c: char| c == ',' || c == ';' || c.is_whitespace()).filter(|word| !word.is_empty());
            let numbers: Result<Vec<f64>, usize> =
                words.enumerate().map(|(k, word)| word.parse().map_err(|_| k + 1)).collect();
            let numbers = match numbers {
                Ok(numbers) => numbers,
                // A line of words is a heading, once, before the first entry.
                Err(_) if rows.is_empty() && !headed => {
                    headed = true;
                    continue;
                }
                Err(word) => return Err(refused(format!("word {word} is not a number"))),
            };
            let expected = *columns.get_or_insert(numbers.len());
            if numbers.len() != expected {
                return Err(refused(format!("{} numbers, where the lines before have {expected}", numbers.len())));
            }
            let (angle, values) = match numbers[..] {
                [angle, value] => (angle, [value; 3]),
                [angle, r, g, b] => (angle, [r, g, b]),
                _ => return Err(refused(format!("{} numbers: expected an angle and one or three", numbers.len()))),
            };
            if !(-1.0..=180.0).contains(&angle) {
                return Err(refused("angle out of range: expected 0 to 180 degrees, or a cosine from -1 to 1".into()));
            }
            if !values.iter().all(|value| (0.0..=1e30).contains(value)) {
                return Err(refused("value out of range: expected 0 to 1e30".into()));
            }
            if rows.len() == MOST_ENTRIES {
                return Err(refused(format!("more than {MOST_ENTRIES} entries")));
            }
            rows.push((number + 1, angle, values.map(|v| v as f32)));
        }
        let in_degrees = rows.iter().any(|(_, angle, _)| *angle > 1.0);
        if let Some((line, ..)) = rows.iter().find(|(_, angle, _)| in_degrees && *angle < 0.0) {
            let problem = "a negative angle among angles in degrees: expected 0 to 180".to_owned();
            return Err(PhaseTextError { line: *line, problem });
        }
        let cosine = |angle: f64| if in_degrees { angle.to_radians().cos() } else { angle };
        Ok(Self::At(rows.into_iter().map(|(_, angle, values)| (cosine(angle), values)).collect()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entries(text: &str) -> Vec<(f64, [f32; 3])> {
        match PhaseEntries::from_text(text).unwrap() {
            PhaseEntries::At(entries) => entries,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn angles_and_cosines_one_colour_and_three() {
        let degrees = entries("theta,value\n0, 4\n90;2 # half\n\n180\t1\n");
        assert_eq!(degrees.len(), 3);
        for ((found, _), expected) in degrees.iter().zip([1.0, 0.0, -1.0]) {
            assert!((found - expected).abs() < 1e-15);
        }
        assert_eq!(degrees[1].1, [2.0; 3]);
        let cosines = entries("# from a program\n-1 1 2 3\n0.5 4 5 6\n1 7 8 9");
        assert_eq!(cosines, [(-1.0, [1.0, 2.0, 3.0]), (0.5, [4.0, 5.0, 6.0]), (1.0, [7.0, 8.0, 9.0])]);
    }

    #[test]
    fn malformed_lines_are_named() {
        for (text, line, problem) in [
            ("0,1\n90,x\n", 2, "word 2 is not a number"),
            ("a,b\nc,d\n", 2, "word 1 is not a number"),
            ("0,1\n\n90,1,1,1\n", 3, "4 numbers, where the lines before have 2"),
            ("0\n", 1, "1 numbers: expected an angle"),
            ("0,1,2\n", 1, "3 numbers: expected an angle"),
            ("0,1\n200,1\n", 2, "angle out of range"),
            ("0,1\nNaN,1\n", 2, "angle out of range"),
            ("0,1\n90,-1\n", 2, "value out of range"),
            ("0,inf\n", 1, "value out of range"),
            ("0.5,1\n-0.5,1\n90,1\n", 2, "negative angle among angles in degrees"),
        ] {
            let error = PhaseEntries::from_text(text).unwrap_err();
            assert!(error.line == line && error.problem.contains(problem), "{error}");
        }
    }
}

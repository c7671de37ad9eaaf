//! Phase functions from files: tables as programs for Mie scattering write them.

use std::path::{Path, PathBuf};

use pellucid_io::{Transfer, read_png};
use pellucid_optics::{PhaseEntries, srgb_decode};

use crate::LoadError;

/// Reads the entries of a phase function: lines of numbers, or the first row of a PNG as light.
///
/// # Errors
/// [`LoadError::Io`] for pictures and [`LoadError::Line`] for lines.
pub fn read(path: &Path) -> Result<PhaseEntries, LoadError> {
    if path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("png")) {
        let picture = read_png(path)?;
        let linear = |v: f32| if picture.transfer == Transfer::Srgb { srgb_decode(v) } else { v };
        let row = picture.pixels.iter().take(picture.width as usize);
        return Ok(PhaseEntries::Even(row.map(|[r, g, b, _]| [*r, *g, *b].map(linear)).collect()));
    }
    let text = std::fs::read_to_string(path).map_err(|source| LoadError::Text { path: path.to_owned(), source })?;
    lines(path, &text)
}

/// The entries of a text: an angle in degrees, or its cosine if none is beyond -1 to 1, and one number or three,
/// between commas, semicolons or blanks. A first line of words, empty lines and those after `#` say nothing.
fn lines(path: &Path, text: &str) -> Result<PhaseEntries, LoadError> {
    // With their lines.
    let mut rows: Vec<(usize, f64, [f32; 3])> = Vec::new();
    let mut columns = None;
    let mut headed = false;
    for (number, line) in text.lines().enumerate() {
        let refused = |problem: String| LoadError::Line { path: PathBuf::from(path), line: number + 1, problem };
        let line = line.split('#').next().unwrap_or_default().trim();
        if line.is_empty() {
            continue;
        }
        let words = line.split(|c: char| c == ',' || c == ';' || c.is_whitespace()).filter(|word| !word.is_empty());
        let numbers: Result<Vec<f64>, &str> = words.map(|word| word.parse().map_err(|_| word)).collect();
        let numbers = match numbers {
            Ok(numbers) => numbers,
            // A line of words is a heading, once, before the first entry.
            Err(_) if rows.is_empty() && !headed => {
                headed = true;
                continue;
            }
            Err(word) => return Err(refused(format!("'{word}' is not a number"))),
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
            return Err(refused(format!("angle {angle}: expected 0 to 180 degrees, or a cosine from -1 to 1")));
        }
        if let Some(value) = values.iter().find(|value| !(0.0..=1e30).contains(*value)) {
            return Err(refused(format!("value {value}: expected 0 to 1e30")));
        }
        rows.push((number + 1, angle, values.map(|v| v as f32)));
    }
    let in_degrees = rows.iter().any(|(_, angle, _)| *angle > 1.0);
    let negative = rows.iter().find(|(_, angle, _)| in_degrees && *angle < 0.0);
    if let Some((line, angle, _)) = negative {
        let problem = format!("angle {angle} among angles in degrees: expected 0 to 180");
        return Err(LoadError::Line { path: PathBuf::from(path), line: *line, problem });
    }
    let cosine = |angle: f64| if in_degrees { angle.to_radians().cos() } else { angle };
    Ok(PhaseEntries::At(rows.into_iter().map(|(_, angle, values)| (cosine(angle), values)).collect()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entries(text: &str) -> Vec<(f64, [f32; 3])> {
        match lines(Path::new("a.csv"), text).unwrap() {
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
            ("0,1\n90,x\n", 2, "'x' is not a number"),
            ("a,b\nc,d\n", 2, "'c' is not a number"),
            ("0,1\n\n90,1,1,1\n", 3, "4 numbers, where the lines before have 2"),
            ("0\n", 1, "1 numbers: expected an angle"),
            ("0,1,2\n", 1, "3 numbers: expected an angle"),
            ("0,1\n200,1\n", 2, "angle 200"),
            ("0,1\nNaN,1\n", 2, "angle NaN"),
            ("0,1\n90,-1\n", 2, "value -1"),
            ("0,inf\n", 1, "value inf"),
            ("0.5,1\n-0.5,1\n90,1\n", 2, "angle -0.5 among angles in degrees"),
        ] {
            let error = lines(Path::new("mie.csv"), text).unwrap_err().to_string();
            assert!(error.starts_with(&format!("mie.csv, line {line}: ")) && error.contains(problem), "{error}");
        }
    }
}

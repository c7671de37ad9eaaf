//! Errors about optical properties.

use std::path::PathBuf;

use pellucid_field::{Short, nearest};

/// Why an optical property cannot be used as given.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum OpticsError {
    /// A colour that is no code, no name and not three numbers in 0..=1.
    #[error(
        "colour {found}: expected \"#rrggbb\", a name of CSS such as \"orange\", or [r, g, b] with numbers from 0 to 1{}",
        pointer(meant)
    )]
    Color {
        /// What was given.
        found: String,
        /// The name of a colour that it may mean.
        meant: Option<&'static str>,
    },
    /// A list of control points has no points.
    #[error("{list} has no points: at least one is needed")]
    NoPoints {
        /// The list.
        list: &'static str,
    },
    /// One control point cannot be used.
    #[error("{list}, point {index} (value {}): {problem}", Short(*value))]
    Point {
        /// The list the point is in.
        list: &'static str,
        /// Its position in the list, from 0.
        index: usize,
        /// Its data value.
        value: f64,
        /// What is wrong with it and what is expected.
        problem: String,
    },
    /// A numeric setting is outside its range.
    #[error("{name} is {}: expected {expected}", Short(*found))]
    Parameter {
        /// The setting.
        name: &'static str,
        /// Its value.
        found: f64,
        /// What is allowed.
        expected: &'static str,
    },
    /// An interval is empty, reversed or not finite.
    #[error("{name} [{}, {}]: expected finite numbers, the second {expected} the first", Short(found[0]), Short(found[1]))]
    Interval {
        /// The setting.
        name: &'static str,
        /// The interval.
        found: [f64; 2],
        /// How its ends must relate: "above" or "not below".
        expected: &'static str,
    },
    /// A direction without length.
    #[error(
        "{name} [{}, {}, {}]: expected finite numbers that are not all zero",
        Short(found[0]), Short(found[1]), Short(found[2])
    )]
    Direction {
        /// The setting.
        name: &'static str,
        /// The direction.
        found: [f64; 3],
    },
    /// A file that holds no phase function, or was not read.
    #[error("phase function {}: {problem}", file.display())]
    PhaseFile {
        /// The file, as the document names it.
        file: PathBuf,
        /// What is wrong with it and what is expected.
        problem: String,
    },
    /// A picture that cannot be the sky.
    #[error("picture of the sky: {problem}")]
    SkyMap {
        /// What is wrong with it and what is expected.
        problem: String,
    },
    /// Edges of a face that are too short, too long or parallel.
    #[error("edges of a rectangle {found:?}: expected two of finite length in world units that are not parallel")]
    Edges {
        /// The edges.
        found: [[f64; 3]; 2],
    },
    /// A name that is not in the list it should be from.
    #[error("{kind} \"{found}\" is unknown{}; known are: {known}", pointer(meant))]
    Name {
        /// What the name is for.
        kind: &'static str,
        /// The name.
        found: String,
        /// The one of them that it may mean.
        meant: Option<String>,
        /// The names there are, comma separated.
        known: String,
    },
    /// A phase function whose anisotropy is to vary with the data, but which is not described by one.
    #[error(
        "phase function {phase} has no single anisotropy that could vary: expected henyey_greenstein, schlick or hybrid"
    )]
    NoAnisotropy {
        /// Its name.
        phase: &'static str,
    },
    /// A volume-property file that cannot be read.
    #[error("volume property file: {problem}")]
    VolumeProperty {
        /// What is wrong with it, with line and column where known.
        problem: String,
    },
}

/// Passes a number within `range` on; anything else, NaN included, is an error.
pub(crate) fn checked(
    name: &'static str,
    found: f64,
    range: std::ops::RangeInclusive<f64>,
    expected: &'static str,
) -> Result<(), OpticsError> {
    if found.is_finite() && range.contains(&found) {
        return Ok(());
    }
    Err(OpticsError::Parameter { name, found, expected })
}

/// The answer to a name that is not among those known.
pub(crate) fn unknown_name<'a>(
    kind: &'static str,
    found: &str,
    known: impl IntoIterator<Item = &'a str>,
) -> OpticsError {
    let known: Vec<&str> = known.into_iter().collect();
    let meant = nearest(found, known.iter().copied()).map(str::to_owned);
    OpticsError::Name { kind, found: found.to_owned(), meant, known: known.join(", ") }
}

/// The question after a name that is not known.
fn pointer(meant: &Option<impl std::fmt::Display>) -> String {
    meant.as_ref().map_or_else(String::new, |name| format!(" (did you mean {name}?)"))
}

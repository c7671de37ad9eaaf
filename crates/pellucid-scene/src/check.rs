//! Validation: the same checks whether a scene comes from a file, a flag or Rust code.

use pellucid_field::Short;

/// A value of the scene that is out of its range.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{path}: {message}")]
pub struct Invalid {
    /// Where in the document: `volumes[0].window`, `camera.projection.perspective.vertical_fov`.
    pub path: String,
    /// What was found and what is allowed.
    pub message: String,
}

/// Outcome of a check.
pub(crate) type Checked = Result<(), Invalid>;

/// Fails with what was found and what is allowed unless `holds`.
pub(crate) fn require(holds: bool, path: &str, key: &str, found: impl std::fmt::Display, allowed: &str) -> Checked {
    if holds {
        return Ok(());
    }
    // A number of 300 digits tells nothing.
    let found = found.to_string();
    let found = found.parse().ok().filter(|_| found.len() > 12).map_or(found, |number| Short(number).to_string());
    Err(Invalid { path: join(path, key), message: format!("found {found}, expected {allowed}") })
}

/// Coordinates of which a picture can be made: squares and products of them stay finite.
const FARTHEST: f64 = 1e100;

/// A position is finite.
pub(crate) fn finite(path: &str, key: &str, v: [f64; 3]) -> Checked {
    let holds = v.iter().all(|x| x.abs() <= FARTHEST);
    require(holds, path, key, format!("{v:?}"), "three finite numbers, none beyond 1e100")
}

/// A direction is finite and not zero.
pub(crate) fn direction(path: &str, key: &str, v: [f64; 3]) -> Checked {
    finite(path, key, v)?;
    let holds = v.iter().any(|x| x.abs() >= FARTHEST.recip());
    require(holds, path, key, format!("{v:?}"), "a direction that is not zero")
}

/// A number is finite and greater than 0.
pub(crate) fn positive(path: &str, key: &str, number: f64, allowed: &str) -> Checked {
    require(number > 0.0 && number <= FARTHEST, path, key, number, allowed)
}

/// Path of a key inside a table.
pub(crate) fn join(path: &str, key: &str) -> String {
    match (path.is_empty(), key.is_empty()) {
        (true, _) => key.to_owned(),
        (_, true) => path.to_owned(),
        _ => format!("{path}.{key}"),
    }
}

/// Numbers of voxels per axis.
pub(crate) fn dims(path: &str, key: &str, found: &[usize; 3]) -> Checked {
    require(found.iter().all(|n| (1..=65_536).contains(n)), path, key, format!("{found:?}"), "1 to 65536 per axis")
}

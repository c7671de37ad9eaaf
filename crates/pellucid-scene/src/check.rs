//! Validation: the same checks whether a scene comes from a file, a flag or Rust code.

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
    Err(Invalid { path: join(path, key), message: format!("found {found}, expected {allowed}") })
}

/// A position is finite.
pub(crate) fn finite(path: &str, key: &str, v: [f64; 3]) -> Checked {
    require(v.iter().all(|x| x.is_finite()), path, key, format!("{v:?}"), "three finite numbers")
}

/// A direction is finite and not zero.
pub(crate) fn direction(path: &str, key: &str, v: [f64; 3]) -> Checked {
    finite(path, key, v)?;
    let longest = v.iter().fold(0.0f64, |m, x| m.max(x.abs()));
    require(longest > 1e-12 && longest < 1e100, path, key, format!("{v:?}"), "a direction that is not zero")
}

/// Path of a key inside a table.
pub(crate) fn join(path: &str, key: &str) -> String {
    match (path.is_empty(), key.is_empty()) {
        (true, _) => key.to_owned(),
        (_, true) => path.to_owned(),
        _ => format!("{path}.{key}"),
    }
}

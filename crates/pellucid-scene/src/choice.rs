//! What was chosen on the user's behalf.

use std::fmt;

/// Something that was chosen because the scene left it open.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Choice {
    /// The setting.
    pub setting: &'static str,
    /// What was chosen, and why.
    pub chosen: String,
}

impl fmt::Display for Choice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.setting, self.chosen)
    }
}

/// A number as it is told: with the 7 digits that single precision holds.
pub(crate) fn number(v: f64) -> String {
    format!("{v:.6e}").parse().map_or(v.to_string(), |v: f64| v.to_string())
}

//! What was chosen on the user's behalf.

use std::fmt;

use serde_json::Value;

/// Something that was chosen because the scene left it open.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Choice {
    /// The setting.
    pub setting: &'static str,
    /// What was chosen, and why, in words.
    pub chosen: String,
    /// What was chosen as a document or a program has it: a number, a list, a name, a table.
    pub value: Value,
}

impl Choice {
    /// A choice, its value and the words for it.
    pub fn new(setting: &'static str, value: impl Into<Value>, chosen: impl Into<String>) -> Self {
        Self { setting, chosen: chosen.into(), value: value.into() }
    }
}

impl fmt::Display for Choice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.setting, self.chosen)
    }
}

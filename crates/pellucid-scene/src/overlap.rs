//! What lies where several volumes overlap.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::check::{Checked, require};

/// What lies where volumes overlap. Whatever the rule, all volumes are sampled together.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub enum Overlap {
    /// All of them: extinctions add, and emission is weighted by them. The order of the list changes nothing.
    #[default]
    Add,
    /// The one with the largest opacity. The order of the list changes nothing.
    Maximum,
    /// The first of the list that has any opacity.
    Priority,
    /// Of two volumes one, in the colours of the other: function on form.
    Fused {
        /// The volume, by its place in the list, whose transfer function gives the colour at its values, whatever
        /// its opacity.
        color: usize,
        /// The volume that gives opacity and shape. Where the other has no value it is white.
        opacity: usize,
    },
}

impl Overlap {
    /// Whether a volume, by its place in the list, holds light back: of two that are fused, one gives its colours alone.
    pub fn holds_back(&self, volume: usize) -> bool {
        match self {
            Self::Add | Self::Maximum | Self::Priority => true,
            Self::Fused { opacity, .. } => *opacity == volume,
        }
    }

    pub(crate) fn check(&self, volumes: usize) -> Checked {
        let Self::Fused { color, opacity } = *self else { return Ok(()) };
        let path = "overlap.fused";
        require(volumes == 2, "", "volumes", volumes, "2 where overlap is fused")?;
        require(color < volumes, path, "color", color, "0 or 1")?;
        require(opacity < volumes && opacity != color, path, "opacity", opacity, "the other one of 0 and 1")
    }
}

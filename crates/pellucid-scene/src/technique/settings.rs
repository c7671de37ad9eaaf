//! What the settings of every technique tell of it.

use pellucid_optics::{Environment, Lighting};

use super::Technique;
use super::mode::Mode;
use super::needs::Needs;
use crate::Look;
use crate::check::Checked;

/// Settings of a technique.
pub(super) trait Settings {
    /// The technique's name, as in a document.
    fn name(&self) -> &'static str;

    /// What it asks of a scene.
    fn needs(&self) -> Needs;

    /// What becomes of the samples.
    fn mode(&self) -> &Mode {
        &Mode::Composite
    }

    /// The same, to be changed, if there is a choice.
    fn mode_mut(&mut self) -> Option<&mut Mode> {
        None
    }

    /// What shines from around, if the technique knows of it.
    fn environment(&self) -> Option<&Environment> {
        None
    }

    /// The same, to be changed.
    fn environment_mut(&mut self) -> Option<&mut Environment> {
        None
    }

    /// The technique of the same kind, and with the same kind of mode, with all settings at their defaults.
    fn plain(&self) -> Technique;

    /// Settings of its own that change nothing as the others are, with the reason.
    fn idle(&self) -> Vec<(&'static str, &'static str)> {
        Vec::new()
    }

    /// Settings of its own, and what it makes of lights, by a look.
    fn light_by(&mut self, _look: Look, _lighting: &mut Lighting) {}

    /// Refuses what is out of range.
    fn check(&self, _path: &str) -> Checked {
        Ok(())
    }
}

//! The lobe of Henyey and Greenstein with a table added where light is thrown back (6.2-8): a glory
//! has about a thousandth of the forward peak, but is the only thing to be seen around the shadow of
//! the eye.

use std::path::{Path, PathBuf};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::henyey_greenstein;
use super::table::{Lobe, PhaseEntries, TableAngles, TableDocument};
use crate::OpticsError;

/// Values from 90 to 180 degrees for each colour, which are added, over the largest of them, to
/// Henyey and Greenstein's lobe over its own peak.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(try_from = "TableDocument", into = "TableDocument")]
pub struct BackLobe {
    document: TableDocument,
    lobe: Lobe,
}

impl TryFrom<TableDocument> for BackLobe {
    type Error = OpticsError;

    fn try_from(document: TableDocument) -> Result<Self, OpticsError> {
        Ok(Self { lobe: document.lobe(BACK)?, document })
    }
}

impl From<BackLobe> for TableDocument {
    fn from(back: BackLobe) -> Self {
        back.document
    }
}

/// The cosines of what is thrown back, in the order of angles.
const BACK: [f64; 2] = [0.0, -1.0];

impl BackLobe {
    /// A lobe of these values, at angles from 90 to 180 degrees or cosines from -1 to 0.
    ///
    /// # Errors
    /// As [`PhaseTable::new`](super::PhaseTable::new).
    pub fn new(uniform_in: TableAngles, values: Vec<[f32; 3]>) -> Result<Self, OpticsError> {
        Self::try_from(TableDocument { uniform_in, values, file: None })
    }

    /// A lobe whose entries are in a file, even until they are [`fill`](Self::fill)ed in.
    ///
    /// # Errors
    /// None: the file is not read here.
    pub fn of_file(uniform_in: TableAngles, file: impl Into<PathBuf>) -> Result<Self, OpticsError> {
        Self::try_from(TableDocument { uniform_in, values: Vec::new(), file: Some(file.into()) })
    }

    /// The file that holds the entries, if one does.
    pub fn file(&self) -> Option<&Path> {
        self.document.file.as_deref()
    }

    /// The name of the file, to be changed.
    pub fn file_mut(&mut self) -> Option<&mut PathBuf> {
        self.document.file.as_mut()
    }

    /// Whether its file has yet to be read.
    pub fn is_unread(&self) -> bool {
        self.document.file.is_some() && !self.lobe.is_filled
    }

    /// Takes the entries of its file.
    ///
    /// # Errors
    /// As [`PhaseTable::fill`](super::PhaseTable::fill).
    pub fn fill(&mut self, entries: &PhaseEntries) -> Result<(), OpticsError> {
        self.lobe = self.document.filled(entries, BACK)?;
        Ok(())
    }

    #[inline]
    pub(super) fn renormalised(&self, g: f32, mu: f32) -> [f32; 3] {
        let forward = henyey_greenstein::eval(g, mu) / henyey_greenstein::peak(g);
        self.lobe.renormalised(mu).map(|back| forward + back)
    }

    /// The share of the light that Henyey and Greenstein's lobe scatters, for each colour.
    #[inline]
    fn shares(&self, g: f32) -> [f32; 3] {
        let forward = henyey_greenstein::peak(g).recip();
        self.lobe.renormalised_integral().map(|back| forward / (forward + back))
    }

    #[inline]
    pub(super) fn eval(&self, g: f32, mu: f32) -> [f32; 3] {
        let (shares, back, forward) = (self.shares(g), self.lobe.eval(mu), henyey_greenstein::eval(g, mu));
        std::array::from_fn(|channel| shares[channel] * forward + (1.0 - shares[channel]) * back[channel])
    }

    /// The density of [`sample`](Self::sample): both lobes by the mean of their shares, whichever colours
    /// the table's are.
    #[inline]
    pub(super) fn pdf(&self, g: f32, mu: f32) -> f32 {
        let (share, back) = (super::mean(self.shares(g)), super::mean(self.lobe.eval(mu)));
        share * henyey_greenstein::eval(g, mu) + (1.0 - share) * back
    }

    #[inline]
    pub(super) fn sample(&self, g: f32, u: f32) -> f32 {
        let (is_forward, u) = super::choose(super::mean(self.shares(g)), u);
        if is_forward { henyey_greenstein::sample(g, u) } else { self.lobe.sample(u) }
    }

    pub(super) fn mean_cosine(&self, g: f32) -> [f32; 3] {
        let (shares, back) = (self.shares(g), self.lobe.mean_cosine());
        std::array::from_fn(|channel| shares[channel] * g + (1.0 - shares[channel]) * back[channel])
    }
}

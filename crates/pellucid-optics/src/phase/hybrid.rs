//! The lobe of Henyey and Greenstein with a table added where light is thrown back (6.2-8): a glory
//! has about a thousandth of the forward peak, but is the only thing to be seen around the shadow of
//! the eye.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::henyey_greenstein;
use super::table::{Lobe, TableAngles};
use crate::OpticsError;

/// Values from 90 to 180 degrees for each colour, which are added, over the largest of them, to
/// Henyey and Greenstein's lobe over its own peak.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(try_from = "Document", into = "Document")]
pub struct BackLobe {
    uniform_in: TableAngles,
    values: Vec<[f32; 3]>,
    lobe: Lobe,
}

/// The lobe as it stands in a document, before it is checked.
#[derive(Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "BackLobe")]
struct Document {
    /// Where the entries are: angles from 90 to 180 degrees, or cosines from -1 to 0. Default theta.
    #[serde(default)]
    uniform_in: TableAngles,
    /// Linear red, green and blue, not negative; 2 to 65,536 entries, ends included.
    #[schemars(length(min = 2, max = 65536))]
    values: Vec<[f32; 3]>,
}

impl TryFrom<Document> for BackLobe {
    type Error = OpticsError;

    fn try_from(Document { uniform_in, values }: Document) -> Result<Self, OpticsError> {
        Self::new(uniform_in, values)
    }
}

impl From<BackLobe> for Document {
    fn from(BackLobe { uniform_in, values, .. }: BackLobe) -> Self {
        Self { uniform_in, values }
    }
}

impl BackLobe {
    /// A lobe of these values, at angles from 90 to 180 degrees or cosines from -1 to 0.
    ///
    /// # Errors
    /// As [`PhaseTable::new`](super::PhaseTable::new).
    pub fn new(uniform_in: TableAngles, values: Vec<[f32; 3]>) -> Result<Self, OpticsError> {
        let lobe = Lobe::new(uniform_in, &values, [0.0, -1.0])?;
        Ok(Self { uniform_in, values, lobe })
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

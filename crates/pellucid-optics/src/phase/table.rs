//! Phase functions as tables by angle (6.2-2, 6.2-5, 6.2-7).

use std::f32::consts::{PI, TAU};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::OpticsError;
use crate::error::checked;

/// Values by angle, for each colour; only their ratios within a colour matter, as each is scaled to
/// conserve light. Between entries they are linear in the cosine, whatever the entries' spacing: so the
/// integral is exact, and so are the directions that are sampled.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(try_from = "Document", into = "Document")]
pub struct PhaseTable {
    uniform_in: TableAngles,
    /// As given, from the first angle on.
    values: Vec<[f32; 3]>,
    lobe: Lobe,
}

/// Where the entries of a table are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum TableAngles {
    /// Evenly spaced angles, from 0 degrees (forward) to 180 (default): peaks keep their shape (6.2-5).
    #[default]
    Theta,
    /// Evenly spaced cosines, from -1 (back) to 1 (forward). For mild anisotropy.
    Cosine,
}

/// The table as it stands in a document, before it is checked.
#[derive(Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "PhaseTable")]
struct Document {
    /// Where the entries are. Default theta.
    #[serde(default)]
    uniform_in: TableAngles,
    /// Linear red, green and blue, not negative; 2 to 65,536 entries, ends included.
    #[schemars(length(min = 2, max = 65536))]
    values: Vec<[f32; 3]>,
}

impl TryFrom<Document> for PhaseTable {
    type Error = OpticsError;

    fn try_from(Document { uniform_in, values }: Document) -> Result<Self, OpticsError> {
        Self::new(uniform_in, values)
    }
}

impl From<PhaseTable> for Document {
    fn from(PhaseTable { uniform_in, values, .. }: PhaseTable) -> Self {
        Self { uniform_in, values }
    }
}

impl PhaseTable {
    /// A table of these values, at angles from 0 to 180 degrees or cosines from -1 to 1.
    ///
    /// # Errors
    /// [`OpticsError::Parameter`] unless there are 2 to 65,536 entries, none negative, and every colour
    /// has some light.
    pub fn new(uniform_in: TableAngles, values: Vec<[f32; 3]>) -> Result<Self, OpticsError> {
        let lobe = Lobe::new(uniform_in, &values, [1.0, -1.0])?;
        Ok(Self { uniform_in, values, lobe })
    }

    /// Share per steradian, for each colour.
    #[inline]
    pub(super) fn eval(&self, mu: f32) -> [f32; 3] {
        self.lobe.eval(mu)
    }

    /// The values over the largest of all colours (6.2-7).
    #[inline]
    pub(super) fn renormalised(&self, mu: f32) -> [f32; 3] {
        self.lobe.renormalised(mu)
    }

    #[inline]
    pub(super) fn sample(&self, u: f32) -> f32 {
        self.lobe.sample(u)
    }

    pub(super) fn mean_cosine(&self) -> [f32; 3] {
        self.lobe.mean_cosine()
    }
}

/// A function of the cosine between two bounds, piecewise linear, nothing outside.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Lobe {
    uniform_in: TableAngles,
    /// The lowest and the highest cosine.
    bounds: [f32; 2],
    /// Angle of the first entry and entries per radian, or cosine and entries per unit of cosine.
    origin: f32,
    scale: f32,
    /// Cosines of the entries, ascending or descending.
    cosines: Vec<f32>,
    /// Values per steradian.
    values: Vec<[f32; 3]>,
    /// Share of the light, as the mean of its colours, before each entry.
    cumulative: Vec<f32>,
    /// What the values per steradian are multiplied by to become values over the largest of all.
    renormalising: [f32; 3],
}

impl Lobe {
    /// Entries from the first to the last of these cosines, if uniform in theta, else in the other order.
    pub(super) fn new(
        uniform_in: TableAngles,
        values: &[[f32; 3]],
        [first, last]: [f64; 2],
    ) -> Result<Self, OpticsError> {
        let count = values.len();
        checked("number of phase table entries", count as f64, 2.0..=65_536.0, "2 to 65,536")?;
        for value in values.iter().flatten() {
            checked("phase table value", f64::from(*value), 0.0..=1e30, "0 to 1e30")?;
        }
        let steps = (count - 1) as f64;
        let (origin, range) = match uniform_in {
            TableAngles::Theta => (first.acos(), last.acos() - first.acos()),
            TableAngles::Cosine => (last, first - last),
        };
        let cosine = |entry: usize| {
            let place = origin + range * entry as f64 / steps;
            if uniform_in == TableAngles::Theta { place.cos() } else { place }
        };
        let cosines: Vec<f64> = (0..count).map(cosine).collect();
        let values = values.iter().map(|value| value.map(f64::from));
        let mut values: Vec<[f64; 3]> = values.collect();
        let mut integrals = [0.0; 3];
        for (mu, pair) in cosines.windows(2).zip(values.windows(2)) {
            for (channel, integral) in integrals.iter_mut().enumerate() {
                *integral += std::f64::consts::PI * (mu[1] - mu[0]).abs() * (pair[0][channel] + pair[1][channel]);
            }
        }
        for integral in integrals {
            checked("light of a phase table's colour", integral, f64::MIN_POSITIVE..=f64::MAX, "more than 0")?;
        }
        let largest = values.iter().flatten().copied().fold(0.0, f64::max);
        for value in &mut values {
            *value = std::array::from_fn(|channel| value[channel] / integrals[channel]);
        }
        let mut sum = 0.0;
        let mut cumulative = vec![0.0];
        for (mu, pair) in cosines.windows(2).zip(values.windows(2)) {
            sum += std::f64::consts::PI * (mu[1] - mu[0]).abs() * pair.iter().flatten().sum::<f64>() / 3.0;
            cumulative.push(sum as f32);
        }
        Ok(Self {
            uniform_in,
            bounds: [last as f32, first as f32],
            origin: origin as f32,
            scale: (steps / range) as f32,
            cosines: cosines.into_iter().map(|mu| mu as f32).collect(),
            values: values.into_iter().map(|value| value.map(|v| v as f32)).collect(),
            cumulative,
            renormalising: integrals.map(|integral| (integral / largest) as f32),
        })
    }

    #[inline]
    pub(super) fn eval(&self, mu: f32) -> [f32; 3] {
        let mu = mu.clamp(-1.0, 1.0);
        if !(self.bounds[0]..=self.bounds[1]).contains(&mu) {
            return [0.0; 3];
        }
        let place = if self.uniform_in == TableAngles::Theta { mu.acos() } else { mu };
        let position = ((place - self.origin) * self.scale).max(0.0);
        let entry = (position as usize).min(self.values.len() - 2);
        let t = (mu - self.cosines[entry]) / (self.cosines[entry + 1] - self.cosines[entry]);
        let (from, to, t) = (self.values[entry], self.values[entry + 1], t.clamp(0.0, 1.0));
        std::array::from_fn(|channel| from[channel] + (to[channel] - from[channel]) * t)
    }

    #[inline]
    pub(super) fn renormalised(&self, mu: f32) -> [f32; 3] {
        let value = self.eval(mu);
        std::array::from_fn(|channel| value[channel] * self.renormalising[channel])
    }

    /// The integral over all directions of the renormalised values, for each colour.
    pub(super) fn renormalised_integral(&self) -> [f32; 3] {
        self.renormalising
    }

    /// A cosine distributed as the mean of the colours.
    #[inline]
    pub(super) fn sample(&self, u: f32) -> f32 {
        let last = self.values.len() - 1;
        let u = u * self.cumulative[last];
        let entry = self.cumulative.partition_point(|&before| before <= u).clamp(1, last) - 1;
        let [from, to] = [entry, entry + 1].map(|entry| super::mean(self.values[entry]));
        // The share t of the cell with from t + (to - from) t^2 / 2 = the rest of u over the cell's width.
        let width = self.cosines[entry + 1] - self.cosines[entry];
        let rest = (u - self.cumulative[entry]).max(0.0) / (TAU * width.abs());
        let discriminant = (from * from + 2.0 * (to - from) * rest).max(0.0);
        let t = 2.0 * rest / (from + discriminant.sqrt()).max(f32::MIN_POSITIVE);
        self.cosines[entry] + width * t.clamp(0.0, 1.0)
    }

    pub(super) fn mean_cosine(&self) -> [f32; 3] {
        let mut sum = [0.0; 3];
        for (mu, pair) in self.cosines.windows(2).zip(self.values.windows(2)) {
            for (channel, sum) in sum.iter_mut().enumerate() {
                // The integral of a product of two straight lines.
                let (from, to) = (pair[0][channel], pair[1][channel]);
                let product = mu[0] * (2.0 * from + to) + mu[1] * (from + 2.0 * to);
                *sum += f64::from(PI / 3.0 * (mu[1] - mu[0]).abs() * product);
            }
        }
        sum.map(|sum| sum as f32)
    }
}

//! Phase functions as tables by angle (6.2-2, 6.2-5, 6.2-7).

use std::f32::consts::{PI, TAU};
use std::path::{Path, PathBuf};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::OpticsError;
use crate::error::checked;

/// Values by angle, for each colour; only their ratios within a colour matter, as each is scaled to
/// conserve light. Between entries they are linear in the cosine, whatever the entries' spacing: so the
/// integral is exact, and so are the directions that are sampled.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(try_from = "TableDocument", into = "TableDocument")]
pub struct PhaseTable {
    document: TableDocument,
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

/// The table as it stands in a document, before it is checked: with values or a file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "PhaseTable")]
pub(super) struct TableDocument {
    /// Where the entries are: from 0 to 180 degrees or from cosine -1 to 1; of what is added to a lobe, from 90 to
    /// 180 degrees or from cosine -1 to 0. Default theta.
    #[serde(default)]
    pub uniform_in: TableAngles,
    /// Linear red, green and blue, not negative; 2 to 65,536 entries, ends included.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schemars(length(min = 2, max = 65536))]
    pub values: Vec<[f32; 3]>,
    /// A file with the entries; a relative path starts at the scene's folder. A CSV file has lines of an angle in
    /// degrees, or of a cosine if none is beyond -1 to 1, and one number or three; of a PNG file the first row
    /// is read.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub file: Option<PathBuf>,
}

impl TableDocument {
    /// The lobe between two cosines; isotropic until a file is read.
    pub fn lobe(&self, ends: [f64; 2]) -> Result<Lobe, OpticsError> {
        match (&self.file, self.values.as_slice()) {
            (None, values) => Lobe::new(self.uniform_in, values, ends),
            (Some(_), []) => Lobe::new(self.uniform_in, &[[1.0; 3]; 2], ends),
            (Some(file), _) => {
                let problem = "it has values besides: expected one of both".to_owned();
                Err(OpticsError::PhaseFile { file: file.clone(), problem })
            }
        }
    }
}

impl TryFrom<TableDocument> for PhaseTable {
    type Error = OpticsError;

    fn try_from(document: TableDocument) -> Result<Self, OpticsError> {
        Ok(Self { lobe: document.lobe(WHOLE)?, document })
    }
}

impl From<PhaseTable> for TableDocument {
    fn from(table: PhaseTable) -> Self {
        table.document
    }
}

/// The cosines of all directions, in the order of angles.
const WHOLE: [f64; 2] = [1.0, -1.0];

impl PhaseTable {
    /// A table of these values, at angles from 0 to 180 degrees or cosines from -1 to 1.
    ///
    /// # Errors
    /// [`OpticsError::Parameter`] unless there are 2 to 65,536 entries, none negative, and every colour
    /// has some light.
    pub fn new(uniform_in: TableAngles, values: Vec<[f32; 3]>) -> Result<Self, OpticsError> {
        Self::try_from(TableDocument { uniform_in, values, file: None })
    }

    /// A table whose entries are in a file, isotropic until they are [`fill`](Self::fill)ed in.
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
    /// As [`PhaseTable::new`], and [`OpticsError::PhaseFile`] for angles that do not go from end to end.
    pub fn fill(&mut self, entries: &PhaseEntries) -> Result<(), OpticsError> {
        self.lobe = self.document.filled(entries, WHOLE)?;
        Ok(())
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

/// The entries of a table's file.
#[derive(Clone, Debug, PartialEq)]
pub enum PhaseEntries {
    /// Evenly spaced, as the table says.
    Even(Vec<[f32; 3]>),
    /// At cosines, in any order.
    At(Vec<(f64, [f32; 3])>),
}

impl TableDocument {
    /// The lobe between two cosines that a file describes.
    pub fn filled(&self, entries: &PhaseEntries, ends: [f64; 2]) -> Result<Lobe, OpticsError> {
        let lobe = match entries {
            PhaseEntries::Even(values) => Lobe::new(self.uniform_in, values, ends)?,
            PhaseEntries::At(entries) => Lobe::at(entries, ends).map_err(|error| match error {
                OpticsError::PhaseFile { problem, .. } => {
                    OpticsError::PhaseFile { file: self.file.clone().unwrap_or_default(), problem }
                }
                other => other,
            })?,
        };
        Ok(Lobe { is_filled: true, ..lobe })
    }
}

/// A function of the cosine between two bounds, piecewise linear, nothing outside.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Lobe {
    /// `None` if the entries are where they are.
    uniform_in: Option<TableAngles>,
    /// Whether a file was read.
    pub is_filled: bool,
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
        let steps = (count - 1) as f64;
        let (origin, range) = match uniform_in {
            TableAngles::Theta => (first.acos(), last.acos() - first.acos()),
            TableAngles::Cosine => (last, first - last),
        };
        let cosine = |entry: usize| {
            let place = origin + range * entry as f64 / steps;
            if uniform_in == TableAngles::Theta { place.cos() } else { place }
        };
        let lobe = Self::between((0..count).map(cosine).collect(), values)?;
        Ok(Self { uniform_in: Some(uniform_in), origin: origin as f32, scale: (steps / range) as f32, ..lobe })
    }

    /// Entries at cosines, which must reach from the first to the last of these.
    fn at(entries: &[(f64, [f32; 3])], [first, last]: [f64; 2]) -> Result<Self, OpticsError> {
        checked("number of phase table entries", entries.len() as f64, 2.0..=65_536.0, "2 to 65,536")?;
        let mut entries = entries.to_vec();
        entries.sort_by(|(a, _), (b, _)| b.total_cmp(a));
        let refused = |problem| Err(OpticsError::PhaseFile { file: PathBuf::new(), problem });
        if entries.windows(2).any(|pair| pair[0].0 == pair[1].0) {
            return refused("it has two entries of the same angle".to_owned());
        }
        let found = [entries[0].0, entries[entries.len() - 1].0];
        // A hundredth of a degree at right angles; files are rounded.
        if !((found[0] - first).abs() < 2e-4 && (found[1] - last).abs() < 2e-4) {
            return refused(format!("its cosines do not go from end to end: expected from {first} to {last}"));
        }
        let (mut cosines, values): (Vec<f64>, Vec<[f32; 3]>) = entries.into_iter().unzip();
        let end = cosines.len() - 1;
        (cosines[0], cosines[end]) = (first, last);
        Self::between(cosines, &values)
    }

    /// Values at cosines that ascend or descend from end to end.
    fn between(cosines: Vec<f64>, values: &[[f32; 3]]) -> Result<Self, OpticsError> {
        for value in values.iter().flatten() {
            checked("phase table value", f64::from(*value), 0.0..=1e30, "0 to 1e30")?;
        }
        let ends = [cosines[0], cosines[cosines.len() - 1]].map(|mu| mu as f32);
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
            uniform_in: None,
            is_filled: false,
            bounds: [ends[0].min(ends[1]), ends[0].max(ends[1])],
            origin: 0.0,
            scale: 0.0,
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
        let even = |place: f32| ((place - self.origin) * self.scale).max(0.0) as usize;
        let entry = match self.uniform_in {
            Some(TableAngles::Theta) => even(mu.acos()),
            Some(TableAngles::Cosine) => even(mu),
            None => self.cosines.partition_point(|cosine| *cosine >= mu).max(1) - 1,
        };
        let entry = entry.min(self.values.len() - 2);
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

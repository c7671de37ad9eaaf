//! Transfer functions as tables: what is looked up per sample.

use pellucid_field::parallel;
use rayon::prelude::*;

use crate::opacity::correct_opacity;
use crate::{Chroma, DataRange, Nodes, OpticsError, TransferFunction};

/// A sampled transfer function: linear RGB, not associated, and opacity per unit distance at
/// every node (4.1-4). Between nodes it is interpolated linearly, beyond them it is constant.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    nodes: Nodes,
    entries: Vec<[f32; 4]>,
}

impl Table {
    /// Samples `tf` at `entries` nodes from `domain[0]` to `domain[1]` inclusive.
    ///
    /// # Errors
    /// As [`Nodes::new`].
    pub fn build(tf: &TransferFunction, domain: [f64; 2], entries: usize) -> Result<Self, OpticsError> {
        Ok(Self::at(tf, Nodes::new(domain, entries)?))
    }

    /// Samples `tf` as densely as this data need it: see [`Nodes::for_data`].
    ///
    /// # Errors
    /// As [`Nodes::for_data`].
    pub fn for_data(tf: &TransferFunction, data: &DataRange) -> Result<Self, OpticsError> {
        Ok(Self::at(tf, Nodes::for_data(tf, data)?))
    }

    fn at(tf: &TransferFunction, nodes: Nodes) -> Self {
        let entry = |node| {
            let value = nodes.value(node);
            let [r, g, b] = tf.color(value);
            [r, g, b, tf.opacity(value)]
        };
        // Small tables are built faster than threads are woken.
        let entries = parallel(|| (0..nodes.count()).into_par_iter().with_min_len(2048).map(entry).collect());
        Self { nodes, entries }
    }

    /// The same opacities with other colours, linear RGB by data value and entry.
    pub fn recolored(&self, color: impl Fn(f64, [f32; 4]) -> [f32; 3]) -> Self {
        let entry = |(node, &entry): (usize, &[f32; 4])| {
            let [r, g, b] = color(self.nodes.value(node), entry);
            [r, g, b, entry[3]]
        };
        Self { nodes: self.nodes.clone(), entries: self.entries.iter().enumerate().map(entry).collect() }
    }

    /// Where the entries are.
    pub fn nodes(&self) -> &Nodes {
        &self.nodes
    }

    /// Linear RGB and opacity per unit distance of every node.
    pub fn entries(&self) -> &[[f32; 4]] {
        &self.entries
    }

    /// Linear RGB (not associated) and opacity per unit distance at a data value; zero where the
    /// value is absent.
    pub fn lookup(&self, value: f32) -> [f32; 4] {
        interpolate(&self.nodes, &self.entries, value)
    }
}

/// What a ray marcher looks up: associated linear RGB and opacity of one step.
///
/// Colours are associated *before* they are interpolated, so what is invisible lends its
/// neighbours no colour (3.2-8). Used at the voxels instead of the samples, the same table is
/// pre-classification (4.2-1).
#[derive(Clone, Debug, PartialEq)]
pub struct StepTable {
    nodes: Nodes,
    entries: Vec<[f32; 4]>,
}

impl StepTable {
    /// The table for steps of `ratio` unit distances.
    ///
    /// # Errors
    /// [`OpticsError::Parameter`] unless the ratio is finite and not negative.
    pub fn new(table: &Table, ratio: f32) -> Result<Self, OpticsError> {
        crate::error::checked("step in unit distances", ratio as f64, 0.0..=f32::MAX as f64, "0 or more")?;
        let associate = |&[r, g, b, alpha]: &[f32; 4]| {
            let alpha = correct_opacity(alpha, ratio);
            [r * alpha, g * alpha, b * alpha, alpha]
        };
        Ok(Self { nodes: table.nodes.clone(), entries: table.entries.iter().map(associate).collect() })
    }

    /// The table for steps of `ratio` unit distances through what holds each colour back in its own way; the opacity
    /// is that of the colour that is lost least.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn chromatic(table: &Table, ratio: f32, chroma: &Chroma) -> Result<Self, OpticsError> {
        let mut steps = Self::new(table, ratio * chroma.least)?;
        for (step, [r, g, b, _]) in steps.entries.iter_mut().zip(&table.entries) {
            let alpha = step[3];
            for (channel, (color, ratio)) in [r, g, b].into_iter().zip(chroma.ratios).enumerate() {
                step[channel] = color * correct_opacity(alpha, ratio);
            }
        }
        Ok(steps)
    }

    /// The table for steps of `ratio` unit distances, [`chromatic`](Self::chromatic) where colours are held back each in
    /// its own way.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn of(table: &Table, ratio: f32, chroma: Option<&Chroma>) -> Result<Self, OpticsError> {
        match chroma {
            Some(chroma) => Self::chromatic(table, ratio, chroma),
            None => Self::new(table, ratio),
        }
    }

    /// Where the entries are.
    pub fn nodes(&self) -> &Nodes {
        &self.nodes
    }

    /// Associated linear RGB and opacity of one step at every node.
    pub fn entries(&self) -> &[[f32; 4]] {
        &self.entries
    }

    /// Associated linear RGB and opacity of one step at a data value; zero where the value is
    /// absent.
    #[inline]
    pub fn lookup(&self, value: f32) -> [f32; 4] {
        interpolate(&self.nodes, &self.entries, value)
    }
}

#[inline(always)]
fn interpolate(nodes: &Nodes, entries: &[[f32; 4]], value: f32) -> [f32; 4] {
    if !value.is_finite() {
        return [0.0; 4];
    }
    let (node, t) = nodes.cell(nodes.clamped_position(value));
    let (from, to) = (entries[node], entries[node + 1]);
    std::array::from_fn(|channel| from[channel] + (to[channel] - from[channel]) * t)
}

//! What of a volume's scattering depends on the data, at evenly spaced values.

use crate::{DataRange, Nodes, OpticsError, Scattering, Table};

const ENTRIES: usize = 4096;

/// Anisotropy and surfaces over the data.
#[derive(Clone, Debug, PartialEq)]
pub struct ScatterTable {
    nodes: Nodes,
    entries: Vec<[f32; 4]>,
}

impl ScatterTable {
    /// The scattering of what a transfer function's table classifies.
    ///
    /// # Errors
    /// As [`Nodes::new`].
    pub fn new(scattering: &Scattering, table: &Table, data: &DataRange) -> Result<Self, OpticsError> {
        let entry = |value| {
            let found = scattering.at(value, table.lookup(value as f32));
            [found.g, scattering.surface_at(value, 0.0), 0.0, 0.0]
        };
        let (nodes, entries) = tabulate(data, entry)?;
        Ok(Self { nodes, entries })
    }

    /// Where the entries are.
    pub fn nodes(&self) -> &Nodes {
        &self.nodes
    }

    /// Anisotropy, and the part that is a surface but for what gradients make one.
    pub fn entries(&self) -> &[[f32; 4]] {
        &self.entries
    }
}

/// What gets through of indirect light over the data (K-08, 6.3-1).
#[derive(Clone, Debug, PartialEq)]
pub struct TransportTable {
    nodes: Nodes,
    entries: Vec<[f32; 4]>,
}

impl TransportTable {
    /// For lengths of `ratio` unit distances; `None` if indirect light is attenuated as direct light is.
    ///
    /// # Errors
    /// As [`Nodes::new`].
    pub fn new(scattering: &Scattering, data: &DataRange, ratio: f64) -> Result<Option<Self>, OpticsError> {
        if scattering.transport.is_none() {
            return Ok(None);
        }
        let entry = |value| {
            let unit = scattering.transport_at(value).unwrap_or([1.0; 3]);
            let [r, g, b] = unit.map(|transmittance| f64::from(transmittance).powf(ratio) as f32);
            [r, g, b, 0.0]
        };
        let (nodes, entries) = tabulate(data, entry)?;
        Ok(Some(Self { nodes, entries }))
    }

    /// Where the entries are.
    pub fn nodes(&self) -> &Nodes {
        &self.nodes
    }

    /// The part that gets through, linear RGB.
    pub fn entries(&self) -> &[[f32; 4]] {
        &self.entries
    }
}

fn tabulate(data: &DataRange, entry: impl Fn(f64) -> [f32; 4]) -> Result<(Nodes, Vec<[f32; 4]>), OpticsError> {
    let nodes = Nodes::new([data.low, data.high], ENTRIES)?;
    let entries = (0..ENTRIES).map(|node| entry(nodes.value(node))).collect();
    Ok((nodes, entries))
}

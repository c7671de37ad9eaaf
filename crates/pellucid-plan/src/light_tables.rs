//! What samples that scatter light look up, and what its indirect part loses (6.2, 6.3).

use pellucid_optics::{Albedo, DataRange, OpticsError, ScatterTable, StepTable, Table, TransportTable};
use pellucid_scene::{LightPath, Stage};

/// The tables of a layer whose samples scatter light as a cloud; all are empty where they do not.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LightTables {
    /// What of scattering depends on the data.
    pub scatter: Option<ScatterTable>,
    /// Associated colours of one step, if what samples scatter is not the transfer function's colour.
    pub albedo: Option<StepTable>,
    /// What gets through of indirect light in one step, if that is not what gets through of direct light.
    pub transport: Option<TransportTable>,
}

impl LightTables {
    /// The tables of a layer of a stage, by its number, with that of its transfer function, over a range of data values.
    ///
    /// # Errors
    /// As [`Nodes::new`](pellucid_optics::Nodes::new).
    pub fn new(stage: &Stage, layer: usize, table: &Table, data: &DataRange) -> Result<Self, OpticsError> {
        if !stage.scatters_in(layer) {
            return Ok(Self::default());
        }
        let volume = &stage.volumes[layer];
        let scattering = &volume.scattering;
        let ratio = stage.step / volume.unit_distance();
        let albedo = (scattering.albedo != Albedo::Color).then(|| {
            let albedo = |value, entry| scattering.at(value, entry).albedo;
            StepTable::of(&table.recolored(albedo), ratio as f32, stage.chroma(volume).as_ref())
        });
        let spreads = stage.technique.needs().light == LightPath::Spreads;
        let transport = spreads.then(|| TransportTable::new(scattering, data, ratio)).transpose()?.flatten();
        Ok(Self { scatter: Some(ScatterTable::new(scattering, table, data)?), albedo: albedo.transpose()?, transport })
    }
}

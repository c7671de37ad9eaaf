//! What a slab takes of light that crosses all of it, and half of it, as tables: a directional light travels as far in
//! every slab, so that most samples need no power.

use pellucid_optics::{OpticsError, StepTable, TransportTable};
use pellucid_plan::half_angle::Ways;

use crate::classify::Lookup;
use crate::prepare::Prepared;

/// Tables for the length that light travels in a slab; for a step, if that differs from ray to ray.
pub struct Lengths {
    /// The length in steps.
    pub steps: f32,
    /// Of the colour that is lost least.
    opacity: StepTable,
    /// Of the whole length and of half of it, if indirect light is attenuated in its own way.
    transport: Option<[TransportTable; 2]>,
}

impl Lengths {
    /// For the ways of a light.
    ///
    /// # Errors
    /// As [`StepTable::new`].
    pub fn new(prepared: &Prepared, ways: Ways) -> Result<Self, OpticsError> {
        let steps = match ways {
            Ways::Same(steps) => steps,
            Ways::From { .. } => 1.0,
        };
        let (volume, tables) = (prepared.volume, &prepared.tables);
        let ratio = f64::from(steps) * prepared.stage.step / volume.unit_distance();
        let least = prepared.stage.chroma(volume).map_or(1.0, |chroma| chroma.least);
        let transport = |share: f64| TransportTable::new(&volume.scattering, &tables.range, ratio * share);
        let transport = match tables.light.transport {
            Some(_) => transport(1.0)?.zip(transport(0.5)?).map(<[TransportTable; 2]>::from),
            None => None,
        };
        Ok(Self { steps, opacity: StepTable::new(&tables.table, ratio as f32 * least)?, transport })
    }

    /// Opacities over the length.
    pub fn opacity(&self) -> Lookup<'_> {
        Lookup::of_steps(&self.opacity)
    }

    /// What gets through of indirect light over the length, if that is something else.
    pub fn transport(&self) -> Option<Lookup<'_>> {
        self.transport.as_ref().map(|[whole, _]| Lookup::of_rows(whole.entries(), whole.nodes()))
    }

    /// The same over half of it.
    pub fn half_transport(&self) -> Option<Lookup<'_>> {
        self.transport.as_ref().map(|[_, half]| Lookup::of_rows(half.entries(), half.nodes()))
    }
}

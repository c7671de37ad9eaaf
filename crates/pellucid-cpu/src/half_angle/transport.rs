//! What gets through of indirect light (K-08, 6.3-1).

use pellucid_optics::{DataRange, Nodes, OpticsError, Scattering};

use crate::classify::Lookup;
use crate::lanes::*;

/// Transport colours of one step over the data.
pub struct Transport {
    nodes: Nodes,
    entries: Vec<[f32; 4]>,
}

impl Transport {
    /// For steps of `ratio` unit distances; `None` if indirect light is attenuated as direct light is.
    ///
    /// # Errors
    /// As [`Nodes::new`].
    pub fn new(scattering: &Scattering, data: &DataRange, ratio: f64) -> Result<Option<Self>, OpticsError> {
        const ENTRIES: usize = 4096;
        if scattering.transport.is_none() {
            return Ok(None);
        }
        let nodes = Nodes::new([data.low, data.high], ENTRIES)?;
        let entry = |node| {
            let unit = scattering.transport_at(nodes.value(node)).unwrap_or([1.0; 3]);
            let [r, g, b] = unit.map(|through| f64::from(through).powf(ratio) as f32);
            [r, g, b, 0.0]
        };
        Ok(Some(Self { nodes, entries: (0..ENTRIES).map(entry).collect() }))
    }

    /// As it is looked up.
    pub fn lookup(&self) -> Lookup<'_> {
        Lookup::of_rows(&self.entries, &self.nodes)
    }
}

/// What gets through so many steps of samples of these values.
#[inline(always)]
pub fn through<S: Lanes>(s: S, transport: &Lookup, value: F32<S>, ratio: F32<S>) -> [F32<S>; 3] {
    let [r, g, b, _] = transport.lookup(s, value);
    let (one_step, is_one) = ([r, g, b], ratio.simd_eq(splat(s, 1.0)));
    if is_one.all_true() {
        return one_step;
    }
    xyz!(C => is_one.select(one_step[C], power(s, one_step[C], ratio)))
}

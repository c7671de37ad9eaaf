//! How samples scatter light, as shaders look it up: the structure of `scatter.wgsl`.

use std::f32::consts::PI;

use pellucid_optics::{Anisotropy, Nodes, Phase, PhaseNormalization, Scattering, SurfaceShare};
use pellucid_scene::LightTables;

type Four = [f32; 4];

/// Angles that a phase function is listed at, from 0 to 180 degrees.
const ANGLES: usize = 8192;

/// Which formula `scatter.wgsl` has for a phase function.
const LISTED: f32 = 0.0;
const HENYEY_GREENSTEIN: f32 = 1.0;
const SCHLICK: f32 = 2.0;
const HYBRID: f32 = 3.0;

/// The structure's numbers; nothing if samples do not scatter.
pub fn to_fours(scattering: &Scattering, tables: &LightTables) -> Vec<Four> {
    let Some(scatter) = &tables.scatter else { return Vec::new() };
    let mut entries = Vec::new();
    let properties = append(&mut entries, scatter.nodes(), scatter.entries());
    let transport = tables.transport.as_ref();
    let transport = transport.map_or([0.0; 4], |table| append(&mut entries, table.nodes(), table.entries()));
    let listed = Listed::new(scattering);
    let angles = [0.0, 0.0, entries.len() as f32, listed.entries.len() as f32];
    entries.extend(listed.entries);
    let is_renormalised = f32::from(scattering.phase_normalization == PhaseNormalization::Renormalised);
    let is_uniform = f32::from(scattering.anisotropy == Anisotropy::Uniform);
    let g = scattering.phase.anisotropy().unwrap_or(0.0);
    let surfaces = match &scattering.surface {
        SurfaceShare::Gradient(weight) => [weight.low, 1.0 / (weight.high - weight.low), 0.0, 0.0],
        _ => [0.0; 4],
    };
    let header = [properties, transport, angles, [listed.kind, is_renormalised, g, is_uniform], listed.back, surfaces];
    header.into_iter().chain(entries).collect()
}

/// Puts a table behind the others; where its entries are.
fn append(entries: &mut Vec<Four>, nodes: &Nodes, table: &[Four]) -> Four {
    let first = entries.len() as f32;
    entries.extend_from_slice(table);
    [nodes.origin(), nodes.scale(), first, table.len() as f32]
}

/// A phase function by its angle, as far as it is not a formula.
struct Listed {
    kind: f32,
    entries: Vec<Four>,
    /// What a hybrid throws back, over its forward peak, integrated over all directions.
    back: Four,
}

impl Listed {
    fn new(scattering: &Scattering) -> Self {
        let (phase, normalization) = (&scattering.phase, scattering.phase_normalization);
        let list = |value: &dyn Fn(f32) -> [f32; 3]| {
            let cosine = |k: usize| (k as f32 / (ANGLES - 1) as f32 * PI).cos();
            (0..ANGLES).map(|k| four(value(cosine(k)))).collect()
        };
        match phase {
            Phase::HenyeyGreenstein { .. } => Self::formula(HENYEY_GREENSTEIN),
            Phase::Schlick { .. } => Self::formula(SCHLICK),
            Phase::Hybrid { .. } => {
                // Without anisotropy the forward lobe is 1 over its peak, and the rest is what is thrown back.
                let back = |mu| phase.weight(PhaseNormalization::Renormalised, 0.0, mu).map(|weight| weight - 1.0);
                let share = phase.eval(0.0, 1.0).map(|forward| forward * 4.0 * PI);
                let integral = share.map(|share| 4.0 * PI * (1.0 / share - 1.0));
                Self { kind: HYBRID, entries: list(&back), back: four(integral) }
            }
            _ => Self { entries: list(&|mu| phase.weight(normalization, 0.0, mu)), ..Self::formula(LISTED) },
        }
    }

    /// Nothing listed, but for an entry that is never asked for and its neighbour.
    fn formula(kind: f32) -> Self {
        Self { kind, entries: vec![[0.0; 4]; 2], back: [0.0; 4] }
    }
}

fn four([r, g, b]: [f32; 3]) -> Four {
    [r, g, b, 0.0]
}

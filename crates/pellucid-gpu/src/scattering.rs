//! How samples scatter light, as shaders look it up: the structure of `frame.wgsl`, and tables behind those of the
//! transfer function.

use std::f32::consts::PI;

use crate::four::Four;
use pellucid_optics::{Anisotropy, Nodes, Phase, PhaseNormalization, ScatterTable, Scattering, SurfaceShare};
use pellucid_plan::{LightTables, Tables};

/// Angles that a phase function is listed at, from 0 to 180 degrees.
const ANGLES: usize = 8192;

/// Fours that tell where the tables are.
pub const HEADER: usize = 8;

/// Numbers, and the tables they tell of.
pub type Scatterers = ([Four; HEADER], Vec<Four>);

/// Which formula `scatter.wgsl` has for a phase function.
const LISTED: f32 = 0.0;
const HENYEY_GREENSTEIN: f32 = 1.0;
const SCHLICK: f32 = 2.0;
const HYBRID: f32 = 3.0;

/// Directions of equal likelihood that a phase function is listed with: so many that neighbours still differ near a
/// strong peak.
const COSINES: usize = 512;

/// The most bytes that all of it takes.
pub fn most_bytes(tables: &Tables) -> u64 {
    let Some(scatter) = &tables.light.scatter else { return 0 };
    let transport = tables.light.transport.as_ref().map_or(0, |transport| transport.entries().len());
    let colors = transport.max(tables.table.entries().len());
    ((scatter.entries().len() + colors + ANGLES + COSINES + 1) * size_of::<Four>()) as u64
}

/// What samples that scatter once look up, from entry `first` on; nothing if they do not.
pub fn of_samples(scattering: &Scattering, tables: &LightTables, first: usize) -> Scatterers {
    let Some(scatter) = &tables.scatter else { return Scatterers::default() };
    let transport = tables.transport.as_ref().map(|table| (table.nodes(), table.entries()));
    listed(scattering, scatter, transport, Listed::weights(scattering), first)
}

/// What paths look up: albedos are in the place of transport colours, and phase functions can be sampled.
pub fn of_paths(scattering: &Scattering, tables: &Tables, first: usize) -> Scatterers {
    let Some(scatter) = &tables.light.scatter else { return Scatterers::default() };
    let nodes = tables.table.nodes();
    let albedo = |(node, entry): (usize, &Four)| four(scattering.at(nodes.value(node), *entry).albedo);
    let albedos: Vec<_> = tables.table.entries().iter().enumerate().map(albedo).collect();
    listed(scattering, scatter, Some((nodes, &albedos)), Listed::sampled(scattering), first)
}

fn listed(
    scattering: &Scattering,
    scatter: &ScatterTable,
    colors: Option<(&Nodes, &[Four])>,
    listed: Listed,
    first: usize,
) -> Scatterers {
    let mut entries = Vec::new();
    let mut append = |table: &[Four]| {
        let place = (first + entries.len()) as f32;
        entries.extend_from_slice(table);
        [place, table.len() as f32]
    };
    let mut by_nodes = |nodes: &Nodes, table: &[Four]| {
        let [place, count] = append(table);
        [nodes.origin(), nodes.scale(), place, count]
    };
    let properties = by_nodes(scatter.nodes(), scatter.entries());
    let colors = colors.map_or([0.0; 4], |(nodes, colors)| by_nodes(nodes, colors));
    let [place, count] = append(&listed.entries);
    let angles = [0.0, 0.0, place, count];
    let [place, count] = append(&listed.cosines);
    let cosines = [place, count, 0.0, 0.0];
    let is_renormalised = f32::from(scattering.phase_normalization == PhaseNormalization::Renormalised);
    let is_uniform = f32::from(scattering.anisotropy == Anisotropy::Uniform);
    let g = scattering.phase.anisotropy().unwrap_or(0.0);
    let [low, rise] = match &scattering.surface {
        SurfaceShare::Gradient(weight) => [weight.low, 1.0 / (weight.high - weight.low)],
        _ => [0.0; 2],
    };
    let is_told = is_uniform == 0.0 || matches!(scattering.surface, SurfaceShare::Values(_));
    let surfaces = [low, rise, f32::from(is_told), 0.0];
    let phase = [listed.kind, is_renormalised, g, is_uniform];
    ([properties, colors, angles, phase, listed.back, cosines, listed.shares, surfaces], entries)
}

/// A phase function by its angle, as far as it is not a formula.
struct Listed {
    kind: f32,
    entries: Vec<Four>,
    /// What a hybrid throws back, over its forward peak, integrated over all directions.
    back: Four,
    /// Cosines between which directions are equally likely, ascending.
    cosines: Vec<Four>,
    /// What makes a weight a share per steradian.
    shares: Four,
}

impl Listed {
    /// For samples that scatter once.
    fn weights(scattering: &Scattering) -> Self {
        match &scattering.phase {
            Phase::Hybrid { .. } => {
                let phase = &scattering.phase;
                // Without anisotropy the forward lobe is 1 over its peak, and the rest is what is thrown back.
                let back = |mu| phase.weight(PhaseNormalization::Renormalised, 0.0, mu).map(|weight| weight - 1.0);
                let share = phase.eval(0.0, 1.0).map(|forward| forward * 4.0 * PI);
                let integral = share.map(|share| 4.0 * PI * (1.0 / share - 1.0));
                Self { kind: HYBRID, entries: list(back), back: four(integral), ..Self::formula(HYBRID) }
            }
            _ => Self::sampled(scattering),
        }
    }

    /// For paths, which are scattered by one phase function at all values, or by a formula.
    fn sampled(scattering: &Scattering) -> Self {
        let (phase, normalization) = (&scattering.phase, scattering.phase_normalization);
        let g = phase.anisotropy().unwrap_or(0.0);
        match phase {
            // Isotropic is its lobe without anisotropy.
            Phase::Isotropic | Phase::HenyeyGreenstein { .. } => Self::formula(HENYEY_GREENSTEIN),
            Phase::Schlick { .. } => Self::formula(SCHLICK),
            _ => {
                let weight = |mu| phase.weight(normalization, g, mu);
                let brightest = (0..ANGLES).map(cosine).max_by(|a, b| weight(*a)[1].total_cmp(&weight(*b)[1]));
                let brightest = brightest.unwrap_or(1.0);
                let (value, weighted) = (phase.eval(g, brightest), weight(brightest));
                let shares = [0, 1, 2].map(|c| if weighted[c] > 0.0 { value[c] / weighted[c] } else { 1.0 / PI });
                Self {
                    entries: list(weight),
                    cosines: cosines(phase, g),
                    shares: four(shares),
                    ..Self::formula(LISTED)
                }
            }
        }
    }

    /// Nothing listed, but for entries that are never asked for.
    fn formula(kind: f32) -> Self {
        let nothing = vec![[0.0; 4]; 2];
        Self { kind, entries: nothing.clone(), back: [0.0; 4], cosines: nothing, shares: [0.0; 4] }
    }
}

/// The cosine of a listed angle.
fn cosine(number: usize) -> f32 {
    (number as f32 / (ANGLES - 1) as f32 * PI).cos()
}

fn list(value: impl Fn(f32) -> [f32; 3]) -> Vec<Four> {
    (0..ANGLES).map(|number| four(value(cosine(number)))).collect()
}

/// Quantiles of the cosine, with both ends: every direction can be chosen.
fn cosines(phase: &Phase, g: f32) -> Vec<Four> {
    const SAMPLES: usize = 32 * COSINES;
    let mut sampled: Vec<f32> = (0..SAMPLES).map(|k| phase.sample(g, (k as f32 + 0.5) / SAMPLES as f32)).collect();
    sampled.sort_unstable_by(f32::total_cmp);
    let inner = (1..COSINES).map(|k| sampled[k * SAMPLES / COSINES]);
    std::iter::once(-1.0).chain(inner).chain([1.0]).map(|mu| [mu, 0.0, 0.0, 0.0]).collect()
}

fn four([r, g, b]: [f32; 3]) -> Four {
    [r, g, b, 0.0]
}

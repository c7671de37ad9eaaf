//! The tables and blocks of a stage: the same numbers that the CPU backend looks up.

use std::borrow::Cow;

use pellucid_optics::{ColorSpace, Nodes, Scattering, SurfaceShare, TransferFunction, path_extinction};
use pellucid_plan::{BlockContent, BlockMap, Tables};
use pellucid_scene::{Classification, ColorWeight, Combine, Isovalue, LightPath, Mode, Slice, Stage, StageVolume};

use crate::scattering::{self, Scatterers};
use crate::shaders::Pass;
use crate::uniforms::Level;

/// What a stage's mode needs.
pub struct Optics<'a> {
    /// The pass that draws it.
    pub pass: Pass,
    /// Whether values have opacity 1.
    pub opaque: bool,
    /// What is read between voxels, and how.
    pub tables: &'a Tables,
    /// Linear RGB and opacity: per unit distance, per step or per segment, as the pass wants.
    pub entries: Cow<'a, [[f32; 4]]>,
    /// Whether those are colours without their opacity.
    pub bleeds: bool,
    /// Where they are.
    pub nodes: Nodes,
    /// What blocks say, if any are skipped.
    pub blocks: Option<&'a BlockMap>,
    /// Isosurfaces.
    pub levels: Vec<Level>,
    /// Whether samples may be surfaces in light, and whether gradients tell how much of one.
    pub shaded: bool,
    pub weighted: bool,
    scattering: &'a Scattering,
}

impl<'a> Optics<'a> {
    /// What a stage's pass wants of the tables of a volume, by its number.
    pub fn new(stage: &'a Stage, number: usize, tables: &'a Tables) -> Self {
        let volume = &stage.volumes[number];
        // Light on its way classifies every sample by itself.
        let light = stage.technique.needs().light;
        let (pass, opaque) = match light {
            LightPath::Spreads => (Pass::Composite, false),
            LightPath::Scatters => (Pass::PathTrace, false),
            LightPath::Arrives => pass_of(stage),
        };
        let bleeds = pass == Pass::CompositePre
            && stage.slicing().is_some_and(|slicing| slicing.colors == ColorWeight::NonAssociated);
        let steps = tables.scattered_steps();
        let (entries, nodes) = match (pass, &tables.preintegration, &tables.stride_entries) {
            _ if light == LightPath::Spreads => (steps.entries(), steps.nodes()),
            (Pass::PreIntegrated, Some(segments), _) => (segments.entries(), segments.nodes()),
            (Pass::Composite, _, Some(strides)) => (strides.as_slice(), tables.step_table.nodes()),
            // Colours without their opacity, which invisible values have, too.
            _ if bleeds => (tables.table.entries(), tables.table.nodes()),
            (Pass::Composite, ..) => (steps.entries(), steps.nodes()),
            (Pass::CompositePre | Pass::XRay, ..) => (tables.step_table.entries(), tables.step_table.nodes()),
            _ => (tables.table.entries(), tables.table.nodes()),
        };
        let levels = levels(&stage.isovalues(number), &volume.transfer_function);
        // A plane is met once: there is nothing to leap over.
        let blocks = tables.blocks.as_ref().filter(|_| pass != Pass::Slice);
        let scattering = &volume.scattering;
        let (shaded, weighted) = match tables.light.scatter {
            // Paths meet surfaces of a material only; slices have one for all volumes.
            Some(_) => (
                scattering.has_surfaces() && (pass != Pass::PathTrace || volume.material.is_some()),
                matches!(scattering.surface, SurfaceShare::Gradient(_)),
            ),
            None => (volume.material.is_some() && lights(stage.mode()), volume.gradient_weight.is_some()),
        };
        let entries = match pass {
            Pass::PathTrace => extinctions(stage, volume, tables),
            _ => Cow::Borrowed(entries),
        };
        Self {
            pass,
            opaque,
            tables,
            entries,
            bleeds,
            nodes: nodes.clone(),
            blocks,
            levels,
            shaded,
            weighted,
            scattering,
        }
    }
}

impl<'a> Optics<'a> {
    /// What light meets on its way through a volume, however that is drawn.
    pub fn of_light(stage: &'a Stage, number: usize, tables: &'a Tables) -> Self {
        let steps = tables.scattered_steps();
        Self {
            pass: Pass::Composite,
            entries: Cow::Borrowed(steps.entries()),
            bleeds: false,
            nodes: steps.nodes().clone(),
            ..Self::new(stage, number, tables)
        }
    }
}

impl Optics<'_> {
    /// Bytes of the tables on the device.
    pub fn table_bytes(&self) -> u64 {
        let tables =
            size_of_val(&*self.entries) + size_of_val(self.nodes.knots()) + size_of_val(self.levels.as_slice());
        tables as u64 + scattering::most_bytes(self.tables)
    }

    /// How samples scatter, as shaders look it up behind the entries: made anew whenever it is asked for.
    pub fn scattering(&self) -> Scatterers {
        let first = self.entries.len();
        match self.pass {
            Pass::PathTrace => scattering::of_paths(self.scattering, self.tables, first),
            _ => scattering::of_samples(self.scattering, &self.tables.light, first),
        }
    }

    /// Bytes of the map of blocks on the device.
    pub fn block_bytes(&self) -> u64 {
        self.blocks.map_or(0, |map| {
            let each = match map.content {
                BlockContent::Distances(_) if map.levels.is_none() => 1,
                BlockContent::Distances(_) => 2,
                BlockContent::Extremes(_) => 4,
            };
            map.dims.iter().product::<usize>() as u64 * each
        })
    }
}

/// Colours, and extinctions per step: what paths look up.
fn extinctions<'a>(stage: &Stage, volume: &StageVolume, tables: &Tables) -> Cow<'a, [[f32; 4]]> {
    let (unit, step) = (volume.unit_distance(), stage.step as f32);
    let entry = |&[r, g, b, opacity]: &[f32; 4]| [r, g, b, path_extinction(opacity, unit) * step];
    tables.table.entries().iter().map(entry).collect()
}

/// Whether a mode shows surfaces in light.
pub fn lights(mode: &Mode) -> bool {
    matches!(mode, Mode::Composite | Mode::Isosurface(_))
}

/// Whether a stage's mode looks at pairs of values.
pub fn is_of_segments(stage: &Stage) -> bool {
    matches!(pass_of(stage).0, Pass::PreIntegrated | Pass::Isosurface)
}

/// The pass of a stage's mode, and whether values are opaque.
fn pass_of(stage: &Stage) -> (Pass, bool) {
    match stage.mode() {
        Mode::Composite => match stage.quality.classification {
            Classification::Post => (Pass::Composite, false),
            Classification::Pre => (Pass::CompositePre, false),
            Classification::PreIntegrated if stage.integrates_segments() => (Pass::PreIntegrated, false),
            Classification::PreIntegrated => (Pass::Composite, false),
        },
        Mode::Maximum => (Pass::Maximum, false),
        Mode::Minimum => (Pass::Minimum, false),
        Mode::Average => (Pass::Average, false),
        Mode::Additive => (Pass::Additive, false),
        Mode::XRay => (Pass::XRay, false),
        Mode::Isosurface(_) => (Pass::Isosurface, false),
        Mode::Slice(Slice { thickness, .. }) if *thickness <= 0.0 => (Pass::Slice, true),
        Mode::Slice(Slice { combine, .. }) => match combine {
            Combine::Maximum => (Pass::Maximum, true),
            Combine::Minimum => (Pass::Minimum, true),
            Combine::Average => (Pass::Average, true),
        },
    }
}

fn levels(isovalues: &[Isovalue], tf: &TransferFunction) -> Vec<Level> {
    let level = |iso: &Isovalue| {
        let [r, g, b] = iso.color.map_or_else(|| tf.color(iso.value), |color| color.to_linear(ColorSpace::Srgb));
        Level { color: [r, g, b, iso.opacity], value: [iso.value as f32, 0.0, 0.0, 0.0] }
    };
    isovalues.iter().map(level).collect()
}

//! Measurements over one setting, camera still.

use std::iter::successors;

use pellucid::field::VoxelType;
use pellucid::load;
use pellucid::optics::{OpacityPoint, TransferFunction};
use pellucid::scene::{SampleSource, Scene, Source, Stage};

use super::meter::Meter;
use super::subject::{Subject, still};
use super::timing::Timing;
use super::variants::{self, Variant};
use crate::failure::Failure;

/// What is varied.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sweep {
    /// Distance between samples.
    Step,
    /// Size of the picture.
    Size,
    /// Number of threads.
    Threads,
    /// Reconstruction filter.
    Filter,
    /// Gradient estimator.
    Gradient,
    /// Direction of view.
    View,
    /// Voxels and their type, of a built-in field.
    Volume,
    /// Whether the transfer function changes from frame to frame.
    Edit,
}

/// Every sweep by its name.
pub const SWEEPS: [(&str, Sweep); 8] = [
    ("step", Sweep::Step),
    ("size", Sweep::Size),
    ("threads", Sweep::Threads),
    ("filter", Sweep::Filter),
    ("gradient", Sweep::Gradient),
    ("view", Sweep::View),
    ("volume", Sweep::Volume),
    ("edit", Sweep::Edit),
];

/// One setting and its frames.
pub struct Row {
    /// The setting.
    pub label: String,
    /// Its frames.
    pub timing: Timing,
}

impl Sweep {
    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        SWEEPS.iter().find(|(_, sweep)| *sweep == self).map_or("", |(name, _)| name)
    }

    /// Refuses before long work a scene it makes no sense for.
    pub fn check(self, scene: &Scene) -> Result<(), Failure> {
        if self == Self::Volume { sample(scene).map(|_| ()) } else { Ok(()) }
    }

    /// Measures every setting. `largest` is the most voxels per axis of [`Sweep::Volume`].
    pub fn run(self, subject: &Subject, meter: &mut Meter, largest: usize) -> Result<Vec<Row>, Failure> {
        match self {
            Self::Step => all(variants::steps(subject), subject, meter),
            Self::Size => all(variants::sizes(subject), subject, meter),
            Self::Filter => all(variants::filters(subject), subject, meter),
            Self::Gradient => all(variants::gradients(subject), subject, meter),
            Self::View => all(variants::views(subject), subject, meter),
            Self::Threads => threads(subject, meter),
            Self::Volume => volumes(subject, meter, largest),
            Self::Edit => edits(subject, meter),
        }
    }
}

fn all(variants: Vec<Variant>, subject: &Subject, meter: &mut Meter) -> Result<Vec<Row>, Failure> {
    let row = |(label, scene)| Ok(Row { label, timing: still(&scene, &subject.volumes, meter)?.0 });
    variants.into_iter().map(row).collect()
}

/// 1, 2, 4 and so on, and all.
fn threads(subject: &Subject, meter: &Meter) -> Result<Vec<Row>, Failure> {
    let most = meter.threads();
    let counts = successors(Some(1), |n: &u16| n.checked_mul(2)).take_while(|n| *n < most).chain([most]);
    let row = |count: u16| {
        let mut meter = meter.with_threads(count)?;
        Ok(Row { label: count.to_string(), timing: still(&subject.scene, &subject.volumes, &mut meter)?.0 })
    };
    counts.map(row).collect()
}

/// The built-in field of the first volume.
fn sample(scene: &Scene) -> Result<&SampleSource, Failure> {
    match scene.volumes.as_slice() {
        [entry] => match &entry.source {
            Source::Sample(sample) => Ok(sample),
            _ => Err(Failure::input("--sweep volume samples a built-in field at many sizes, and the input is a file")
                .hint("pellucid bench sample:head --sweep volume")),
        },
        entries => {
            Err(Failure::input(format_args!("--sweep volume takes one volume, the scene lists {}", entries.len())))
        }
    }
}

/// 64^3, 128^3 and so on up to `largest`, in three types of voxels: always the same picture, but for
/// the resolution.
fn volumes(subject: &Subject, meter: &mut Meter, largest: usize) -> Result<Vec<Row>, Failure> {
    let sample = sample(&subject.scene)?;
    let fixed = subject.with_choices();
    let sizes = successors(Some(64), |n: &usize| n.checked_mul(2)).take_while(|n| *n <= largest);
    let types = [VoxelType::U8, VoxelType::U16, VoxelType::F32];
    let kinds = sizes.flat_map(|n| types.map(|voxel_type| (n, voxel_type)));
    let row = |(n, voxel_type)| {
        let mut scene = fixed.clone();
        let source = SampleSource { dims: Some([n; 3]), voxel_type: Some(voxel_type), ..sample.clone() };
        scene.volumes.iter_mut().for_each(|entry| entry.source = Source::Sample(source.clone()));
        let (volumes, _) = load(&scene, "")?;
        Ok(Row { label: format!("{n}^3 {voxel_type}"), timing: still(&scene, &volumes, meter)?.0 })
    };
    kinds.map(row).collect()
}

/// The same stage again and again, then with another transfer function every time.
fn edits(subject: &Subject, meter: &mut Meter) -> Result<Vec<Row>, Failure> {
    let (unchanged, _) = meter.measure(&mut subject.stage.clone(), |_, _| Ok(()))?;
    let mut edit = 0;
    let (edited, _) = meter.measure(&mut subject.stage.clone(), |_, stage| {
        edit += 1;
        thin(&subject.stage, stage, edit)
    })?;
    let row = |label: &str, timing| Row { label: label.to_owned(), timing };
    Ok(vec![row("unchanged", unchanged), row("edited", edited)])
}

/// Gives `stage` the transfer functions of `original`, a little less opaque with every edit: never
/// the same twice, and never much less work.
fn thin(original: &Stage, stage: &mut Stage, edit: usize) -> Result<(), Failure> {
    let factor = 1.0 - 0.1 * edit as f32 / (edit + 10) as f32;
    for (from, to) in original.volumes.iter().zip(&mut stage.volumes) {
        let tf = &from.transfer_function;
        let thinner = |point: &OpacityPoint| OpacityPoint { opacity: point.opacity * factor, ..*point };
        let opacities = tf.opacities().iter().map(thinner).collect();
        to.transfer_function = TransferFunction::new(tf.colors().to_vec(), opacities)
            .map(|thin| thin.with_color_space(tf.color_space()))
            .and_then(|thin| thin.with_unit_distance(tf.unit_distance()))
            .map_err(Failure::work)?;
    }
    Ok(())
}

//! The order in which layers are merged: that of their content, so that sums do not depend on the order of the document.

use std::cmp::Ordering;
use std::sync::Arc;

use pellucid_field::Volume;
use pellucid_scene::{Overlap, Stage, StageVolume};

/// The numbers of a stage's volumes in the order in which they are merged: as listed where the rule of their overlap
/// asks for it, else by what they are. Sums of more than two numbers depend on their order by roundings.
pub fn merge_order(stage: &Stage) -> Vec<usize> {
    let mut order: Vec<usize> = (0..stage.volumes.len()).collect();
    if matches!(stage.overlap, Overlap::Add | Overlap::Maximum) {
        let keys: Vec<String> = stage.volumes.iter().map(key).collect();
        order.sort_by(|&a, &b| keys[a].cmp(&keys[b]).then_with(|| by_voxels(&stage.volumes[a], &stage.volumes[b])));
    }
    order
}

/// What tells volumes apart, but for their voxels.
fn key(volume: &StageVolume) -> String {
    let data = &volume.volume;
    format!(
        "{:?}",
        (
            (data.grid(), data.statistics(), data.value_map(), volume.component, volume.origin),
            (&volume.transfer_function, &volume.material, &volume.gradient_weight),
            (&volume.scattering, &volume.perturbation, &volume.region),
        )
    )
}

/// Looked at only where all else is the same.
fn by_voxels(a: &StageVolume, b: &StageVolume) -> Ordering {
    let of = |volume: &StageVolume| [Some(volume.volume.clone()), volume.colors.clone()];
    let pairs = of(a).into_iter().flatten().zip(of(b).into_iter().flatten());
    let by_bytes = |(a, b): (Arc<Volume>, Arc<Volume>)| match Arc::ptr_eq(&a, &b) {
        true => Ordering::Equal,
        false => a.voxels().as_bytes().cmp(b.voxels().as_bytes()),
    };
    pairs.map(by_bytes).fold(a.colors.is_some().cmp(&b.colors.is_some()), Ordering::then)
}

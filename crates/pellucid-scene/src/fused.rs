//! The optics of two volumes of which one gives the other its colours.

use pellucid_optics::{Color, ColorPoint, OpacityPoint, OpticsError, TransferFunction};

use crate::{Overlap, StageVolume};

/// Gives volumes the optics that they are fused by: one opaque colours without light, the other white matter.
pub fn fuse(overlap: Overlap, volumes: &mut [StageVolume]) -> Result<(), OpticsError> {
    let Overlap::Fused { color, opacity } = overlap else { return Ok(()) };
    let of = |colors, opacities, old: &TransferFunction| {
        TransferFunction::new(colors, opacities)?.with_unit_distance(old.unit_distance())
    };
    let colored = &mut volumes[color];
    let tf = &colored.transfer_function;
    colored.transfer_function = of(tf.colors().to_vec(), vec![OpacityPoint::new(0.0, 1.0)], tf)?;
    (colored.material, colored.gradient_weight) = (None, None);
    let tf = &volumes[opacity].transfer_function;
    let white = vec![ColorPoint::new(0.0, Color::WHITE)];
    volumes[opacity].transfer_function = of(white, tf.opacities().to_vec(), tf)?;
    volumes[opacity].colors = None;
    Ok(())
}

//! World frames and units: everything that states an anatomical frame becomes LPS millimetres.

use glam::{DAffine3, DMat3, DVec3};

/// The frame a file states its positions in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Frame {
    /// x to the patient's left, y to the back, z to the head: the frame of DICOM and of the world.
    Lps,
    /// x to the right, y to the front: the frame of NIfTI.
    Ras,
    /// x to the left, y to the front; left-handed.
    Las,
    /// Left-handed, with no meaning beyond that; mirrored in z so that shapes keep their sides.
    LeftHanded,
    /// Not stated; positions stay as they are.
    Unstated,
}

impl Frame {
    /// Whether directions have an anatomical meaning.
    pub fn is_anatomical(self) -> bool {
        matches!(self, Self::Lps | Self::Ras | Self::Las)
    }

    /// Takes positions of this frame to the world.
    pub fn world_from_frame(self) -> DMat3 {
        DMat3::from_diagonal(match self {
            Self::Lps | Self::Unstated => DVec3::ONE,
            Self::Ras => DVec3::new(-1.0, -1.0, 1.0),
            Self::Las => DVec3::new(1.0, -1.0, 1.0),
            Self::LeftHanded => DVec3::new(1.0, 1.0, -1.0),
        })
    }
}

/// Millimetres per unit of length; `None` for a unit that is not known.
pub(crate) fn millimetres(unit: &str) -> Option<f64> {
    Some(match unit.trim().to_lowercase().as_str() {
        "mm" | "millimeter" | "millimeters" | "millimetre" | "millimetres" => 1.0,
        "m" | "meter" | "meters" | "metre" | "metres" => 1e3,
        "cm" | "centimeter" | "centimeters" | "centimetre" | "centimetres" => 10.0,
        "um" | "\u{b5}m" | "\u{3bc}m" | "micron" | "microns" | "micrometer" | "micrometers" | "micrometre" => 1e-3,
        "nm" | "nanometer" | "nanometers" | "nanometre" | "nanometres" => 1e-6,
        _ => return None,
    })
}

/// Frame and unit of a file's positions, brought to the world.
pub(crate) fn to_world(file_from_index: DAffine3, frame: Frame, millimetres_per_unit: f64) -> DAffine3 {
    DAffine3::from_mat3(frame.world_from_frame() * millimetres_per_unit) * file_from_index
}

/// An affine from the steps along one, two or three axes. Missing axes stand perpendicular on the
/// others and step by the mean of their lengths, so that an image has a thickness.
pub(crate) fn affine_from_steps(steps: &[DVec3], origin: DVec3) -> DAffine3 {
    let thickness = steps.iter().map(|step| step.length()).sum::<f64>() / steps.len().max(1) as f64;
    let axes = match *steps {
        [] => DMat3::IDENTITY,
        [x] => {
            let (y, z) = x.try_normalize().unwrap_or(DVec3::X).any_orthonormal_pair();
            DMat3::from_cols(x, y * thickness, z * thickness)
        }
        [x, y] => DMat3::from_cols(x, y, x.cross(y).normalize_or_zero() * thickness),
        [x, y, z, ..] => DMat3::from_cols(x, y, z),
    };
    DAffine3 { matrix3: axes, translation: origin }
}

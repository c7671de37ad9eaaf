//! From s-form, q-form and voxel sizes to one affine, and back.

use glam::{DAffine3, DMat3, DQuat, DVec3};
use pellucid_field::Warning;

use super::header::NiftiHeader;
use crate::world::{Frame, to_world};

/// Millimetres per unit of the spatial part of `xyzt_units`; `None` if it is not stated.
fn millimetres_per_unit(xyzt_units: i32) -> Option<f64> {
    match xyzt_units & 7 {
        1 => Some(1e3),
        2 => Some(1.0),
        3 => Some(1e-3),
        _ => None,
    }
}

/// Where the voxels are, whether that is in millimetres, and whether sides are known. The s-form counts before the q-form;
/// without either, the standard's method 1 knows the size of voxels, but neither side nor place.
pub(super) fn world_from_index(header: &NiftiHeader, warnings: &mut Vec<Warning>) -> (DAffine3, bool, bool) {
    let (affine, frame) = if header.sform_code > 0 {
        let row = |k: usize| header.srow[k];
        let column = |k: usize| DVec3::new(row(0)[k], row(1)[k], row(2)[k]);
        let matrix3 = DMat3::from_cols(column(0), column(1), column(2));
        (DAffine3 { matrix3, translation: column(3) }, Frame::Ras)
    } else {
        let spacing: [f64; 3] = std::array::from_fn(|axis| voxel_size(header, axis, warnings));
        if header.qform_code > 0 {
            // pixdim[0] is the sign of the third axis; 0 counts as 1.
            let side = if header.pixdim[0] < 0.0 { -1.0 } else { 1.0 };
            let scale = DMat3::from_diagonal(DVec3::from_array(spacing) * DVec3::new(1.0, 1.0, side));
            let matrix3 = rotation(header.quatern) * scale;
            (DAffine3 { matrix3, translation: DVec3::from_array(header.qoffset) }, Frame::Ras)
        } else {
            let line = "neither s-form nor q-form: left and right, and the place in the world, are not known";
            warnings.push(Warning::File(line.to_owned()));
            let matrix3 = DMat3::from_diagonal(DVec3::from_array(spacing));
            (DAffine3 { matrix3, translation: DVec3::ZERO }, Frame::Unstated)
        }
    };
    let scale = millimetres_per_unit(header.xyzt_units);
    (to_world(affine, frame, scale.unwrap_or(1.0)), scale.is_some(), frame.is_anatomical())
}

fn voxel_size(header: &NiftiHeader, axis: usize, warnings: &mut Vec<Warning>) -> f64 {
    let found = header.pixdim[axis + 1];
    let is_used = (axis as i64) < header.dim[0];
    if found > 0.0 && found.is_finite() {
        return found;
    }
    let size = if found.is_finite() && found != 0.0 { found.abs() } else { 1.0 };
    if is_used {
        warnings.push(Warning::File(format!("pixdim[{}] is {found}: taken as {size}", axis + 1)));
    }
    size
}

/// The rotation of a unit quaternion whose first part is left out and not negative.
fn rotation([b, c, d]: [f64; 3]) -> DMat3 {
    let square = 1.0 - (b * b + c * c + d * d);
    // A half turn has a = 0; rounding in the file must not turn that into the root of a negative
    // number (nifti1.h uses the same bound).
    let quaternion = if square < 1e-7 {
        DQuat::from_xyzw(b, c, d, 0.0).normalize()
    } else {
        DQuat::from_xyzw(b, c, d, square.sqrt())
    };
    DMat3::from_quat(quaternion)
}

/// The q-form of an affine in RAS: the quaternion's b, c, d and the sign of the third axis, or
/// `None` if the axes are not perpendicular.
pub(super) fn qform(ras_from_index: DAffine3) -> Option<([f64; 3], f64)> {
    let m = ras_from_index.matrix3;
    let (x, y, z) = (m.x_axis.normalize(), m.y_axis.normalize(), m.z_axis.normalize());
    if x.dot(y).abs().max(y.dot(z).abs()).max(z.dot(x).abs()) > 1e-6 {
        return None;
    }
    let side = if m.determinant() < 0.0 { -1.0 } else { 1.0 };
    let q = DQuat::from_mat3(&DMat3::from_cols(x, y, z * side)).normalize();
    let sign = if q.w < 0.0 { -1.0 } else { 1.0 };
    Some(([q.x * sign, q.y * sign, q.z * sign], side))
}

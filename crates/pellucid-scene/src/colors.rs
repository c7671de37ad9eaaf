//! Colours that voxels have of their own, instead of those of a transfer function.

use pellucid_field::{Volume, Voxels};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Where the colours of a volume come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Colors {
    /// From the transfer function.
    TransferFunction,
    /// From the voxels, 3 or 4 components of 8 or 16 bits that are red, green and blue, encoded as sRGB; those of the
    /// transfer function tint them.
    Data,
}

/// Whether the voxels of a volume can be colours: 3 or 4 components of 8 or 16 bits.
pub fn holds_colors(volume: &Volume) -> bool {
    matches!(volume.components(), 3 | 4) && matches!(volume.voxels(), Voxels::U8(_) | Voxels::U16(_))
}

/// Whether voxels have a fourth component that differs from one to another: the alpha of cut out pictures does, and
/// that of whole ones tells nothing.
pub fn holds_alpha(volume: &Volume) -> bool {
    fn varies<T: PartialEq>(data: &[T]) -> bool {
        data.chunks_exact(4).any(|voxel| voxel[3] != data[3])
    }
    volume.components() == 4
        && match volume.voxels() {
            Voxels::U8(data) => varies(data),
            Voxels::U16(data) => varies(data),
            _ => false,
        }
}

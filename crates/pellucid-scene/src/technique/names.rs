//! Techniques by the names that commands have for them: flags, completions and comparisons take them from here.

use super::{SliceGeometry, Technique};

/// Makes of a technique another one, which keeps the mode and its own settings as far as it has any.
pub type Likeness = fn(&Technique) -> Technique;

/// Every technique, slices by their geometry.
pub const TECHNIQUES: &[(&str, Likeness)] = &[
    ("ray-cast", Technique::along_rays),
    ("view-aligned", |technique| technique.in_slices(SliceGeometry::ViewAligned)),
    ("object-aligned", |technique| technique.in_slices(SliceGeometry::ObjectAligned)),
    ("multi-texture", |technique| technique.in_slices(SliceGeometry::MultiTexture)),
    ("shells", |technique| technique.in_slices(SliceGeometry::Shells)),
    ("half-angle", Technique::by_half_angles),
    ("path-trace", Technique::by_paths),
];

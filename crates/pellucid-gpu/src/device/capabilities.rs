//! What a device can do beyond what every one can, and its limits.

use std::fmt;

use wgpu::{Features, Limits};

use super::Ceiling;

/// Optional features and limits of a device: those it was opened with.
#[derive(Clone, Debug)]
pub struct Capabilities {
    /// Features that are used where they are there; none is needed.
    pub features: Features,
    /// Limits: the larger of what WebGPU guarantees and what the adapter has, up to the ceiling.
    pub limits: Limits,
    /// Most bytes of volumes, tables and targets at the same time.
    pub memory: u64,
}

impl Capabilities {
    /// The features that this backend has a use for.
    const USEFUL: Features = Features::FLOAT32_FILTERABLE
        .union(Features::FLOAT32_BLENDABLE)
        .union(Features::TEXTURE_FORMAT_16BIT_NORM)
        .union(Features::TIMESTAMP_QUERY);

    pub(super) fn of(adapter: &wgpu::Adapter, ceiling: &Ceiling) -> Self {
        let offered = adapter.limits();
        let mut limits = Limits::default();
        if !ceiling.guaranteed {
            limits = limits.or_better_values_from(&offered);
        }
        // An adapter below WebGPU's defaults is taken as it is.
        limits.max_texture_dimension_3d = limits.max_texture_dimension_3d.min(offered.max_texture_dimension_3d);
        if let Some(side) = ceiling.texture_side {
            limits.max_texture_dimension_3d = limits.max_texture_dimension_3d.min(side);
        }
        let memory = ceiling.memory.unwrap_or(u64::MAX);
        Self { features: adapter.features() & Self::USEFUL, limits, memory }
    }

    /// The features that this backend has a use for, by name, and whether they are there.
    pub fn optional(&self) -> impl Iterator<Item = (&'static str, bool)> + use<'_> {
        Self::USEFUL.iter_names().map(|(name, feature)| (name, self.has(feature)))
    }

    /// Whether a feature is there.
    pub fn has(&self, feature: Features) -> bool {
        self.features.contains(feature)
    }
}

impl fmt::Display for Capabilities {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let yes = |feature| if self.has(feature) { "yes" } else { "no" };
        write!(
            f,
            "3D textures to {}, buffers to {} MiB, bindings to {} MiB, float filtering {}, 16-bit norm {}, \
             timestamps {}",
            self.limits.max_texture_dimension_3d,
            self.limits.max_buffer_size >> 20,
            self.limits.max_storage_buffer_binding_size >> 20,
            yes(Features::FLOAT32_FILTERABLE),
            yes(Features::TEXTURE_FORMAT_16BIT_NORM),
            yes(Features::TIMESTAMP_QUERY),
        )
    }
}

//! A mark of all that light belongs to, by which other light is known.

use std::fmt::{self, Write};

use pellucid_field::Volume;
use pellucid_optics::SkyMap;
use rayon::prelude::*;

/// A hash (FNV-1a, 64 bits) of what is written into it.
pub struct Mark(u64);

impl Mark {
    /// Of nothing yet.
    pub fn new() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }

    /// The hash.
    pub fn number(&self) -> u64 {
        self.0
    }

    /// A volume's voxels, where they are, and what its numbers mean.
    pub fn add_volume(&mut self, volume: &Volume) {
        /// Bytes that are hashed at once, side by side with others.
        const CHUNK: usize = 1 << 20;
        let (grid, voxels) = (volume.grid(), volume.voxels());
        let what = (grid.dims(), grid.world_from_index(), volume.components(), volume.value_map());
        self.add(&(what, voxels.voxel_type()));
        let of_chunk = |bytes: &[u8]| {
            let mut mark = Self::new();
            mark.add_bytes(bytes);
            mark.0
        };
        let chunks: Vec<u64> = voxels.as_bytes().par_chunks(CHUNK).map(of_chunk).collect();
        chunks.iter().for_each(|hash| self.add_bytes(&hash.to_le_bytes()));
    }

    /// A picture of the sky.
    pub fn add_sky(&mut self, map: &SkyMap) {
        self.add(&map.size());
        map.texels().iter().flatten().for_each(|v| self.add_bytes(&v.to_bits().to_le_bytes()));
    }

    /// Settings, as they are written for people who look for mistakes: all numbers have all of their digits there.
    pub fn add(&mut self, settings: &impl fmt::Debug) {
        // Hashing does not fail.
        let _ = write!(self, "{settings:?};");
    }

    fn add_bytes(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.0 = (self.0 ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01b3);
        }
    }
}

impl Write for Mark {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        self.add_bytes(text.as_bytes());
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By the values that its authors publish (Fowler, Noll, Vo).
    #[test]
    fn texts_have_the_hashes_that_everybody_has() {
        for (text, hash) in
            [("", 0xcbf2_9ce4_8422_2325), ("a", 0xaf63_dc4c_8601_ec8c), ("foobar", 0x8594_4171_f739_67e8)]
        {
            let mut mark = Mark::new();
            mark.write_str(text).unwrap();
            assert_eq!(mark.number(), hash, "{text}");
        }
    }
}

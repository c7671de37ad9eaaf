//! Where a slice's indirect light is gathered from (Eq. 6.11, K-09).

use pellucid_scene::{BlurJitter, BlurScaling, HalfAngle};

/// Offsets of the taps of a slab, as shares of the radius of the blur: corners of a regular polygon, which
/// neither move light nor, being the same for all texels, lose any. On the rim their second moment is half
/// the radius squared on each axis, over a disc a quarter of it.
pub fn offsets(settings: &HalfAngle, slab: usize) -> Vec<[f32; 2]> {
    let [turn, radius] = pattern(settings, slab);
    let offset = |tap: u32| {
        let (sin, cos) = ((f64::from(tap) + turn) / f64::from(settings.taps) * std::f64::consts::TAU).sin_cos();
        [(radius * cos) as f32, (radius * sin) as f32]
    };
    (0..count(settings)).map(offset).collect()
}

/// How many taps there are: none if nothing is blurred.
pub fn count(settings: &HalfAngle) -> u32 {
    if settings.taps < 2 || settings.blur_angle == 0.0 { 0 } else { settings.taps }
}

/// The polygon of a slab: by which part of the angle between two corners it is turned, and its corners' share of
/// the blur's radius.
pub fn pattern(settings: &HalfAngle, slab: usize) -> [f64; 2] {
    match settings.jitter {
        BlurJitter::Fixed => [0.0, 1.0],
        BlurJitter::PerSlice => {
            let noise = |number: u64| random(u64::from(settings.seed) << 32 | slab as u64, number);
            // Uniform in area.
            [noise(0), noise(1).sqrt()]
        }
    }
}

/// The radius of the blur in world units, for slabs in which light travels so far.
pub fn radius(settings: &HalfAngle, path: f64, voxel: f64) -> f64 {
    let scaled = match settings.blur_scaling {
        BlurScaling::PerSlice => path,
        BlurScaling::PerDistance => (path * voxel).sqrt(),
    };
    scaled * (settings.blur_angle.to_radians() / 2.0).tan()
}

/// A number from 0 to 1 (SplitMix64).
fn random(seed: u64, number: u64) -> f64 {
    let mut z = seed.wrapping_mul(0xD1B5_4A32_D192_ED03).wrapping_add((number + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15));
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
}

//! Gradient noise (Perlin 2002) with continuous second derivatives, and its fractal sums.

use super::footprint::Footprint;
use super::number::Number;

/// Waves in a unit of noise, about where its spectrum has its peak.
pub(super) const WAVES: f64 = 0.7;

/// Gradient noise: 0 at integer points, between about -1 and 1, features about one unit wide.
pub(super) fn noise<N: Number>(p: [N; 3]) -> N {
    let cell = p.map(|x| x.value().floor());
    let fraction: [N; 3] = std::array::from_fn(|axis| p[axis] - cell[axis]);
    let fade = fraction.map(N::smoothstep);
    let corner = |i: usize| {
        let step = [i & 1, i >> 1 & 1, i >> 2];
        let hash = hash(std::array::from_fn(|axis| cell[axis] as i64 + step[axis] as i64));
        let [x, y, z]: [N; 3] = std::array::from_fn(|axis| fraction[axis] - step[axis] as f64);
        slope(hash, x, y, z)
    };
    let edge = |i: usize| corner(i).mix(corner(i + 1), fade[0]);
    let face = |i: usize| edge(i).mix(edge(i + 2), fade[1]);
    face(0).mix(face(4), fade[2])
}

/// The linear function of a lattice point: one of the twelve directions to the edges of a cube.
fn slope<N: Number>(hash: u32, x: N, y: N, z: N) -> N {
    let (a, b) = match hash % 12 / 4 {
        0 => (x, y),
        1 => (y, z),
        _ => (z, x),
    };
    (if hash & 1 == 0 { a } else { -a }) + (if hash & 2 == 0 { b } else { -b })
}

/// A well mixed number for every lattice point (the finaliser of MurmurHash3).
fn hash([x, y, z]: [i64; 3]) -> u32 {
    let mut h = (x as u32).wrapping_mul(0x8da6_b343)
        ^ (y as u32).wrapping_mul(0xd816_3841)
        ^ (z as u32).wrapping_mul(0xcb1a_b31f);
    h = (h ^ h >> 16).wrapping_mul(0x85eb_ca6b);
    h = (h ^ h >> 13).wrapping_mul(0xc2b2_ae35);
    h ^ h >> 16
}

/// Sum of `octaves` of noise, each twice as fine and half as strong, between about -1 and 1: as much of it as is
/// seen, where one unit of the first is `unit` long.
pub(super) fn fractal<N: Number>(p: [N; 3], octaves: u32, unit: f64, seen: Footprint) -> N {
    let mut sum = N::constant(0.0);
    let (mut frequency, mut amplitude) = (1.0, 0.5);
    for _ in 0..octaves {
        let detail = seen.detail(frequency * WAVES / unit);
        if detail == 0.0 {
            break;
        }
        // An offset keeps the zeros of all octaves at lattice points from falling together.
        sum = sum + noise(p.map(|x| x * frequency + frequency * 0.37)) * (amplitude * detail);
        frequency *= 2.0;
        amplitude *= 0.5;
    }
    sum
}

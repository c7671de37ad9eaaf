//! A periodic volume of random numbers: detail that costs 128 KiB at any resolution (K-20, MOD-07).

/// Texels along an axis; a power of two, so that coordinates wrap by masking.
const SIZE: usize = 32;

/// A cube of 32 x 32 x 32 texels of four independent random bytes, slightly blurred, that repeats for
/// ever: one period is one unit of its coordinates.
///
/// The same seed gives the same bytes on every machine. Texel i along an axis is the sample **at** coordinate
/// i / 32.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Noise {
    texels: Vec<[u8; 4]>,
}

impl Noise {
    /// Texels along an axis.
    pub const SIZE: usize = SIZE;

    /// The noise of a seed. The blur, weights 1, 6, 1 eighths along each axis and around the edges, hides
    /// the creases of trilinear interpolation (K-20) and leaves a standard deviation of about 0.13.
    pub fn new(seed: u32) -> Self {
        let raw = Self::from_fn(|[x, y, z]| random(seed, (x + SIZE * (y + SIZE * z)) as u32).to_le_bytes());
        Self::from_fn(|texel| {
            let mut sums = [0u32; 4];
            for tap in 0..27 {
                let steps = [tap % 3, tap / 3 % 3, tap / 9];
                let weight: u32 = steps.iter().map(|step| [1, 6, 1][*step]).product();
                // One back, here, one on.
                let at = [0, 1, 2].map(|axis| texel[axis] + steps[axis] + SIZE - 1);
                for (sum, byte) in sums.iter_mut().zip(raw.texel(at)) {
                    *sum += weight * u32::from(byte);
                }
            }
            sums.map(|sum| ((sum + 256) / 512) as u8)
        })
    }

    /// Noise of any texels, numbered from 0 to 31 along each axis.
    pub fn from_fn(texel: impl Fn([usize; 3]) -> [u8; 4]) -> Self {
        let at = |i: usize| texel([i % SIZE, i / SIZE % SIZE, i / (SIZE * SIZE)]);
        Self { texels: (0..SIZE * SIZE * SIZE).map(at).collect() }
    }

    /// All 32,768 texels, x fastest.
    pub fn texels(&self) -> &[[u8; 4]] {
        &self.texels
    }

    /// A texel of the endless repetition.
    fn texel(&self, at: [usize; 3]) -> [u8; 4] {
        let [x, y, z] = at.map(|i| i % SIZE);
        self.texels[x + SIZE * (y + SIZE * z)]
    }

    /// Four numbers from -1 to 1 at a place given in texels (32 to a period), by trilinear interpolation:
    /// `2 n - 1` of the numbers n from 0 to 1 that the bytes stand for, so that what is displaced by them
    /// stays where it is in the mean (K-24).
    #[inline]
    pub fn signed(&self, place: [f32; 3]) -> [f32; 4] {
        let cell = place.map(f32::floor);
        let [u, v, w] = [0, 1, 2].map(|axis| place[axis] - cell[axis]);
        let first = cell.map(|x| (x as i32).rem_euclid(SIZE as i32) as usize);
        let corner = |i: usize| self.texel([first[0] + (i & 1), first[1] + (i >> 1 & 1), first[2] + (i >> 2)]);
        let corners: [[u8; 4]; 8] = std::array::from_fn(corner);
        std::array::from_fn(|channel| {
            let byte = |i: usize| f32::from(corners[i][channel]);
            let row = |i: usize| byte(i) + u * (byte(i + 1) - byte(i));
            let slice = |i: usize| row(i) + v * (row(i + 2) - row(i));
            let byte = slice(0) + w * (slice(4) - slice(0));
            byte * (2.0 / 255.0) - 1.0
        })
    }
}

/// A well mixed number for every seed and place (twice the finaliser of MurmurHash3).
fn random(seed: u32, place: u32) -> u32 {
    let mix = |mut h: u32| {
        h = (h ^ h >> 16).wrapping_mul(0x85eb_ca6b);
        h = (h ^ h >> 13).wrapping_mul(0xc2b2_ae35);
        h ^ h >> 16
    };
    mix(mix(seed.wrapping_add(0x9e37_79b9)) ^ place.wrapping_mul(0x9e37_79b1))
}

//! Straight lines in double precision: rays of an eye, of a light or of a path, each between a beginning and an end.
//! They are carried from one space into another here, and cut by boxes and planes.

use glam::{DAffine3, DVec3};
use pellucid_scene::Ray;

use crate::lanes::xyz;

/// Lines side by side: far from the volume f32 would blur where they enter it. What is done with them is done with
/// the first few: one plain loop over plain arrays after the other, of which the compiler makes vectors.
pub struct Lines<const N: usize> {
    /// Where they come from.
    pub origin: [[f64; N]; 3],
    /// Where they go to.
    pub direction: [[f64; N]; 3],
    /// How many times that far they begin, and end; nothing is left of one that ends before it begins.
    pub ends: [[f64; N]; 2],
}

impl<const N: usize> Lines<N> {
    /// Lines that no one has directed yet, from their origins on.
    pub const UNDIRECTED: Self =
        Self { origin: [[0.0; N]; 3], direction: [[0.0; N]; 3], ends: [[0.0; N], [f64::INFINITY; N]] };

    /// The first `n` in another space, with the same ends.
    #[inline(always)]
    pub fn carried(&self, n: usize, target_from_source: &DAffine3) -> Self {
        let (turn, moved) = (&target_from_source.matrix3, target_from_source.translation);
        let mut carried = Self { ends: self.ends, ..Self::UNDIRECTED };
        for axis in 0..3 {
            let (x, y, z, moved) = (turn.x_axis[axis], turn.y_axis[axis], turn.z_axis[axis], moved[axis]);
            for lane in 0..n {
                let [a, b, c] = xyz!(I => self.origin[I][lane]);
                carried.origin[axis][lane] = x * a + y * b + z * c + moved;
                let [a, b, c] = xyz!(I => self.direction[I][lane]);
                carried.direction[axis][lane] = x * a + y * b + z * c;
            }
        }
        carried
    }

    /// Keeps what of the first `n` lies between the corners of a box.
    #[inline(always)]
    pub fn keep_box(&mut self, n: usize, low: DVec3, high: DVec3) {
        let [t0, t1] = &mut self.ends;
        for axis in 0..3 {
            for lane in 0..n {
                let (origin, inverse) = (self.origin[axis][lane], 1.0 / nonzero(self.direction[axis][lane]));
                let (near, far) = ((low[axis] - origin) * inverse, (high[axis] - origin) * inverse);
                t0[lane] = larger(t0[lane], smaller(near, far));
                t1[lane] = smaller(t1[lane], larger(near, far));
            }
        }
    }

    /// Keeps what of the first `n` lies in a half-space `normal . p >= offset`.
    #[inline(always)]
    pub fn keep_side(&mut self, n: usize, normal: DVec3, offset: f64) {
        let [t0, t1] = &mut self.ends;
        for lane in 0..n {
            let [x, y, z] = xyz!(I => self.direction[I][lane]);
            let slope = normal.x * x + normal.y * y + normal.z * z;
            let [x, y, z] = xyz!(I => self.origin[I][lane]);
            let above = normal.x * x + normal.y * y + normal.z * z - offset;
            let crossing = -above / nonzero(slope);
            t0[lane] = if slope >= 0.0 { larger(t0[lane], crossing) } else { t0[lane] };
            t1[lane] = if slope < 0.0 { smaller(t1[lane], crossing) } else { t1[lane] };
        }
    }
}

impl From<(&Ray, [f64; 2])> for Lines<1> {
    /// What of a ray is between two distances.
    fn from((ray, ends): (&Ray, [f64; 2])) -> Self {
        let [origin, direction] = [ray.origin, ray.direction].map(|v| v.to_array().map(|v| [v]));
        Self { origin, direction, ends: ends.map(|end| [end]) }
    }
}

/// The larger number: one instruction, as nothing is said of NaN.
#[inline(always)]
pub fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// The smaller number.
#[inline(always)]
pub fn smaller(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// A number to divide by: a line along a plane is on one side of it by the sign of a huge number.
#[inline(always)]
fn nonzero(x: f64) -> f64 {
    if x.abs() < 1e-200 { 1e-200 } else { x }
}

//! What of a shape a voxel sees: edges as wide, and thin things as faint, as their mean over it.

use super::number::Number;

/// Width of the narrowest edge that a grid holds, in voxels. The quintic step over three is the mean of a sharp
/// edge under a kernel with a standard deviation of 0.57 voxels, that of a cubic B-spline: what it passes
/// beyond the Nyquist frequency is not seen.
const EDGE: f64 = 3.0;

/// The same for large even surfaces, where the trilinear interpolation of narrower edges still shows as rings:
/// normals of a ball's isosurface are 3 degrees off at 3 voxels, and 1.4 at 4.5.
const SMOOTH: f64 = 4.5;

/// Share of a small neighbourhood that lies inside a shape: 1 inside, 0 outside, 1/2 on the
/// surface, with an edge `width` wide.
pub(super) fn inside<N: Number>(distance: N, width: f64) -> N {
    (distance * -width.recip() + 0.5).smoothstep()
}

/// The width of a voxel that sees a field; 0 for the field itself.
#[derive(Clone, Copy, Debug)]
pub(super) struct Footprint(pub f64);

impl Footprint {
    /// That of a point.
    pub const POINT: Self = Self(0.0);

    /// How wide an edge is drawn that is `own` wide.
    pub fn edge(self, own: f64) -> f64 {
        own.max(EDGE * self.0)
    }

    /// How wide an edge of a large even surface is drawn.
    pub fn smooth_edge(self, own: f64) -> f64 {
        own.max(SMOOTH * self.0)
    }

    /// Share of a voxel that lies inside a shape with edges `own` wide.
    pub fn inside<N: Number>(self, distance: N, own: f64) -> N {
        inside(distance, self.edge(own))
    }

    /// What is left of the share inside a shape where it is thinner than the edges drawn, given half its extent
    /// across each axis in which it is limited: exact in the middle of a sheet (one), nearly so of a rod (two)
    /// and of a ball (three).
    pub fn thin<const AXES: usize>(self, half: [f64; AXES], own: f64) -> f64 {
        let width = self.edge(own);
        let least = half.into_iter().fold(f64::INFINITY, f64::min);
        if width == own || least >= 0.5 * width {
            return 1.0;
        }
        let step = |h: f64, width: f64| (0.5 + h / width).smoothstep();
        let middle =
            |width: f64| half.iter().map(|h| 2.0 * step(*h, width) - 1.0).product::<f64>() / step(least, width);
        middle(width) / middle(own)
    }

    /// What is left of detail of that many waves per unit length: all of it up to a sixth of the sampling rate, nothing
    /// from a third on (Norton, Rockwood and Skolmoski 1982).
    pub fn detail(self, frequency: f64) -> f64 {
        1.0 - (6.0 * frequency * self.0 - 1.0).smoothstep()
    }
}

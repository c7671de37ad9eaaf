//! Light from far away in a few numbers: real spherical harmonics, after the appendix of C. Wyman, S. Parker,
//! P. Shirley and C. Hansen, "Interactive Display of Isosurfaces with Global Illumination", IEEE Transactions on
//! Visualization and Computer Graphics 12(2), 2006.
//!
//! Coefficient `l (l + 1) + m` is that of degree l and order m, -l to l; there is no Condon-Shortley phase. The poles
//! are the world's z, and azimuths go from +x towards +y.

mod bands;
mod basis;
mod light;
mod rotation;
mod sky;
mod zonal;

pub use bands::{Bands, MOST_BANDS, MOST_COEFFICIENTS};
pub use basis::{spherical_harmonics, spherical_harmonics_f64};
pub use light::Harmonics;
pub use rotation::Rotation;
pub use zonal::{Window, Zonal};

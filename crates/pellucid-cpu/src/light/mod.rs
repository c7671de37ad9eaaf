//! Light at samples: what arrives there, and what of it they send to the eye.
//!
//! [`Arriving`] is what is left of lights on their way (6.1), told by shadow rays, volumes of light or the picture of light
//! of half-angle slicing. `Shading` is what a sample makes of it: it reflects light (`blinn_phong`, 5.4), scatters it (`scattered`,
//! 6.2), or does both (`hybrid`, K-11). [`Lighting`] is all of it for a volume, as the medium asks for it.

mod blinn_phong;
mod choice;
mod gradient;
mod hybrid;
mod lighting;
mod lights;
mod scatter;
mod scattered;
mod shading;
#[cfg(test)]
mod tests;
mod unlit;

pub use blinn_phong::BlinnPhong;
pub use gradient::normals;
pub use lighting::{Answer, Lighting};
pub use lights::{Aim, Arriving, Lights};
pub use unlit::Unlit;

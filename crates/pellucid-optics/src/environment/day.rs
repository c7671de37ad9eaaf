//! A sky by day, made up: no measurement of one.

use std::f32::consts::PI;

use glam::Vec3;

use super::map::SkyMap;
use crate::OpticsError;

const WIDTH: usize = 256;
const HEIGHT: usize = 128;

/// A blue sky, pale at the horizon, with a sun of 2 degrees halfway up on the right (+x, towards the eye that
/// looks along +y), over brown ground. The sun, a haze around it and the sky bring about a third of the light each.
pub fn day() -> Result<SkyMap, OpticsError> {
    let sun = Vec3::new(0.8, -0.4, 0.6).normalize();
    let texel = |k: usize| {
        let theta = PI * ((k / WIDTH) as f32 + 0.5) / HEIGHT as f32;
        let turn = 2.0 * PI * ((k % WIDTH) as f32 + 0.5) / WIDTH as f32 - PI;
        let direction = Vec3::new(theta.sin() * turn.sin(), theta.sin() * turn.cos(), theta.cos());
        let near = direction.dot(sun).clamp(-1.0, 1.0);
        let disc = if near > 2f32.to_radians().cos() { 250.0 } else { 0.0 };
        let haze = 2.5 * near.max(0.0).powi(40);
        let height = direction.z;
        let [low, high] =
            if height >= 0.0 { [[0.75, 0.82, 0.9], [0.12, 0.3, 0.75]] } else { [[0.3, 0.26, 0.2], [0.16, 0.12, 0.08]] };
        let t = height.abs().sqrt();
        let warm = [1.0, 0.93, 0.8];
        std::array::from_fn(|channel| low[channel] + (high[channel] - low[channel]) * t + (disc + haze) * warm[channel])
    };
    SkyMap::new(WIDTH, HEIGHT, (0..WIDTH * HEIGHT).map(texel).collect())
}

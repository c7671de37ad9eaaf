//! Half-angle slicing: light that travels through the volume while it is drawn (Kniss et al. 2003, section
//! 6.3).
//!
//! Slabs lie halfway between the light and the eye (`pellucid_scene::half_angle`), and rays of both cross them in the same order
//! (`crossing`). Light is a picture of the volume as the light sees it (`frame`, `buffer`): slab after slab it
//! loses what the slab holds (`matter`) and spreads (`advance`), and the eye looks at each slab in the
//! light that has come to it (`eye`). Several lights are several sweeps, each with slabs of its own.
//!
//! A few slabs are a *run*. Their matter is looked up along rays of light, then light passes them one by one,
//! leaving a buffer in front of each, and then the eye looks at them all, pixel by pixel: rays and colours stay
//! at hand, and threads meet once a slab.

mod advance;
mod buffer;
mod crossing;
mod eye;
mod frame;
mod lengths;
mod matter;
mod sweep;
mod transport;

#[cfg(test)]
mod tests;

use pellucid_optics::ResolvedLight;
use pellucid_scene::half_angle::{Geometry, LightError, lights, material};
use pellucid_scene::{Control, HalfAngle};
use rayon::prelude::*;

use crate::RenderError;
use crate::classify::Lookup;
use crate::integrator::Found;
use crate::lanes::*;
use crate::prepare::Prepared;
use crate::surface::Surface;
use crate::tiles::{Tile, Tiles};

use eye::{Eye, EyePacket};
pub use lengths::Lengths;
pub use matter::Matter;
pub use sweep::Sweep;

/// Draws a stage into tiles.
///
/// # Errors
/// [`RenderError::Light`] if there is no such light or one stands in the volume, [`RenderError::Cancelled`].
pub fn draw(
    prepared: &Prepared,
    settings: &HalfAngle,
    set: InstructionSet,
    control: &Control,
    tiles: &mut Tiles,
) -> Result<(), RenderError> {
    let stage = prepared.stage;
    let lights = lights(stage, settings)?;
    let subs = stage.quality.supersampling.pow(2) as usize;
    let sweeps = lights.len() * subs;
    tiles.clear();
    for (place, (number, light)) in lights.iter().enumerate() {
        let geometry =
            Geometry::new(stage, prepared.grid(), settings, light).ok_or(LightError::Inside { light: *number })?;
        let lengths = Lengths::new(prepared, geometry.ways)?;
        let done = place * subs;
        let drawing = Drawing {
            prepared,
            settings,
            geometry: &geometry,
            lengths,
            light,
            lights: lights.len(),
            is_first: done == 0,
        };
        for sub in 0..subs {
            let report = |share: f64| control.report(((done + sub) as f64 + share) / sweeps as f64);
            dispatch!(set, s => drawing.sweep(s, sub, control, &report, tiles))?;
        }
    }
    Ok(())
}

/// One of the lights, and what it shines on.
struct Drawing<'a> {
    prepared: &'a Prepared<'a>,
    settings: &'a HalfAngle,
    geometry: &'a Geometry,
    lengths: Lengths,
    light: &'a ResolvedLight,
    /// How many lights there are: each sweep brings its share of what does not depend on them.
    lights: usize,
    is_first: bool,
}

impl Drawing<'_> {
    /// Adds the picture in this light, by one ray of every pixel.
    fn sweep<S: Lanes>(
        &self,
        s: S,
        sub: usize,
        control: &Control,
        report: &dyn Fn(f64),
        tiles: &mut Tiles,
    ) -> Result<(), RenderError> {
        let eye = self.eye(s)?;
        let cancelled = || control.is_cancelled();
        let mut light = Sweep::new(self.prepared, self.settings, self.geometry, self.matter(s)?, cancelled)?;
        let length = light.run_length();
        let columns = 1 << width::<S>().ilog2().div_ceil(2);
        let packets = |tile: &Tile| match control.is_cancelled() {
            true => Err(RenderError::Cancelled),
            false => Ok(self.packets(tile, [width::<S>(), columns], sub)),
        };
        let mut seen: Vec<Vec<EyePacket>> = tiles.all().par_iter().map(packets).collect::<Result<_, _>>()?;
        let end = seen.iter().flatten().map(|packet| packet.slabs().end).max().unwrap_or(0);
        for start in (0..end).step_by(length) {
            let run = start..end.min(start + length);
            light.pass(run.clone(), cancelled)?;
            tiles.all_mut().par_iter_mut().zip(&mut seen).try_for_each(|(tile, packets)| {
                if control.is_cancelled() {
                    return Err(RenderError::Cancelled);
                }
                eye.look(packets, run.clone(), light.buffers(), &mut tile.tally);
                Ok(())
            })?;
            report(run.end as f64 / (end + length) as f64);
        }
        let world_from_index = self.prepared.grid().world_from_index();
        let n = self.prepared.stage.quality.supersampling as f32;
        let rays = 1.0 / (n * n);
        tiles.all_mut().par_iter_mut().zip(&seen).for_each(|(tile, packets)| {
            for packet in packets {
                let (left, top) = (packet.corner[0], packet.corner[1]);
                eye.finish(packet, self.prepared.stage, &world_from_index, |lane, mut found: Found| {
                    // Light of several sweeps adds up; what holds it back is the same in all of them.
                    found.color[3] /= self.lights as f32;
                    tile.hit += u64::from(self.is_first);
                    tile.tally.samples += u64::from(found.samples);
                    tile.add(left + lane % columns, top + lane / columns, rays, &found);
                });
            }
        });
        report(1.0);
        Ok(())
    }

    fn packets(&self, tile: &Tile, [lanes, columns]: [usize; 2], sub: usize) -> Vec<EyePacket> {
        let (place, size) = ([tile.x, tile.y], [tile.width, tile.height]);
        let packet = |(top, left)| {
            EyePacket::new(self.prepared, &self.geometry.slabs, [place, [left, top], size], [lanes, columns], sub)
        };
        tile.corners(columns, lanes / columns).filter_map(packet).collect()
    }

    fn eye<S: Lanes>(&self, s: S) -> Result<Eye<'_, S>, RenderError> {
        let (prepared, settings) = (self.prepared, self.settings);
        let stage = prepared.stage;
        let (material, ambient) = material(stage, prepared.volume, settings, self.lights);
        let lights = std::slice::from_ref(self.light);
        let mut surface = Surface::new(material, None, lights, ambient, prepared.grid().world_from_index());
        if let Some(scatter) = prepared.scatter() {
            surface = surface.scattering(scatter);
        }
        Ok(Eye {
            s,
            field: prepared.any(prepared.sampler()?),
            table: Lookup::of_steps(prepared.step_table()),
            half_transport: self.lengths.half_transport(),
            half: self.lengths.steps * 0.5,
            surface,
            frame: &self.geometry.frame,
            ways: self.geometry.ways,
            correction: settings.correction,
            scales: [settings.direct, settings.indirect],
            skip: prepared.grids.skip.as_ref(),
            varied: prepared.varied(),
            early_termination: stage.quality.early_termination,
        })
    }

    fn matter<S: Lanes>(&self, s: S) -> Result<Matter<'_, S>, RenderError> {
        let prepared = self.prepared;
        Ok(Matter {
            s,
            field: prepared.any(prepared.sampler()?),
            steps: self.lengths.steps,
            table: self.lengths.opacity(),
            transport: self.lengths.transport().filter(|_| self.settings.indirect > 0.0),
            skip: prepared.grids.skip.as_ref(),
            varied: prepared.varied(),
        })
    }
}

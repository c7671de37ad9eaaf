//! Half-angle slicing: light that travels through the volume while it is drawn (Kniss et al. 2003, section
//! 6.3).
//!
//! Slabs lie halfway between the light and the eye (`pellucid_plan::half_angle`), and rays of both cross them in the
//! same order (`crossing`). Light is a picture of the volume as the light sees it (`frame`, `buffer`): slab after slab it
//! loses what the slab holds (`matter`, `advance`) and spreads (`looks`, `blur`), and the eye looks at each slab in the
//! light that has come to it (`eye`). Several lights are several sweeps, each with slabs of its own.
//!
//! A few slabs are a *run*. Their matter is looked up along rays of light, then light passes them one by one,
//! leaving a buffer in front of each, and then the eye looks at them all, pixel by pixel: rays and colours stay
//! at hand, and threads meet once a slab.

mod advance;
mod band;
mod blur;
mod buffer;
mod crossing;
mod eye;
mod frame;
mod lengths;
mod look;
mod looks;
mod matter;
mod optics;
mod pieces;
mod reached;
mod step;
mod sweep;
mod transport;
mod work;

#[cfg(test)]
mod tests;

use glam::DAffine3;
use pellucid_optics::ResolvedLight;
use pellucid_plan::half_angle::{Geometry, LightError, around, into_cone, lights, material};
use pellucid_scene::{Control, HalfAngle, InScatter};
use rayon::prelude::*;

use crate::RenderError;
use crate::classify::{Lookup, Post};
use crate::field::{Any, Field};
use crate::integrator::Found;
use crate::lanes::*;
use crate::light::{Answer, BlinnPhong, Lighting, Lights};
use crate::packet::Packet;
use crate::prepare::Prepared;
use crate::rays::Emitter;
use crate::reconstruct::WithField;
use crate::solid::Solid;
use crate::tiles::{Tile, Tiles};
use crate::vary::Placed;

use eye::Eye;
pub use lengths::Lengths;
use look::{EyeLayers, EyePacket};
pub use matter::Matter;
use optics::SlabOptics;
pub use sweep::Sweep;
pub use work::Seen;

/// Draws a stage into tiles: one volume, or layers in the order in which they are merged.
///
/// # Errors
/// [`RenderError::Light`] if there is no such light or one stands in a volume, [`RenderError::Cancelled`].
pub fn draw(
    layers: &[Prepared],
    settings: &HalfAngle,
    set: InstructionSet,
    control: &Control,
    tiles: &mut Tiles,
) -> Result<(), RenderError> {
    let stage = layers[0].stage;
    let lights = lights(stage, settings)?;
    let subs = stage.quality.supersampling.pow(2) as usize;
    let sweeps = lights.len() * subs;
    let grid = around(stage)?;
    tiles.clear();
    for (place, (number, light)) in lights.iter().enumerate() {
        let geometry = Geometry::new(stage, &grid, settings, light).ok_or(LightError::Inside { light: *number })?;
        let lengths = layers.iter().map(|layer| Lengths::new(layer, geometry.ways));
        let lengths = lengths.collect::<Result<Vec<_>, _>>()?;
        let done = place * subs;
        let drawing = Drawing {
            layers,
            settings,
            geometry: &geometry,
            lengths,
            light,
            lights: lights.len(),
            is_first: done == 0,
        };
        for sub in 0..subs {
            let report = |share: f64| control.report(((done + sub) as f64 + share) / sweeps as f64);
            let samplers = layers.iter().map(Prepared::sampler).collect::<Result<Vec<_>, _>>()?;
            dispatch!(set, s => {
                let sweep = EyeSweep { s, drawing: &drawing, sub, control, report: &report, tiles: &mut *tiles };
                match layers {
                    [prepared] => prepared.with_field(samplers[0].clone(), sweep),
                    _ => {
                        let each = layers.iter().zip(samplers).map(|(layer, sampler)| layer.any(sampler));
                        sweep.through(&each.collect::<Vec<Any<_>>>())
                    }
                }
            })?;
        }
    }
    Ok(())
}

/// One of the lights, and what it shines on.
struct Drawing<'a> {
    layers: &'a [Prepared<'a>],
    settings: &'a HalfAngle,
    geometry: &'a Geometry,
    lengths: Vec<Lengths>,
    light: &'a ResolvedLight,
    /// How many lights there are: each sweep brings its share of what does not depend on them.
    lights: usize,
    is_first: bool,
}

/// A picture in one light by one ray of every pixel, `sub`, once the field is known.
struct EyeSweep<'a, S> {
    s: S,
    drawing: &'a Drawing<'a>,
    sub: usize,
    control: &'a Control<'a>,
    report: &'a (dyn Fn(f64) + 'a),
    tiles: &'a mut Tiles,
}

impl<'f, S: Lanes> WithField<'f, S> for EyeSweep<'_, S> {
    type Output = Result<(), RenderError>;

    fn with<F: Field<S> + 'f>(self, field: F) -> Self::Output {
        self.through(&[field])
    }
}

impl<S: Lanes> EyeSweep<'_, S> {
    /// Draws the picture through the fields of all layers.
    fn through<F: Field<S>>(self, fields: &[F]) -> Result<(), RenderError> {
        let Self { s, drawing, sub, control, report, tiles } = self;
        let Drawing { layers, settings, geometry, .. } = *drawing;
        let stage = layers[0].stage;
        let each = || (0..layers.len()).zip(fields);
        let eyes = each().map(|(number, field)| drawing.eye(s, number, field)).collect();
        let eye =
            EyeLayers { layers: eyes, overlap: stage.overlap, early_termination: stage.quality.early_termination };
        let cancelled = || control.is_cancelled();
        let matter = each().map(|(number, field)| drawing.matter(s, number, field)).collect();
        let mut light = Sweep::new(layers, settings, geometry, matter, Seen::InMatter, cancelled)?;
        let length = light.run_length();
        let emitter = Emitter::of_eye(stage, InstructionSet::of(s));
        let solids: Vec<Solid> = layers.iter().map(Prepared::solid).collect();
        let columns = 1 << width::<S>().ilog2().div_ceil(2);
        let packets = |tile: &Tile| match control.is_cancelled() {
            true => Err(RenderError::Cancelled),
            false => Ok(drawing.packets(s, tile, (&emitter, &solids), columns, sub)),
        };
        let mut seen: Vec<Vec<EyePacket>> = tiles.all().par_iter().map(packets).collect::<Result<_, _>>()?;
        let mut end = seen.iter().flatten().map(|packet| packet.slabs().end).max().unwrap_or(0);
        let mut start = 0;
        while start < end {
            let run = start..end.min(start + length);
            light.pass(run.clone(), cancelled)?;
            let look = |(tile, packets): (&mut Tile, &mut Vec<EyePacket>)| match control.is_cancelled() {
                true => Err(RenderError::Cancelled),
                false => Ok(eye.look(packets, run.clone(), light.buffers(), &mut tile.tally)),
            };
            let ends = tiles.all_mut().par_iter_mut().zip(&mut seen).map(look);
            // Where nothing is left to be seen, no light is needed.
            end = ends.try_reduce(|| 0, |a, b| Ok(a.max(b)))?;
            start = run.end;
            report(start as f64 / (end.max(start) + length) as f64);
        }
        let worlds: Vec<DAffine3> = layers.iter().map(|layer| layer.grid().world_from_index()).collect();
        let n = stage.quality.supersampling as f32;
        let rays = 1.0 / (n * n);
        tiles.all_mut().par_iter_mut().zip(&seen).for_each(|(tile, packets)| {
            for packet in packets {
                let (left, top) = (packet.corner[0], packet.corner[1]);
                eye.finish(packet, stage, &worlds, |lane, mut found: Found| {
                    // Light of several sweeps adds up; what holds it back is the same in all of them.
                    let lights = drawing.lights as f32;
                    found.color[3] /= lights;
                    found.opacities = found.opacities.map(|opacity| opacity / lights);
                    tile.hit += u64::from(drawing.is_first);
                    tile.tally.samples += u64::from(found.samples);
                    tile.add(left + lane % columns, top + lane / columns, rays, &found);
                });
            }
        });
        report(1.0);
        Ok(())
    }
}

impl Drawing<'_> {
    /// The rays through a tile that meet any field, `columns` side by side.
    fn packets<S: Lanes>(
        &self,
        s: S,
        tile: &Tile,
        (emitter, solids): (&Emitter, &[Solid]),
        columns: usize,
        sub: usize,
    ) -> Vec<EyePacket> {
        let (layers, slabs, lanes) = (self.layers, &self.geometry.slabs, width::<S>());
        let n = layers[0].stage.quality.supersampling as usize;
        let mut packets: Vec<EyePacket> = Vec::with_capacity((tile.width * tile.height).div_ceil(lanes));
        let mut rays = vec![Packet::NOTHING; layers.len()];
        for (top, left) in tile.corners(columns, lanes / columns) {
            let corner = [left, top];
            rays.fill(Packet::NOTHING);
            if emitter.emit_pixels(tile, corner, [lanes, columns], (sub, n), (solids, &mut *rays)) > 0 {
                packets.extend(EyePacket::new(s, &rays, slabs, layers, corner));
            }
        }
        packets
    }

    fn eye<'f, S: Lanes, F: Field<S>>(&'f self, s: S, number: usize, field: &'f F) -> Eye<'f, S, F> {
        let (prepared, lengths, settings) = (&self.layers[number], &self.lengths[number], self.settings);
        let stage = prepared.stage;
        let (material, ambient) = material(stage, prepared.volume, settings, self.lights);
        let lights = std::slice::from_ref(self.light);
        let lighting = Lighting {
            lights: Lights::new(lights, prepared.grid().world_from_index()),
            shadow: None,
            chroma: None,
            answer: Answer::new(BlinnPhong { material, weight: None, ambient }, prepared.scatter()),
        };
        let optics = SlabOptics {
            classifier: Post(Lookup::of_steps(prepared.step_table())),
            transport: lengths.half_transport().filter(|_| settings.indirect > 0.0),
            placed: Placed { paint: prepared.paint(), varied: prepared.varied() },
        };
        Eye {
            medium: prepared.one_grid(s, field, optics, Some(lighting)),
            half: lengths.steps * 0.5,
            frame: self.geometry.frame.on(prepared.grid()),
            ways: self.geometry.ways,
            correction: settings.correction,
            into_cone: (settings.in_scatter != InScatter::Indirect).then(|| into_cone(stage, settings)),
            scales: [settings.direct, settings.indirect],
        }
    }

    fn matter<'f, S: Lanes, F: Field<S>>(&'f self, s: S, number: usize, field: &'f F) -> Matter<'f, S, F> {
        Matter::new(s, &self.layers[number], &self.lengths[number], field, self.settings)
    }
}

//! Light on its way through all slabs.

use std::ops::Range;

use pellucid_field::Grid;
use pellucid_plan::half_angle::{Geometry, into_cone, taps};
use pellucid_scene::{HalfAngle, InScatter, Overlap};
use rayon::prelude::*;

use super::band::{BAND, Band, TILE, run_length};
use super::buffer::{LightBuffer, MOST_CHANNELS, Shape};
use super::looks::{Looks, Reach};
use super::matter::{Matter, look_up};
use super::step::Step;
use super::work::{Seen, around, needed};
use crate::RenderError;
use crate::field::Field;
use crate::lanes::*;
use crate::prepare::Prepared;
use crate::rays::Emitter;
use crate::solid::Solid;

/// Light that passes slab after slab.
pub struct Sweep<'a, S, F> {
    settings: &'a HalfAngle,
    /// What slabs hold, layer by layer.
    layers: Vec<Matter<'a, S, F>>,
    /// What lies where they overlap.
    overlap: Overlap,
    /// The rows of the picture.
    bands: Vec<Band>,
    /// In front of every slab of a run, and behind the last.
    buffers: Vec<LightBuffer>,
    /// Slabs of the run that was passed last.
    passed: usize,
    /// Where something is, if light comes from there alone.
    presence: Option<Presence>,
    /// Tiles that differ from light as it entered, band by band.
    touched: Vec<bool>,
    /// The slabs up to which the light of tiles matters to anything.
    needed: Vec<usize>,
    blur: Reach,
    /// Tiles that a blur reaches over in a slab.
    reach: usize,
    phase: [f32; 3],
}

impl<'a, S: Lanes, F: Field<S>> Sweep<'a, S, F> {
    /// Light in front of the first slab, and where it will be looked at.
    ///
    /// # Errors
    /// [`RenderError::Cancelled`], as `cancelled` says.
    pub fn new(
        prepared: &[Prepared],
        settings: &'a HalfAngle,
        geometry: &'a Geometry,
        layers: Vec<Matter<'a, S, F>>,
        seen: Seen,
        cancelled: impl Fn() -> bool + Sync,
    ) -> Result<Self, RenderError> {
        let stop = || if cancelled() { Err(RenderError::Cancelled) } else { Ok(()) };
        let Geometry { grid, frame, slabs, longest, .. } = geometry;
        let (s, step, voxel) = (layers[0].medium.s, prepared[0].stage.step, grid.smallest_spacing());
        let indirect = (settings.indirect > 0.0).then_some(settings.initial_indirect);
        let across = frame.finest(grid);
        let farthest = if indirect.is_some() { taps::radius(settings, *longest, voxel) * across } else { 0.0 };
        let pad = farthest.ceil() as usize + 2;
        let shape = Shape::new(frame.size, pad);
        let tiles = shape.width.div_ceil(TILE);
        let run = run_length([shape.width, shape.height]);
        // Of what all light loses alike there is one opacity a texel.
        let apart = indirect.is_some() && layers.iter().any(Matter::tells_colors_apart);
        let channels = if apart { MOST_CHANNELS } else { 1 };
        let emitter = Emitter::of_light(frame, step, InstructionSet::of(s));
        let grids: Vec<Grid> = prepared.iter().map(|layer| *layer.grid()).collect();
        let solids: Vec<Solid> = prepared.iter().map(Prepared::solid).collect();
        let rows = |top: usize| BAND.min(shape.height - top);
        let bands: Vec<Band> = (0..shape.height.div_ceil(BAND))
            .into_par_iter()
            .map(|band| {
                stop()?;
                let place = [band * BAND, rows(band * BAND), shape.width];
                Ok(Band::new(s, (&grids, &solids, step), (&emitter, slabs), place, [run, channels]))
            })
            .collect::<Result<_, RenderError>>()?;
        let gated = matches!(settings.in_scatter, InScatter::DirectFromMatter | InScatter::BothFromMatter);
        let reach = pad.div_ceil(BAND.min(TILE));
        let needed = match seen {
            Seen::InMatter => {
                let each = prepared.iter().map(|layer| needed(layer, geometry, [tiles, bands.len()], farthest));
                let later = |a: Vec<usize>, b: Vec<usize>| a.into_iter().zip(b).map(|(a, b)| a.max(b)).collect();
                each.reduce(later).unwrap_or_default()
            }
            Seen::Everywhere => vec![slabs.count; tiles * bands.len()],
        };
        let buffers = (0..=run).map(|_| stop().map(|()| LightBuffer::new(shape, indirect)));
        Ok(Self {
            settings,
            passed: 0,
            buffers: buffers.collect::<Result<_, _>>()?,
            layers,
            overlap: prepared[0].stage.overlap,
            presence: (gated && indirect.is_some()).then(|| Presence::new(&shape, tiles * bands.len())),
            touched: vec![false; tiles * bands.len()],
            bands,
            needed,
            blur: indirect.map_or(Reach::Even([0.0; 2]), |_| Reach::new(settings, geometry, voxel, &shape)),
            reach,
            phase: into_cone(prepared[0].stage, settings),
        })
    }

    /// How many slabs it passes at once.
    pub fn run_length(&self) -> usize {
        self.buffers.len() - 1
    }

    /// Light in front of every slab of the run that was passed last, and behind it.
    pub fn buffers(&self) -> &[LightBuffer] {
        &self.buffers[..=self.passed]
    }

    /// Leaves of the light in front of the first slab a round beam in the middle of the picture, of a radius in
    /// texels.
    #[cfg(test)]
    pub fn shine(&mut self, radius: f32) {
        for LightBuffer { shape, fresh, lost } in &mut self.buffers {
            lost.chunks_exact_mut(fresh.len()).for_each(|texel| texel.copy_from_slice(fresh));
            let Shape { width, height, .. } = *shape;
            for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
                let [dx, dy] = [(x, width), (y, height)].map(|(at, n)| at as f32 + 0.5 - n as f32 / 2.0);
                if dx.hypot(dy) <= radius {
                    lost[shape.at(x, y) * fresh.len()..][..fresh.len()].fill(0.0);
                }
            }
        }
        self.touched.fill(true);
    }

    /// Passes a run of slabs, of at most [`run_length`](Self::run_length).
    ///
    /// # Errors
    /// [`RenderError::Cancelled`], as `cancelled` says.
    pub fn pass(&mut self, run: Range<usize>, cancelled: impl Fn() -> bool + Sync) -> Result<(), RenderError> {
        let stop = || if cancelled() { Err(RenderError::Cancelled) } else { Ok(()) };
        // What is behind the last run is in front of this one.
        self.buffers.swap(0, self.passed);
        self.passed = run.len();
        let Self { layers, overlap, bands, .. } = self;
        bands.par_iter_mut().try_for_each(|band| {
            stop()?;
            look_up(layers, *overlap, band, run.clone());
            Ok::<_, RenderError>(())
        })?;
        for slab in run.clone() {
            self.pass_slab(slab, slab - run.start, &cancelled);
        }
        stop()
    }

    fn pass_slab(&mut self, slab: usize, number: usize, cancelled: &(impl Fn() -> bool + Sync)) {
        let Self { settings, layers, bands, buffers, presence, touched, needed, reach, .. } = self;
        let offsets = taps::offsets(settings, slab);
        if let Some(presence) = presence {
            presence.mark(bands, &buffers[number].shape, number);
        }
        let step = Step {
            s: layers[0].medium.s,
            number,
            looks: Looks::new(&offsets, self.blur.in_slab(slab), presence.is_some(), &buffers[number].shape),
            chroma: layers[0].medium.chroma,
            in_scatter: settings.in_scatter,
            phase: self.phase,
            presence: presence.as_ref().map(|presence| presence.texels.as_slice()),
        };
        let [light, next] = &mut buffers[number..number + 2] else { return };
        let shape = light.shape;
        let tiles = shape.width.div_ceil(TILE);
        // Where all light comes from matter, what is empty is dark.
        let everywhere = settings.in_scatter == InScatter::BothFromMatter;
        let near = around(touched, tiles, *reach);
        let found: Vec<Vec<bool>> = bands_of(&mut next.lost, &shape, light.channels())
            .enumerate()
            .map(|(band, rows)| {
                let pass = |tile: usize| {
                    let before = touched[band * tiles + tile];
                    let asked = !cancelled()
                        && slab <= needed[band * tiles + tile]
                        && (everywhere || bands[band].holds(number, tile) || near[band * tiles + tile]);
                    (asked && step.pass(light, rows, &bands[band], [band * BAND, tile])) || before
                };
                (0..tiles).map(pass).collect()
            })
            .collect();
        *touched = found.concat();
    }
}

/// The rows of bands in a buffer of so many numbers per texel, with the padding beside them.
fn bands_of<'a>(
    buffer: &'a mut [f32],
    shape: &Shape,
    channels: usize,
) -> impl IndexedParallelIterator<Item = &'a mut [f32]> {
    let Shape { height, pad, stride, .. } = shape;
    buffer[pad * stride * channels..(pad + height) * stride * channels].par_chunks_mut(BAND * stride * channels)
}

/// Where a slab holds something.
struct Presence {
    /// 1 where something is, else 0, in every channel of a texel; outside of the picture there is nothing.
    texels: Vec<f32>,
    /// Tiles in which something is, band by band.
    tiles: Vec<bool>,
}

impl Presence {
    /// Nothing is anywhere.
    fn new(shape: &Shape, tiles: usize) -> Self {
        Self { texels: vec![0.0; shape.len() * MOST_CHANNELS], tiles: vec![false; tiles] }
    }

    /// Marks what a slab holds, by its number in the run.
    fn mark(&mut self, bands: &[Band], shape: &Shape, number: usize) {
        let Self { texels, tiles } = self;
        let marks = tiles.par_chunks_mut(shape.width.div_ceil(TILE)).zip(bands);
        bands_of(texels, shape, MOST_CHANNELS).zip(marks).for_each(|(rows, (marks, band))| {
            for (tile, mark) in marks.iter_mut().enumerate() {
                let was_marked = std::mem::replace(mark, band.holds(number, tile));
                if !*mark && !was_marked {
                    continue;
                }
                let columns = tile * TILE..shape.width.min((tile + 1) * TILE);
                let first = (shape.pad + columns.start) * MOST_CHANNELS;
                for (row, texels) in rows.chunks_exact_mut(shape.stride * MOST_CHANNELS).enumerate() {
                    let opacities = band.opacities(number, row, &columns).chunks_exact(band.channels);
                    for (texel, opacity) in texels[first..].chunks_exact_mut(MOST_CHANNELS).zip(opacities) {
                        texel.fill(if opacity[0] > 0.0 { 1.0 } else { 0.0 });
                    }
                }
            }
        });
    }
}

//! From a stage to a frame.

use std::slice;
use std::sync::atomic::AtomicU64;
use std::time::Instant;

use pellucid_field::{Threads, Volume, memory, parallel};
use pellucid_plan::cautions;
use pellucid_scene::{Control, Frame, FrameStatistics, RenderWarning, Stage, Technique, denoise};

use crate::RenderError;
use crate::half_angle;
use crate::illumination::{Baked, Globally, IlluminationCache};
use crate::integrator::{Integrator, Traced};
use crate::lanes::InstructionSet;
use crate::layers::Layers;
use crate::packet::Packet;
use crate::path_trace::PathTracer;
use crate::prepare::{Cache, Prepared};
use crate::rays::Emitter;
use crate::shadow::LightCache;
use crate::solid::Solid;
use crate::tiles::{TILE, Tile, Tiles};

/// The CPU backend. Keep one for several frames: what depends on the data alone (blocks, filter
/// coefficients) is made once, and memory is used again.
#[derive(Default)]
pub struct CpuRenderer {
    /// The ones that all parallel work has, if none are said.
    threads: Option<Threads>,
    instructions: InstructionSet,
    tile: Option<usize>,
    cache: Cache,
    lights: LightCache,
    illumination: IlluminationCache,
    tiles: Tiles,
}

impl CpuRenderer {
    /// The most threads of a renderer of its own.
    pub const MOST_THREADS: usize = Threads::MOST;

    /// A renderer on the threads of [`parallel`], all cores if nothing else is said, with the best
    /// instructions of the machine.
    pub fn new() -> Self {
        Self::default()
    }

    /// A renderer on its own threads, 1 to [`CpuRenderer::MOST_THREADS`]. The picture does not
    /// depend on their number.
    ///
    /// # Errors
    /// [`RenderError::Threads`] if there are too many or the system refuses them.
    pub fn with_threads(threads: usize) -> Result<Self, RenderError> {
        Ok(Self::default().on_threads(Threads::new(threads)?))
    }

    /// The same renderer on other threads.
    pub fn on_threads(self, threads: Threads) -> Self {
        Self { threads: Some(threads), ..self }
    }

    /// Whether this backend has the technique that a stage asks for.
    pub fn draws(stage: &Stage) -> bool {
        !stage.technique.needs().blending && Self::merges(stage)
    }

    /// Whether the technique draws as many volumes as a stage has.
    fn merges(stage: &Stage) -> bool {
        !stage.has_layers() || stage.technique.needs().several_volumes
    }

    /// The same renderer with tiles of another side, in pixels (at least 1). The picture does not
    /// depend on it.
    pub fn with_tile_size(mut self, side: usize) -> Self {
        self.tile = Some(side.max(1));
        self
    }

    /// The same renderer with other instructions. The picture depends on them by roundings only.
    ///
    /// # Errors
    /// [`RenderError::Instructions`] if the machine lacks them.
    pub fn with_instructions(mut self, set: InstructionSet) -> Result<Self, RenderError> {
        self.instructions = set.resolve().ok_or(RenderError::Instructions { set })?;
        Ok(self)
    }

    /// The instructions that are used; never [`InstructionSet::Auto`].
    pub fn instructions(&self) -> InstructionSet {
        self.instructions.resolve().unwrap_or(InstructionSet::Baseline)
    }

    /// Draws a frame.
    ///
    /// # Errors
    /// [`RenderError`]; nothing of an unfinished frame is returned.
    pub fn render(&mut self, stage: &Stage, control: &Control) -> Result<Frame, RenderError> {
        let mut frame = Frame::default();
        self.render_into(stage, control, &mut frame)?;
        Ok(frame)
    }

    /// Finds light at all places of the lattice around the isosurfaces of a stage, on those sides of them that its picture
    /// sees, and keeps it for pictures: of `surfaces = "drawn"` at the places beside these, of `"own"` at all. Where a
    /// stage asks for none, these are no places.
    ///
    /// # Errors
    /// [`RenderError`]; what was found until then is kept.
    pub fn bake(&mut self, stage: &Stage, control: &Control) -> Result<Baked, RenderError> {
        self.render(stage, &Control { progress: None, ..*control })?;
        let Some(settings) = stage.global_illumination() else { return Ok(Baked::default()) };
        let set = self.instructions();
        let Self { threads, cache, illumination, .. } = self;
        let work = || {
            let prepared = Prepared::new(stage, 0, cache)?;
            let (kept, distant) = (illumination.kept(&prepared, settings)?, illumination.distant(stage, settings));
            let global =
                Globally { settings, kept: &kept, distant: distant.as_ref(), control, waiting: &AtomicU64::new(0) };
            let baked = prepared.bake(set, global)?.bake();
            if control.is_cancelled() { Err(RenderError::Cancelled) } else { Ok(baked) }
        };
        match threads {
            Some(threads) => threads.run(work),
            None => parallel(work),
        }
    }

    /// What is kept of the light of the last stage's isosurfaces, as a volume, for a file or for
    /// [`GlobalIllumination::baked`](pellucid_scene::GlobalIllumination::baked) of a scene of the same data and settings; `None`
    /// if nothing is. Its description says what it is the light of.
    ///
    /// A voxel is a place of the lattice: red, green and blue of the light that its paths have found there, all together, and how
    /// many paths these are, so that their quotient is as bright as a white surface looks there; or 0 where no surface is near,
    /// or -1 where nothing is known. Sides of surfaces, which the description lists, lie one
    /// behind the other along z, and so do further numbers of places that keep light in spherical harmonics.
    ///
    /// # Errors
    /// [`RenderError::SavedLight`] if there is no memory for it, [`RenderError::Field`] if places are closer to each other than
    /// voxels can be.
    pub fn baked_light(&self) -> Result<Option<Volume>, RenderError> {
        let work = || self.illumination.save();
        match &self.threads {
            Some(threads) => threads.run(work),
            None => parallel(work),
        }
    }

    /// Draws a frame into one that is there; the memory of its pictures is used again if they have
    /// the right size.
    ///
    /// # Errors
    /// [`RenderError`]; the frame is then what it was before.
    pub fn render_into(&mut self, stage: &Stage, control: &Control, frame: &mut Frame) -> Result<(), RenderError> {
        let set = self.instructions();
        let [width, height] = [stage.viewpoint.width, stage.viewpoint.height];
        if (frame.width, frame.height) != (width, height) {
            // There is one more of them, in tiles.
            memory::afford(width.saturating_mul(height).saturating_mul(2 * Frame::PIXEL_BYTES))?;
        }
        let Self { threads, tile, cache, lights, illumination, tiles, .. } = self;
        tiles.cover(width, height, tile.unwrap_or(TILE), stage.holds_back_each_color());
        let work = || render(stage, control, set, (cache, lights, illumination), tiles, frame);
        match threads {
            Some(threads) => threads.run(work),
            None => parallel(work),
        }
    }
}

fn render(
    stage: &Stage,
    control: &Control,
    set: InstructionSet,
    (cache, lights, illumination): (&mut Cache, &mut LightCache, &mut IlluminationCache),
    tiles: &mut Tiles,
    frame: &mut Frame,
) -> Result<(), RenderError> {
    if stage.volumes.is_empty() || !CpuRenderer::merges(stage) {
        return Err(RenderError::Volumes { found: stage.volumes.len(), technique: stage.technique.name() });
    }
    let (started, waiting) = (Instant::now(), AtomicU64::new(0));
    let drawing;
    match &stage.technique {
        Technique::RayCast(_) if stage.has_layers() => {
            let layers = Layers::new(stage, cache)?;
            let lights = lights.lights(layers.each(), set, control)?;
            let integrator = layers.integrator(set, lights.as_ref().map(|lights| lights.as_slice()))?;
            let rays = (Emitter::of_eye(stage, set), &*layers.each().iter().map(Prepared::solid).collect::<Vec<_>>());
            drawing = Instant::now();
            tiles.draw(control, |tile| draw_tile(stage, &rays, integrator.as_ref(), control, tile))?;
        }
        Technique::RayCast(_) => {
            let prepared = Prepared::new(stage, 0, cache)?;
            let lights = lights.lights(slice::from_ref(&prepared), set, control)?;
            let global = stage.global_illumination();
            let kept = global.map(|global| {
                let kept = illumination.kept(&prepared, global)?;
                Ok::<_, RenderError>((kept, illumination.distant(stage, global)))
            });
            let kept = kept.transpose()?;
            let global = global.zip(kept.as_ref()).map(|(settings, (kept, distant))| Globally {
                settings,
                kept,
                distant: distant.as_ref(),
                control,
                waiting: &waiting,
            });
            let lights = lights.as_ref().map(|lights| lights.as_slice());
            let integrator = prepared.integrator(set, lights, global)?;
            let rays = (Emitter::of_eye(stage, set), &[prepared.solid()][..]);
            drawing = Instant::now();
            tiles.draw(control, |tile| draw_tile(stage, &rays, integrator.as_ref(), control, tile))?;
        }
        Technique::HalfAngle(settings) => {
            let layers = Layers::new(stage, cache)?;
            drawing = Instant::now();
            half_angle::draw(layers.each(), settings, set, control, tiles)?;
        }
        Technique::PathTrace(settings) => {
            let tracer = PathTracer::new(stage, settings, &mut cache.plan)?;
            let drawer = tracer.drawer()?;
            drawing = Instant::now();
            tiles.draw(control, |tile| drawer.draw(tile, control))?;
        }
        _ => return Err(RenderError::Technique { technique: stage.technique.name() }),
    }
    let view = &stage.viewpoint;
    if let Some(settings) = stage.path_trace().filter(|settings| settings.denoise) {
        let mut whole = Frame::new(view.width, view.height);
        tiles.assemble(&mut whole);
        denoise(&mut whole, settings.samples, control).map_err(|_| RenderError::Cancelled)?;
        *frame = whole;
    } else {
        if (frame.width, frame.height) != (view.width, view.height) {
            *frame = Frame::new(view.width, view.height);
        }
        tiles.assemble(frame);
    }
    let (tally, rays_hit) = tiles.total();
    let rays = match stage.technique {
        Technique::PathTrace(_) => tally.paths,
        _ => (view.width * view.height) as u64 * u64::from(stage.quality.supersampling).pow(2),
    };
    frame.statistics = FrameStatistics {
        rays,
        rays_hit,
        rays_terminated: tally.terminated,
        samples: tally.samples,
        samples_visible: tally.visible,
        samples_skipped: tally.skipped,
        light: tally.light,
        waiting: waiting.into_inner(),
        setup_seconds: (drawing - started).as_secs_f64(),
        render_seconds: drawing.elapsed().as_secs_f64(),
        device_seconds: None,
    };
    frame.warnings.clear();
    frame.warnings.extend(stage.fallbacks());
    frame.warnings.extend(cautions(stage, usize::MAX));
    frame.warnings.extend(RenderWarning::clamped(&frame.statistics));
    frame.backdrop = stage.backdrop();
    if tally.visible == 0 || stage.is_too_faint(frame) {
        frame.warnings.push(RenderWarning::empty(stage, rays_hit));
    }
    Ok(())
}

/// Packets per side of a wave: those that are followed in turns.
const WAVE: usize = 4;

fn draw_tile(
    stage: &Stage,
    (emitter, solids): &(Emitter, &[Solid]),
    integrator: &dyn Integrator,
    control: &Control,
    tile: &mut Tile,
) -> Result<(), RenderError> {
    let lanes = integrator.width();
    // As square as can be: rays close to each other read the same voxels.
    let columns = 1 << lanes.ilog2().div_ceil(2);
    let rows = lanes / columns;
    let n = stage.quality.supersampling as usize;
    let weight = 1.0 / (n * n) as f32;
    let mut packets = vec![Packet::NOTHING; solids.len()];
    let (mut wave, mut traced, mut corners) = (Vec::new(), Vec::new(), Vec::new());
    for (wave_top, wave_left) in tile.corners(columns * WAVE, rows * WAVE) {
        for sub in 0..n * n {
            if control.is_cancelled() {
                return Err(RenderError::Cancelled);
            }
            wave.clear();
            traced.clear();
            corners.clear();
            for number in 0..WAVE * WAVE {
                let (left, top) = (wave_left + number % WAVE * columns, wave_top + number / WAVE * rows);
                packets.fill(Packet::NOTHING);
                let (pixels, met) = ([lanes, columns], (*solids, &mut *packets));
                let hit = emitter.emit_pixels(tile, [left, top], pixels, (sub, n), met);
                if hit > 0 {
                    tile.hit += hit;
                    if packets.len() > 1 {
                        wave.push(emitter.around(&packets));
                    }
                    wave.extend_from_slice(&packets);
                    traced.push(Traced::NOTHING);
                    corners.push((left, top));
                }
            }
            integrator.trace(&wave, &mut traced, &mut tile.tally);
            // The first of a group of packets is that of all layers.
            let group = wave.len() / traced.len().max(1);
            for ((packet, traced), &(left, top)) in wave.iter().step_by(group.max(1)).zip(&traced).zip(&corners) {
                for lane in (0..lanes).filter(|&lane| packet.count[lane] > 0.0) {
                    let found = traced.ray(lane, packet, stage.step);
                    tile.add(left + lane % columns, top + lane / columns, weight, &found);
                }
            }
        }
    }
    Ok(())
}

//! From a stage to a frame.

use std::time::Instant;

use pellucid_field::{ComponentView, Filter, Linear, Reconstruct, for_voxels, with_reconstruction};
use pellucid_scene::{Control, Frame, Jitter, RenderWarning, Stage, blue_noise};

use crate::RenderError;
use crate::integrator::{Integrator, Tally, Traced};
use crate::lattice::Lattice;
use crate::prepare::{Cache, Prepared};
use crate::span::Span;
use crate::tiles::{TILE, Tile, draw, tiles};

/// The CPU backend. Keep one for several frames: what depends on the data alone (blocks, filter
/// coefficients) is made once.
#[derive(Default)]
pub struct CpuRenderer {
    pool: Option<rayon::ThreadPool>,
    tile: Option<usize>,
    cache: Cache,
}

impl CpuRenderer {
    /// The most threads of a renderer of its own. Systems hang rather than refuse far beyond.
    pub const MOST_THREADS: usize = 1024;

    /// A renderer on all cores.
    pub fn new() -> Self {
        Self::default()
    }

    /// A renderer on its own threads, 1 to [`CpuRenderer::MOST_THREADS`]. The picture does not
    /// depend on their number.
    ///
    /// # Errors
    /// [`RenderError::Threads`] if there are too many or the system refuses them.
    pub fn with_threads(threads: usize) -> Result<Self, RenderError> {
        if !(1..=Self::MOST_THREADS).contains(&threads) {
            let reason = format!("1 to {} are possible", Self::MOST_THREADS);
            return Err(RenderError::Threads { threads, reason });
        }
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .map_err(|error| RenderError::Threads { threads, reason: error.to_string() })?;
        Ok(Self { pool: Some(pool), ..Self::default() })
    }

    /// The same renderer with tiles of another side, in pixels (at least 1). The picture does not
    /// depend on it.
    pub fn with_tile_size(mut self, side: usize) -> Self {
        self.tile = Some(side.max(1));
        self
    }

    /// Draws a frame.
    ///
    /// # Errors
    /// [`RenderError`]; nothing of an unfinished frame is returned.
    pub fn render(&mut self, stage: &Stage, control: &Control) -> Result<Frame, RenderError> {
        let Self { pool, tile, cache } = self;
        let side = tile.unwrap_or(TILE);
        match pool {
            Some(pool) => pool.install(|| render(stage, control, side, cache)),
            None => render(stage, control, side, cache),
        }
    }
}

fn render(stage: &Stage, control: &Control, side: usize, cache: &mut Cache) -> Result<Frame, RenderError> {
    let [volume] = stage.volumes.as_slice() else {
        return Err(RenderError::Volumes { found: stage.volumes.len() });
    };
    let started = Instant::now();
    let prepared = Prepared::new(stage, volume, cache)?;
    let sampler = prepared.sampler()?;
    // Trilinear interpolation of every voxel type is compiled into the loops of every mode. Other
    // filters cost so much per sample that a virtual call each does not show.
    let (mut frame, drawing) = match sampler.filter() {
        Filter::Linear => for_voxels!(sampler.source().voxels(), data => {
            let view = ComponentView::new(sampler.source(), data, sampler.component());
            cast(stage, &prepared, Linear(view), control, side)?
        }),
        _ => with_reconstruction!(&sampler, field => {
            cast(stage, &prepared, &field as &dyn Reconstruct, control, side)?
        }),
    };
    frame.statistics.setup_seconds = (drawing - started).as_secs_f64();
    frame.statistics.render_seconds = drawing.elapsed().as_secs_f64();
    if frame.statistics.samples_visible == 0 {
        frame.warnings.push(RenderWarning::Empty { reason: why_empty(&frame) });
    }
    Ok(frame)
}

fn why_empty(frame: &Frame) -> String {
    if frame.statistics.rays_hit == 0 {
        "no ray meets the volume; look at the camera and the clips".to_owned()
    } else {
        "the rays meet the volume but no sample has opacity; look at the transfer function and the window".to_owned()
    }
}

/// One tile's pixels, row by row, and its counts.
struct Drawn {
    pixels: Vec<(Traced, u32)>,
    tally: Tally,
    hit: u64,
}

fn cast<R: Reconstruct>(
    stage: &Stage,
    prepared: &Prepared,
    field: R,
    control: &Control,
    side: usize,
) -> Result<(Frame, Instant), RenderError> {
    let integrator = prepared.integrator(field);
    let drawing = Instant::now();
    Ok((cast_rays(stage, prepared, integrator.as_ref(), control, side)?, drawing))
}

fn cast_rays(
    stage: &Stage,
    prepared: &Prepared,
    integrator: &dyn Integrator,
    control: &Control,
    side: usize,
) -> Result<Frame, RenderError> {
    let view = &stage.viewpoint;
    let all = tiles(view.width, view.height, side);
    let drawn = draw(&all, control, |tile| draw_tile(stage, prepared, integrator, control, tile))?;
    let mut frame = Frame::new(view.width, view.height);
    let mut tally = Tally::default();
    for (tile, drawn) in all.iter().zip(drawn) {
        for ((x, y), (traced, samples)) in tile.pixels().zip(drawn.pixels) {
            let pixel = y * view.width + x;
            frame.color[pixel] = traced.color;
            frame.depth[pixel] = traced.depth as f32;
            frame.normal[pixel] = traced.normal.as_vec3().to_array();
            frame.samples[pixel] = samples;
        }
        tally.add(&drawn.tally);
        frame.statistics.rays_hit += drawn.hit;
    }
    let per_pixel = u64::from(stage.quality.supersampling).pow(2);
    frame.statistics.rays = (view.width * view.height) as u64 * per_pixel;
    frame.statistics.rays_terminated = tally.terminated;
    frame.statistics.samples = tally.samples;
    frame.statistics.samples_visible = tally.visible;
    frame.statistics.samples_skipped = tally.skipped;
    Ok(frame)
}

fn draw_tile(
    stage: &Stage,
    prepared: &Prepared,
    integrator: &dyn Integrator,
    control: &Control,
    tile: Tile,
) -> Result<Drawn, RenderError> {
    let n = stage.quality.supersampling as usize;
    let weight = 1.0 / (n * n) as f32;
    let mut drawn = Drawn { pixels: Vec::with_capacity(tile.width * tile.height), tally: Tally::default(), hit: 0 };
    for (x, y) in tile.pixels() {
        let before = drawn.tally.samples;
        let mut pixel = Traced::NOTHING;
        for sub in 0..n * n {
            if control.is_cancelled() {
                return Err(RenderError::Cancelled);
            }
            let inside = |cell: usize| (cell as f64 + 0.5) / n as f64;
            let ray = stage.viewpoint.ray(x as f64 + inside(sub % n), y as f64 + inside(sub / n));
            let Some(span) = Span::new(&ray, prepared.grid(), &prepared.region) else { continue };
            drawn.hit += 1;
            let lattice = Lattice::new(&span, stage.step, jitter(stage, x, y, sub));
            let traced = integrator.trace(&span, &lattice, &mut drawn.tally);
            for channel in 0..4 {
                pixel.color[channel] += traced.color[channel] * weight;
            }
            if traced.depth < pixel.depth {
                pixel.depth = traced.depth;
                pixel.normal = traced.normal;
            }
        }
        drawn.pixels.push((pixel, (drawn.tally.samples - before) as u32));
    }
    Ok(drawn)
}

/// Where in its first step a ray starts, `[0, 1)`. The rays of one pixel differ by the golden
/// ratio, which spreads any number of them evenly.
fn jitter(stage: &Stage, x: usize, y: usize, sub: usize) -> f64 {
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    match stage.quality.jitter {
        Jitter::Centered => 0.5,
        Jitter::BlueNoise { seed } => (blue_noise(x, y, seed) + sub as f64 * GOLDEN).fract(),
    }
}

//! Pictures that come soon and get better.

mod light;
mod mean;
mod passes;
mod preview;
mod rays;

use std::time::{Duration, Instant};

use pellucid_field::parallel;
use pellucid_optics::Lighting;
use pellucid_scene::{Control, Frame, ResolveError, Stage, Viewpoint};

use crate::{RenderError, Renderer};
use light::Light;
pub use passes::Passes;
use preview::Pace;
use rays::Rays;

/// Draws a stage again and again, each time better: a preview of low resolution that comes within
/// some milliseconds, then the full picture, then the mean of ever more frames whose rays and samples
/// lie elsewhere, which smooths edges and the grain of large steps.
///
/// Where surfaces are lit by all light that arrives, full pictures come every quarter of a second, each of more of their light,
/// until all of it is known; only then frames are averaged. Without previews the first picture waits for all of it.
///
/// [`Progressive::step`] draws the next picture and [`Progressive::frame`] is the last one finished,
/// whatever happens. A new stage or view starts again with the preview. Memory is kept from picture
/// to picture.
///
/// For a window, one thread owns this and steps; the thread of events raises the [`Cancel`] of the
/// step when the camera moves, which ends the step at once:
///
/// ```
/// use pellucid::scene::{Cancel, Control, SampleSource, Scene, Source};
/// use pellucid::{Backend, Picture, Progressive, RenderError, Renderer, load};
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// # let ball = SampleSource { name: "ball".into(), dims: Some([32; 3]), voxel_type: None };
/// # let mut scene = Scene::of(Source::Sample(ball));
/// # (scene.image.width, scene.image.height) = (64, 48);
/// # let (volumes, _) = load(&scene, "")?;
/// let (stage, _) = scene.resolve(&volumes)?;
/// let view = stage.viewpoint;
/// let mut progressive = Progressive::new(Renderer::new(Backend::Auto)?, stage).with_frames(4);
///
/// let cancel = Cancel::default(); // A clone of it belongs to the thread of events.
/// let control = Control { cancel: Some(&cancel), ..Control::default() };
/// loop {
///     match progressive.step(&control) {
///         Ok(step) => {
///             let pixels = progressive.frame().to_rgba8(&scene.image); // Show them.
///             assert_eq!(pixels.len(), 64 * 48 * 4);
///             if !step.more {
///                 assert_eq!(step.picture, Picture::Full { frames: 4 });
///                 break; // Sleep until the camera moves.
///             }
///         }
///         Err(RenderError::Cancelled) => break, // Take the new camera.
///         Err(error) => return Err(error.into()),
///     }
/// }
/// progressive.look_from(view.turntable(5.0), &scene.lighting)?;
/// # let step = progressive.step(&control)?;
/// # assert!(step.more);
/// # Ok(())
/// # }
/// ```
///
/// [`Cancel`]: pellucid_scene::Cancel
pub struct Progressive {
    renderer: Renderer,
    stage: Stage,
    preview_within: Option<Duration>,
    frames: u32,
    /// The last picture of this stage.
    reached: Option<Picture>,
    /// What is known of the light of its surfaces.
    light: Light,
    pace: Pace,
    shown: Frame,
    /// Drawn, to be enlarged.
    small: Frame,
    /// Drawn, to be taken into the mean.
    next: Frame,
}

/// A picture of a [`Progressive`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Picture {
    /// A picture with one ray for this many pixels per axis, enlarged.
    Preview {
        /// 2 to 16.
        reduction: usize,
    },
    /// The mean of so many frames in full resolution. A single one is that of [`Renderer::render`].
    Full {
        /// At least 1.
        frames: u32,
    },
}

/// What [`Progressive::step`] did.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Step {
    /// The picture that is [`Progressive::frame`] now.
    pub picture: Picture,
    /// Whether another step makes it better.
    pub more: bool,
}

impl Progressive {
    /// Time within which a preview shall come.
    pub const PREVIEW: Duration = Duration::from_millis(30);
    /// Frames averaged.
    pub const FRAMES: u32 = 16;

    /// Pictures of a stage: a preview within [`Progressive::PREVIEW`], up to [`Progressive::FRAMES`]
    /// frames.
    pub fn new(renderer: Renderer, stage: Stage) -> Self {
        Self {
            renderer,
            stage,
            preview_within: Some(Self::PREVIEW),
            frames: Self::FRAMES,
            reached: None,
            light: Light::default(),
            pace: Pace::default(),
            shown: Frame::default(),
            small: Frame::default(),
            next: Frame::default(),
        }
    }

    /// The same with another time for the preview. Its resolution is chosen by what the pictures
    /// before it took, so the first one and one after a great change may miss the time; where the full
    /// picture is fast enough there is no preview. `None` never draws one, and the first picture waits for all light.
    pub fn with_preview(mut self, within: Option<Duration>) -> Self {
        self.preview_within = within;
        self
    }

    /// The same with means of up to `frames` frames; fewer than 2 draw the full picture once.
    pub fn with_frames(mut self, frames: u32) -> Self {
        self.frames = frames.max(1);
        self
    }

    /// Takes another stage, and starts again. The last picture is shown until the next one is there.
    pub fn set_stage(&mut self, stage: Stage) {
        self.stage = stage;
        self.begin();
    }

    /// Looks at the stage from elsewhere, with the lights of the scene's `lighting`, and starts again.
    /// The view also says how large the pictures are.
    ///
    /// # Errors
    /// Those of [`Stage::look_from`]; nothing has changed then.
    pub fn look_from(&mut self, viewpoint: Viewpoint, lighting: &Lighting) -> Result<(), ResolveError> {
        self.stage.look_from(viewpoint, lighting)?;
        self.begin();
        Ok(())
    }

    fn begin(&mut self) {
        (self.reached, self.light) = (None, Light::default());
    }

    /// The last picture finished; empty before the first. A mean of frames has the colours averaged,
    /// samples and statistics summed, and the depth and normal of its first frame.
    pub fn frame(&self) -> &Frame {
        &self.shown
    }

    /// The last picture finished.
    pub fn into_frame(self) -> Frame {
        self.shown
    }

    /// Draws the next picture. Draws nothing if there is no better one.
    ///
    /// # Errors
    /// [`RenderError`], among them [`RenderError::Cancelled`]; the last picture stays, and another
    /// step tries the same again.
    pub fn step(&mut self, control: &Control) -> Result<Step, RenderError> {
        let picture = match self.reached {
            None => self.first(),
            Some(Picture::Preview { .. }) => Picture::Full { frames: 1 },
            Some(full) if !self.light_is_known() => full,
            Some(Picture::Full { frames }) => Picture::Full { frames: frames.saturating_add(1).min(self.frames) },
        };
        if self.reached != Some(picture) || !self.light_is_known() {
            match picture {
                Picture::Preview { reduction } => self.draw_preview(reduction, control)?,
                Picture::Full { frames } => self.draw_full(frames, control)?,
            }
            self.reached = Some(picture);
        }
        let more = picture != Picture::Full { frames: self.frames } || !self.light_is_known();
        Ok(Step { picture, more })
    }

    /// Whether pictures need not wait for light any more, or do so in one step, as those without a preview.
    fn light_is_known(&self) -> bool {
        self.preview_within.is_none() || self.light.is_known(&self.stage)
    }

    fn first(&self) -> Picture {
        let rays_per_pixel = f64::from(self.stage.quality.supersampling).powi(2);
        let reduction =
            self.preview_within.map_or(1, |within| self.pace.reduction(&self.stage.viewpoint, rays_per_pixel, within));
        if reduction > 1 { Picture::Preview { reduction } } else { Picture::Full { frames: 1 } }
    }

    fn draw_preview(&mut self, reduction: usize, control: &Control) -> Result<(), RenderError> {
        let view = self.stage.viewpoint;
        let rays = Rays::of(&self.stage).reduced(preview::rows(&view, reduction));
        let (width, height) = rays.size();
        if (self.small.width, self.small.height) != (width, height) {
            self.small.clear(width, height);
        }
        let within = self.preview_within.unwrap_or_default() / 2;
        let control = &Control { haste: self.light.haste(&self.stage, within), ..*control };
        draw(&mut self.renderer, &mut self.stage, rays, control, &mut self.small)?;
        let enlarging = Instant::now();
        parallel(|| preview::enlarge(&self.small, &mut self.shown, view.width, view.height));
        self.pace.preview(&self.small.statistics, enlarging.elapsed().as_secs_f64());
        Ok(())
    }

    fn draw_full(&mut self, frames: u32, control: &Control) -> Result<(), RenderError> {
        let rays = Rays::of(&self.stage).frame(frames - 1);
        // Further frames see a little more, and all of it is lit.
        let soon = frames == 1 && !self.light_is_known();
        let haste = if soon { self.light.haste(&self.stage, Light::WITHIN) } else { None };
        let frame = if frames == 1 { &mut self.shown } else { &mut self.next };
        draw(&mut self.renderer, &mut self.stage, rays, &Control { haste, ..*control }, frame)?;
        if !soon {
            self.pace.whole(&frame.statistics);
        }
        self.light.advance(&frame.statistics);
        if frames > 1 {
            mean::average(&mut self.shown, &self.next, 1.0 / frames as f32);
        }
        Ok(())
    }
}

/// Draws a stage with other rays, and leaves it as it was.
fn draw(
    renderer: &mut Renderer,
    stage: &mut Stage,
    rays: Rays,
    control: &Control,
    frame: &mut Frame,
) -> Result<(), RenderError> {
    let own = rays.exchange(stage);
    let drawn = renderer.render_into(stage, control, frame);
    own.exchange(stage);
    drawn
}

#[cfg(test)]
mod tests {
    use pellucid_scene::{SampleSource, Scene, Source};

    use super::*;

    fn ball() -> Scene {
        let ball = SampleSource { name: "ball".into(), dims: Some([16; 3]), voxel_type: None };
        let mut scene = Scene::of(Source::Sample(ball));
        (scene.image.width, scene.image.height) = (96, 64);
        scene
    }

    #[test]
    fn memory_is_kept_from_round_to_round() {
        let scene = ball();
        let (stage, _) = scene.resolve(&crate::load(&scene, "").unwrap().0).unwrap();
        let view = stage.viewpoint;
        // No preview comes within no time: the first is unmeasured, those after it as coarse as can be.
        let mut progressive =
            Progressive::new(Renderer::default(), stage).with_frames(3).with_preview(Some(Duration::ZERO));
        let mut memory = None;
        for round in 0..4 {
            let mut pictures = Vec::new();
            while progressive.reached != Some(Picture::Full { frames: 3 }) {
                pictures.push(progressive.step(&Control::default()).unwrap().picture);
            }
            let reduction = if round == 0 { 4 } else { 16 };
            assert_eq!(pictures[0], Picture::Preview { reduction });
            assert_eq!(pictures[1..], [1, 2, 3].map(|frames| Picture::Full { frames }));
            let held = [&progressive.shown, &progressive.small, &progressive.next].map(|frame| {
                let places = (frame.color.as_ptr(), frame.depth.as_ptr());
                (places, frame.normal.as_ptr(), frame.samples.as_ptr(), frame.color.capacity())
            });
            assert_eq!(*memory.get_or_insert(held), held, "round {round}");
            progressive.look_from(view.turned(view.up, 10.0 * f64::from(round)), &scene.lighting).unwrap();
        }
    }

    #[test]
    fn a_step_leaves_the_stage_as_it_was() {
        let scene = ball();
        let (stage, _) = scene.resolve(&crate::load(&scene, "").unwrap().0).unwrap();
        let own = Rays::of(&stage);
        let mut progressive = Progressive::new(Renderer::default(), stage).with_frames(3);
        while progressive.step(&Control::default()).unwrap().more {
            assert_eq!(Rays::of(&progressive.stage), own);
        }
        assert_eq!(Rays::of(&progressive.stage), own);
    }
}

//! A scene that is measured.

use std::sync::Arc;
use std::time::Instant;

use pellucid::field::Volume;
use pellucid::scene::{Choice, Frame, LookAt, Projection, Scene, Stage, View, Viewpoint};

use super::meter::{Meter, Plan};
use super::timing::Timing;
use crate::failure::Failure;
use crate::flags::{SceneFlags, Staged};
use crate::input::{Input, RawFlags};
use crate::render::{affordable, drawable};
use crate::report::{Report, in_flags};

/// A scene, loaded once.
pub struct Subject {
    /// As the command line names it.
    pub name: String,
    /// The scene with all flags applied.
    pub scene: Scene,
    /// Its volumes.
    pub volumes: Vec<Arc<Volume>>,
    /// What it resolves to.
    pub stage: Stage,
    /// What was chosen for it.
    pub choices: Vec<Choice>,
    /// What was lost on the way.
    pub warnings: Vec<String>,
    /// Seconds to fetch the volumes.
    pub load_seconds: f64,
    /// Milliseconds from there to the first picture: choices, renderer, tables and the frame.
    pub first_ms: f64,
}

impl Subject {
    /// Loads a scene, starts a renderer and draws the first picture. `check` has the scene before
    /// anything is loaded.
    pub fn open<'a>(
        input: &Input,
        raw: &RawFlags,
        flags: &SceneFlags,
        plan: Plan<'a>,
        report: Report,
        check: impl FnOnce(&Scene) -> Result<(), Failure>,
    ) -> Result<(Self, Meter<'a>), Failure> {
        let base = input.open(raw)?;
        let scene = flags.apply(&base.scene)?;
        affordable(&scene.image, 1)?;
        let idle = plan.engine.check()?;
        drawable(&scene, &base)?;
        check(&scene)?;
        let loading = Instant::now();
        let (volumes, warnings) = base.load(&scene)?;
        let load_seconds = loading.elapsed().as_secs_f64();
        let choosing = Instant::now();
        let Staged { scene, mut stage, choices, warnings: of_settings } = flags.stage(&base, scene, &volumes)?;
        let chosen = choosing.elapsed();
        let mut warnings: Vec<String> = warnings.iter().map(ToString::to_string).collect();
        warnings.extend(idle);
        warnings.extend(of_settings);
        report.opening(&scene, &volumes, &choices, &warnings);
        let drawing = Instant::now();
        let mut meter = Meter::new(Plan { engine: plan.engine.suited_to(&scene.technique), ..plan })?;
        let mut frame = Frame::default();
        meter.frame(&mut stage, &mut frame, |_| Ok(()))?;
        let first_ms = (chosen + drawing.elapsed()).as_secs_f64() * 1e3;
        for warning in &frame.warnings {
            report.warn(in_flags(warning));
            warnings.push(warning.to_string());
        }
        let name = input.to_string();
        Ok((Self { name, scene, volumes, stage, choices, warnings, load_seconds, first_ms }, meter))
    }

    /// Frames of a walk of `degrees` around the target, about the direction the camera calls up: the
    /// first from the scene's own camera, the last one step short of the end.
    pub fn orbit(&self, meter: &mut Meter, degrees: f64) -> Result<(Timing, Frame), Failure> {
        let up = match self.scene.camera.view {
            View::LookAt(look) => look.up,
            View::Orbit(_) => [0.0, 0.0, 1.0],
        };
        let (view, each) = (self.stage.viewpoint, degrees / meter.frames() as f64);
        meter.measure(&mut self.stage.clone(), |k, stage| {
            Ok(stage.look_from(view.turned(up.into(), each * k as f64), &self.scene.lighting)?)
        })
    }

    /// The scene with the look and the camera chosen for its volumes written down, so that others
    /// can take their place.
    pub fn with_choices(&self) -> Scene {
        let mut scene = self.scene.clone();
        for (entry, staged) in scene.volumes.iter_mut().zip(&self.stage.volumes) {
            entry.transfer_function = Some(staged.transfer_function.clone());
            (entry.shading, entry.material) = (Some(staged.material.is_some()), staged.material.or(entry.material));
            entry.gradient_weight = staged.gradient_weight;
        }
        let Viewpoint { eye, target, up, half_height, perspective, .. } = self.stage.viewpoint;
        scene.camera.view =
            View::LookAt(LookAt { position: eye.to_array(), target: target.to_array(), up: up.to_array() });
        if !perspective {
            scene.camera.projection = Projection::Orthographic { height: Some(2.0 * half_height) };
        }
        scene
    }
}

/// Frames of a scene over loaded volumes, all from its own camera, and the first one timed.
pub fn still(scene: &Scene, volumes: &[Arc<Volume>], meter: &mut Meter) -> Result<(Timing, Frame), Failure> {
    affordable(&scene.image, 1)?;
    let (mut stage, _) = scene.resolve(volumes)?;
    let view = stage.viewpoint;
    meter.measure(&mut stage, |_, stage| Ok(stage.look_from(view, &scene.lighting)?))
}

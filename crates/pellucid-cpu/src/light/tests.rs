//! What shading is told of a sample.

use glam::DAffine3;
use pellucid_field::{Grid, Volume, Voxels};
use pellucid_optics::{Color, ColorPoint, Interpolation, OpacityPoint, TransferFunction};
use pellucid_scene::{Classification, Orbit, Overlap, Projection, Scene, Source, Stage, View};

use super::gradient::Slope;
use super::lights::{Arrivals, Lights};
use super::shading::Shading;
use super::unlit::Unlit;
use super::{Answer, Lighting};
use crate::composite::Accumulation;
use crate::integrator::{Integrator, Tally, Traced};
use crate::lanes::*;
use crate::layers::AsLayer;
use crate::medium::Many;
use crate::modes::Composited;
use crate::packet::Packet;
use crate::prepare::{Cache, Prepared};
use crate::rays::Emitter;
use crate::samples::RUN;

/// Shows what it is told as red, green and blue: the opacity in front, the length of the gradient, the value.
struct Told;

impl<S: Lanes> Shading<S> for Told {
    fn has_surface(&self, _: S, _: &Unlit<S>) -> bool {
        true
    }

    fn weighs_gradients(&self) -> bool {
        true
    }

    fn along(&self, _: S, _: F32<S>) -> Option<[F32<S>; 3]> {
        None
    }

    fn shade(&self, s: S, sample: &Unlit<S>, slope: &Slope<S>, front: Option<F32<S>>, _: &Arrivals<S>) -> [F32<S>; 4] {
        sample.lit(s, [front.unwrap_or(splat(s, 0.0)), slope.magnitude, sample.value], [splat(s, 0.0); 3])
    }
}

/// A white medium of one opacity a unit, whose values rise from 0 to 1 along the view, over 16 units.
fn stage(classification: Classification) -> Stage {
    const DEPTH: usize = 17;
    let grid = Grid::with_affine([3, DEPTH, 3], DAffine3::IDENTITY).unwrap();
    let values: Vec<f32> = (0..grid.len()).map(|i| (i / 3 % DEPTH) as f32 / (DEPTH - 1) as f32).collect();
    let volume = Volume::new(grid, Voxels::from(values)).unwrap();
    let opacity = |value| OpacityPoint { value, opacity: 0.1, interpolation: Interpolation::Linear };
    let white = vec![ColorPoint::new(0.0, Color::WHITE)];
    let tf = TransferFunction::new(white, vec![opacity(0.0), opacity(1.0)]).unwrap();
    let mut scene = Scene::of(Source::memory());
    scene.volumes[0].transfer_function = Some(tf.with_unit_distance(Some(1.0)).unwrap());
    scene.volumes[0].shading = Some(false);
    scene.camera.view = View::Orbit(Orbit { azimuth: 0.0, elevation: 0.0, ..Default::default() });
    scene.camera.projection = Projection::Orthographic { height: Some(1.0) };
    (scene.image.width, scene.image.height) = (1, 1);
    scene.quality.step = 0.5;
    scene.quality.classification = classification;
    scene.resolve(&[std::sync::Arc::new(volume)]).unwrap().0
}

fn told<'a, S: Lanes>() -> Option<Lighting<'a, S>> {
    let lights = Lights::new(&[], DAffine3::IDENTITY);
    Some(Lighting { lights, shadow: None, chroma: None, answer: Answer::Other(Box::new(Told)) })
}

fn accumulation() -> Accumulation {
    Accumulation { chroma: None, early_termination: 2.0 }
}

/// What a ray through the middle gathers in pieces of so many steps, where the opacity in front is told anew after some.
fn expected(lengths: &[f64], told_after: usize) -> [f64; 3] {
    let (mut transmittance, mut front, mut color, mut from) = (1.0, 0.0, [0.0; 3], 0.0);
    for (number, length) in lengths.iter().enumerate() {
        if number % told_after == 0 {
            front = 1.0 - transmittance;
        }
        let (left, middle) = (0.9f64.powf(length * 0.5), from + length * 0.5);
        let seen = [front, 1.0 / 16.0, middle / 32.0];
        color.iter_mut().zip(seen).for_each(|(sum, seen)| *sum += transmittance * (1.0 - left) * seen);
        transmittance *= left;
        from += length;
    }
    color
}

fn trace(integrator: &dyn Integrator, wave: &[Packet]) -> [f64; 3] {
    let mut traced = [Traced::NOTHING];
    integrator.trace(wave, &mut traced, &mut Tally::default());
    [0, 1, 2].map(|channel| f64::from(traced[0].color[channel][0]))
}

fn assert_near(found: [f64; 3], expected: [f64; 3]) {
    let apart = found.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(apart < 1e-5, "{found:?} is not {expected:?}");
}

#[test]
fn shading_is_told_of_the_opacity_in_front_the_gradient_and_the_value() {
    for classification in [Classification::Post, Classification::PreIntegrated, Classification::Pre] {
        let stage = stage(classification);
        let prepared = [Prepared::new(&stage, 0, &mut Cache::default()).unwrap()];
        let mut packets = [Packet::NOTHING];
        let (mut wanted, middle) = ([false; MOST_LANES], [0.5; MOST_LANES]);
        wanted[0] = true;
        let emitter = Emitter::of_eye(&stage, InstructionSet::Baseline);
        emitter.emit(&middle, &middle, &wanted, 0, (&[prepared[0].solid()], &mut packets));

        let (s, sampler) = (baseline!(), || prepared[0].sampler().unwrap());
        let alone = prepared[0].with_medium(s, sampler(), told(), Composited(accumulation()));
        let mut lengths = vec![1.0; 32];
        if classification == Classification::PreIntegrated {
            // Segments lie between samples, and begin and end where rays do.
            lengths = [vec![0.5], vec![1.0; 31], vec![0.5]].concat();
        }
        assert_near(trace(&*alone, &packets), expected(&lengths, 1));

        // Layers are asked for several pieces at a time.
        let layers = vec![prepared[0].with_medium(s, sampler(), told(), AsLayer)];
        let many = Many { s, layers, overlap: Overlap::Add, accumulation: accumulation(), step: stage.step };
        let [packet] = packets;
        assert_near(trace(&many, &[emitter.around(std::slice::from_ref(&packet)), packet]), expected(&[1.0; 32], RUN));
    }
}

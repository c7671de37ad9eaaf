//! What samples in slabs send to the eye, in the light that has come to them (Eq. 6.9, 6.10, K-05).

use pellucid_plan::half_angle::{LightFrame, Ways};
use pellucid_scene::LightCorrection;

use super::buffer::{Light, LightBuffer};
use super::crossing::{Crossings, Passage};
use super::frame::Project;
use super::optics::{SlabOptics, SlabSample};
use super::transport;
use crate::chroma;
use crate::element::Element;
use crate::field::Field;
use crate::lanes::*;
use crate::light::{Arriving, Unlit, normals};
use crate::medium::{Beam, OneGrid};

/// What holds light back on its way through a slab to a sample: all that is there.
pub struct Attenuation<S: Lanes> {
    /// Opacity of one step.
    pub alpha: F32<S>,
    /// What gets through of indirect light over half of the slab, where most samples are, if that is something else.
    pub transmittance: Option<[F32<S>; 3]>,
}

/// A volume as the eye looks at it.
pub struct Eye<'a, S: Lanes, F> {
    /// What lies along rays, by single steps, and by half slabs for indirect light.
    pub medium: OneGrid<'a, S, &'a F, SlabOptics<'a>>,
    /// How long half a slab is, in steps.
    pub half: f32,
    /// Where samples are in the light's picture.
    pub frame: LightFrame,
    /// Length of a ray of light in a slab, in steps, or the coordinate of a light that is somewhere.
    pub ways: Ways,
    /// What light loses in front of a sample.
    pub correction: LightCorrection,
    /// Weights of direct light that becomes indirect there, if any does (6.3-7).
    pub into_cone: Option<[f32; 3]>,
    /// Factors of direct and indirect light.
    pub scales: [f32; 2],
}

impl<S: Lanes, F: Field<S>> Eye<'_, S, F> {
    /// What is seen at index positions, before any light is on it; `None` if nothing is.
    #[inline(always)]
    pub fn see(&self, index: &Vec3<S>, lanes: Mask<S>) -> Option<SlabSample<S>> {
        self.medium.at(index, lanes, splat(self.medium.s, 1.0))
    }

    /// What samples in slab k send to the eye, in the light that comes to them through what is `held` back there.
    #[inline(always)]
    pub fn lit(
        &self,
        sight: &SlabSample<S>,
        held: &Attenuation<S>,
        passage: &Passage<S>,
        (k, light): (usize, &LightBuffer),
        beam: Option<&Beam<S>>,
    ) -> Element<S> {
        let (s, OneGrid { field, lighting, .. }, chroma) = (self.medium.s, &self.medium, self.medium.chroma.as_ref());
        let (&Passage { place, index, ratio, .. }, &SlabSample { value, rgba, visible, .. }) = (passage, sight);
        let rgba = chroma::over_length(s, chroma, rgba, ratio);
        let (Some(lighting), Some(beam)) = (lighting, beam) else { return Element { rgba, visible } };
        let arriving = self.arriving(light, &index, place - k as f32, held, k);
        let direct = chroma::each(s, chroma, arriving.direct);
        let direct = xyz!(C => direct[C] * self.scales[0]);
        let sample = Unlit { rgba, value, index, lanes: visible };
        let mut lit = lighting.shade_by(
            s,
            &sample,
            (&beam.aim, Arriving::Share(direct)),
            None,
            #[inline(always)]
            || beam.gradients(s, lighting, &index, field.gradients(s, index, visible)),
        );
        if let Some(indirect) = arriving.indirect {
            let radiance = lighting.lights.radiance(s, &index, visible);
            for channel in 0..3 {
                let factor = indirect[channel] * radiance[channel] * self.scales[1];
                lit[channel] = visible.select(rgba[channel].mul_add(factor, lit[channel]), lit[channel]);
            }
        }
        Element { rgba: lit, visible }
    }

    /// What gets through half a slab of indirect light: what samples say or, where they say nothing, as much as of
    /// direct light.
    #[inline(always)]
    pub fn half_transmittance(&self, sight: &SlabSample<S>) -> [F32<S>; 3] {
        let s = self.medium.s;
        sight.transmittance.unwrap_or_else(|| {
            let transmittance = part_transmittance(s, splat(s, 1.0) - sight.rgba[3], splat(s, self.half));
            chroma::each(s, self.medium.chroma.as_ref(), transmittance)
        })
    }

    /// Unit normals at index positions.
    #[inline(always)]
    pub fn normals(&self, index: Vec3<S>, lanes: Mask<S>) -> Vec3<S> {
        normals(self.medium.s, self.medium.field.gradients(self.medium.s, index, lanes)).0
    }

    /// What light needs of the eye's rays, with the faces by which they come in: for some that is where they leave the
    /// last slab.
    #[inline(always)]
    pub fn beam(&self, to_eye: Vec3<S>, rays: &Crossings<S>, backward: Mask<S>) -> Option<Beam<S>> {
        let [entry, direction] = rays.entry(backward);
        self.medium.beam(to_eye, &entry, &direction)
    }

    /// The light that has come to samples a part of the way through slab k.
    #[inline(always)]
    fn arriving(
        &self,
        light: &LightBuffer,
        index: &Vec3<S>,
        part: F32<S>,
        &Attenuation { alpha, transmittance }: &Attenuation<S>,
        k: usize,
    ) -> Light<S> {
        let (s, one, chroma) = (self.medium.s, splat(self.medium.s, 1.0), self.medium.chroma.as_ref());
        let [texels, _] = self.frame.texels(s, index);
        let place = light.place(s, texels);
        let Light { direct, indirect } = light.fetch(s, &place);
        let (inside, halves) = match (self.correction, self.ways) {
            (LightCorrection::None, _) => return Light { direct, indirect },
            (LightCorrection::HalfSlab, Ways::Same(steps)) => (part * steps, part * 2.0),
            (LightCorrection::HalfSlab, Ways::From { place, step }) => {
                let distance = self.frame.distance(s, index);
                let inside = part * (distance / ((part + (k as f32 - place)) * step));
                (inside, inside / self.half)
            }
        };
        let left = part_transmittance(s, one - alpha, inside);
        let indirect = match (indirect, transmittance) {
            (None, _) => None,
            (Some(light), None) => {
                let left = chroma::each(s, chroma, left);
                Some(xyz!(C => light[C] * left[C]))
            }
            (Some(light), Some(transmittance)) => {
                let passing = xyz!(C => transport::over(s, transmittance[C], halves));
                let mut indirect = xyz!(C => light[C] * passing[C]);
                if let Some(into_cone) = self.into_cone {
                    // As light does that passes the slab.
                    let [from, left] = [direct, left].map(|light| chroma::each(s, chroma, light));
                    for channel in 0..3 {
                        let scattered = (passing[channel] - left[channel]).max(splat(s, 0.0)) * into_cone[channel];
                        indirect[channel] = from[channel].mul_add(scattered, indirect[channel]);
                    }
                }
                Some(indirect)
            }
        };
        Light { direct: direct * left, indirect }
    }
}

/// What gets through so many steps, of which one lets `through` through. Half a step is what most samples ask.
#[inline(always)]
fn part_transmittance<S: Lanes>(s: S, transmittance: F32<S>, steps: F32<S>) -> F32<S> {
    let half = steps.simd_eq(splat(s, 0.5));
    let root = transmittance.max(splat(s, 0.0)).sqrt();
    if half.all_true() { root } else { half.select(root, power(s, transmittance, steps)) }
}

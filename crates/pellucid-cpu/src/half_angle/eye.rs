//! What samples in slabs send to the eye, in the light that has come to them (Eq. 6.9, 6.10, K-05).

use pellucid_optics::Chroma;
use pellucid_plan::half_angle::{LightFrame, Ways};
use pellucid_scene::LightCorrection;

use super::buffer::{Light, LightBuffer};
use super::crossing::{Crossings, Passage};
use super::frame::Project;
use super::transport;
use crate::chroma;
use crate::classify::Lookup;
use crate::cut::{Cut, Cuts};
use crate::element::Element;
use crate::field::Field;
use crate::lanes::*;
use crate::paint::Paint;
use crate::skip::SkipGrid;
use crate::surface::{Aim, Surface, Unlit, normals};
use crate::vary::Varied;

/// What is seen at samples.
pub struct ClassifiedSample<S: Lanes> {
    value: F32<S>,
    /// Associated colours of one step.
    pub one_step: [F32<S>; 4],
    /// Lanes with any opacity.
    pub visible: Mask<S>,
    /// What gets through of indirect light over half of a slab, if that is something else.
    pub transmittance: Option<[F32<S>; 3]>,
}

/// What holds light back on its way through a slab to a sample: all that is there.
pub struct Attenuation<S: Lanes> {
    /// Opacity of one step.
    pub alpha: F32<S>,
    /// What gets through of indirect light over half of the slab, where most samples are, if that is something else.
    pub transmittance: Option<[F32<S>; 3]>,
}

/// A volume as the eye looks at it.
pub struct Eye<'a, S: Lanes, F> {
    /// The instruction set.
    pub s: S,
    /// The field.
    pub field: &'a F,
    /// Associated colours of one step.
    pub table: Lookup<'a>,
    /// What gets through of indirect light over half of a slab, if that is something else.
    pub half_transport: Option<Lookup<'a>>,
    /// How long that is, in steps.
    pub half: f32,
    /// How each colour is held back, if not all alike.
    pub chroma: Option<Chroma>,
    /// How samples answer the light.
    pub surface: Surface<'a, S>,
    /// Where they are in the light's picture.
    pub frame: LightFrame,
    /// Length of a ray of light in a slab, in steps, or the coordinate of a light that is somewhere.
    pub ways: Ways,
    /// What light loses in front of a sample.
    pub correction: LightCorrection,
    /// Weights of direct light that becomes indirect there, if any does (6.3-7).
    pub into_cone: Option<[f32; 3]>,
    /// Factors of direct and indirect light.
    pub scales: [f32; 2],
    /// Where matter is cut.
    pub cuts: Cuts,
    /// Blocks that can contribute, if empty space is skipped.
    pub skip: Option<&'a SkipGrid>,
    /// What varies optics, if anything does.
    pub varied: Option<Varied<'a>>,
    /// The colours of voxels, if they are drawn in them.
    pub paint: Option<Paint<'a>>,
}

impl<S: Lanes, F: Field<S>> Eye<'_, S, F> {
    /// What is seen at samples, before any light is on it; `None` if nothing is.
    #[inline(always)]
    pub fn see(&self, passage: &Passage<S>, lanes: Mask<S>, light: &LightBuffer) -> Option<ClassifiedSample<S>> {
        let (s, index) = (self.s, &passage.index);
        let value = self.field.values(s, *index, lanes);
        let position = self.table.position(s, value);
        let candidates = lanes & self.table.may_be_visible(s, position);
        if !candidates.any_true() {
            return None;
        }
        let mut one_step = self.table.at(s, position, None);
        let visible = candidates & one_step[3].simd_gt(splat(s, 0.0));
        if !visible.any_true() {
            return None;
        }
        if let Some(paint) = &self.paint {
            one_step = paint.tint(s, index, one_step);
        }
        let noise = self.noise(index);
        if let Some((varied, noise)) = &noise {
            one_step = varied.associated(s, noise, one_step);
        }
        let transmittance = match &self.half_transport {
            Some(table) if light.channels() > 1 => {
                let transmittance = transport::transmittance(s, table, value, splat(s, 1.0));
                Some(match &noise {
                    Some((varied, noise)) => varied.transport(s, noise, transmittance),
                    None => transmittance,
                })
            }
            _ => None,
        };
        Some(ClassifiedSample { value, one_step, visible, transmittance })
    }

    /// What samples in slab k send to the eye, in the light that comes to them through what is `held` back there.
    #[inline(always)]
    pub fn lit(
        &self,
        sight: &ClassifiedSample<S>,
        held: &Attenuation<S>,
        passage: &Passage<S>,
        (k, light): (usize, &LightBuffer),
        (aim, cut): (&Aim<S>, &Cut<S>),
    ) -> Element<S> {
        let s = self.s;
        let (&Passage { place, index, ratio, .. }, &ClassifiedSample { value, one_step, visible, .. }) =
            (passage, sight);
        let rgba = chroma::over_length(s, self.chroma.as_ref(), one_step, ratio);
        let arriving = self.arriving(light, &index, place - k as f32, held, k);
        let direct = chroma::each(s, self.chroma.as_ref(), arriving.direct);
        let direct = xyz!(C => direct[C] * self.scales[0]);
        let sample = Unlit { rgba, value, index, lanes: visible };
        let mut lit = self.surface.shade_through(
            s,
            &sample,
            aim,
            #[inline(always)]
            || {
                let gradients = self.field.gradients(s, index, visible);
                if self.surface.weighs_gradients() { gradients } else { cut.gradients(s, &index, gradients) }
            },
            #[inline(always)]
            |_| direct,
        );
        if let Some(indirect) = arriving.indirect {
            let radiance = self.surface.radiance(s, &index, visible);
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
    pub fn half_transmittance(&self, sight: &ClassifiedSample<S>) -> [F32<S>; 3] {
        let s = self.s;
        sight.transmittance.unwrap_or_else(|| {
            let transmittance = part_transmittance(s, splat(s, 1.0) - sight.one_step[3], splat(s, self.half));
            chroma::each(s, self.chroma.as_ref(), transmittance)
        })
    }

    /// Opacities of one step at index positions, and the lanes in which there may be any.
    #[inline(always)]
    pub fn opacities(&self, index: &Vec3<S>, lanes: Mask<S>) -> (F32<S>, Mask<S>) {
        let s = self.s;
        let value = self.field.values(s, *index, lanes);
        let position = self.table.position(s, value);
        let visible = lanes & self.table.may_be_visible(s, position);
        let mut alpha = self.table.at(s, position, None)[3];
        if let Some((varied, noise)) = self.noise(index) {
            alpha = varied.opacity(s, &noise, alpha);
        }
        (alpha, visible)
    }

    /// Unit normals at index positions.
    #[inline(always)]
    pub fn normals(&self, index: Vec3<S>, lanes: Mask<S>) -> Vec3<S> {
        normals(self.s, self.field.gradients(self.s, index, lanes)).0
    }

    /// The faces by which the eye's rays come in, which for some is where they leave the last slab.
    #[inline(always)]
    pub fn cut(&self, rays: &Crossings<S>, backward: Mask<S>) -> Cut<S> {
        let [entry, direction] = rays.entry(backward);
        self.cuts.met(self.s, &entry, &direction)
    }

    /// The noise at index positions, if optics vary.
    #[inline(always)]
    fn noise(&self, index: &Vec3<S>) -> Option<(Varied<'_>, [F32<S>; 4])> {
        self.varied.map(
            #[inline(always)]
            |varied| (varied, varied.noise(self.s, index)),
        )
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
        let (s, one) = (self.s, splat(self.s, 1.0));
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
                let left = chroma::each(s, self.chroma.as_ref(), left);
                Some(xyz!(C => light[C] * left[C]))
            }
            (Some(light), Some(transmittance)) => {
                let passing = xyz!(C => transport::over(s, transmittance[C], halves));
                let mut indirect = xyz!(C => light[C] * passing[C]);
                if let Some(into_cone) = self.into_cone {
                    // As light does that passes the slab.
                    let [from, left] = [direct, left].map(|light| chroma::each(s, self.chroma.as_ref(), light));
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

//! The light of a volume: which lights arrive, and what its samples make of them.

use pellucid_optics::Chroma;

use super::blinn_phong::BlinnPhong;
use super::gradient::Slope;
use super::hybrid::Hybrid;
use super::lights::{Aim, Arrivals, Arriving, Lights};
use super::scatter::Scatter;
use super::scattered::Scattered;
use super::shading::Shading;
use super::unlit::Unlit;
use crate::lanes::*;
use crate::shadow::Shadow;

/// How samples answer light: as most of them do, compiled into the loops, or by one virtual call a packet.
pub enum Answer<'a, S> {
    /// By reflection.
    Reflected(BlinnPhong),
    /// In another way.
    Other(Box<dyn Shading<S> + 'a>),
}

/// Lights, what holds them back, and what samples make of them.
pub struct Lighting<'a, S> {
    /// The lights.
    pub lights: Lights<'a>,
    /// What holds their light back on its way, if anything does.
    pub shadow: Option<Box<dyn Shadow<S> + 'a>>,
    /// How it holds back each colour, if not all alike.
    pub chroma: Option<Chroma>,
    /// What samples make of them.
    pub answer: Answer<'a, S>,
}

impl<'a, S: Lanes> Answer<'a, S> {
    /// By reflection where there is no scattering, by scattering where there are no surfaces, else by both.
    pub fn new(reflection: BlinnPhong, scatter: Option<Scatter<'a>>) -> Self {
        match scatter {
            None => Self::Reflected(reflection),
            Some(scatter) if scatter.has_surfaces() => Self::Other(Box::new(Boxed(Hybrid { scatter, reflection }))),
            Some(scatter) => Self::Other(Box::new(Boxed(Scattered { scatter, unlit: reflection.unlit() }))),
        }
    }
}

/// Behind a virtual call, which the instruction set is switched on again after.
struct Boxed<T>(T);

impl<S: Lanes, T: Shading<S>> Shading<S> for Boxed<T> {
    fn has_surface(&self, s: S, sample: &Unlit<S>) -> bool {
        s.vectorize(
            #[inline(always)]
            || self.0.has_surface(s, sample),
        )
    }

    fn weighs_gradients(&self) -> bool {
        self.0.weighs_gradients()
    }

    fn along(&self, s: S, mu: F32<S>) -> Option<[F32<S>; 3]> {
        s.vectorize(
            #[inline(always)]
            || self.0.along(s, mu),
        )
    }

    fn shade(
        &self,
        s: S,
        sample: &Unlit<S>,
        slope: &Slope<S>,
        front: Option<F32<S>>,
        lights: &Arrivals<S>,
    ) -> [F32<S>; 4] {
        s.vectorize(
            #[inline(always)]
            || self.0.shade(s, sample, slope, front, lights),
        )
    }
}

impl<S: Lanes> Lighting<'_, S> {
    /// Whether samples depend on the length of a gradient, not on its direction alone.
    pub fn weighs_gradients(&self) -> bool {
        match &self.answer {
            Answer::Reflected(shading) => Shading::<S>::weighs_gradients(shading),
            Answer::Other(shading) => shading.weighs_gradients(),
        }
    }

    /// What the directional lights need of rays, once for all of their samples.
    #[inline(always)]
    pub fn aim(&self, s: S, to_eye: Vec3<S>) -> Aim<S> {
        match &self.answer {
            Answer::Reflected(_) => self.lights.aim(
                s,
                to_eye,
                #[inline(always)]
                |_| None,
            ),
            Answer::Other(shading) => self.lights.aim(
                s,
                to_eye,
                #[inline(always)]
                |mu| shading.along(s, mu),
            ),
        }
    }

    /// Lights samples, with an opacity in front of them, by all lights, of which shadows leave their share. The gradient is
    /// asked for where there are surfaces only.
    #[inline(always)]
    pub fn shade(
        &self,
        s: S,
        sample: &Unlit<S>,
        aim: &Aim<S>,
        front: Option<F32<S>>,
        gradient: impl FnOnce() -> Vec3<S>,
    ) -> [F32<S>; 4] {
        let arriving = match &self.shadow {
            Some(shadow) => Arriving::Shadowed(&**shadow, self.chroma.as_ref()),
            None => Arriving::Whole,
        };
        self.shade_by(s, sample, (aim, arriving), front, gradient)
    }

    /// The same, where it is known what is left of lights.
    #[inline(always)]
    pub fn shade_by(
        &self,
        s: S,
        sample: &Unlit<S>,
        (aim, arriving): (&Aim<S>, Arriving<S>),
        front: Option<F32<S>>,
        gradient: impl FnOnce() -> Vec3<S>,
    ) -> [F32<S>; 4] {
        let lights = Arrivals { lights: &self.lights, aim, sample, arriving };
        match &self.answer {
            Answer::Reflected(shading) => shading.shade(s, sample, &Slope::new(s, gradient()), front, &lights),
            Answer::Other(shading) => {
                let has_surface = shading.has_surface(s, sample);
                let slope = if has_surface { Slope::new(s, gradient()) } else { Slope::none(s) };
                shading.shade(s, sample, &slope, front, &lights)
            }
        }
    }
}

//! Emission and absorption, front to back (1.4-8, 7.1-2).

use glam::DVec3;
use pellucid_field::Reconstruct;
use pellucid_optics::{PreIntegration, correct_associated, over};

use crate::integrator::{Integrator, Tally, Traced};
use crate::lattice::Lattice;
use crate::medium::Classify;
use crate::probe::Probe;
use crate::samples::each_sample;
use crate::segments::each_segment;
use crate::skip::SkipGrid;
use crate::span::Span;
use crate::surface::{Surface, normal};

/// What every compositing loop shares: the field, light, empty blocks and the stop criterion.
pub struct Medium<'a, R> {
    /// The field.
    pub probe: Probe<'a, R>,
    /// Light, if surfaces are shaded.
    pub surface: Option<Surface<'a>>,
    /// Blocks that can contribute, if empty space is skipped.
    pub skip: Option<SkipGrid<'a>>,
    /// Opacity at which a ray stops.
    pub early_termination: f32,
}

/// One ray's accumulated light.
struct Accumulator {
    color: [f32; 4],
    /// Distance at which opacity first reached one half.
    half: Option<f64>,
}

impl<R: Reconstruct> Medium<'_, R> {
    /// Shades an associated sample: colour is lit, opacity stays (5.4-1: the light is weighted by
    /// the sample's opacity, or transparent samples would glow).
    #[inline]
    fn lit(&self, span: &Span, t: f64, value: f64, rgba: [f32; 4]) -> [f32; 4] {
        let Some(surface) = &self.surface else { return rgba };
        let [r, g, b, a] = rgba;
        let base = [r / a, g / a, b / a];
        let gradient = self.probe.gradient(span.index_at(t), value);
        let [r, g, b] = surface.shade(base, span.ray.at(t), gradient, -span.ray.direction);
        [r * a, g * a, b * a, a]
    }

    /// Adds a sample behind what is there. Returns whether the ray is done.
    #[inline(always)]
    fn add(&self, ray: &mut Accumulator, t: f64, rgba: [f32; 4]) -> bool {
        ray.color = over(ray.color, rgba);
        if ray.half.is_none() && ray.color[3] >= 0.5 {
            ray.half = Some(t);
        }
        ray.color[3] >= self.early_termination
    }

    fn finish(&self, ray: &Accumulator, span: &Span) -> Traced {
        let Some(depth) = ray.half else { return Traced { color: ray.color, ..Traced::NOTHING } };
        let index = span.index_at(depth);
        let value = self.probe.value(index);
        let normal = if value.is_nan() { DVec3::ZERO } else { normal(self.probe.gradient(index, value)) };
        Traced { color: ray.color, depth, normal }
    }
}

/// Compositing of classified samples.
pub struct Composite<'a, R, C> {
    /// The shared parts.
    pub medium: Medium<'a, R>,
    /// How samples get colour and opacity.
    pub classifier: C,
}

impl<R: Reconstruct, C: Classify<R>> Integrator for Composite<'_, R, C> {
    fn trace(&self, span: &Span, lattice: &Lattice, tally: &mut Tally) -> Traced {
        let medium = &self.medium;
        let mut ray = Accumulator { color: [0.0; 4], half: None };
        each_sample(medium.skip.as_ref(), span, lattice, tally, |k, t, tally| {
            let (value, mut rgba) = self.classifier.classify(&medium.probe, span.index_at(t));
            if rgba[3] == 0.0 {
                return false;
            }
            tally.visible += 1;
            let ratio = lattice.ratio(k);
            if ratio < 1.0 {
                rgba = correct_associated(rgba, ratio as f32);
            }
            medium.add(&mut ray, t, medium.lit(span, t, value, rgba))
        });
        medium.finish(&ray, span)
    }
}

/// Compositing of pre-integrated segments between the nodes of the lattice (4.6-7, 7.2-3): one
/// fetch a step, and the first segment starts at the entry, not at a made-up value of 0.
pub struct PreIntegrated<'a, R> {
    /// The shared parts.
    pub medium: Medium<'a, R>,
    /// Ray integrals of one full step.
    pub table: &'a PreIntegration,
}

impl<R: Reconstruct> Integrator for PreIntegrated<'_, R> {
    fn trace(&self, span: &Span, lattice: &Lattice, tally: &mut Tally) -> Traced {
        let medium = &self.medium;
        let mut ray = Accumulator { color: [0.0; 4], half: None };
        each_segment(&medium.probe, medium.skip.as_ref(), span, lattice, tally, |segment, tally| {
            let [start, end] = segment.t;
            let Some(rgba) = self.integral(segment.value, (end - start) / lattice.step()) else { return false };
            tally.visible += 1;
            let middle = (start + end) / 2.0;
            let value = if medium.surface.is_some() { medium.probe.value(span.index_at(middle)) } else { f64::NAN };
            medium.add(&mut ray, middle, medium.lit(span, middle, value, rgba))
        });
        medium.finish(&ray, span)
    }
}

impl<R> PreIntegrated<'_, R> {
    /// The integral over a segment with these values at its ends, if it has any opacity. Where one
    /// end is absent the field reaches half way with the value of the other.
    #[inline(always)]
    fn integral(&self, [front, back]: [f64; 2], ratio: f64) -> Option<[f32; 4]> {
        let (front, back, ratio) = match (front.is_nan(), back.is_nan()) {
            (false, false) => (front, back, ratio),
            (false, true) => (front, front, ratio / 2.0),
            (true, false) => (back, back, ratio / 2.0),
            (true, true) => return None,
        };
        let rgba = self.table.lookup(front as f32, back as f32);
        let rgba = if ratio == 1.0 { rgba } else { correct_associated(rgba, ratio as f32) };
        (rgba[3] > 0.0).then_some(rgba)
    }
}

//! First surfaces of constant value, found along the ray without a mesh (5.5-8).

use glam::DVec3;
use pellucid_field::Reconstruct;
use pellucid_optics::{ColorSpace, TransferFunction, over};
use pellucid_scene::Isovalue;

use crate::integrator::{Integrator, Tally, Traced};
use crate::lattice::Lattice;
use crate::probe::Probe;
use crate::segments::{Segment, each_segment};
use crate::skip::SkipGrid;
use crate::span::Span;
use crate::surface::{Surface, normal};

/// A surface, classified.
#[derive(Clone, Copy, Debug)]
pub struct Level {
    /// Data value.
    pub value: f64,
    /// Linear RGB.
    pub color: [f32; 3],
    /// Opacity.
    pub opacity: f32,
}

impl Level {
    /// The surface of the document, its colour from the transfer function unless it has its own.
    pub fn new(iso: &Isovalue, tf: &TransferFunction) -> Self {
        let color = iso.color.map_or_else(|| tf.color(iso.value), |color| color.to_linear(ColorSpace::Srgb));
        Self { value: iso.value, color, opacity: iso.opacity }
    }
}

/// Shaded isosurfaces.
pub struct Isosurfaces<'a, R> {
    /// The field.
    pub probe: Probe<'a, R>,
    /// Light, if surfaces are shaded.
    pub surface: Option<Surface<'a>>,
    /// The surfaces.
    pub levels: Vec<Level>,
    /// Blocks that hold a surface, if the others are skipped.
    pub skip: Option<SkipGrid<'a>>,
    /// Opacity at which a ray stops.
    pub early_termination: f32,
}

/// Width of the bracket around a root, in voxels, below which it is found.
const ROOT_VOXELS: f64 = 1e-5;

impl<R: Reconstruct> Integrator for Isosurfaces<'_, R> {
    fn trace(&self, span: &Span, lattice: &Lattice, tally: &mut Tally) -> Traced {
        let mut traced = Traced::NOTHING;
        each_segment(&self.probe, self.skip.as_ref(), span, lattice, tally, |segment, tally| {
            self.cross(span, segment, &mut traced, tally)
        });
        traced
    }
}

impl<R: Reconstruct> Isosurfaces<'_, R> {
    /// Adds the surfaces that one segment crosses, nearest first. Returns whether the ray is done.
    #[inline(always)]
    fn cross(&self, span: &Span, segment: Segment, traced: &mut Traced, tally: &mut Tally) -> bool {
        let value = segment.value;
        if value[0].is_nan() || value[1].is_nan() {
            return false;
        }
        // A ray leaves the value at the segment's start and meets levels in the order of value.
        let rising = value[1] > value[0];
        let mut done = |level: &Level| {
            if (value[0] < level.value) == (value[1] < level.value) {
                return false;
            }
            self.hit(span, segment, level, traced, tally)
        };
        if rising { self.levels.iter().any(&mut done) } else { self.levels.iter().rev().any(&mut done) }
    }

    fn hit(&self, span: &Span, segment: Segment, level: &Level, traced: &mut Traced, tally: &mut Tally) -> bool {
        let t = self.root(span, segment, level.value);
        let index = span.index_at(t);
        let gradient = self.probe.gradient(index, level.value);
        let color = self
            .surface
            .as_ref()
            .map_or(level.color, |surface| surface.shade(level.color, span.ray.at(t), gradient, -span.ray.direction));
        tally.visible += 1;
        let [r, g, b] = color.map(|channel| channel * level.opacity);
        traced.color = over(traced.color, [r, g, b, level.opacity]);
        if traced.depth.is_infinite() {
            traced.depth = t;
            traced.normal = toward(normal(gradient), -span.ray.direction);
        }
        traced.color[3] >= self.early_termination
    }

    /// Where the field passes `level` between two distances whose values bracket it: regula falsi
    /// with the Illinois rule, with bisection when it stalls, to [`ROOT_VOXELS`].
    fn root(&self, span: &Span, Segment { t: [mut t0, mut t1], value }: Segment, level: f64) -> f64 {
        let (mut f0, mut f1) = (value[0] - level, value[1] - level);
        let tolerance = ROOT_VOXELS / span.index_direction().abs().max_element();
        let mut kept = 0i32;
        for round in 0..64 {
            if t1 - t0 <= tolerance {
                break;
            }
            let t = if round % 3 == 2 { (t0 + t1) / 2.0 } else { t0 + (t1 - t0) * (f0 / (f0 - f1)) };
            let f = self.probe.value(span.index_at(t)) - level;
            if f.is_nan() || f == 0.0 {
                return t;
            }
            if (f < 0.0) == (f0 < 0.0) {
                (t0, f0) = (t, f);
                f1 = if kept == 1 { f1 / 2.0 } else { f1 };
                kept = 1;
            } else {
                (t1, f1) = (t, f);
                f0 = if kept == -1 { f0 / 2.0 } else { f0 };
                kept = -1;
            }
        }
        (t0 + t1) / 2.0
    }
}

/// The normal on the side of a direction.
fn toward(normal: DVec3, direction: DVec3) -> DVec3 {
    if normal.dot(direction) < 0.0 { -normal } else { normal }
}

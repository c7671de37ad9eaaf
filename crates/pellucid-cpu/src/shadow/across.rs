//! Shadows that several volumes cast on each other.

use glam::DAffine3;
use pellucid_scene::Overlap;

use super::{DARK, Shadow, ToLights};
use crate::element::Element;
use crate::integrator::Counter;
use crate::lanes::*;
use crate::medium::{Layer, Ways};

/// All volumes between the samples of one of them and lights.
pub struct Across<'a, S> {
    /// What they are made of, by steps of shadow rays.
    pub layers: Vec<Box<dyn Layer<S> + 'a>>,
    /// The ways in each of them.
    pub ways: Vec<(Turn, ToLights)>,
    /// What lies where they overlap.
    pub overlap: Overlap,
}

/// From index positions of one grid to those of another.
pub struct Turn {
    /// The columns of a matrix, and what is added.
    columns: [[f32; 3]; 4],
}

impl Turn {
    /// An affine map.
    pub fn new(map: DAffine3) -> Self {
        Self { columns: map.as_affine3a().to_cols_array_2d() }
    }

    /// Where positions are in the other grid.
    #[inline(always)]
    pub fn of<S: Lanes>(&self, s: S, p: &Vec3<S>) -> Vec3<S> {
        let [x, y, z, moved] = &self.columns;
        xyz!(I => p[0].mul_add(
            splat(s, x[I]),
            p[1].mul_add(splat(s, y[I]), p[2].mul_add(splat(s, z[I]), splat(s, moved[I]))),
        ))
    }
}

impl<S: Lanes> Shadow<S> for Across<'_, S> {
    fn transmittance(&self, s: S, light: usize, index: &Vec3<S>, lanes: Mask<S>) -> F32<S> {
        s.vectorize(
            #[inline(always)]
            || {
                let mut spans = Vec::with_capacity(self.ways.len());
                for (turn, ways) in &self.ways {
                    spans.push(ways.span(s, light, &turn.of(s, index), lanes, 0.0));
                }
                let ways = Ways::new(s, spans, splat(s, 0.5));
                let (mut progress, mut counter) = (ways.start(s), Counter::new(s));
                let mut transmittance = splat(s, 1.0);
                let what = (&*self.layers, self.overlap);
                while ways.run(
                    s,
                    &mut progress,
                    what,
                    &mut counter,
                    #[inline(always)]
                    |_, Element { rgba, visible }, _| {
                        transmittance = visible.select(transmittance - transmittance * rgba[3], transmittance);
                        transmittance.simd_le(splat(s, DARK))
                    },
                ) {}
                transmittance
            },
        )
    }
}

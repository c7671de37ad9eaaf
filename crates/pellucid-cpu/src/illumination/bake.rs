//! Light at all places of a lattice, found at once (G-07).

use std::sync::Mutex;

use rayon::prelude::*;

use super::global::Global;
use crate::lanes::Lanes;

/// Light that was found at all places.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Baked {
    /// Places that were looked at: those of each side of a surface.
    pub places: usize,
    /// Those of them that have a surface, and light.
    pub lit: usize,
}

/// Something that finds light at all places.
pub trait Bake: Sync {
    /// Finds it, on those sides of surfaces of which anything is known, unless it is cancelled.
    fn bake(&self) -> Baked;
}

impl<S: Lanes> Bake for Global<'_, S> {
    fn bake(&self) -> Baked {
        let (places, asked) = (self.places(), self.places().asked());
        let (kept, control) = (asked.kept, asked.control);
        let Some(lattice) = &kept.lattice else { return Baked::default() };
        let sides: Vec<_> = kept.touched().collect();
        let rows = lattice.dims[1] * lattice.dims[2];
        let (done, all) = (Mutex::new(0usize), rows * sides.len());
        let of_row = |number: usize| {
            let ((surface, side), row) = (sides[number / rows], number % rows);
            let at = |x| [x, row % lattice.dims[1], row / lattice.dims[1]];
            let lit = (0..lattice.dims[0]).filter(|&x| places.light(lattice, surface, at(x), side).is_some()).count();
            // Reported under the lock, so that progress never runs backwards.
            let mut done = done.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
            *done += 1;
            control.report(*done as f64 / all as f64);
            lit
        };
        let lit = (0..all).into_par_iter().map(of_row).sum();
        Baked { places: all * lattice.dims[0], lit }
    }
}

//! Light at all places of a lattice, found at once (G-07).

use std::sync::Mutex;

use rayon::prelude::*;

use super::global::Global;
use crate::lanes::Lanes;

/// Something that finds light at all places.
pub trait Bake: Sync {
    /// Finds it, on those sides of surfaces of which anything is known, unless it is cancelled. Returns how many places it
    /// looked at.
    fn bake(&self) -> usize;
}

impl<S: Lanes> Bake for Global<'_, S> {
    fn bake(&self) -> usize {
        let (places, asked) = (self.places(), self.places().asked());
        let (kept, control) = (asked.kept, asked.control);
        let Some(lattice) = &kept.lattice else { return 0 };
        let sides: Vec<_> = kept.touched().collect();
        let rows = lattice.dims[1] * lattice.dims[2];
        let (done, all) = (Mutex::new(0usize), rows * sides.len());
        (0..all).into_par_iter().for_each(|number| {
            let ((surface, side), row) = (sides[number / rows], number % rows);
            for x in 0..lattice.dims[0] {
                places.light(lattice, surface, [x, row % lattice.dims[1], row / lattice.dims[1]], side);
            }
            // Reported under the lock, so that progress never runs backwards.
            let mut done = done.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
            *done += 1;
            control.report(*done as f64 / all as f64);
        });
        all * lattice.dims[0]
    }
}

//! The walk over the pieces of rays between planes of voxels, on each of which the field is smooth.
//!
//! Where a piece begins and ends follows from its cell alone: a walk that leaps meets the same pieces, to
//! the bit, as one that does not.

use crate::field::Knots;
use crate::lanes::*;
use crate::packet::Rays;

/// How many pieces are looked at between two looks at the blocks.
pub const RUN: usize = 8;

/// Where rays are on their way from cell to cell.
pub struct Cells<S: Lanes> {
    /// Entries of rays, counted in cells.
    origin: Vec3<S>,
    /// Cells a step, and one over it, very large along axes that the ray does not move on.
    direction: Vec3<S>,
    inverse: Vec3<S>,
    /// 1 along axes on which the ray ascends, else 0.
    ascends: Vec3<S>,
    /// Coordinates of the cell.
    cell: Vec3<S>,
    /// Distances of the piece's ends, in steps.
    pub ends: [F32<S>; 2],
    /// Distance of the ray's exit.
    length: F32<S>,
}

impl<S: Lanes> Cells<S> {
    /// At the entries of rays, in a field with such knots.
    #[inline(always)]
    pub fn new(s: S, rays: &Rays<S>, knots: Knots) -> Self {
        let Knots { per_voxel, shift } = knots;
        let (zero, one) = (splat(s, 0.0), splat(s, 1.0));
        let origin = xyz!(I => rays.origin[I].mul_add(splat(s, per_voxel), splat(s, shift)));
        let mut cells = Self {
            origin,
            direction: xyz!(I => rays.direction[I] * per_voxel),
            inverse: xyz!(I => rays.inverse[I] * (1.0 / per_voxel)),
            ascends: xyz!(I => rays.inverse[I].simd_gt(zero).select(one, zero)),
            cell: xyz!(I => origin[I].floor()),
            ends: [zero; 2],
            length: rays.count.simd_gt(zero).select(rays.length(), splat(s, -1.0)),
        };
        cells.meet(s);
        cells
    }

    /// Lanes whose piece lies on the ray.
    #[inline(always)]
    pub fn are_there(&self) -> Mask<S> {
        self.ends[0].simd_lt(self.length)
    }

    /// Distances of the pieces' middles: off every plane by more than rounding, if they have any length.
    #[inline(always)]
    pub fn middle(&self) -> F32<S> {
        (self.ends[0] + self.ends[1]) * 0.5
    }

    /// Distances of the planes at which cells are left.
    #[inline(always)]
    fn exits(&self) -> Vec3<S> {
        xyz!(I => (self.cell[I] + self.ascends[I] - self.origin[I]) * self.inverse[I])
    }

    /// Where the piece lies between the planes around it.
    #[inline(always)]
    fn meet(&mut self, s: S) {
        let entries = xyz!(I => (self.cell[I] + 1.0 - self.ascends[I] - self.origin[I]) * self.inverse[I]);
        let (exits, zero) = (self.exits(), splat(s, 0.0));
        let start = entries[0].max(entries[1]).max(entries[2]).max(zero);
        let end = exits[0].min(exits[1]).min(exits[2]).min(self.length);
        self.ends = [start, end.max(start)];
    }

    /// Goes on to the next piece in these lanes.
    #[inline(always)]
    pub fn advance(&mut self, s: S, lanes: Mask<S>) {
        let exits = self.exits();
        let next = exits[0].min(exits[1]).min(exits[2]);
        self.cell = xyz!(I => {
            let crossed = lanes & exits[I].simd_le(next);
            crossed.select(self.cell[I] + self.ascends[I] * 2.0 - 1.0, self.cell[I])
        });
        self.meet(s);
    }

    /// Goes to the cell at a distance ahead in these lanes; never back, wherever rounding puts it.
    #[inline(always)]
    pub fn leap(&mut self, s: S, distance: F32<S>, lanes: Mask<S>) {
        self.cell = xyz!(I => {
            let there = self.direction[I].mul_add(distance, self.origin[I]).floor();
            let ahead = self.ascends[I].simd_gt(splat(s, 0.5)).select(there.max(self.cell[I]), there.min(self.cell[I]));
            lanes.select(ahead, self.cell[I])
        });
        self.meet(s);
    }
}

//! What a pixel may see of the medium, known before any of its paths is followed.

use std::f64::consts::SQRT_2;

use glam::{DAffine3, DVec2, DVec3};
use pellucid_field::{Grid, Leaps};
use pellucid_plan::MajorantGrid;
use pellucid_scene::{PathTrace, Viewpoint};

use super::majorants::Walk;
use super::space::Flight;
use crate::source::Source;

/// The blocks that the rays of a pixel may meet, all of which pass less than a block beside its middle ray.
pub struct Sights {
    source: Source,
    /// Into a grid with one block more on every side.
    block_from_world: DAffine3,
    /// In that grid; live is what is live itself or beside what is.
    leaps: Leaps,
}

/// Where the rays of a pixel may meet the medium.
pub enum Sight {
    /// Nowhere; and whether the middle ray passes through its box, or close by.
    Nowhere(bool),
    /// Between these distances in world units, along each.
    Between([f64; 2]),
}

impl Sights {
    /// Those of a view; `None` if rays of a pixel, or of a lens, lie further apart.
    pub fn new(view: &Viewpoint, grid: &Grid, majorants: &MajorantGrid, settings: &PathTrace) -> Option<Self> {
        let index_from_world = grid.index_from_world();
        let rows = index_from_world.matrix3.transpose();
        let steepest = rows.x_axis.length().max(rows.y_axis.length()).max(rows.z_axis.length());
        let furthest = grid.world_corners().into_iter().map(|corner| corner.distance(view.eye)).fold(0.0, f64::max);
        // From the middle of a pixel to its corner. Rays lie no further apart than the vectors that are made shorter
        // to become their directions.
        let corner = SQRT_2 * view.half_height / view.height as f64;
        let spread = steepest * corner * if view.perspective { furthest } else { 1.0 };
        let size = f64::from(majorants.size);
        // A little less than a block leaves room for rounding.
        let is_narrow = settings.aperture == 0.0 && size.is_finite() && spread < 0.99 * size;
        // Paths are spread over each pixel anyway (`lens.rs`).
        let source = Source::of_eye(&Viewpoint { shift: DVec2::ZERO, ..*view });
        let block_from_index =
            DAffine3::from_translation(DVec3::ONE) * DAffine3::from_scale(DVec3::splat(size.recip()));
        let block_from_world = block_from_index * index_from_world;
        is_narrow.then(|| Self { source, block_from_world, leaps: widened(&majorants.leaps) })
    }

    /// That of a pixel.
    pub fn of_pixel(&self, x: usize, y: usize) -> Sight {
        let world = self.source.lines(1, &[x as f64 + 0.5], &[y as f64 + 0.5]);
        let mut line = world.carried(1, &self.block_from_world);
        line.keep_box(1, DVec3::ZERO, DVec3::from_array(self.leaps.dims().map(|n| n as f64)));
        let Some((enter, flight)) = Flight::new(&line) else { return Sight::Nowhere(false) };
        let mut walk = Walk::new(&self.leaps, 1.0, &flight);
        let (mut at, mut met) = (0.0, None);
        loop {
            if walk.is_live() {
                let (first, _) = met.unwrap_or((at, at));
                met = Some((first, walk.exit()));
            }
            let Some(next) = walk.advance() else { break };
            at = next;
        }
        let distance = |way: f32| enter + f64::from(way);
        met.map_or(Sight::Nowhere(true), |(first, last)| Sight::Between([distance(first), distance(last)]))
    }
}

fn widened(leaps: &Leaps) -> Leaps {
    let [nx, ny, nz] = leaps.dims();
    let dims = [nx + 2, ny + 2, nz + 2];
    // The block itself, or the nearest one of the grid.
    let inner = |place: usize, n: usize| place.saturating_sub(1).min(n - 1);
    Leaps::new(dims, |block| {
        let [x, y, z] = [block % dims[0], block / dims[0] % dims[1], block / (dims[0] * dims[1])];
        leaps.distance(inner(x, nx) + nx * (inner(y, ny) + ny * inner(z, nz))) <= 1
    })
}

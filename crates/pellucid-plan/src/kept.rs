//! What depends on the data of a layer alone, and stays while settings change: blocks, their extremes, coefficients.

use std::sync::Arc;

use pellucid_field::{Blocks, FieldError, Filter, Volume, spline_coefficients};
use pellucid_optics::Displacer;

use crate::blocks::BlockContent;

/// What is kept of the data of a layer; each of it is the last that was asked for.
#[derive(Default)]
pub(crate) struct Kept {
    blocks: Option<KeptBlocks>,
    /// Of half the size.
    fine_blocks: Option<KeptBlocks>,
    extremes: Option<(Arc<Blocks>, bool, Arc<Vec<f32>>)>,
    coefficients: Option<(Arc<Volume>, usize, Arc<Volume>)>,
    alone: Option<(Arc<Volume>, usize, Arc<Volume>)>,
}

/// Blocks and what they are of.
type KeptBlocks = (Arc<Volume>, usize, Margin, Arc<Blocks>);

/// How far a filter, or a displacement, sees beyond a cell, in voxels, and samples leave the range of what it
/// sees.
#[derive(Clone, Copy, PartialEq)]
pub(crate) struct Margin {
    pub reach: usize,
    pub overshoot: f64,
}

impl Kept {
    /// Blocks of the usual size, or larger ones where there would be more than `most` along an axis.
    pub fn blocks(
        &mut self,
        volume: &Arc<Volume>,
        component: usize,
        margin: Margin,
        most: usize,
    ) -> Result<Arc<Blocks>, FieldError> {
        let cells = volume.grid().dims().into_iter().max().unwrap_or(1);
        let size = Blocks::CELLS.max(cells.div_ceil(most).next_power_of_two());
        kept(&mut self.blocks, volume, component, margin, size)
    }

    /// Blocks of half the usual size.
    pub fn fine_blocks(
        &mut self,
        volume: &Arc<Volume>,
        component: usize,
        margin: Margin,
    ) -> Result<Arc<Blocks>, FieldError> {
        kept(&mut self.fine_blocks, volume, component, margin, Blocks::CELLS / 2)
    }

    /// The largest values of blocks, or the smallest with their signs turned.
    pub fn extremes(&mut self, blocks: &Arc<Blocks>, minimum: bool) -> BlockContent {
        let values = match &self.extremes {
            Some((of, least, values)) if Arc::ptr_eq(of, blocks) && *least == minimum => values.clone(),
            _ => {
                let values = BlockContent::extremes(blocks, minimum);
                self.extremes = Some((blocks.clone(), minimum, values.clone()));
                values
            }
        };
        BlockContent::Extremes(values)
    }

    /// The coefficients of a spline through the voxels.
    pub fn coefficients(&mut self, volume: &Arc<Volume>, component: usize) -> Result<Arc<Volume>, FieldError> {
        made(&mut self.coefficients, volume, component, spline_coefficients)
    }

    /// A component by itself.
    pub fn alone(&mut self, volume: &Arc<Volume>, component: usize) -> Result<Arc<Volume>, FieldError> {
        if volume.components() == 1 {
            self.alone = None;
            return Ok(volume.clone());
        }
        made(&mut self.alone, volume, component, pellucid_field::component)
    }
}

/// The volume that is kept, if it was made of this, or a new one in its place.
fn made(
    slot: &mut Option<(Arc<Volume>, usize, Arc<Volume>)>,
    volume: &Arc<Volume>,
    component: usize,
    make: impl FnOnce(&Volume, usize) -> Result<Volume, FieldError>,
) -> Result<Arc<Volume>, FieldError> {
    match slot {
        Some((v, c, made)) if Arc::ptr_eq(v, volume) && *c == component => Ok(made.clone()),
        _ => {
            let made = Arc::new(make(volume, component)?);
            *slot = Some((volume.clone(), component, made.clone()));
            Ok(made)
        }
    }
}

/// The blocks that are kept, if they are of this, or new ones in their place.
fn kept(
    slot: &mut Option<KeptBlocks>,
    volume: &Arc<Volume>,
    component: usize,
    margin: Margin,
    size: usize,
) -> Result<Arc<Blocks>, FieldError> {
    match slot {
        Some((v, c, m, blocks)) if Arc::ptr_eq(v, volume) && *c == component && *m == margin => Ok(blocks.clone()),
        _ => {
            let mut blocks = Blocks::new(volume, component, size, margin.reach)?;
            if margin.overshoot > 0.0 {
                blocks = blocks.overshot(margin.overshoot);
            }
            let blocks = Arc::new(blocks);
            *slot = Some((volume.clone(), component, margin, blocks.clone()));
            Ok(blocks)
        }
    }
}

impl Margin {
    /// That of a filter; `None` if its samples leave the range of their voxels too far to tell anything.
    pub fn of(filter: Filter) -> Option<Self> {
        const FURTHEST: f64 = 4.0;
        let overshoot = filter.overshoot();
        (overshoot <= FURTHEST).then(|| Self { reach: filter.half_width() - 1, overshoot })
    }

    /// This, where positions move before the filter sees them: by no more than the displacement's reach, and
    /// a rounding.
    pub fn displaced(self, displacer: Option<&Displacer>) -> Self {
        const ROUNDING: f32 = 1e-3;
        let furthest = displacer.map_or(0.0, |displacer| displacer.reach.into_iter().fold(0.0, f32::max) + ROUNDING);
        Self { reach: self.reach + furthest.ceil() as usize, ..self }
    }
}

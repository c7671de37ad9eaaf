//! Noise taken out of a picture of paths: neighbours that are alike exchange their light (non-local means, Buades et
//! al. 2005), with the noise that is known of every pixel (Rousselle et al. 2012) and edges of depth and normal.
//!
//! What one pixel gets of another, the other loses to it, so that no light comes or goes: a mean of neighbours would
//! lose that of rare bright paths, which differ from all of them.

mod comparison;
mod guides;
mod speckles;

use pellucid_field::parallel;
use rayon::prelude::*;

use crate::{Cancelled, Control, Frame};
use comparison::{Band, Comparison, offsets};
use guides::Guides;

/// Takes noise out of the colours of a frame of so many samples a pixel, and out of what is held back of each colour
/// from behind. Sums over all pixels stay what they were, up to rounding; what has no noise in itself and around stays
/// as it is, to the bit, and no other plane of the frame is changed. Works in parallel ([`parallel`]).
///
/// # Errors
/// [`Cancelled`]; the frame is then what it was before.
pub fn denoise(frame: &mut Frame, samples: u32, control: &Control) -> Result<(), Cancelled> {
    let smooth = || {
        let (color, noise) = speckles::spread(frame);
        let guides = Guides::new(frame, &color, &noise, samples);
        let exchange = Exchange { guides: &guides, size: [frame.width, frame.height], control };
        let whole = exchange.whole()?;
        Ok((exchange.of(&color, &whole)?, exchange.of(&frame.opacities, &whole)?))
    };
    (frame.color, frame.opacities) = parallel(smooth)?;
    Ok(())
}

/// What pixels give each other.
struct Exchange<'a> {
    guides: &'a Guides<'a>,
    size: [usize; 2],
    control: &'a Control<'a>,
}

impl Exchange<'_> {
    /// How much there is like each pixel, itself included.
    fn whole(&self) -> Result<Vec<f32>, Cancelled> {
        self.bands(|_| 1.0, |sum, _, _, weight| *sum += weight)
    }

    /// A plane of the picture after it, given how much there is like each pixel. Of a pixel as much is left as those
    /// that take most of it leave: shares of a pair are the same for both.
    fn of<const N: usize>(&self, plane: &[[f32; N]], whole: &[f32]) -> Result<Vec<[f32; N]>, Cancelled> {
        if plane.is_empty() {
            return Ok(Vec::new());
        }
        self.bands(
            |pixel| plane[pixel],
            |after, own, other, weight| {
                let share = weight / whole[own].max(whole[other]);
                (0..N).for_each(|c| after[c] += share * (plane[other][c] - plane[own][c]));
            },
        )
    }

    /// Begins with a value for each pixel, and adds to it for each that is like it: its own number, the other's and
    /// how alike they are.
    fn bands<T: Send>(
        &self,
        begin: impl Fn(usize) -> T + Sync,
        add: impl Fn(&mut T, usize, usize, f32) + Sync,
    ) -> Result<Vec<T>, Cancelled> {
        let [width, height] = self.size;
        let band = |band: Band| {
            let start = band.first * width;
            let mut values: Vec<T> = (start..start + band.rows * width).map(&begin).collect();
            let mut comparison = Comparison::new(self.guides, band, self.size);
            for offset in offsets() {
                if self.control.is_cancelled() {
                    return Err(Cancelled);
                }
                comparison.pairs(offset, |own, other, weight| add(&mut values[own - start], own, other, weight));
            }
            Ok(values)
        };
        let bands = Band::all(height).into_par_iter().map(band).collect::<Result<Vec<_>, _>>()?;
        Ok(bands.into_iter().flatten().collect())
    }
}

//! Pre-integration: the light of a whole segment of the ray, looked up by the values at its ends
//! (4.5, 4.6).
//!
//! Between two samples the data are taken as linear; the transfer function is integrated over
//! them beforehand, so that a peak narrower than the step between two samples is not missed.

use pellucid_field::parallel;
use rayon::prelude::*;

use crate::error::checked;
use crate::opacity::opacity_from_extinction;
use crate::segment::{Cells, Medium, Segment};
use crate::{DataRange, Nodes, OpticsError, TransferFunction, correct_associated, correct_segment, over};

/// Associated linear RGB and opacity of a segment, by the data values at its front (the end
/// nearer to the eye) and its back.
///
/// All segments of a table have one length, given in unit distances. Other lengths are made of the entries of a segment
/// and of its reverse by [`correct_segment`] (7.3-4).
#[derive(Clone, Debug, PartialEq)]
pub struct PreIntegration {
    nodes: Nodes,
    /// `entries[front + count * back]`.
    entries: Vec<[f32; 4]>,
}

impl PreIntegration {
    /// The smallest and the largest number of nodes per side.
    pub const SIZES: std::ops::RangeInclusive<usize> = 64..=1024;

    /// The full table: light attenuated on its way through the segment (4.5-5), with extinction
    /// `-ln(1 - opacity)` per unit distance and the light of the medium in proportion to it (4.5-2).
    ///
    /// `size` nodes per side over `domain`; `ratio` is the length of a segment in unit distances.
    /// The curves are integrated between the nodes at least at 2048 places and from control point
    /// to control point, so that no peak is lost, however narrow.
    ///
    /// # Errors
    /// [`OpticsError::Parameter`] for a size outside [`SIZES`](Self::SIZES) or a ratio that is
    /// negative or not finite; [`OpticsError::Interval`] as [`Nodes::new`].
    pub fn build(tf: &TransferFunction, domain: [f64; 2], size: usize, ratio: f64) -> Result<Self, OpticsError> {
        let nodes = Self::nodes_for(domain, size, ratio)?;
        let medium = Medium::new(tf, &nodes, 2048usize.div_ceil(size));
        let cells = size - 1;
        // Segments that span `span` cells have `ratio / span` unit distances per cell: they are
        // composed of the same cells, each window in constant time.
        let of_span = |span: usize| {
            let (ascending, descending) = medium.cells(ratio / span as f64);
            [windows(&ascending, span, Segment::then), windows(&descending, span, |a, b| b.then(a))]
        };
        let spans: Vec<[Vec<Segment>; 2]> = parallel(|| (1..=cells).into_par_iter().map(of_span).collect());
        let entry = |front: usize, back: usize| match front.cmp(&back) {
            std::cmp::Ordering::Less => spans[back - front - 1][0][front].to_entry(),
            std::cmp::Ordering::Greater => spans[front - back - 1][1][back].to_entry(),
            std::cmp::Ordering::Equal => constant(tf, nodes.value(front), ratio),
        };
        Ok(Self::fill(&nodes, entry))
    }

    /// The quick table, from the integrals of the curves alone (4.5-4): the opacity is exact, the
    /// colour is the mean along the segment, weighted by extinction.
    ///
    /// What is neglected is the order of colours within a segment: the front ones hide those
    /// behind. A colour that rises linearly from zero is too bright by the relative error `t / 6`
    /// for small optical depths t; a constant colour has none. (The book's form scales the colour
    /// with t instead of the opacity `1 - e^-t`: too bright by `t / 2` even for a constant colour,
    /// and without bound for opaque media.)
    ///
    /// # Errors
    /// As [`PreIntegration::build`].
    pub fn fast(tf: &TransferFunction, domain: [f64; 2], size: usize, ratio: f64) -> Result<Self, OpticsError> {
        let nodes = Self::nodes_for(domain, size, ratio)?;
        let integrals = Medium::new(tf, &nodes, 2048usize.div_ceil(size)).integrals();
        let entry = |front: usize, back: usize| {
            if front == back {
                return constant(tf, nodes.value(front), ratio);
            }
            let (a, b) = (&integrals[front.min(back)], &integrals[front.max(back)]);
            let depth = b[3] - a[3];
            let alpha = opacity_from_extinction(depth / front.abs_diff(back) as f64, ratio);
            let scale = if depth > 0.0 { alpha / depth } else { 0.0 };
            [0, 1, 2, 3].map(|c| if c == 3 { alpha as f32 } else { ((b[c] - a[c]) * scale) as f32 })
        };
        Ok(Self::fill(&nodes, entry))
    }

    /// The full table for this data: over the values where `tf` varies on it (as
    /// [`Nodes::for_data`]), with 256 even nodes per side for data of up to 256 levels and 512 for
    /// others, if those follow the curve; with up to 512 nodes at its control points and around them if not.
    ///
    /// # Errors
    /// As [`PreIntegration::build`].
    pub fn for_data(tf: &TransferFunction, data: &DataRange, ratio: f64) -> Result<Self, OpticsError> {
        let nodes = Nodes::for_segments(tf, data)?;
        if nodes.knots().is_empty() {
            return Self::build(tf, nodes.domain(), nodes.count(), ratio);
        }
        check_ratio(ratio)?;
        let cells = Cells::new(tf, &nodes);
        // Uneven cells share no windows: every segment is composed of its own.
        let last = nodes.count() - 1;
        let row = |low: usize| (low + 1..=last).map(|high| cells.between(low, high, ratio)).collect();
        let rows: Vec<Vec<[Segment; 2]>> = parallel(|| (0..last).into_par_iter().map(row).collect());
        let entry = |front: usize, back: usize| match front.cmp(&back) {
            std::cmp::Ordering::Less => rows[front][back - front - 1][0].to_entry(),
            std::cmp::Ordering::Greater => rows[back][front - back - 1][1].to_entry(),
            std::cmp::Ordering::Equal => constant(tf, nodes.value(front), ratio),
        };
        Ok(Self::fill(&nodes, entry))
    }

    fn nodes_for(domain: [f64; 2], size: usize, ratio: f64) -> Result<Nodes, OpticsError> {
        let (least, most) = Self::SIZES.into_inner();
        checked("size of a pre-integration table", size as f64, least as f64..=most as f64, "64 to 1024")?;
        check_ratio(ratio)?;
        Nodes::new(domain, size)
    }

    fn fill(nodes: &Nodes, entry: impl Fn(usize, usize) -> [f32; 4] + Sync) -> Self {
        let count = nodes.count();
        let mut entries = vec![[0.0; 4]; count * count];
        let fill = |(back, row): (usize, &mut [[f32; 4]])| {
            row.iter_mut().enumerate().for_each(|(front, place)| *place = entry(front, back));
        };
        parallel(|| entries.par_chunks_mut(count).enumerate().for_each(fill));
        Self { nodes: nodes.clone(), entries }
    }

    /// Where the entries are, on both sides.
    pub fn nodes(&self) -> &Nodes {
        &self.nodes
    }

    /// Entry (front, back) is at `front + count * back`.
    pub fn entries(&self) -> &[[f32; 4]] {
        &self.entries
    }

    /// Associated linear RGB and opacity of a segment from data value `front` to `back`; zero if
    /// either is absent.
    pub fn lookup(&self, front: f32, back: f32) -> [f32; 4] {
        self.over_length(front, back, 1.0)
    }

    /// The same of a segment that has `length` times the length of the table's.
    ///
    /// The parts of a segment beyond the domain, where the medium is constant, are composed with
    /// the part within, each with its own share of the length.
    pub fn over_length(&self, front: f32, back: f32, length: f32) -> [f32; 4] {
        if !(front.is_finite() && back.is_finite()) {
            return [0.0; 4];
        }
        let [low, high] = self.nodes.ends();
        let inside = [front, back].map(|value| value.clamp(low, high));
        let [x, y] = inside.map(|value| self.nodes.clamped_position(value));
        let part = |ratio: f32| match ratio {
            1.0 => self.bilinear(x, y),
            _ => correct_segment(self.bilinear(x, y), self.bilinear(y, x), ratio),
        };
        if [front, back] == inside || inside[0] == inside[1] {
            return part(length);
        }
        let whole = (back - front).abs();
        let shares = [(front - inside[0]).abs() / whole, (back - inside[1]).abs() / whole];
        let constant = |at: f32, share: f32| correct_associated(self.bilinear(at, at), share * length);
        over(over(constant(x, shares[0]), part((1.0 - shares[0] - shares[1]) * length)), constant(y, shares[1]))
    }

    fn bilinear(&self, front: f32, back: f32) -> [f32; 4] {
        let ((x, s), (y, t)) = (self.nodes.cell(front), self.nodes.cell(back));
        let at = x + self.nodes.count() * y;
        let rows = [&self.entries[at..at + 2], &self.entries[at + self.nodes.count()..][..2]];
        std::array::from_fn(|channel| {
            let [near, far] = rows.map(|row| row[0][channel] + (row[1][channel] - row[0][channel]) * s);
            near + (far - near) * t
        })
    }
}

fn check_ratio(ratio: f64) -> Result<(), OpticsError> {
    checked("segment in unit distances", ratio, 0.0..=f32::MAX as f64, "0 or more")
}

/// A segment without change of value: what post-classification gives (4.6-1).
fn constant(tf: &TransferFunction, value: f64, ratio: f64) -> [f32; 4] {
    let alpha = crate::correct_opacity(tf.opacity(value), ratio as f32);
    let [r, g, b] = tf.color(value);
    [r * alpha, g * alpha, b * alpha, alpha]
}

/// The composition of every run of `span` neighbours, in order: each item is the end of one run
/// of a block of `span` and the beginning of the next, so two compositions per item suffice
/// (van Herk 1992, for any associative operation).
fn windows(items: &[Segment], span: usize, compose: impl Fn(Segment, Segment) -> Segment) -> Vec<Segment> {
    let mut from_start = items.to_vec();
    for block in from_start.chunks_mut(span) {
        for i in 1..block.len() {
            block[i] = compose(block[i - 1], block[i]);
        }
    }
    let mut to_end = items.to_vec();
    for block in to_end.chunks_mut(span) {
        for i in (1..block.len()).rev() {
            block[i - 1] = compose(block[i - 1], block[i]);
        }
    }
    (0..=items.len() - span)
        .map(|first| {
            // A run that is a whole block is in both lists: composing them would count it twice.
            if first % span == 0 { to_end[first] } else { compose(to_end[first], from_start[first + span - 1]) }
        })
        .collect()
}

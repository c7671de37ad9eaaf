//! Which nodes a transfer function needs on some data.

use crate::curves::{Curves, Off, inner, largest};
use crate::knots::{Break, Knots, breaks};
use crate::{DataRange, Nodes, OpticsError, TransferFunction};

/// What straight lines between even nodes may be off by in opacity, in shares of the largest.
const OPACITY: f32 = 1.0 / 8192.0;
/// And in colour: a step of 8 bits.
const COLOR: f32 = 1.0 / 256.0;

impl Nodes {
    /// Nodes that represent `tf` on this data.
    ///
    /// The domain is where the function varies on the data: its hull within the data's range. Where evenly spaced
    /// nodes will do they are taken, with one beyond either end, because they are found fastest:
    ///
    /// - Integer data of up to 65,536 levels there have a node at every level, so a table is
    ///   exact at every voxel; where that makes fewer than 256 nodes, each level is subdivided
    ///   evenly.
    /// - For other data nodes are doubled from 256 until the largest deviation between table and
    ///   curve is below 1/8192, or 16,384 (256 KiB: in second-level cache) are reached.
    ///
    /// Where that is off by more than 1/8192 in opacity or 1/256 in colour, between levels too, as it is if the
    /// function jumps or has a part that is narrow for its domain, there is a node at every control point, two at a
    /// jump, and as many between them as their colours need. Nothing is too narrow for these but what single precision
    /// cannot tell apart.
    ///
    /// # Errors
    /// [`OpticsError::Interval`] if the data's range is not finite.
    pub fn for_data(tf: &TransferFunction, data: &DataRange) -> Result<Self, OpticsError> {
        let (hull, range) = (data.hull(tf)?, [data.low, data.high]);
        let curves = Curves::of(tf);
        if curves.jump_within(hull)
            && let Some(nodes) = Self::at_points(tf, curves, hull)
        {
            return Ok(nodes);
        }
        let even = match data.level_spacing {
            Some(spacing) if spacing > 0.0 => Self::at_levels(hull, range, spacing),
            _ => None,
        };
        let even = even.map_or_else(|| Self::by_error(tf, curves, hull, range), Ok)?;
        let nodes = if even.follow(tf, curves) { None } else { Self::at_points(tf, curves, hull) };
        Ok(nodes.unwrap_or(even))
    }

    /// Nodes of a table of segments for this data, by the values at both ends.
    ///
    /// Integrals from a value beside a control point to one beyond it change within the distance to that point: where
    /// even nodes do not follow the curve (see [`for_data`](Self::for_data)), there are nodes at the control points
    /// and, away from these, in distances that grow with the distance.
    ///
    /// # Errors
    /// As [`for_data`](Self::for_data).
    pub(crate) fn for_segments(tf: &TransferFunction, data: &DataRange) -> Result<Self, OpticsError> {
        let hull = data.hull(tf)?;
        let levels = data.level_spacing.map_or(f64::INFINITY, |spacing| (data.high - data.low) / spacing + 1.0);
        let even = |domain| Self::new(domain, if levels <= 256.0 { 256 } else { 512 });
        let curves = Curves::of(tf);
        if !curves.jump_within(hull) {
            let nodes = even(Self::for_data(tf, data)?.domain())?;
            if nodes.follow(tf, curves) {
                return Ok(nodes);
            }
        }
        let opacities: Vec<f64> = tf.opacities().iter().map(|point| point.value).collect();
        // Finer, unless there are too many points.
        let choices = [(&tf.values(), 8.0), (&tf.values(), 2.0), (&opacities, 2.0)];
        let graded = choices.into_iter().find_map(|(values, part)| Self::graded(&breaks(curves, values, hull), part));
        // A hull of a single value, or more control points than there are nodes.
        let fallback = || if hull[0] < hull[1] { hull } else { [data.low, data.high] };
        graded.map_or_else(|| even(fallback()), Ok)
    }

    /// A node at every level of integer data, if they are few enough.
    fn at_levels(hull: [f64; 2], range: [f64; 2], spacing: f64) -> Option<Self> {
        // Levels counted from the lowest data value, which is one of them.
        let last = ((range[1] - range[0]) / spacing).round();
        // The tolerance counts an end that is on a level, but for rounding, as being on it.
        let first_needed = (((hull[0] - range[0]) / spacing - 1e-6).ceil() - 1.0).max(0.0);
        let last_needed = (((hull[1] - range[0]) / spacing + 1e-6).floor() + 1.0).min(last);
        let steps = last_needed - first_needed;
        if steps + 1.0 > Self::MOST as f64 {
            return None;
        }
        let steps = (steps as usize).max(1);
        let subdivision = (Self::FEWEST - 1).div_ceil(steps);
        let low = range[0] + first_needed * spacing;
        Self::new([low, low + steps as f64 * spacing], steps * subdivision + 1).ok()
    }

    fn by_error(tf: &TransferFunction, curves: Curves, hull: [f64; 2], range: [f64; 2]) -> Result<Self, OpticsError> {
        const MOST: usize = 16_384;
        let mut count = Self::FEWEST;
        loop {
            let pad = (hull[1] - hull[0]) / (count - 3) as f64;
            let domain = if pad > 0.0 { [hull[0] - pad, hull[1] + pad] } else { range };
            let nodes = Self::new(domain, count)?;
            let [color, opacity] = nodes.error(tf, curves);
            if count == MOST || color.max(opacity) <= OPACITY {
                return Ok(nodes);
            }
            count *= 2;
        }
    }

    /// Whether straight lines between these nodes are near enough to the curves.
    fn follow(&self, tf: &TransferFunction, curves: Curves) -> bool {
        let [color, opacity] = self.error(tf, curves);
        color <= COLOR && opacity <= OPACITY
    }

    /// The largest deviations, of colours and of opacity, between the curves of `tf` and their straight lines between
    /// these even nodes, looked for where they can be: at every control point and between them.
    fn error(&self, tf: &TransferFunction, curves: Curves) -> Off {
        let [low, high] = self.domain();
        let (cells, width) = ((self.count() - 1) as f64, high - low);
        let deviation = |value: f64| {
            let cell = ((value - low) / width * cells).floor().clamp(0.0, cells - 1.0) as usize;
            curves.off_chord([self.value(cell), self.value(cell + 1)], value)
        };
        let values: Vec<f64> = tf.values().into_iter().filter(|value| (low..=high).contains(value)).collect();
        let between = values.windows(2).flat_map(|pair| inner(pair[0], pair[1]));
        let cell_centers = between.map(|value| low + (((value - low) / width * cells).floor() + 0.5) / cells * width);
        values.iter().copied().chain(cell_centers).map(deviation).fold([0.0; 2], largest)
    }

    /// Nodes at every control point, with as many between two as their straight lines need; `None` if there are more
    /// points than nodes.
    fn at_points(tf: &TransferFunction, curves: Curves, hull: [f64; 2]) -> Option<Self> {
        // Opacities of steps bend where those of the unit distance do not: some nodes are needed on any slope.
        const ANY: std::ops::RangeInclusive<usize> = 64..=512;
        const FAST: usize = 4096;
        const MOST: usize = 16_384;
        let breaks = breaks(curves, &tf.values(), hull);
        let sloping = |pair: &[Break]| {
            let [from, to] = [pair[0].value, pair[1].value];
            !pair[1].is_jump && inner(from, to).into_iter().chain([to]).any(|value| curves.differ(from, value))
        };
        let slopes = breaks.windows(2).filter(|pair| sloping(pair)).count().max(1);
        let room = ((Self::MOST - breaks.len().min(Self::MOST)) / slopes).max(1);
        let start = (FAST / slopes).clamp(*ANY.start(), *ANY.end()).min(room);
        let cells = |pair: &[Break]| {
            if !sloping(pair) {
                return 1;
            }
            let [from, to] = [pair[0].value, pair[1].value];
            let mut cells = start;
            while 2 * cells * slopes <= MOST {
                let width = (to - from) / cells as f64;
                let center = |value: f64| from + (((value - from) / width).floor() + 0.5) * width;
                let off = inner(from, to).map(|value| {
                    let middle = center(value);
                    curves.off_chord([middle - 0.5 * width, middle + 0.5 * width], middle)
                });
                let [color, opacity] = off.into_iter().fold([0.0; 2], largest);
                if color.max(opacity) <= OPACITY {
                    break;
                }
                cells *= 2;
            }
            cells
        };
        let cells: Vec<usize> = breaks.windows(2).map(cells).collect();
        Knots::new(breaks, &cells).map(Self::from)
    }

    /// Nodes at breaks, and between them in distances that double with the distance from the nearest, from a
    /// part of the shorter of the two stretches that meet there; `None` if that makes too many nodes.
    fn graded(breaks: &[Break], part: f64) -> Option<Self> {
        // A table of 1 MiB, unless that is too coarse.
        const SIZES: [usize; 2] = [256, 512];
        const FEW: usize = 4;
        const MANY: usize = 32;
        let stretches: Vec<&[Break]> = breaks.windows(2).filter(|pair| !pair[1].is_jump).collect();
        let width = |i: usize| stretches.get(i).map_or(f64::INFINITY, |pair| pair[1].value - pair[0].value);
        let mut graded: Vec<Break> = Vec::new();
        for (i, pair) in stretches.iter().enumerate() {
            let ([from, to], half) = ([pair[0].value, pair[1].value], 0.5 * width(i));
            let scales = [i.checked_sub(1), Some(i + 1)].map(|next| next.map_or(width(i), width).min(width(i)) / part);
            let ahead = octaves(scales[0], half).into_iter().map(|d| from + d);
            let behind = octaves(scales[1], half).into_iter().rev().map(|d| to - d);
            let between = ahead.chain([from + half]).chain(behind);
            let between = between.map(|value| Break { value, address: value as f32, is_jump: false });
            for here in std::iter::once(pair[0]).chain(between) {
                let is_apart = |other: &Break| (other.address - here.address).abs() >= f32::MIN_POSITIVE;
                if graded.last().is_none_or(is_apart) && is_apart(&pair[1]) {
                    graded.push(here);
                }
            }
            graded.push(pair[1]);
        }
        // Jumps at the ends.
        if breaks.get(1)?.is_jump {
            graded.splice(..0, breaks[..2 - usize::from(!graded.is_empty())].iter().copied());
        }
        if graded.last() != breaks.last() {
            graded.extend(breaks.last());
        }
        let jumps = graded.iter().skip(1).filter(|here| here.is_jump).count();
        let stretches = graded.len().saturating_sub(1 + jumps).max(1);
        let each = SIZES.map(|size| (size - 1).saturating_sub(jumps) / stretches);
        let each = if each[0] >= FEW { each[0].min(MANY) } else { each[1].min(FEW) };
        let cells: Vec<usize> = graded.iter().skip(1).map(|here| if here.is_jump { 1 } else { each }).collect();
        if each == 0 { None } else { Knots::new(graded, &cells).map(Self::from) }
    }
}

impl DataRange {
    /// Where a function varies within the range.
    fn hull(&self, tf: &TransferFunction) -> Result<[f64; 2], OpticsError> {
        let found = [self.low, self.high];
        if !(self.low <= self.high && self.low.is_finite() && self.high.is_finite()) {
            return Err(OpticsError::Interval { name: "range of the data", found, expected: "not below" });
        }
        Ok(tf.hull().map(|end| end.clamp(self.low, self.high)))
    }
}

/// Distances 1, 3, 7, 15, ... times a scale that are well below a limit.
fn octaves(scale: f64, limit: f64) -> Vec<f64> {
    const MOST: i32 = 300;
    (1..MOST).map(|octave| scale * (f64::from(octave).exp2() - 1.0)).take_while(|d| *d < 0.75 * limit).collect()
}

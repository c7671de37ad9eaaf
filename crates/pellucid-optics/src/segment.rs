//! The medium along a segment whose data value changes linearly, in double precision.

use crate::opacity::{advance, extinction};
use crate::{Nodes, TransferFunction};

/// Extinction per unit distance that stands for opacity 1, where it is infinite: nothing is seen
/// through a ten-thousandth of the unit distance. Larger numbers would cost the sums their last places.
const OPAQUE: f64 = 1e6;

/// Associated colour and transparency of a piece of a ray.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Segment {
    color: [f64; 3],
    transparency: f64,
}

impl Segment {
    const EMPTY: Self = Self { color: [0.0; 3], transparency: 1.0 };

    /// This piece in front of the `next` one.
    #[inline(always)]
    pub(crate) fn then(self, next: Self) -> Self {
        Self {
            color: std::array::from_fn(|c| self.color[c] + self.transparency * next.color[c]),
            transparency: self.transparency * next.transparency,
        }
    }

    pub(crate) fn to_entry(self) -> [f32; 4] {
        let [r, g, b] = self.color;
        [r as f32, g as f32, b as f32, (1.0 - self.transparency) as f32]
    }
}

/// A transfer function between even nodes: extinction and colour of evenly spaced pieces of each cell.
pub(crate) struct Medium {
    pieces: Vec<Piece>,
    per_cell: usize,
}

/// Mean extinction per unit distance, and the mean colour weighted by it.
#[derive(Clone, Copy)]
struct Piece {
    extinction: f64,
    color: [f64; 3],
}

impl Medium {
    /// The medium in `per_cell` pieces between any two neighbouring nodes.
    pub(crate) fn new(tf: &TransferFunction, nodes: &Nodes, per_cell: usize) -> Self {
        let count = (nodes.count() - 1) * per_cell;
        let [low, high] = nodes.domain();
        let edge = |i: usize| low + (high - low) * (i as f64 / count as f64);
        let breaks = tf.values();
        let pieces = (0..count).map(|i| Piece::between(tf, &breaks, edge(i), edge(i + 1))).collect();
        Self { pieces, per_cell }
    }

    /// Every cell as a segment of `length` unit distances, crossed from its lower to its upper
    /// node and the other way.
    pub(crate) fn cells(&self, length: f64) -> (Vec<Segment>, Vec<Segment>) {
        let length = length / self.per_cell as f64;
        self.pieces
            .chunks(self.per_cell)
            .map(|cell| {
                cell.iter().fold((Segment::EMPTY, Segment::EMPTY), |(ascending, descending), piece| {
                    let transparency = (-piece.extinction * length).exp();
                    let alpha = 1.0 - transparency;
                    let segment = Segment { color: piece.color.map(|v| v * alpha), transparency };
                    (ascending.then(segment), segment.then(descending))
                })
            })
            .unzip()
    }

    /// Integrals from the first node to every node, in units of cells: of extinction times
    /// colour, and of extinction (in the last place).
    pub(crate) fn integrals(&self) -> Vec<[f64; 4]> {
        let mut sum = [0.0; 4];
        let mut integrals = vec![sum];
        for cell in self.pieces.chunks(self.per_cell) {
            for piece in cell {
                let depth = piece.extinction / self.per_cell as f64;
                let [r, g, b] = piece.color.map(|v| v * depth);
                sum = [sum[0] + r, sum[1] + g, sum[2] + b, sum[3] + depth];
            }
            integrals.push(sum);
        }
        integrals
    }
}

/// A transfer function between nodes that are anywhere: the medium in each cell.
pub(crate) struct Cells {
    nodes: Vec<f64>,
    cells: Vec<Cell>,
}

/// A cell, whose colour changes along its optical depth from one end to the other.
struct Cell {
    piece: Piece,
    ends: [[f64; 3]; 2],
}

impl Cells {
    /// The medium between any two neighbouring nodes.
    pub(crate) fn new(tf: &TransferFunction, nodes: &Nodes) -> Self {
        let breaks = tf.values();
        let nodes: Vec<f64> = (0..nodes.count()).map(|node| nodes.value(node)).collect();
        let color = |value: f64| tf.color(value).map(f64::from);
        let cell = |ends: &[f64]| Cell {
            piece: Piece::between(tf, &breaks, ends[0], ends[1]),
            ends: [color(ends[0]), color(ends[1])],
        };
        let cells = nodes.windows(2).map(cell).collect();
        Self { nodes, cells }
    }

    /// Segments of `length` unit distances from node `low` to node `high` and the other way.
    pub(crate) fn between(&self, low: usize, high: usize, length: f64) -> [Segment; 2] {
        let per_value = length / (self.nodes[high] - self.nodes[low]);
        let (mut ascending, mut descending) = (Segment::EMPTY, Segment::EMPTY);
        for (cell, ends) in self.cells[low..high].iter().zip(self.nodes[low..=high].windows(2)) {
            if cell.piece.extinction > 0.0 {
                let [up, down] = cell.both_ways((ends[1] - ends[0]) * per_value);
                (ascending, descending) = (ascending.then(up), down.then(descending));
            }
        }
        [ascending, descending]
    }
}

impl Cell {
    /// This, of a length in unit distances, from its lower to its upper end and the other way.
    fn both_ways(&self, length: f64) -> [Segment; 2] {
        let depth = self.piece.extinction * length;
        let (transparency, ahead) = ((-depth).exp(), advance(depth));
        let color = |from: &[f64; 3], to: &[f64; 3]| {
            std::array::from_fn(|c| {
                let color = self.piece.color[c] + (from[c] - to[c]) * ahead;
                color.clamp(from[c].min(to[c]), from[c].max(to[c])) * (1.0 - transparency)
            })
        };
        let [low, high] = &self.ends;
        [color(low, high), color(high, low)].map(|color| Segment { color, transparency })
    }
}

impl Piece {
    /// Integrates from control point to control point, so that nothing narrow is missed, with
    /// Gauss's three points, which never touch the singularity of the extinction at opacity 1.
    fn between(tf: &TransferFunction, breaks: &[f64], low: f64, high: f64) -> Self {
        const GAUSS: [(f64, f64); 3] =
            [(0.112_701_665_379_258_3, 5.0 / 18.0), (0.5, 8.0 / 18.0), (0.887_298_334_620_741_7, 5.0 / 18.0)];
        let inner = breaks.partition_point(|&b| b <= low)..breaks.partition_point(|&b| b < high);
        let edges = breaks.get(inner).unwrap_or_default().iter().copied().chain([high]);
        let mut from = low;
        let (mut depth, mut light) = (0.0, [0.0; 3]);
        for to in edges {
            for (place, weight) in GAUSS {
                let value = from + (to - from) * place;
                let kappa = extinction(tf.opacity(value) as f64, 1.0).min(OPAQUE) * weight * (to - from);
                depth += kappa;
                let color = tf.color(value);
                (0..3).for_each(|c| light[c] += kappa * color[c] as f64);
            }
            from = to;
        }
        let color = if depth > 0.0 { light.map(|v| v / depth) } else { [0.0; 3] };
        Self { extinction: if high > low { depth / (high - low) } else { 0.0 }, color }
    }
}

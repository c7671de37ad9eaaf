//! How fast light is lost, by data value.

use pellucid_optics::{Nodes, Table, extinction};

/// Extinction per world unit at the nodes of a transfer function's table.
pub struct Extinctions {
    nodes: Nodes,
    entries: Vec<f32>,
    unit_distance: f64,
}

/// Full opacity as a path sees it: a unit distance of it lets 6e-8 of the light through, which single
/// precision cannot tell from none.
const MOST_OPACITY: f32 = 1.0 - f32::EPSILON / 2.0;

impl Extinctions {
    /// Those of a table whose opacities hold for `unit_distance` world units.
    pub fn new(table: &Table, unit_distance: f64) -> Self {
        let mut extinctions = Self { nodes: *table.nodes(), entries: Vec::new(), unit_distance };
        extinctions.entries = table.entries().iter().map(|entry| extinctions.of_opacity(entry[3])).collect();
        extinctions
    }

    /// The extinction of an opacity.
    pub fn of_opacity(&self, opacity: f32) -> f32 {
        extinction(f64::from(opacity.min(MOST_OPACITY)), self.unit_distance) as f32
    }

    /// The extinction at a data value; none where the value is absent.
    #[inline(always)]
    pub fn at(&self, value: f32) -> f32 {
        if value.is_nan() {
            return 0.0;
        }
        let position = self.nodes.clamped_position(value);
        let node = (position as i32 as usize).min(self.entries.len() - 2);
        let (from, to) = (self.entries[node], self.entries[node + 1]);
        from + (to - from) * (position - node as i32 as f32)
    }
}

//! How fast light is lost, by data value.

use pellucid_optics::{Nodes, Table, path_extinction};

/// Extinction per world unit at the nodes of a transfer function's table.
pub struct Extinctions {
    nodes: Nodes,
    entries: Vec<f32>,
}

impl Extinctions {
    /// Those of a table whose opacities hold for `unit_distance` world units.
    pub fn new(table: &Table, unit_distance: f64) -> Self {
        let entries = table.entries().iter().map(|entry| path_extinction(entry[3], unit_distance)).collect();
        Self { nodes: table.nodes().clone(), entries }
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

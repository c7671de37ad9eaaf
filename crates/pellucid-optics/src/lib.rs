//! What it looks like: transfer functions, pre-integration, colour, materials and lights, as pure functions and tables.

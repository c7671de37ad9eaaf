//! Volume graphics: scalar fields in, light out.

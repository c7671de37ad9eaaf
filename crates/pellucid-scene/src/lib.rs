//! What to draw: the scene document, its schema, validation and the frame that comes out.

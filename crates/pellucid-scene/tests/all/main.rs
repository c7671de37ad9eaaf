//! The tests of the crate that need no process of their own, in one program: one link instead of many.

mod automatic;
mod camera;
mod denoise;
mod document_errors;
mod empty;
mod frame;
mod framing;
mod look;
mod region;
mod resolve;
mod round_trip;
mod schema;

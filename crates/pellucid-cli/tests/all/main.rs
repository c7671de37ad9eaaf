//! The tests of the command that need no process of their own, in one program: one link instead of many.

#[path = "../common/mod.rs"]
mod common;

mod bake;
mod bench;
mod commands;
mod flags;
mod readme;
mod render;
mod untrusted;
mod words;

//! The tests of the crate that need no process of their own, in one program: one link instead of many.

mod blocks;
mod closed_form;
mod derived;
mod noise;

//! Solver plugins: which there are, and what each says about itself.

pub(crate) mod built_in;
pub(crate) mod describe;
pub(crate) mod discover;

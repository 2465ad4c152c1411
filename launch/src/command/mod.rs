//! One file per command.

pub(crate) mod check;
mod check_picture;
pub(crate) mod completions;
mod conduct;
pub(crate) mod doctor;
mod failure;
pub(crate) mod list;
pub(crate) mod man;
pub(crate) mod new;
pub(crate) mod plugins;
pub(crate) mod report;
mod resume;
pub(crate) mod run;
pub(crate) mod solver;
pub(crate) mod splat;
pub(crate) mod study;

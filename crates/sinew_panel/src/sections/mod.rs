//! The sections of the panel, one file each: what they show, and which public resource or component they write.

mod files;
mod plots;
mod report;
mod selected;
mod solver;
mod surroundings;
mod time;

pub(crate) use files::files;
pub(crate) use plots::plots;
pub(crate) use report::{has_lines, lines, report};
pub(crate) use selected::selected;
pub(crate) use solver::solver;
pub(crate) use surroundings::surroundings;
pub(crate) use time::time;

//! A fit of a measured profile: summary, pictures and a report.

mod pictures;
mod report;
mod summary;

pub use pictures::{Profiles, Slices};
pub use report::write_report;
pub use summary::{Measured, Summary};

//! `lab/`, a workspace of its own: experiments and measurements that no crate of the product needs.

use crate::run::{Report, cargo};
use std::path::Path;

/// Its format, clippy and fast tests, and the slow ones on request: simulations of 270 million photons.
pub fn check(root: &Path, report: &mut Report, slow: bool) -> Result<(), String> {
    let lab = root.join("lab");
    report.step("lab: format", 0.5, || cargo(&lab, &["fmt", "--check"]))?;
    report.step("lab: clippy", 10.0, || {
        cargo(&lab, &["clippy", "--quiet", "--all-targets", "--all-features", "--", "-D", "warnings"])
    })?;
    report.step("lab: fast tests", 15.0, || cargo(&lab, &["test", "--quiet", "--all-features"]))?;
    if slow {
        report
            .step("lab: slow tests", 60.0, || cargo(&lab, &["test", "--all-features", "--tests", "--", "--ignored"]))?;
    }
    Ok(())
}

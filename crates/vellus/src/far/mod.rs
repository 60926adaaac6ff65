//! Hits averaged over a window of offsets (Yan et al. 2017, Section 5).

pub(crate) mod gaussian_spans;
pub(crate) mod nodes;
pub(crate) mod points;
pub(crate) mod segments;
pub(crate) mod window_hit;

//! How much a test does: `cargo xtask full` does more than `check` and `test`.

/// `full` in `cargo xtask full`, and `usual` else.
///
/// For the number of samples of a statistical test. Its bound must follow from that number.
pub fn effort<T>(usual: T, full: T) -> T {
    if std::env::var("VELLUS_TIER").is_ok_and(|tier| tier == "full") { full } else { usual }
}

//! The instruction set of the processor.

/// An instruction set that this program was compiled for, but the processor does not have: `AVX2` or `FMA`.
///
/// A program should check this when it starts. Otherwise, the system ends it at the first such instruction.
///
/// ```
/// assert_eq!(vellus::missing_instructions(), None);
/// ```
pub fn missing_instructions() -> Option<&'static str> {
    #[cfg(target_arch = "x86_64")]
    {
        if cfg!(target_feature = "avx2") && !is_x86_feature_detected!("avx2") {
            return Some("AVX2");
        }
        if cfg!(target_feature = "fma") && !is_x86_feature_detected!("fma") {
            return Some("FMA");
        }
    }
    None
}

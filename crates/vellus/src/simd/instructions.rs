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
        static MISSING: std::sync::OnceLock<Option<&str>> = std::sync::OnceLock::new();
        *MISSING.get_or_init(|| {
            let [avx2, fma] = processor();
            if cfg!(target_feature = "avx2") && !avx2 {
                return Some("AVX2");
            }
            (cfg!(target_feature = "fma") && !fma).then_some("FMA")
        })
    }
    #[cfg(not(target_arch = "x86_64"))]
    None
}

/// Whether the processor has AVX2 and FMA, and the system saves their registers.
///
/// `is_x86_feature_detected!` cannot tell: it is a constant for instructions that the compiler may use.
#[cfg(target_arch = "x86_64")]
fn processor() -> [bool; 2] {
    use std::arch::x86_64::{__cpuid, __cpuid_count};
    if __cpuid(0).eax < 13 {
        return [false; 2];
    }
    let features = __cpuid(1).ecx;
    // Leaf 13 has the size of what the system saves: 832 bytes with the upper halves of the AVX registers.
    let saved = features & 1 << 27 != 0 && __cpuid_count(13, 0).ebx >= 832;
    [saved && __cpuid_count(7, 0).ebx & 1 << 5 != 0, saved && features & 1 << 12 != 0]
}

#[cfg(all(test, target_arch = "x86_64"))]
mod tests {
    /// A build for all processors, which `cargo xtask test` makes too, compares with the standard library.
    #[test]
    fn the_processor_has_what_the_standard_library_finds() {
        let [avx2, fma] = super::processor();
        assert_eq!(avx2, is_x86_feature_detected!("avx2"));
        assert_eq!(fma, is_x86_feature_detected!("fma"));
    }
}

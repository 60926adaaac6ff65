//! Memory that a user's number asks for.

/// Whether the system gives this many bytes of memory. Ask before an allocation whose size somebody chose: if it fails,
/// the program is ended.
///
/// A system may promise more than it has, but none promises a multiple of it.
pub fn fits_in_memory(bytes: u64) -> bool {
    let mut probe: Vec<u8> = Vec::new();
    let fits = usize::try_from(bytes).is_ok_and(|bytes| probe.try_reserve_exact(bytes).is_ok());
    // Otherwise, the compiler may leave the allocation out, and its failure too.
    std::hint::black_box(&probe);
    fits
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_no_machine_has_does_not_fit() {
        assert!(fits_in_memory(0) && fits_in_memory(1 << 20));
        // No processor addresses more than 2^57 bytes.
        assert!(!fits_in_memory(1 << 58) && !fits_in_memory(u64::MAX));
    }
}

//! Large arrays with random access, on pages of 2 MB if the operating system provides them. This reduces TLB misses of
//! rays through large scenes. Measured: `docs/notes/2026-11-rendering.md`, "Large pages".
#![allow(unsafe_code, reason = "advice to the system, which changes no memory")]

/// An empty vector with a capacity, on large pages if it is long enough.
pub fn with_capacity<T>(capacity: usize) -> Vec<T> {
    let vector = Vec::with_capacity(capacity);
    #[cfg(target_os = "linux")]
    advise(&vector);
    vector
}

/// The same values, on large pages.
pub fn moved<T: Copy>(values: Vec<T>) -> Vec<T> {
    let mut large = with_capacity(values.len());
    large.extend_from_slice(&values);
    large
}

/// Requests large pages for the capacity of a vector. The memory must be reserved but not yet touched. The system may
/// ignore the request.
#[cfg(target_os = "linux")]
fn advise<T>(vector: &Vec<T>) {
    use rustix::mm::{Advice, madvise};
    const PAGE: usize = 1 << 21;
    let start = vector.as_ptr().addr().next_multiple_of(PAGE);
    let end = (vector.as_ptr().addr() + vector.capacity() * size_of::<T>()) / PAGE * PAGE;
    if start < end {
        let first = vector.as_ptr().with_addr(start).cast_mut().cast();
        // SAFETY: the range lies inside the vector's allocation, and this advice does not change memory.
        let _ = unsafe { madvise(first, end - start, Advice::LinuxHugepage) };
    }
}

/// Prefetches a value that will be read soon.
#[inline(always)]
pub fn fetch<T>(value: &T) {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        let first = std::ptr::from_ref(value).cast::<i8>();
        for line in (0..size_of::<T>()).step_by(64) {
            // SAFETY: the address lies inside the referenced value, and nothing is read.
            unsafe { _mm_prefetch::<_MM_HINT_T0>(first.add(line)) };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values stay the same for vectors with several large pages, and for vectors without.
    #[test]
    fn values_stay() {
        for count in [0, 3, 3_000_000] {
            let values: Vec<u64> = (0..count).map(|i| i * 7).collect();
            assert_eq!(moved(values.clone()), values);
        }
    }
}

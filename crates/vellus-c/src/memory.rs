//! The caller's memory: single values, text, and strided arrays.

use crate::status::{Failure, VellusStatus};
use std::ffi::{CStr, c_char};

/// What a pointer points to.
///
/// # Safety
/// The pointer is null, or valid for reads for the lifetime `'a`.
#[inline]
pub(crate) unsafe fn reference<'a, T>(pointer: *const T, name: &str) -> Result<&'a T, Failure> {
    if !pointer.is_aligned() {
        return Err(Failure::misaligned(name, align_of::<T>()));
    }
    // SAFETY: promised by the caller, and aligned.
    unsafe { pointer.as_ref() }.ok_or_else(|| Failure::null(name))
}

/// A place for a result.
///
/// # Safety
/// The pointer is null, or valid for reads and writes for the lifetime `'a`, and nothing else refers to it.
#[inline]
pub(crate) unsafe fn place<'a, T>(pointer: *mut T, name: &str) -> Result<&'a mut T, Failure> {
    if !pointer.is_aligned() {
        return Err(Failure::misaligned(name, align_of::<T>()));
    }
    // SAFETY: promised by the caller, and aligned.
    unsafe { pointer.as_mut() }.ok_or_else(|| Failure::null(name))
}

/// Text of the caller.
///
/// # Safety
/// The pointer is null, or points to text with a zero byte at its end, valid for the lifetime `'a`.
pub(crate) unsafe fn text<'a>(pointer: *const c_char, name: &str) -> Result<&'a str, Failure> {
    if pointer.is_null() {
        return Err(Failure::null(name));
    }
    // SAFETY: promised by the caller.
    let text = unsafe { CStr::from_ptr(pointer) };
    text.to_str().map_err(|_| Failure::text(format!("{name} is not UTF-8")))
}

/// Numbers that a call reads for each query. `data` points to the first query's numbers, which lie side by side. The
/// numbers of query i are `i * stride` bytes further on. A stride of 0 gives all queries the same numbers.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct VellusInput {
    /// The numbers of the first query.
    pub data: *const f32,
    /// The distance of two queries in bytes: 0, or a multiple of 4 that is at least the size of one query's numbers.
    pub stride: usize,
}

/// Memory that a call writes its results to. `data` points to the first query's place, and that of query i is `i *
/// stride` bytes further on. A null pointer means that this result is not wanted.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct VellusOutput {
    /// The place of the first query.
    pub data: *mut f32,
    /// The distance of two queries in bytes: a multiple of 4 that is at least the size of one query's numbers.
    pub stride: usize,
}

/// As VellusOutput, for the numbers of lobes.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct VellusOutputLobes {
    /// The place of the first query.
    pub data: *mut i32,
    /// The distance of two queries in bytes: a multiple of 4, at least 4.
    pub stride: usize,
}

/// Checks address and stride of an array of `count` queries with `numbers` numbers of four bytes each.
fn check(name: &str, address: usize, stride: usize, numbers: usize, count: usize) -> Result<(), Failure> {
    let fail = |text: String| Err(Failure::new(VellusStatus::Stride, format!("{name}: {text}")));
    if !address.is_multiple_of(4) {
        return fail("the address is not a multiple of 4".to_owned());
    }
    if !stride.is_multiple_of(4) || stride < 4 * numbers {
        return fail(format!("a stride of {stride} bytes is not a multiple of 4 of at least {}", 4 * numbers));
    }
    let last = count.saturating_sub(1).checked_mul(stride).and_then(|size| size.checked_add(4 * numbers));
    if last.is_none_or(|size| isize::try_from(size).is_err()) {
        return fail(format!("{count} queries with a stride of {stride} bytes are larger than the address space"));
    }
    Ok(())
}

/// `N` numbers for each query, checked.
#[derive(Clone, Copy)]
pub(crate) struct Numbers<const N: usize> {
    data: *const f32,
    stride: usize,
    count: usize,
}

impl<const N: usize> Numbers<N> {
    /// # Safety
    /// The pointer is null, or valid for reads of `count` queries as [`VellusInput`] describes them, as long as the
    /// result is used.
    pub(crate) unsafe fn new(input: VellusInput, name: &str, count: usize) -> Result<Self, Failure> {
        let VellusInput { data, stride } = input;
        if data.is_null() {
            return Err(Failure::null(name));
        }
        check(name, data.addr(), if stride == 0 { 4 * N } else { stride }, N, if stride == 0 { 1 } else { count })?;
        Ok(Numbers { data, stride, count })
    }

    /// The numbers of query `i`, or of the last one for an `i` beyond it. `count` must not be 0.
    #[inline]
    pub(crate) fn get(&self, i: usize) -> [f32; N] {
        let i = i.min(self.count - 1);
        // SAFETY: `new` checked alignment and size, and its caller promised that the memory can be read.
        unsafe { self.data.byte_add(i * self.stride).cast::<[f32; N]>().read() }
    }

    /// The numbers of eight queries from `first` on; the last one is repeated.
    #[inline]
    pub(crate) fn eight(&self, first: usize) -> [vellus::wide::f32x8; N] {
        let rows: [[f32; N]; 8] = std::array::from_fn(|lane| self.get(first + lane));
        std::array::from_fn(|k| vellus::wide::f32x8::new(std::array::from_fn(|lane| rows[lane][k])))
    }
}

/// The places of results, `N` of type `T` for each query, checked; or none.
#[derive(Clone, Copy)]
pub(crate) struct Places<T, const N: usize> {
    data: *mut T,
    stride: usize,
    count: usize,
}

impl<T: Copy, const N: usize> Places<T, N> {
    /// # Safety
    /// The pointer is null, or valid for writes of `count` queries of four-byte numbers as [`VellusOutput`] describes
    /// them, as long as the result is used.
    pub(crate) unsafe fn new(data: *mut T, stride: usize, name: &str, count: usize) -> Result<Self, Failure> {
        const { assert!(size_of::<T>() == 4 && align_of::<T>() == 4) };
        if !data.is_null() {
            check(name, data.addr(), stride, N, count)?;
        }
        Ok(Places { data, stride, count })
    }

    pub(crate) fn wanted(&self) -> bool {
        !self.data.is_null()
    }

    /// Writes the result of query `i`, if it is wanted and exists.
    #[inline]
    pub(crate) fn set(&self, i: usize, values: [T; N]) {
        if self.wanted() && i < self.count {
            // SAFETY: `new` checked alignment and size, and its caller promised that the memory can be written.
            unsafe { self.data.byte_add(i * self.stride).cast::<[T; N]>().write(values) }
        }
    }
}

//! The exports of the WebAssembly module that the page `explorer.html` uses. Native builds have them in tests only.
//!
//! There are three. [`vellus_alloc`] returns room for a request of `size` bytes. [`vellus_answer`] reads a request
//! there and returns the address of a response: its length in bytes (u32, little-endian), then the JSON text.
//! [`vellus_free`] releases either. For a response it needs the length of the text plus 4. Plain names such as `free`
//! would replace those of C in a test program.
#![allow(unsafe_code, reason = "memory that a page of JavaScript reads and writes; each use states its contract")]

use std::alloc::{Layout, alloc, dealloc};

/// Bytes before the text of a response.
const HEADER: usize = 4;

/// The layout of a block of bytes, or nothing for an empty or a too large one.
fn layout(size: usize) -> Option<Layout> {
    if size == 0 { None } else { Layout::from_size_align(size, 4).ok() }
}

/// Room for `size` bytes, or null if there is none. [`vellus_free`] releases it.
#[unsafe(no_mangle)]
pub extern "C" fn vellus_alloc(size: usize) -> *mut u8 {
    match layout(size) {
        // SAFETY: the layout's size is not 0.
        Some(layout) => unsafe { alloc(layout) },
        None => std::ptr::null_mut(),
    }
}

/// Releases a block. Null is ignored.
///
/// # Safety
/// `block` came from [`vellus_alloc`] or [`vellus_answer`] with this size, and was not released before.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vellus_free(block: *mut u8, size: usize) {
    if let (Some(layout), false) = (layout(size), block.is_null()) {
        // SAFETY: the caller keeps the contract.
        unsafe { dealloc(block, layout) }
    }
}

/// Answers the request of `size` bytes at `request`, JSON in UTF-8. Returns a block: the length of the text (u32,
/// little-endian), then the JSON text. Null if there is no memory.
///
/// # Safety
/// `request` points to `size` bytes that nothing else writes during the call, or is null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vellus_answer(request: *const u8, size: usize) -> *mut u8 {
    let bytes = if request.is_null() || size == 0 {
        &[][..]
    } else {
        // SAFETY: the caller keeps the contract.
        unsafe { std::slice::from_raw_parts(request, size) }
    };
    let text = crate::answer(&String::from_utf8_lossy(bytes));
    let Ok(length) = u32::try_from(text.len()) else { return std::ptr::null_mut() };
    let block = vellus_alloc(HEADER + text.len());
    if !block.is_null() {
        // SAFETY: the block has room for the header and the text, and is new, so that nothing overlaps.
        unsafe {
            std::ptr::copy_nonoverlapping(length.to_le_bytes().as_ptr(), block, HEADER);
            std::ptr::copy_nonoverlapping(text.as_ptr(), block.add(HEADER), text.len());
        }
    }
    block
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ask(request: &str) -> String {
        let room = vellus_alloc(request.len());
        assert!(!room.is_null());
        // SAFETY: both blocks come from this crate, and their sizes are those that it states.
        unsafe {
            std::ptr::copy_nonoverlapping(request.as_ptr(), room, request.len());
            let block = vellus_answer(room, request.len());
            vellus_free(room, request.len());
            let mut header = [0; HEADER];
            std::ptr::copy_nonoverlapping(block, header.as_mut_ptr(), HEADER);
            let length = u32::from_le_bytes(header) as usize;
            let text = std::slice::from_raw_parts(block.add(HEADER), length).to_vec();
            vellus_free(block, HEADER + length);
            String::from_utf8(text).unwrap()
        }
    }

    #[test]
    fn a_request_through_memory_gets_the_answer_of_the_library() {
        let request = r#"{"ask":"parameters"}"#;
        assert_eq!(ask(request), crate::answer(request));
        assert!(ask("{").contains("error"));
    }

    #[test]
    fn empty_blocks_and_null_do_nothing() {
        assert!(vellus_alloc(0).is_null() && vellus_alloc(usize::MAX).is_null());
        // SAFETY: null is ignored.
        unsafe {
            vellus_free(std::ptr::null_mut(), 8);
            let block = vellus_answer(std::ptr::null(), 8);
            assert!(!block.is_null());
        }
    }
}

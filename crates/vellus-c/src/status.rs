//! Status codes, messages, versions, and the guard around every function.

use std::cell::RefCell;
use std::ffi::{CStr, CString, c_char};
use std::panic::{AssertUnwindSafe, catch_unwind};
use vellus::missing_instructions;

/// The version of the binary interface. It grows when a function, a struct or a number changes in a way that breaks
/// programs. A program compares it with vellus_abi_version() when it starts.
pub const VELLUS_ABI_VERSION: u32 = 1;

/// The result of a call. After any value but VELLUS_STATUS_OK, vellus_last_error() has a message, and the call has
/// written no result.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VellusStatus {
    /// The call succeeded.
    Ok = 0,
    /// A pointer is null that must not be.
    Null = 1,
    /// A number is not finite or is out of range, or a direction is not a unit vector.
    Range = 2,
    /// Text is not UTF-8, JSON is wrong, a name is unknown, or a parameter has another number of channels.
    Text = 3,
    /// A stride is too small or not a multiple of 4 bytes, an address is not a multiple of the size of what it points
    /// to, or an array is larger than the address space.
    Stride = 4,
    /// The caller's memory for text or rows is too small.
    Space = 5,
    /// The library was built for instructions that this processor does not have.
    Instructions = 6,
    /// A defect of the library. Please report it with the message.
    Internal = 7,
}

/// Why a call failed.
#[derive(Debug)]
pub(crate) struct Failure {
    status: VellusStatus,
    message: String,
}

impl Failure {
    pub(crate) fn new(status: VellusStatus, message: impl Into<String>) -> Self {
        Failure { status, message: message.into() }
    }

    pub(crate) fn null(name: &str) -> Self {
        Failure::new(VellusStatus::Null, format!("{name} is a null pointer"))
    }

    pub(crate) fn range(message: impl Into<String>) -> Self {
        Failure::new(VellusStatus::Range, message)
    }

    /// The same failure, of query `i` of an array.
    pub(crate) fn of_query(self, i: usize) -> Self {
        Failure { message: format!("query {i}: {}", self.message), ..self }
    }

    /// A pointer whose address the machine cannot read numbers from.
    pub(crate) fn misaligned(name: &str, multiple: usize) -> Self {
        Failure::new(VellusStatus::Stride, format!("the address of {name} is not a multiple of {multiple}"))
    }

    pub(crate) fn text(message: impl Into<String>) -> Self {
        Failure::new(VellusStatus::Text, message)
    }
}

impl From<vellus::Error> for Failure {
    fn from(error: vellus::Error) -> Self {
        let status = match error {
            vellus::Error::OutOfRange { .. } => VellusStatus::Range,
            vellus::Error::Table(_) => VellusStatus::Internal,
            _ => VellusStatus::Text,
        };
        Failure::new(status, error.to_string())
    }
}

thread_local! {
    static MESSAGE: RefCell<CString> = RefCell::default();
}

/// Runs the body of a function. It stores the message of a failure, and turns a panic into a status.
pub(crate) fn guard(body: impl FnOnce() -> Result<(), Failure>) -> VellusStatus {
    // Even copying parameters or making a message may take instructions that the processor does not have.
    if missing_instructions().is_some() {
        return VellusStatus::Instructions;
    }
    let failure = match catch_unwind(AssertUnwindSafe(body)) {
        Ok(Ok(())) => return VellusStatus::Ok,
        Ok(Err(failure)) => failure,
        Err(panic) => {
            let text = panic.downcast_ref::<&str>().map(|text| (*text).to_owned());
            let text = text.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_default();
            // A value that panics when it is dropped would take the panic across the boundary.
            std::mem::forget(panic);
            Failure::new(VellusStatus::Internal, format!("a defect of Vellus: {text}"))
        }
    };
    let message = failure.message.replace('\0', "\\0");
    // Both fail only while the thread ends: the message is then lost, and the status is not.
    MESSAGE.try_with(|stored| stored.replace(CString::new(message).unwrap_or_default())).ok();
    failure.status
}

/// The message of the last call that failed on this thread: one line of UTF-8. It is empty before the first failure. It
/// belongs to the library, and stays valid until the next call fails on this thread, or the thread ends. A call that
/// succeeds does not change it.
#[unsafe(no_mangle)]
pub extern "C" fn vellus_last_error() -> *const c_char {
    if missing_instructions().is_some() {
        return c"this library was built for AVX2 and FMA, which the processor does not have".as_ptr();
    }
    MESSAGE.try_with(|stored| stored.borrow().as_ptr()).unwrap_or(c"".as_ptr())
}

/// The VELLUS_ABI_VERSION that the library was built with.
#[unsafe(no_mangle)]
pub extern "C" fn vellus_abi_version() -> u32 {
    VELLUS_ABI_VERSION
}

const VERSION: &CStr = match CStr::from_bytes_with_nul(concat!(env!("CARGO_PKG_VERSION"), "\0").as_bytes()) {
    Ok(version) => version,
    Err(_) => c"",
};

/// The version of Vellus, such as "0.1.0".
#[unsafe(no_mangle)]
pub extern "C" fn vellus_version() -> *const c_char {
    VERSION.as_ptr()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message() -> String {
        // SAFETY: the library's own text, on this thread.
        unsafe { CStr::from_ptr(vellus_last_error()) }.to_str().unwrap().to_owned()
    }

    #[test]
    fn a_panic_becomes_a_status_and_messages_belong_to_a_thread() {
        assert_eq!(message(), "");
        assert_eq!(guard(|| panic!("{}", "lost")), VellusStatus::Internal);
        assert_eq!(message(), "a defect of Vellus: lost");
        std::thread::spawn(|| assert_eq!(message(), "")).join().unwrap();
        assert_eq!(guard(|| Err(Failure::text("a\0b"))), VellusStatus::Text);
        assert_eq!((guard(|| Ok(())), message()), (VellusStatus::Ok, "a\\0b".to_owned()));
    }
}

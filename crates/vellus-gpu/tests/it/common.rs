//! What the tests on a GPU share.

use vellus_gpu::Device;

/// The GPU, or a message that the test is skipped.
pub fn device(test: &str) -> Option<Device> {
    match Device::open() {
        Ok(device) => Some(device),
        Err(e) => {
            println!("skipped: {test}: {e}");
            None
        }
    }
}

//! What the tests on a GPU share.

use vellus_gpu::Device;

/// The GPU, if there is one.
pub fn device() -> Option<Device> {
    vellus_testing::need("gpu", Device::open())
}

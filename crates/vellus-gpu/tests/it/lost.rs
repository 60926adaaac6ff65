//! A GPU that is lost gives an error, never a panic.

use crate::common::device;
use vellus::{Bcsdf, Fiber, Species};
use vellus_gpu::{DeviceError, Queries, Query};

#[test]
fn a_lost_gpu_is_an_error() -> Result<(), Box<dyn std::error::Error>> {
    let Some(device) = device() else { return Ok(()) };
    let fibers = [Bcsdf::new(&Fiber::preset(Species::RedFox))?];
    let queries = Queries::new(&device, &fibers)?;
    let query = Query { wo: [0.0, 1.0, 0.0], wi: [0.0, -1.0, 0.0], ..Query::default() };
    assert_eq!(queries.run(&[query])?.len(), 1);
    device.destroy();
    let lost = queries.run(&[query]);
    assert!(matches!(lost, Err(DeviceError::Lost(_))), "{lost:?}");
    // Whatever comes later fails in the same way.
    let later = Queries::new(&device, &fibers).and_then(|queries| queries.run(&[query]));
    assert!(matches!(later, Err(DeviceError::Lost(_))), "{later:?}");
    Ok(())
}

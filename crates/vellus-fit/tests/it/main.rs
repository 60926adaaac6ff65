//! The integration tests of `vellus-fit`, as one program.

mod calibration;
mod channels;
mod files;
mod fit;
mod joint;
mod models;
mod refit;
mod verdict;

/// A profile of one direction, for what does not depend on the values.
fn any_profile(channels: usize) -> vellus_fit::Profile {
    let point = vellus_fit::Point { theta: 20.0, phi: 0.0, value: [1.0; 3], sigma: None };
    vellus_fit::Profile {
        theta_o: -30.0,
        quantity: vellus_fit::Quantity::FCos,
        channels,
        channel: String::new(),
        blur: [0.0; 2],
        points: vec![point],
        missing: Vec::new(),
        negative: 0,
        simulated: Vec::new(),
    }
}

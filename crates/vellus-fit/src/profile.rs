//! The measurement of one fibre by a goniometer.

use crate::absorption::check_name;
use crate::error::Error;
use crate::least_squares::LEAST_NOISE;
use std::borrow::Borrow;
use std::str::FromStr;

/// What the numbers of a profile are proportional to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Quantity {
    /// f·cos θ. A fixed camera measures this as radiance while the light moves, as the gantry of Yan et al. 2015 does.
    /// A moving detector that sees the whole fibre measures it as power.
    #[default]
    FCos,
    /// f. A moving camera measures this as radiance while the light is fixed.
    F,
}

impl Quantity {
    /// The name used on the command line and in files.
    pub fn name(self) -> &'static str {
        match self {
            Quantity::FCos => "f-cos",
            Quantity::F => "f",
        }
    }

    /// The names of all quantities.
    pub const NAMES: [&str; 2] = ["f-cos", "f"];
}

impl FromStr for Quantity {
    type Err = Error;

    fn from_str(name: &str) -> Result<Self, Error> {
        let found = [Quantity::FCos, Quantity::F].into_iter().find(|q| q.name() == name);
        found.ok_or_else(|| Error::Parameter(format!("expected {}", Quantity::NAMES.join(" or "))))
    }
}

/// One direction and its measured value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// θ of the direction that moves, degrees.
    pub theta: f64,
    /// φ of the direction that moves minus φ of the fixed direction, degrees. 0 is backward, and 180 is straight
    /// through.
    pub phi: f64,
    /// The measured RGB value, above 0, in any unit. Grey profiles only use the first channel.
    pub value: [f64; 3],
    /// The standard deviation of each value, above 0, in the same unit. Either all points of a profile have it, or
    /// none. A fit uses the ratios of these numbers, and finds a common factor.
    pub sigma: Option<[f64; 3]>,
}

/// Light scattered by one fibre, averaged over its width, between one fixed direction and many other directions.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    /// Inclination of the fixed direction, in (−90, 90) degrees. This direction is ω_o of the model.
    pub theta_o: f64,
    /// What the values are proportional to.
    pub quantity: Quantity,
    /// Number of channels: 1 (grey) or 3 (RGB).
    pub channels: usize,
    /// The name of the channel, such as a wavelength, if this grey profile is one of a measurement with any number of
    /// channels. Otherwise empty. [`fit`](crate::fit()) says what the channels of a measurement share.
    pub channel: String,
    /// Full widths over θ and φ, degrees, of the cell over which each value is an average: the aperture of detector
    /// and light. 0 is a single direction. For a round aperture of diameter d, √3/2 d has the same variance.
    pub blur: [f64; 2],
    /// The measured points.
    pub points: Vec<Point>,
    /// Directions without a value: θ and φ in degrees.
    pub missing: Vec<[f64; 2]>,
    /// The number of these that had a negative value in the file.
    pub negative: usize,
    /// What was simulated, if this is a synthetic measurement: names and values of parameters, as in
    /// [`Estimate`](crate::Estimate). A fit does not use them.
    pub simulated: Vec<(String, f64)>,
}

/// The allowed range of the largest value of a profile. The scale is fitted in [1e-30, 1e30]. This leaves a factor of
/// 1e10 for the values of the model.
pub const LARGEST: [f64; 2] = [1e-20, 1e20];

/// Values are constant if the standard deviation of their logarithms is below this. Single precision and the quadrature
/// of the far field cause errors of this size.
const CONSTANT: f64 = LEAST_NOISE;

/// The largest width of a cell, degrees.
pub const WIDEST: f64 = 30.0;

/// The smallest number of directions for a fit: three for each of a dozen parameters.
pub const FEWEST: usize = 36;

/// The most channels of a measurement. The time of a fit grows with their square.
pub const MOST_CHANNELS: usize = 64;

impl Profile {
    /// Checks that the profile has values in range.
    ///
    /// # Errors
    /// [`Error::Profile`] says what is missing or out of range.
    pub fn validate(&self) -> Result<(), Error> {
        let wrong = |what: String| Err(Error::Profile(what));
        if self.points.is_empty() {
            return wrong(match self.missing.len() {
                0 => "there are no measurements in it".to_owned(),
                n => format!("all {n} measurements are missing"),
            });
        }
        if self.theta_o.is_nan() || self.theta_o.abs() >= 90.0 {
            return wrong(format!("theta_o = {} is out of range: it must be in (-90, 90) degrees", self.theta_o));
        }
        check_blur(self.blur)?;
        if !self.channel.is_empty() {
            check_name(&self.channel, std::iter::empty()).map_err(Error::Profile)?;
            if self.channels > 1 {
                return wrong(format!("only grey values have a channel, such as '{}', not RGB", self.channel));
            }
        }
        for p in &self.points {
            check_angles(p.theta, p.phi).map_err(Error::Profile)?;
            if let Some(x) = p.value[..self.channels].iter().find(|x| !(x.is_finite() && **x > 0.0)) {
                return wrong(format!("the value {x} at theta {}, phi {} is not above 0", p.theta, p.phi));
            }
            let sigma = p.sigma.iter().flat_map(|sigma| &sigma[..self.channels]);
            if let Some(x) = sigma.into_iter().find(|x| !(x.is_finite() && **x > 0.0)) {
                return wrong(format!("sigma = {x} at theta {}, phi {} is not above 0", p.theta, p.phi));
            }
            if p.sigma.is_some() != self.points[0].sigma.is_some() {
                return wrong(format!(
                    "only one of the values at theta {}, phi {} and theta {}, phi {} has a sigma: give all of them",
                    self.points[0].theta, self.points[0].phi, p.theta, p.phi
                ));
            }
        }
        let ([low, high], [_, largest]) = (LARGEST, self.range());
        if !(low..=high).contains(&largest) {
            return wrong(format!(
                "the largest value, {largest:e}, is out of range: it must be in [{low:e}, {high:e}]; choose another \
                 unit"
            ));
        }
        for (name, values) in [("theta", self.axis(|p| p.theta)), ("phi", self.axis(|p| p.phi))] {
            if let [only] = values[..] {
                return wrong(format!(
                    "all measurements have the same {name}, {only}: a profile is needed over both theta and phi"
                ));
            }
        }
        if self.points.len() < FEWEST {
            return wrong(format!("{} measurements are too few: {FEWEST} are needed", self.points.len()));
        }
        Ok(())
    }

    /// Checks that the values are not all the same.
    ///
    /// # Errors
    /// [`Error::Profile`] if each channel is a constant.
    pub fn check_varies(&self) -> Result<(), Error> {
        let count = self.points.len() as f64;
        let scatter = |c: usize| {
            let logs = || self.points.iter().map(|p| p.value[c].ln());
            let mean = logs().sum::<f64>() / count;
            (logs().map(|x| (x - mean).powi(2)).sum::<f64>() / count).sqrt()
        };
        if (0..self.channels).all(|c| scatter(c) < CONSTANT) {
            return Err(Error::Profile(format!(
                "all measurements are the same, {:e}, to within {CONSTANT} of it: a constant says nothing about a \
                 fibre; \
                 is the column of the values the right one?",
                self.points[0].value[0]
            )));
        }
        Ok(())
    }

    /// The distinct values of one coordinate, sorted.
    pub fn axis(&self, coordinate: impl Fn(&Point) -> f64) -> Vec<f64> {
        let mut values: Vec<f64> = self.points.iter().map(coordinate).collect();
        values.sort_by(f64::total_cmp);
        values.dedup();
        values
    }

    /// The median of all values.
    pub(crate) fn median(&self) -> f64 {
        let mut values: Vec<f64> = self.points.iter().flat_map(|p| &p.value[..self.channels]).copied().collect();
        let middle = values.len() / 2;
        if values.is_empty() { 1.0 } else { *values.select_nth_unstable_by(middle, f64::total_cmp).1 }
    }

    /// The logarithm of the ratio of the largest to the smallest value.
    pub fn log_range(&self) -> f64 {
        let [low, high] = self.range();
        (high / low).ln()
    }

    /// Smallest and largest value.
    pub fn range(&self) -> [f64; 2] {
        let values = self.points.iter().flat_map(|p| &p.value[..self.channels]);
        values.fold([f64::INFINITY, 0.0], |[low, high], &x| [low.min(x), high.max(x)])
    }
}

/// How many of the profiles are channels of one measurement: all before the first channel that comes again.
pub(crate) fn channels_of<P: Borrow<Profile>>(profiles: &[P]) -> usize {
    let again = |k: &usize| profiles[..*k].iter().any(|p| p.borrow().channel == profiles[*k].borrow().channel);
    (1..profiles.len()).find(again).unwrap_or(profiles.len())
}

/// Checks the widths of the cells.
pub(crate) fn check_blur(blur: [f64; 2]) -> Result<(), Error> {
    match blur.into_iter().find(|x| !(0.0..=WIDEST).contains(x)) {
        Some(x) => Err(Error::Profile(format!("blur = {x} is out of range: it must be in [0, {WIDEST}] degrees"))),
        None => Ok(()),
    }
}

/// Checks a direction in degrees. The error names the angle that is out of range.
pub(crate) fn check_angles(theta: f64, phi: f64) -> Result<(), String> {
    if theta.is_nan() || theta.abs() >= 90.0 {
        return Err(format!("theta = {theta} is out of range: it must be in (-90, 90) degrees"));
    }
    if phi.is_nan() || phi.abs() > 360.0 {
        return Err(format!("phi = {phi} is out of range: it must be in [-360, 360] degrees"));
    }
    Ok(())
}

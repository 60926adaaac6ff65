//! A picture rendered by several methods, each compared with its own converged picture.

use crate::shot::{Converged, FAR, MULTI, Method, NEAR, PUBLISHED, Point, Shot, YAN2015, speedup};
use crate::{Claim, Table, Verdict};
use anyhow::{Context as _, Result};
use vellus_render::Film;

/// The methods that most experiments compare.
pub const METHODS: [Method; 5] = [NEAR, MULTI, FAR, YAN2015, PUBLISHED];

/// A method's error and time at several numbers of samples.
pub struct Measured {
    pub method: Method,
    pub points: Vec<Point>,
    /// The picture with the most samples.
    pub film: Film,
}

impl Measured {
    /// Error and time at the largest number of samples.
    pub fn last(&self) -> Point {
        self.points.last().copied().unwrap_or_else(Point::none)
    }
}

/// All methods, measured.
pub struct Comparison {
    converged: Vec<(Method, Converged)>,
    pub measured: Vec<Measured>,
}

impl Comparison {
    /// Renders converged pictures with two halves of `half` samples each, then measures all methods at 1, 2, 4, …
    /// `most` samples.
    pub fn new(shot: &mut Shot<'_>, methods: &[Method], half: u64, most: u64) -> Result<Self> {
        let targets = methods.iter().filter(|&&method| target(method) == method);
        let converged: Vec<_> =
            targets.map(|&method| Ok((method, shot.converge(method, half)?))).collect::<Result<_>>()?;
        let mut comparison = Comparison { converged, measured: Vec::new() };
        let pairs: Vec<_> = methods.iter().map(|&m| Ok((m, comparison.converged(m)?))).collect::<Result<_>>()?;
        let found = shot.measure(&pairs, most)?;
        let measured = methods.iter().zip(found);
        comparison.measured = measured.map(|(&method, (points, film))| Measured { method, points, film }).collect();
        Ok(comparison)
    }

    /// The picture that a method converges to.
    pub fn converged(&self, method: Method) -> Result<&Converged> {
        let found = self.converged.iter().find(|(m, _)| *m == target(method));
        found.map(|(_, converged)| converged).with_context(|| format!("{} was not converged", method.name))
    }

    /// The methods with converged pictures, and these pictures.
    pub fn all_converged(&self) -> &[(Method, Converged)] {
        &self.converged
    }

    /// The measurements of a method.
    pub fn of(&self, method: Method) -> Result<&Measured> {
        let found = self.measured.iter().find(|measured| measured.method == method);
        found.with_context(|| format!("{} was not measured", method.name))
    }

    /// Error and time of all methods.
    pub fn table(&self) -> Result<Table> {
        let header = ["method", "samples", "processor time, s", "RMSE", "relMSE", "mean of the converged picture"];
        let mut table = Table::new("errors", "Error and time; the methods alternated on the same machine", &header);
        for Measured { method, points, .. } in &self.measured {
            let mean = self.converged(*method)?.mean();
            for point in points {
                table.row([
                    method.name.to_owned(),
                    point.samples.to_string(),
                    format!("{:.3}", point.time),
                    format!("{:.5}", point.rmse()),
                    format!("{:.5}", point.rel_mse.max(0.0)),
                    format!("{mean:.5}"),
                ]);
            }
        }
        Ok(table)
    }

    /// Speed at equal quality against the model of 2015 as published: with traced paths, large tables and its own
    /// sampling.
    pub fn beside_published(&self, method: Method) -> Result<Claim> {
        let (points, published) = (&self.of(method)?.points, &self.of(PUBLISHED)?.points);
        let claim = Claim::not_judged(
            format!("{} reaches the same error sooner than 2015 as published", method.sentence()),
            format!("{:.2} × as fast", speedup(points, published, |p| p.mse)),
            "What was published, in our program and renderer: traced paths, tables of 755 MB, scattered light sampled \
             uniformly. The paper's factor is the one above.",
        );
        Ok(claim.more(parts(points, published)))
    }
}

/// Speed at equal quality of `points` against `others` by relative error, and the two factors of the speed by squared
/// error.
pub fn parts(points: &[Point], others: &[Point]) -> String {
    let relative = speedup(points, others, |p| p.rel_mse);
    let (noise, time) = (ratio(others, points, |p| p.mse), ratio(others, points, |p| p.time));
    format!("By relative error {relative:.2} ×; {noise:.2} × from the noise of a sample, {time:.2} × from its time.")
}

/// Our claim of the time of a multi-scale sample relative to the near field. `view` is "From afar" or the like.
pub fn our_time(view: &str, time: f64) -> Claim {
    let what = format!("{view} multi-scale takes hardly more time than the near field");
    let claim = Claim::new(what, format!("{time:.2} × the time"), time, Verdict::at_most(time, 1.15));
    claim
        .ours("at most 1.15 ×")
        .or_because("Hits after the first use the far field, which takes longer and has less noise.")
}

/// The method with the same converged picture. That of 2015 as published differs by rounding and by interpolation in
/// its tables: less than 0.3 % of the scattered light, far less than the noise of any measured picture.
fn target(method: Method) -> Method {
    if method == PUBLISHED { YAN2015 } else { method }
}

/// The ratio of a quantity of `a` to that of `b`: the geometric mean over the last three points.
pub fn ratio(a: &[Point], b: &[Point], of: impl Fn(&Point) -> f64) -> f64 {
    let last = a.len().min(b.len()).min(3);
    let log = |p: &Point| of(p).max(1e-300).ln();
    let sum: f64 = (1..=last).map(|k| log(&a[a.len() - k]) - log(&b[b.len() - k])).sum();
    (sum / last.max(1) as f64).exp()
}

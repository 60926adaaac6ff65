//! The result of a fit as text, as a fibre file and as JSON.

use crate::text;
use serde_json::{Map, Value, json};
use std::path::Path;
use vellus::ScatterExit;
use vellus_fit::{Absorption, Estimate, Fit, NOISE_LIKE, Part, Point, Profile, Starts, State};
use vellus_models::ModelKind;

/// A difference in χ² of three standard errors.
const SIGNIFICANT: f64 = 9.0;

/// How far an azimuth may be from that of a highlight to count as near it, degrees.
const NEAR: f64 = 30.0;

/// A profile and its file.
#[derive(Clone, Copy)]
pub struct Measured<'a> {
    /// The file of the profile.
    pub path: &'a Path,
    /// The measured profile.
    pub profile: &'a Profile,
}

/// A fit and its profiles.
pub struct Summary<'a> {
    /// The profiles, at least one.
    pub measured: Vec<Measured<'a>>,
    /// The fit.
    pub fit: &'a Fit,
}

/// The value of a parameter, with digits down to a tenth of its error, or with four digits.
pub(super) fn value(e: &Estimate) -> String {
    let text = match e.error {
        Some(error) if (1e-6..1e6).contains(&e.value.abs()) => {
            let digits = (1.0 - error.max(1e-9).log10().floor()).clamp(0.0, 8.0) as usize;
            format!("{:.digits$}", e.value)
        }
        _ => significant(e.value),
    };
    text + e.unit
}

/// A number with four significant digits, without trailing zeros.
pub(super) fn significant(x: f64) -> String {
    if x == 0.0 {
        "0".to_owned()
    } else if (1e-4..1e5).contains(&x.abs()) {
        let digits = (3 - x.abs().log10().floor() as i32).clamp(0, 8) as usize;
        let text = format!("{x:.digits$}");
        if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
    } else {
        format!("{x:.3e}")
    }
}

/// The standard error, with two digits.
pub(super) fn error(e: &Estimate) -> String {
    e.error.map_or(String::new(), |x| {
        let digits = (1.0 - x.max(1e-9).log10().floor()).clamp(0.0, 8.0) as usize;
        if !(1e-6..1e6).contains(&x) { format!("{x:.1e}{}", e.unit) } else { format!("{x:.digits$}{}", e.unit) }
    })
}

/// The 95 % interval.
pub(super) fn interval(e: &Estimate) -> String {
    let end = |x: f64| value(&Estimate { value: x, ..e.clone() });
    e.interval.map_or(String::new(), |[low, high]| format!("{} to {}", end(low), end(high)))
}

/// How the parameter was treated.
pub(super) fn remark(e: &Estimate) -> String {
    match &e.state {
        State::Fixed => "fixed".to_owned(),
        State::Tied(leader) => format!("tied to {leader}"),
        State::AtBound => "at the end of its range".to_owned(),
        State::Fitted if !e.determined => "not determined".to_owned(),
        State::Fitted => String::new(),
    }
}

/// Error and remark, for a comment.
fn note(e: &Estimate) -> String {
    // A parameter that differs between profiles has several values, of which the file contains the first.
    let own = e.name.contains('[').then(|| format!("{} = {}", e.name, value(e)));
    let error = e.error.map(|_| format!("± {}", error(e)));
    let remark = Some(remark(e)).filter(|r| !r.is_empty());
    own.into_iter().chain(error).chain(remark).collect::<Vec<_>>().join(", ")
}

/// The values that fit nearly as well as that of a parameter that the data does not determine.
fn vague(e: &Estimate) -> String {
    // Only angles can be negative.
    let least = if e.unit.is_empty() { 0.0 } else { f64::NEG_INFINITY };
    let range = e.error.filter(|error| error.is_finite()).map(|error| {
        let [low, high] = [(e.value - error).max(least), e.value + error].map(|x| significant(rounded(x, error)));
        format!("values from {low} to {high}{} fit", e.unit)
    });
    let others = range.unwrap_or_else(|| "other values fit".to_owned());
    format!("the data does not determine {}: {others} nearly as well as {}", e.name, value(e))
}

/// A number without the digits below a tenth of its error.
fn rounded(x: f64, error: f64) -> f64 {
    let step = 10f64.powf(error.max(1e-9).log10().floor() - 1.0);
    (x / step).round() * step
}

/// The change of parameters that the data sees least: its share of each, and its standard error in usual ranges.
fn least_certain(shares: &[(String, f64)], error: f64) -> String {
    let first = shares.first().map_or(1.0, |(_, x)| *x);
    let names = |same: bool| {
        let chosen = shares.iter().filter(|(_, x)| (x * first > 0.0) == same);
        chosen.map(|(name, _)| name.as_str()).collect::<Vec<_>>().join(" and ")
    };
    let (with, against) = (names(true), names(false));
    let change = match (shares.len(), against.is_empty()) {
        (0, _) => return "nothing was fitted".to_owned(),
        (1, _) => with,
        (_, true) => format!("more {with} together"),
        (_, false) => format!("more {with} with less {against}"),
    };
    if error < 1.0 {
        format!("{change}: the profile stays nearly the same over {:.0} % of the usual ranges", 100.0 * error)
    } else {
        format!("{change}: the profile stays the same over all of the usual ranges")
    }
}

/// A warning if a highlight is at an inclination that was not measured: then `theta_o` probably has the wrong sign, or
/// is off. All angles are in degrees.
///
/// Light leaves at θ = −θ_o, shifted by α toward the root (R, backward) or by α/2 toward the tip (TT, straight
/// through): Table 2 of the paper, with x from root to tip.
fn hidden_highlight(profile: &Profile, theta_o: f64, alpha: f64) -> Option<String> {
    let highlights: [(&str, f64, f64); 2] = [("R", 0.0, -theta_o - alpha), ("TT", 180.0, -theta_o + 0.5 * alpha)];
    highlights.into_iter().find_map(|(name, phi, theta)| {
        let distance = |p: &Point| ((p.phi - phi + 180.0).rem_euclid(360.0) - 180.0).abs();
        let near = profile.points.iter().filter(|p| distance(p) <= NEAR).map(|p| p.theta);
        let [low, high] =
            near.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], theta| [low.min(theta), high.max(theta)]);
        // Nothing to say without a value near it.
        (low <= high && !(low..=high).contains(&theta)).then(|| {
            let [theta_o, alpha, theta, low, high] = [theta_o, alpha, theta, low, high].map(significant);
            format!(
                "the highlight {name} is outside of the data: theta_o = {theta_o}° and alpha = {alpha}° put it at \
                 theta = {theta}°, and the values near phi = {phi}° are at {low} to {high}°"
            )
        })
    })
}

fn percent(x: f64) -> String {
    format!("{:.2} %", 100.0 * x)
}

impl Summary<'_> {
    /// The profile with this index, the fit, and its result for the profile.
    pub(super) fn part(&self, k: usize) -> (&Profile, &Fit, &Part) {
        (self.measured[k].profile, self.fit, &self.fit.parts[k])
    }

    /// The name of the file of a profile, and its channel.
    pub(super) fn name(&self, k: usize) -> String {
        let Measured { path, profile } = self.measured[k];
        let name = path.file_name().map_or(String::new(), |n| n.to_string_lossy().into_owned());
        if profile.channel.is_empty() { name } else { format!("{name}, channel {}", profile.channel) }
    }

    /// The files of all profiles. The channels of a file are next to each other.
    pub(super) fn files(&self) -> Vec<&Path> {
        let mut files: Vec<&Path> = self.measured.iter().map(|m| m.path).collect();
        files.dedup();
        files
    }

    /// The fitted absorptions, if the profiles are channels.
    pub(super) fn absorptions(&self) -> Vec<Absorption> {
        let profiles: Vec<&Profile> = self.measured.iter().map(|m| m.profile).collect();
        Absorption::fitted(&profiles, &self.fit.parts)
    }

    /// Whether this is a fit of synthetic measurements.
    pub(super) fn is_synthetic(&self) -> bool {
        self.measured.iter().any(|m| !m.profile.simulated.is_empty())
    }

    /// The share that the fit explains. It can be less than that of a constant, because not every model can give
    /// constant profiles.
    fn explained(&self) -> String {
        let share = self.fit.explained.share;
        let much = if share > 0.0 { percent(share) } else { "nothing".to_owned() };
        format!("{much} of the variation of the logarithms")
    }

    /// How scattered light leaves the fitted fibre, for a model that has more than one way.
    fn exit(&self) -> Option<ScatterExit> {
        (self.fit.model == ModelKind::Vellus).then_some(self.fit.specimen.fiber.exit)
    }

    /// The model, and how scattered light leaves the fibre.
    pub(super) fn model(&self) -> String {
        let exit = self.exit().map(|exit| format!(", {exit} exit"));
        format!("{}{}", self.fit.model, exit.unwrap_or_default())
    }

    /// The reason why the fit says nothing about the fibre, or `None` if it does.
    pub fn no_fit(&self) -> Option<String> {
        let fit = self.fit;
        fit.no_fit.map(|why| format!("no fit: {why} (it explains {}, NRMSE {})", self.explained(), percent(fit.nrmse)))
    }

    fn hidden_highlight(&self) -> Option<String> {
        self.fit.parts.iter().enumerate().find_map(|(k, part)| {
            let alpha = f64::from(part.specimen.fiber.alpha).to_degrees();
            let what = hidden_highlight(self.measured[k].profile, part.theta_o, alpha)?;
            Some(if self.measured.len() > 1 { format!("{}: {what}", self.name(k)) } else { what })
        })
    }

    /// The message if there is no fit: the file, the reason (`why`), and the options that may help. `out` is the file
    /// that was not written, and `page` is the report.
    pub fn refusal(&self, why: &str, out: Option<&Path>, page: Option<&Path>) -> String {
        let out = out.map(|out| format!("; {} was not written", out.display())).unwrap_or_default();
        let page = page.map(|page| format!("; {} shows the differences", page.display())).unwrap_or_default();
        let highlight = self.hidden_highlight().map(|what| format!("; {what}")).unwrap_or_default();
        format!(
            "{}: {why}{out}{page}{highlight}. Check the columns of the file, --angles, --quantity and --theta-o, or \
             try another --model. --allow-bad-fit accepts the fit",
            self.files().iter().map(|path| path.display().to_string()).collect::<Vec<_>>().join(", ")
        )
    }

    /// The message of an interrupted fit of this many starts: the `written` files contain the best fit so far.
    pub fn interruption(&self, written: &[String], starts: usize) -> String {
        let place = match written {
            [] => "is printed above".to_owned(),
            files => format!("is in {}", files.join(" and ")),
        };
        let finished = self.fit.starts.finished;
        format!("the best fit after {finished} of {starts} starts {place}; the same command starts from the beginning")
    }

    /// Warnings, one sentence each.
    pub fn warnings(&self) -> Vec<String> {
        let fit = self.fit;
        let mut warnings = Vec::new();
        if fit.interrupted {
            warnings.push("interrupted: this is the best so far, and may be far from the best there is".to_owned());
        }
        warnings.extend(self.no_fit());
        for (k, Measured { profile: Profile { points, missing, negative, .. }, .. }) in self.measured.iter().enumerate()
        {
            if *negative > 0 {
                let all = points.len() + missing.len();
                let name = if self.measured.len() > 1 { format!("{}: ", self.name(k)) } else { String::new() };
                warnings.push(format!("{name}negative values, which count as missing: {negative} of {all} directions"));
            }
        }
        if let Some(what) = self.hidden_highlight() {
            let is_fixed = |e: &Estimate| e.name.starts_with("theta_o") && e.state == State::Fixed;
            let advice = if fit.estimates.iter().any(is_fixed) { ", or fit it (--free theta_o)" } else { "" };
            warnings.push(format!("{what}; check the sign of theta_o{advice}"));
        }
        for e in &fit.estimates {
            match e.state {
                State::Fitted if !e.determined => warnings.push(vague(e)),
                State::AtBound => warnings.push(format!(
                    "{} ended at the end of its range, {}: the data asks for a value beyond it, or does not \
                     determine it",
                    e.name,
                    value(e)
                )),
                _ => {}
            }
        }
        if let Some(rival) = &fit.rival
            && rival.chi2 < SIGNIFICANT
        {
            let values: Vec<String> = fit
                .estimates
                .iter()
                .zip(&rival.values)
                .filter(|(e, _)| e.state == State::Fitted)
                .map(|(e, x)| format!("{} {}", e.name, text::number(*x)))
                .collect();
            warnings.push(format!("another fibre fits as well (χ² worse by {:.1}): {}", rival.chi2, values.join(", ")));
        }
        if fit.widened > NOISE_LIKE {
            warnings.push(format!(
                "the model does not follow the data to within its noise: neighbouring residuals correlate by {:.2} \
                 over φ and {:.2} over θ; standard errors are {:.1} times as large for it, and say nothing about what \
                 a \
                 better model would find",
                fit.neighbours[0], fit.neighbours[1], fit.widened
            ));
        }
        warnings
    }

    /// Names and values of the fit's settings and its quality.
    pub fn lines(&self) -> Vec<(String, String)> {
        let fit = self.fit;
        let Starts { begun, finished, ended_here: same } = fit.starts;
        let outliers = match fit.outliers {
            0 => String::new(),
            n => format!("; {n} of them counted for less"),
        };
        let profiles = self.measured.iter().zip(&fit.parts).map(|(Measured { path, profile }, part)| {
            let [low, high] = profile.range().map(text::number);
            let blur = match profile.blur {
                [0.0, 0.0] => String::new(),
                [theta, phi] => format!(", cells of {theta}° × {phi}°"),
            };
            let color = match (profile.channel.as_str(), profile.channels) {
                ("", 1) => "grey".to_owned(),
                ("", _) => "RGB".to_owned(),
                (name, _) => format!("channel {name}"),
            };
            let line = format!(
                "{}: {} directions, {} missing, {color}, θ_o = {}°, {}{blur}, {low} to {high}, NRMSE {}",
                path.display(),
                profile.points.len(),
                profile.missing.len(),
                profile.theta_o,
                profile.quantity.name(),
                percent(part.nrmse)
            );
            ("profile".to_owned(), line)
        });
        let rest = [
            ("NRMSE".to_owned(), format!("{} of the range", percent(fit.nrmse))),
            ("NRMSE, logarithms".to_owned(), format!("{} of theirs", percent(fit.log_nrmse))),
            ("explained".to_owned(), self.explained()),
            ("scatter".to_owned(), format!("{} of the values{outliers}", percent(fit.noise))),
            (
                "starts".to_owned(),
                format!(
                    "{begun}, of which {finished} were finished and {same} ended here{}",
                    match &fit.rival {
                        Some(rival) => format!("; χ² of the next best minimum is worse by {:.0}", rival.chi2),
                        None => "; no other minimum as good was found".to_owned(),
                    }
                ),
            ),
            ("least certain".to_owned(), least_certain(&fit.weakest.shares, fit.weakest.standard_error)),
        ];
        std::iter::once(("model".to_owned(), self.model())).chain(profiles).chain(rest).collect()
    }

    /// The value that was simulated, if the profile is a synthetic measurement.
    fn simulated(&self, e: &Estimate) -> Option<f64> {
        // `scale[2]` is the scale of the second profile.
        let name = e.name.split('[').next()?;
        let simulated = &self.measured.get(e.profile)?.profile.simulated;
        simulated.iter().find(|(known, _)| known == name).map(|(_, x)| *x)
    }

    /// The same as text, in the unit of the parameter.
    pub(super) fn simulated_text(&self, e: &Estimate) -> String {
        self.simulated(e).map_or(String::new(), |x| significant(x) + e.unit)
    }

    /// A table for readers.
    pub fn table(&self) -> String {
        let mut rows = vec![["", "value", "± 1 s.e.", "95 % interval", "simulated", ""].map(str::to_owned).to_vec()];
        for e in &self.fit.estimates {
            rows.push(vec![e.name.clone(), value(e), error(e), interval(e), self.simulated_text(e), remark(e)]);
        }
        if !self.is_synthetic() {
            rows.iter_mut().for_each(|row| drop(row.remove(4)));
        }
        let mut text = text::align(&rows);
        text.push('\n');
        for (name, what) in self.lines() {
            text += &format!("{name}: {what}\n");
        }
        text
    }

    /// A fibre file. `fiber` is the fitted fibre as TOML; this adds errors, remarks and the summary as comments.
    pub fn toml(&self, fiber: &str) -> String {
        let mut text = String::new();
        if self.fit.interrupted {
            text += "# INTERRUPTED: the best so far\n";
        }
        if self.fit.no_fit.is_some() {
            text += "# NO FIT: do not use this fibre for a measured one\n";
        }
        for (name, what) in self.lines() {
            text += &format!("# {name}: {what}\n");
        }
        for warning in self.warnings() {
            text += &format!("# warning: {warning}\n");
        }
        // The refractive index of the medulla belongs to a model, not to a fibre file. It becomes a comment.
        for e in self.fit.estimates.iter().filter(|e| e.name == "eta_m") {
            text += &format!("# {} = {}  # {}\n", e.name, text::number(e.value), note(e));
        }
        for line in fiber.lines() {
            let name = line.split_once(" = ").map_or("", |(name, _)| name);
            let of = |e: &&Estimate| e.name.split(['.', '[']).next() == Some(name);
            let notes: Vec<String> = self.fit.estimates.iter().filter(of).map(note).collect();
            let notes = if name == "exit" {
                "given".to_owned()
            } else if notes.is_empty() {
                format!("{} has none", self.fit.model)
            } else {
                notes.join("; ")
            };
            text += &format!("{line}  # {notes}\n");
        }
        text
    }

    /// The result as JSON.
    pub fn json(&self) -> Value {
        let fit = self.fit;
        let parameters: Map<String, Value> = fit
            .estimates
            .iter()
            .map(|e| {
                let (state, tied_to) = match &e.state {
                    State::Fitted => ("fitted", None),
                    State::AtBound => ("at bound", None),
                    State::Fixed => ("fixed", None),
                    State::Tied(leader) => ("tied", Some(leader)),
                };
                let unit = if e.unit.is_empty() { Value::Null } else { json!("degrees") };
                let body = json!({"value": e.value, "standard_error": e.error, "interval": e.interval, "unit": unit,
                    "state": state, "tied_to": tied_to, "determined": e.determined, "simulated": self.simulated(e)});
                (e.name.clone(), body)
            })
            .collect();
        let values = |values: &[f64]| -> Map<String, Value> {
            fit.estimates.iter().zip(values).map(|(e, x)| (e.name.clone(), json!(x))).collect()
        };
        let profile = |(Measured { path, profile }, part): (&Measured, &Part)| {
            json!({"file": path, "points": profile.points.len(), "missing": profile.missing.len(),
                "channels": profile.channels, "channel": profile.channel,
                "quantity": profile.quantity.name(), "blur": profile.blur,
                "range": profile.range(), "nrmse": part.nrmse, "log_nrmse": part.log_nrmse})
        };
        let profiles: Vec<Value> = self.measured.iter().zip(&fit.parts).map(profile).collect();
        let weakest: Map<String, Value> = fit.weakest.shares.iter().map(|(name, x)| (name.clone(), json!(x))).collect();
        json!({
            "vellus_version": env!("CARGO_PKG_VERSION"),
            "model": fit.model.name(),
            "exit": self.exit().map(ScatterExit::name),
            "interrupted": fit.interrupted,
            "profiles": profiles,
            "parameters": parameters,
            "correlations": {"names": fit.correlations.names, "matrix": fit.correlations.matrix},
            "nrmse": fit.nrmse,
            "log_nrmse": fit.log_nrmse,
            "explained": fit.explained.share,
            "significance": fit.explained.significance,
            "no_fit": fit.no_fit.map(|why| why.to_string()),
            "scatter": fit.noise,
            "outliers": fit.outliers,
            "neighbour_correlation": {"phi": fit.neighbours[0], "theta": fit.neighbours[1]},
            "errors_widened_by": fit.widened,
            "least_determined": {"direction": weakest, "standard_error": fit.weakest.standard_error},
            "starts": {"begun": fit.starts.begun, "finished": fit.starts.finished, "ended_here": fit.starts.ended_here},
            "rival": fit.rival.as_ref().map(|r| json!({"chi2": r.chi2, "parameters": values(&r.values)})),
            "evaluations": fit.evaluations,
            "warnings": self.warnings(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vellus_fit::Quantity;

    fn estimate(name: &str, value: f64, error: Option<f64>, unit: &'static str) -> Estimate {
        Estimate {
            name: name.to_owned(),
            profile: 0,
            unit,
            value,
            error,
            interval: None,
            state: State::Fitted,
            determined: false,
        }
    }

    #[test]
    fn what_is_not_determined_is_said_in_plain_words() {
        let found = vague(&estimate("sigma_ca", 0.33, Some(0.32), ""));
        assert_eq!(found, "the data does not determine sigma_ca: values from 0.01 to 0.65 fit nearly as well as 0.33");
        // An absorption is not negative, but an angle may be.
        assert!(vague(&estimate("sigma_ca", 0.1, Some(0.4), "")).contains("from 0 to 0.5 fit"));
        assert!(vague(&estimate("alpha", 1.0, Some(4.0), "°")).contains("from -3 to 5° fit"));
        assert!(vague(&estimate("g", 0.5, None, "")).contains(": other values fit nearly as well as 0.5"));
    }

    /// R moves by α one way, TT by α/2 the other way. Azimuths count on the circle.
    #[test]
    fn a_highlight_outside_of_the_data_is_named() {
        let angles = |phi: f64| [10.0, 50.0].map(|theta| Point { theta, phi, value: [1.0; 3], sigma: None });
        let points = [-20.0, 90.0, 170.0, 200.0].into_iter().flat_map(angles).collect();
        let (quantity, simulated) = (Quantity::FCos, Vec::new());
        let (blur, missing) = ([0.0; 2], Vec::new());
        let channel = String::new();
        let profile =
            Profile { theta_o: -30.0, quantity, channels: 1, channel, blur, points, missing, negative: 0, simulated };
        assert_eq!(hidden_highlight(&profile, -30.0, 5.0), None);
        let found = hidden_highlight(&profile, 30.0, 5.0).unwrap();
        let parts = ["highlight R is outside", "theta_o = 30°", "theta = -35°", "phi = 0°", "10 to 50°"];
        assert!(parts.iter().all(|part| found.contains(part)), "{found}");
        // R at −30° + 45° is inside of the data, TT at −52.5° is not.
        assert!(hidden_highlight(&profile, 30.0, -45.0).unwrap().contains("highlight TT"));
        assert!(hidden_highlight(&profile, -14.0, 5.0).unwrap().contains("theta = 9°"));
        let aside = Profile { points: angles(90.0).to_vec(), ..profile };
        assert_eq!(hidden_highlight(&aside, 30.0, 5.0), None);
    }

    #[test]
    fn the_least_certain_change_is_said_in_plain_words() {
        let shares = |x: &[(&str, f64)]| x.iter().map(|(name, x)| ((*name).to_owned(), *x)).collect::<Vec<_>>();
        let found = least_certain(&shares(&[("sigma_ca", -0.7), ("sigma_ma", 0.6), ("g", -0.2)]), 0.343);
        let expected = "more sigma_ca and g with less sigma_ma: the profile stays nearly the same over 34 % of the \
                        usual ranges";
        assert_eq!(found, expected);
        assert!(least_certain(&shares(&[("eta", 1.0)]), 2.0).starts_with("eta: the profile stays the same over all"));
        assert!(least_certain(&shares(&[("a", 1.0), ("b", 1.0)]), 0.1).starts_with("more a and b together: "));
    }
}

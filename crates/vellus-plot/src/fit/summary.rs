//! The result of a fit as text, as a fibre file and as JSON.

use crate::text;
use serde_json::{Map, Value, json};
use std::path::Path;
use vellus::Exit;
use vellus_fit::{Estimate, Fit, NOISE_LIKE, Profile, Starts, State};
use vellus_models::ModelKind;

/// A difference in χ² of three standard errors.
const SIGNIFICANT: f64 = 9.0;

/// A fit and its profile.
pub struct Summary<'a> {
    /// The file of the profile.
    pub path: &'a Path,
    /// The measured profile.
    pub profile: &'a Profile,
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
    let error = e.error.map(|_| format!("± {}", error(e)));
    let remark = Some(remark(e)).filter(|r| !r.is_empty());
    error.into_iter().chain(remark).collect::<Vec<_>>().join(", ")
}

fn percent(x: f64) -> String {
    format!("{:.2} %", 100.0 * x)
}

impl Summary<'_> {
    /// The share that the fit explains. It can be less than that of a constant, because not every model can give
    /// constant profiles.
    fn explained(&self) -> String {
        let share = self.fit.explained.share;
        let much = if share > 0.0 { percent(share) } else { "nothing".to_owned() };
        format!("{much} of the variation of the logarithms")
    }

    /// How scattered light leaves the fitted fibre, for a model that has more than one way.
    fn exit(&self) -> Option<Exit> {
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

    /// The message if there is no fit: the file, the reason (`why`), and the options that may help. `out` is the file
    /// that was not written, and `page` is the report.
    pub fn refusal(&self, why: &str, out: Option<&Path>, page: Option<&Path>) -> String {
        let out = out.map(|out| format!("; {} was not written", out.display())).unwrap_or_default();
        let page = page.map(|page| format!("; {} shows the differences", page.display())).unwrap_or_default();
        format!(
            "{}: {why}{out}{page}. Check the columns of the file, --angles, --quantity and --theta-o, or try another \
             --model. --allow-bad-fit accepts the fit",
            self.path.display()
        )
    }

    /// The message of an interrupted fit of so many starts: the `written` files contain the best fit so far.
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
        let names = |found: &dyn Fn(&&Estimate) -> bool| {
            let named = |e: &Estimate| match error(e) {
                error if error.is_empty() => format!("{} ({})", e.name, value(e)),
                error => format!("{} ({} ± {error})", e.name, value(e)),
            };
            fit.estimates.iter().filter(found).map(named).collect::<Vec<_>>().join(", ")
        };
        let vague = names(&|e| e.state == State::Fitted && !e.determined);
        if !vague.is_empty() {
            warnings.push(format!(
                "the data does not determine {vague}: other values fit nearly as well, because the standard error is \
                 above a tenth of the usual range"
            ));
        }
        let at_bound = names(&|e| e.state == State::AtBound);
        if !at_bound.is_empty() {
            warnings.push(format!("at the end of its range: {at_bound}"));
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
        let (fit, profile) = (self.fit, self.profile);
        let [low, high] = profile.range();
        let Starts { begun, finished, ended_here: same } = fit.starts;
        let outliers = match fit.outliers {
            0 => String::new(),
            n => format!("; {n} of them counted for less"),
        };
        vec![
            ("model".to_owned(), self.model()),
            (
                "profile".to_owned(),
                format!(
                    "{}: {} directions, {} missing, {}, θ_o = {}°, {}",
                    self.path.display(),
                    profile.points.len(),
                    profile.missing.len(),
                    if profile.channels == 1 { "grey" } else { "RGB" },
                    profile.theta_o,
                    profile.quantity.name()
                ),
            ),
            ("measured range".to_owned(), format!("{} to {}", text::number(low), text::number(high))),
            ("NRMSE".to_owned(), format!("{} of that range", percent(fit.nrmse))),
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
            (
                "least determined".to_owned(),
                format!(
                    "{}{}",
                    fit.weakest.shares.iter().map(|(name, x)| format!("{x:+.2} {name}")).collect::<Vec<_>>().join(" "),
                    if fit.weakest.standard_error < 1.0 {
                        format!(", to {} of their usual ranges", percent(fit.weakest.standard_error))
                    } else {
                        ": not at all".to_owned()
                    }
                ),
            ),
        ]
    }

    /// The value that was simulated, if the profile is a synthetic measurement.
    fn simulated(&self, e: &Estimate) -> Option<f64> {
        self.profile.simulated.iter().find(|(name, _)| *name == e.name).map(|(_, x)| *x)
    }

    /// The same as text, in the unit of the parameter.
    pub(super) fn simulated_text(&self, e: &Estimate) -> String {
        self.simulated(e).map_or(String::new(), |x| significant(x) + e.unit)
    }

    /// A table for readers.
    pub fn table(&self) -> String {
        let mut rows = vec![["", "value", "± 1 s.e.", "simulated", ""].map(str::to_owned).to_vec()];
        for e in &self.fit.estimates {
            rows.push(vec![e.name.clone(), value(e), error(e), self.simulated_text(e), remark(e)]);
        }
        if self.profile.simulated.is_empty() {
            rows.iter_mut().for_each(|row| drop(row.remove(3)));
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
            let of = |e: &&Estimate| e.name.split('.').next() == Some(name);
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
        let (fit, profile) = (self.fit, self.profile);
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
                let body = json!({"value": e.value, "standard_error": e.error, "unit": unit, "state": state,
                    "tied_to": tied_to, "determined": e.determined, "simulated": self.simulated(e)});
                (e.name.clone(), body)
            })
            .collect();
        let values = |values: &[f64]| -> Map<String, Value> {
            fit.estimates.iter().zip(values).map(|(e, x)| (e.name.clone(), json!(x))).collect()
        };
        let weakest: Map<String, Value> = fit.weakest.shares.iter().map(|(name, x)| (name.clone(), json!(x))).collect();
        json!({
            "vellus_version": env!("CARGO_PKG_VERSION"),
            "model": fit.model.name(),
            "exit": self.exit().map(Exit::name),
            "interrupted": fit.interrupted,
            "profile": {"file": self.path, "points": profile.points.len(), "missing": profile.missing.len(),
                "channels": profile.channels, "quantity": profile.quantity.name(), "range": profile.range()},
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

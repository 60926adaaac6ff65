//! The variables of a fit: the parameters that are neither fixed nor tied to others.

use crate::error::Error;
use crate::forward::Forward;
use crate::parameters::{Curve, Kind, Name, Parameter, Setup, assemble, values_of};
use crate::profile::{MOST_CHANNELS, Profile, channels_of};
use vellus::{Fiber, Parameter as FiberParameter, ScatterExit};
use vellus_models::ModelKind;

/// Where the value of a parameter comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Source {
    /// The index of its variable in the fit. Tied parameters share a variable.
    Free(usize),
    /// A given value.
    Fixed(f64),
}

/// Parameters that are not treated in the usual way. The name of a colour without a channel means all of its channels.
#[derive(Clone, Debug, Default)]
pub struct Requests {
    /// Parameters with fixed values: one value, or one for each channel. Angles are in degrees.
    pub fix: Vec<(Name, Vec<f64>)>,
    /// Pairs of parameters: the first gets the value of the second.
    pub tie: Vec<(Name, Name)>,
    /// Parameters to fit that are usually fixed.
    pub free: Vec<Name>,
    /// Parameters of the fibre that differ from profile to profile in a joint fit, such as the absorption if each
    /// profile has a wavelength of its own.
    pub separate: Vec<Name>,
    /// Parameters that all profiles of a joint fit share: those of the measurement, such as the scale, and the
    /// absorption of channels.
    pub share: Vec<Name>,
}

impl Requests {
    /// Adds a request to fix a parameter: `eta=1.55` or `sigma_ca=0.1,0.2,0.4`.
    ///
    /// # Errors
    /// [`Error::Parameter`] for an unknown parameter, or for text that is not NAME=VALUE.
    pub fn add_fix(&mut self, text: &str) -> Result<(), Error> {
        let (name, values) = pair(text, "NAME=VALUE")?;
        let number = |x: &str| x.trim().parse::<f64>().map_err(|_| Error::Parameter(format!("'{x}' is not a number")));
        self.fix.push((name, values.split(',').map(number).collect::<Result<_, _>>()?));
        Ok(())
    }

    /// Adds a request to tie a parameter to another: `beta_n=beta_m`.
    ///
    /// # Errors
    /// [`Error::Parameter`] for an unknown parameter, or for text that is not NAME=NAME.
    pub fn add_tie(&mut self, text: &str) -> Result<(), Error> {
        let (name, leader) = pair(text, "NAME=NAME")?;
        self.tie.push((name, leader.parse()?));
        Ok(())
    }

    /// Adds a request to fit a parameter that usually is fixed.
    ///
    /// # Errors
    /// [`Error::Parameter`] for an unknown parameter.
    pub fn add_free(&mut self, name: &str) -> Result<(), Error> {
        self.free.push(name.trim().parse()?);
        Ok(())
    }
}

/// Splits `NAME=…`.
fn pair<'a>(text: &'a str, expected: &str) -> Result<(Name, &'a str), Error> {
    let (name, value) = text.split_once('=').ok_or_else(|| Error::Parameter(format!("expected {expected}")))?;
    Ok((name.trim().parse()?, value.trim()))
}

/// A parameter of one profile. `place` is part of the name if profiles have different values.
fn of_profile(p: &Parameter, profile: &Profile, place: &[String]) -> Parameter {
    let mut p = p.clone();
    if !place.is_empty() {
        p.name = format!("{}[{}]", p.name, place.join(","));
    }
    if p.kind == Kind::Background {
        // In the unit of the profile.
        let unit = profile.median();
        p.usual = p.usual.map(|x| x * unit);
        if let Curve::Log { offset } = &mut p.curve {
            *offset *= unit;
        }
    }
    p
}

/// The parameters and the variables of one fit.
#[derive(Clone, Debug)]
pub struct Space {
    /// The model.
    pub model: Forward,
    /// How scattered light leaves the fibre.
    pub exit: ScatterExit,
    /// All parameters. In a joint fit, one that differs from profile to profile is there once for each.
    pub parameters: Vec<Parameter>,
    /// For each profile, the indices of its parameters.
    pub members: Vec<Vec<usize>>,
    /// The inclination of the fixed direction of each profile, degrees.
    thetas: Vec<f64>,
    /// Where the value of each comes from.
    pub sources: Vec<Source>,
    /// For each variable, the index of the parameter that it is named after.
    pub leads: Vec<usize>,
    /// The smallest and the largest value of each variable.
    pub bounds: Vec<[f64; 2]>,
}

impl Space {
    /// The parameters of a model for one profile or more. All profiles have the same number of channels.
    ///
    /// # Errors
    /// [`Error::Profile`] for profiles with different numbers of channels, or none. [`Error::Parameter`] for a
    /// parameter that the model does not have, a value out of range, or requests that contradict each other.
    pub fn new(model: Forward, profiles: &[Profile], requests: &Requests) -> Result<Self, Error> {
        let channels = profiles.first().map_or(0, |profile| profile.channels);
        if channels == 0 || profiles.iter().any(|profile| profile.channels != channels) {
            return Err(Error::Profile("all profiles of a fit must have one channel, or all three".to_owned()));
        }
        // Channels are ordered by measurement, and then by channel. Other profiles are one measurement each.
        let spectrum = if profiles.iter().all(|p| p.channel.is_empty()) { 1 } else { channels_of(profiles) };
        let measurements = profiles.len() / spectrum;
        if let Some((k, p)) = profiles.iter().enumerate().find(|(k, p)| p.channel != profiles[k % spectrum].channel) {
            let expected = &profiles[k % spectrum].channel;
            return Err(Error::Profile(format!(
                "channel '{}' in place of '{expected}': all measurements of a fit must have the same channels, in the \
                 same order",
                p.channel
            )));
        }
        if measurements * spectrum != profiles.len() || spectrum > MOST_CHANNELS {
            return Err(Error::Profile(format!(
                "{} profiles of {spectrum} channels: all measurements of a fit must have the same channels, at most \
                 {MOST_CHANNELS}",
                profiles.len()
            )));
        }
        let (mut parameters, mut members) = (Vec::new(), vec![Vec::new(); profiles.len()]);
        for p in model.parameters(channels) {
            let named = |names: &[Name]| names.iter().any(|name| name.means(p.kind, channels));
            let absorbs = matches!(p.kind, Kind::Fiber(FiberParameter::SigmaCa | FiberParameter::SigmaMa, _));
            let [by_measurement, by_channel] = match (named(&requests.separate), named(&requests.share)) {
                (true, _) => [true; 2],
                (_, true) => [false; 2],
                _ => [p.kind.is_of_measurement(), absorbs],
            };
            let first = parameters.len();
            for (k, profile) in profiles.iter().enumerate() {
                let measurement = if by_measurement { k / spectrum } else { 0 };
                let channel = if by_channel { k % spectrum } else { 0 };
                let index = first + measurement * if by_channel { spectrum } else { 1 } + channel;
                if index == parameters.len() {
                    let name = (by_channel && spectrum > 1).then(|| profile.channel.clone());
                    let number = (by_measurement && measurements > 1).then(|| (measurement + 1).to_string());
                    parameters.push(of_profile(&p, profile, &name.into_iter().chain(number).collect::<Vec<_>>()));
                }
                members[k].push(index);
            }
        }
        let thetas: Vec<f64> = profiles.iter().map(|profile| profile.theta_o).collect();
        let mut given: Vec<Option<f64>> = vec![None; parameters.len()];
        let find = |name: Name| -> Result<Vec<usize>, Error> {
            let found: Vec<usize> =
                (0..parameters.len()).filter(|&i| name.means(parameters[i].kind, channels)).collect();
            if found.is_empty() {
                let known = model.parameters(channels);
                let known: Vec<&str> = known.iter().map(|p| p.name.as_str()).collect();
                return Err(Error::Parameter(format!(
                    "unknown parameter '{name}': those of {} are {}",
                    model.kind(),
                    known.join(", ")
                )));
            }
            Ok(found)
        };
        for (theta_o, indices) in thetas.iter().zip(&members) {
            for &i in indices {
                match parameters[i].kind {
                    Kind::ThetaO => given[i] = Some(*theta_o),
                    Kind::Background | Kind::Fiber(FiberParameter::MedullaAir, _) => given[i] = Some(0.0),
                    _ => {}
                }
            }
        }
        for &name in requests.separate.iter().chain(&requests.share) {
            find(name)?;
        }
        for &name in &requests.free {
            find(name)?.into_iter().for_each(|i| given[i] = None);
        }
        for (name, values) in &requests.fix {
            let places = find(*name)?;
            if values.len() != 1 && values.len() != places.len() {
                let count =
                    if places.len() == 1 { "one value".to_owned() } else { format!("one value or {}", places.len()) };
                return Err(Error::Parameter(format!("{name} takes {count}, not {}", values.len())));
            }
            for (k, &i) in places.iter().enumerate() {
                let (x, p) = (values[if values.len() == 1 { 0 } else { k }], &parameters[i]);
                if !(p.low..=p.high).contains(&x) {
                    let unit = if p.unit.is_empty() { "" } else { " degrees" };
                    return Err(Error::Parameter(format!(
                        "{} = {x} is out of range: it must be in [{}, {}]{unit}",
                        p.name, p.low, p.high
                    )));
                }
                given[i] = Some(x);
            }
        }
        // Ties form a forest: each parameter points to the one that gives its value.
        let mut follows: Vec<usize> = (0..parameters.len()).collect();
        let root = |follows: &[usize], mut i: usize| {
            while follows[i] != i {
                i = follows[i];
            }
            i
        };
        for (name, leader) in &requests.tie {
            let (names, leaders) = (find(*name)?, find(*leader)?);
            if leaders.len() != 1 && leaders.len() != names.len() {
                return Err(Error::Parameter(format!("{name} and {leader} have different numbers of channels")));
            }
            for (k, &i) in names.iter().enumerate() {
                let leader = leaders[if leaders.len() == 1 { 0 } else { k }];
                let (a, b) = (root(&follows, i), root(&follows, leader));
                if i == leader || a == b {
                    return Err(Error::Parameter(format!("{} cannot be tied to itself", parameters[i].name)));
                }
                if given[a].is_some() {
                    return Err(Error::Parameter(format!("{} cannot be both fixed and tied", parameters[a].name)));
                }
                follows[a] = b;
            }
        }
        let (mut leads, mut sources, mut bounds) = (Vec::new(), vec![Source::Fixed(0.0); parameters.len()], Vec::new());
        for (i, p) in parameters.iter().enumerate() {
            let lead = root(&follows, i);
            sources[i] = match given[lead] {
                Some(x) => Source::Fixed(x),
                None => {
                    let known = leads.iter().position(|&l| l == lead);
                    let column = known.unwrap_or_else(|| {
                        leads.push(lead);
                        let l = &parameters[lead];
                        bounds.push([l.curve.variable(l.low), l.curve.variable(l.high)]);
                        leads.len() - 1
                    });
                    let curve = parameters[lead].curve;
                    let [low, high]: [f64; 2] = bounds[column];
                    bounds[column] = [
                        low.max(curve.variable(p.low.max(parameters[lead].low))),
                        high.min(curve.variable(p.high.min(parameters[lead].high))),
                    ];
                    Source::Free(column)
                }
            };
        }
        if let Some(k) = bounds.iter().position(|[low, high]| low >= high) {
            return Err(Error::Parameter(format!(
                "{} is tied to a parameter that has no value in common with it",
                parameters[leads[k]].name
            )));
        }
        if leads.is_empty() {
            return Err(Error::Parameter("every parameter is fixed: there is nothing to fit".to_owned()));
        }
        let exit = if model.kind() == ModelKind::Vellus { ScatterExit::default() } else { ScatterExit::Open };
        Ok(Space { model, exit, parameters, members, thetas, sources, leads, bounds })
    }

    /// The same parameters for a fibre that scattered light leaves in another way.
    ///
    /// # Errors
    /// [`Error::Parameter`] for [`ScatterExit::Reflecting`] and a model that does not have it.
    pub fn with_exit(self, exit: ScatterExit) -> Result<Self, Error> {
        if exit == ScatterExit::Reflecting && self.model.kind() != ModelKind::Vellus {
            let model = self.model.kind();
            return Err(Error::Parameter(format!("{model} has no exit '{exit}': only {} has", ModelKind::Vellus)));
        }
        Ok(Space { exit, ..self })
    }

    /// The parameter that a variable is named after.
    pub fn lead(&self, column: usize) -> &Parameter {
        &self.parameters[self.leads[column]]
    }

    /// Converts the variables `u` to the values of all parameters.
    pub fn values(&self, u: &[f64]) -> Vec<f64> {
        let value = |source: &Source| match *source {
            Source::Fixed(x) => x,
            Source::Free(column) => {
                let lead = self.lead(column);
                lead.curve.value(u[column]).clamp(lead.low, lead.high)
            }
        };
        self.sources.iter().map(value).collect()
    }

    /// The fibre and the measurement of one profile, for the values of all parameters.
    pub(crate) fn setup(&self, profile: usize, values: &[f64]) -> Setup {
        assemble(self.exit, self.members[profile].iter().map(|&i| (&self.parameters[i], values[i])))
    }

    /// The variables of a fibre, with the scale 1 and no background, clamped to the bounds. A tied group has the value
    /// of its leader.
    pub(crate) fn variables(&self, fiber: &Fiber) -> Vec<f64> {
        let theta_o = |i: usize| {
            let profile = self.members.iter().position(|indices| indices.contains(&i));
            profile.map_or(0.0, |k| self.thetas[k])
        };
        let one = |(i, p): (usize, &Parameter)| values_of(std::slice::from_ref(p), fiber, theta_o(i), 1.0)[0];
        let values: Vec<f64> = self.parameters.iter().enumerate().map(one).collect();
        let variable = |(column, &lead): (usize, &usize)| {
            let [low, high] = self.bounds[column];
            self.parameters[lead].curve.variable(values[lead]).clamp(low, high)
        };
        self.leads.iter().enumerate().map(variable).collect()
    }

    /// The index of the variable of a profile's parameter, if the parameter is fitted.
    pub fn column_of(&self, profile: usize, kind: Kind) -> Option<usize> {
        let i = self.members[profile].iter().find(|&&i| self.parameters[i].kind == kind)?;
        match self.sources[*i] {
            Source::Free(column) => Some(column),
            Source::Fixed(_) => None,
        }
    }

    /// Raises the lower bound of a profile's parameter to `least`, if the parameter is fitted.
    pub fn resolve(&mut self, profile: usize, kind: Kind, least: f64) {
        if let Some(column) = self.column_of(profile, kind) {
            let lead = &self.parameters[self.leads[column]];
            let [low, high] = &mut self.bounds[column];
            *low = low.max(lead.curve.variable(least.max(lead.low))).min(*high - 1e-3);
        }
    }

    /// The size of the usual range of a variable.
    pub fn width(&self, column: usize) -> f64 {
        let [low, high] = self.usual(column);
        (high - low).max(1e-3)
    }

    /// The usual range of a variable, within its bounds.
    pub fn usual(&self, column: usize) -> [f64; 2] {
        let lead = self.lead(column);
        let [low, high] = self.bounds[column];
        lead.usual.map(|x| lead.curve.variable(x).clamp(low, high))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn requests_are_read_from_text() {
        let mut requests = Requests::default();
        requests.add_fix("sigma_ca = 0.1, 0.2,0.4").unwrap();
        requests.add_tie("sigma_ma.r=scale").unwrap();
        requests.add_free(" theta_o").unwrap();
        assert_eq!(requests.fix[0].1, [0.1, 0.2, 0.4]);
        assert_eq!((requests.tie[0].1, requests.free[0]), (Name::Scale, Name::ThetaO));
        for (error, part) in [
            (requests.add_fix("eta").unwrap_err(), "expected NAME=VALUE"),
            (requests.add_fix("eta=x").unwrap_err(), "'x' is not a number"),
            (requests.add_tie("eta").unwrap_err(), "expected NAME=NAME"),
            (requests.add_free("colour").unwrap_err(), "unknown parameter 'colour'"),
        ] {
            assert!(error.to_string().contains(part), "{error}");
        }
    }
}

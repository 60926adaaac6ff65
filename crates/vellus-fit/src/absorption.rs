//! Absorption in any number of channels: files with one row for each.

use crate::error::Error;
use crate::outcome::Part;
use crate::profile::{MOST_CHANNELS, Profile, channels_of};
use std::path::Path;
use vellus::{Fiber, Parameter};

/// The absorption of a fibre in one channel, such as a wavelength.
#[derive(Clone, Debug, PartialEq)]
pub struct Absorption {
    /// The name of the channel.
    pub channel: String,
    /// σ_c,a, absorption of the cortex per fibre radius, in [0, 1000].
    pub sigma_ca: f32,
    /// σ_m,a, absorption of the medulla per fibre radius, in [0, 1000].
    pub sigma_ma: f32,
}

/// The largest file that is read.
const MOST_BYTES: u64 = 1 << 20;

impl Absorption {
    /// Reads a CSV file with the columns channel, sigma_ca and sigma_ma, and a row for each channel.
    ///
    /// # Errors
    /// [`Error::Read`], [`Error::Line`] or [`Error::File`] for a file that cannot be read, other columns, a value out
    /// of range, a channel without a name or with that of another one, no channel, or more than [`MOST_CHANNELS`].
    pub fn read(path: &Path) -> Result<Vec<Self>, Error> {
        let bytes = vellus_io::read_at_most(path, MOST_BYTES);
        let bytes = bytes.map_err(|source| Error::Read { path: path.to_owned(), source })?;
        let mut csv = csv::ReaderBuilder::new().trim(csv::Trim::All).comment(Some(b'#')).from_reader(&bytes[..]);
        let head = csv.headers().map_err(|e| Error::csv(path, &e))?.clone();
        let at = |name: &str| head.iter().position(|h| h == name);
        let (Some(channel), Some(ca), Some(ma), 3) = (at("channel"), at("sigma_ca"), at("sigma_ma"), head.len()) else {
            let found: Vec<&str> = head.iter().collect();
            let what = format!("the columns are {}: expected channel, sigma_ca, sigma_ma", found.join(", "));
            return Err(Error::file(path, what));
        };
        let mut all: Vec<Absorption> = Vec::new();
        for record in csv.records() {
            let record = record.map_err(|e| Error::csv(path, &e))?;
            let line = record.position().map_or(0, csv::Position::line);
            let wrong = |what: String| Error::line(path, line, what);
            let sigma = |i: usize, parameter: Parameter| {
                let (name, cell) = (&head[i], &record[i]);
                let x: f32 = cell.parse().map_err(|_| wrong(format!("{name} = '{cell}' is not a number")))?;
                let range = parameter.range();
                let outside =
                    || wrong(format!("{name} = {cell} is out of range: it must be in {range} per fibre radius"));
                if range.contains(x) { Ok(x) } else { Err(outside()) }
            };
            let (sigma_ca, sigma_ma) = (sigma(ca, Parameter::SigmaCa)?, sigma(ma, Parameter::SigmaMa)?);
            let channel = record[channel].to_owned();
            check_name(&channel, all.iter().map(|a| a.channel.as_str())).map_err(wrong)?;
            all.push(Absorption { channel, sigma_ca, sigma_ma });
        }
        match all.len() {
            1..=MOST_CHANNELS => Ok(all),
            n => Err(Error::file(path, format!("it has {n} channels: expected 1 to {MOST_CHANNELS}"))),
        }
    }

    /// Writes what [`Absorption::read`] reads.
    pub fn csv(all: &[Self]) -> String {
        let row = |a: &Self| format!("{},{},{}\n", a.channel, a.sigma_ca, a.sigma_ma);
        "channel,sigma_ca,sigma_ma\n".to_owned() + &all.iter().map(row).collect::<String>()
    }

    /// The fitted absorptions of the channels of profiles: those of the first measurement. Empty if the profiles have
    /// no channels with names.
    pub fn fitted(profiles: &[&Profile], parts: &[Part]) -> Vec<Self> {
        let of = |(profile, part): (&&Profile, &Part)| {
            let Fiber { sigma_ca, sigma_ma, .. } = part.specimen.fiber;
            Absorption { channel: profile.channel.clone(), sigma_ca: sigma_ca[0], sigma_ma: sigma_ma[0] }
        };
        let all = profiles.iter().zip(parts).filter(|(profile, _)| !profile.channel.is_empty());
        all.map(of).take(channels_of(profiles)).collect()
    }

    /// The fibre with this absorption in all of its channels. Each channel is a fibre of its own, because the shape of
    /// scattered light follows the mean absorption of the three channels of a fibre.
    pub fn apply(&self, fiber: &Fiber) -> Fiber {
        Fiber { sigma_ma: [self.sigma_ma; 3], ..fiber.with_absorption([self.sigma_ca; 3]) }
    }
}

/// Checks the name of a channel. It may not contain what separates names in files and tables.
pub(crate) fn check_name<'a>(name: &str, mut others: impl Iterator<Item = &'a str>) -> Result<(), String> {
    if name.is_empty() || name.contains([',', '[', ']', '"', '#', '=']) || name.contains(char::is_whitespace) {
        return Err(format!("a channel has the name '{name}': expected letters and digits, such as 550 or blue"));
    }
    if others.any(|other| other == name) {
        return Err(format!("there are two channels '{name}'"));
    }
    Ok(())
}

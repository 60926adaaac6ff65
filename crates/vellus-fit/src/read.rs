//! Reads profiles from the files of gantries and of programs.

use crate::absorption::check_name;
use crate::error::Error;
use crate::image;
use crate::profile::{MOST_CHANNELS, Point, Profile, Quantity, check_angles, check_blur};
use crate::write::SIMULATED;
use std::path::Path;
use std::str::FromStr;

/// The coordinates of a file's angles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Angles {
    /// θ is measured from the plane normal to the fibre, φ from the azimuth of the fixed direction.
    Fiber,
    /// The coordinates of the measurements of Yan et al. 2015: θ is 90° minus the file's value, φ is the file's value
    /// minus 90°. The range [40, 80] in the file is θ from 50° to 10°; [70, 290] is φ from −20° to 200°.
    Gantry,
}

impl Angles {
    /// The names used on the command line and in files.
    pub const NAMES: [&str; 2] = ["fiber", "gantry"];

    /// Converts a file's angles to θ and φ of the fibre.
    fn convert(self, theta: f64, phi: f64) -> [f64; 2] {
        match self {
            Angles::Fiber => [theta, phi],
            Angles::Gantry => [90.0 - theta, phi - 90.0],
        }
    }

    /// Converts a file's angles and checks them. The message quotes the numbers of the file.
    fn check(self, theta: f64, phi: f64) -> Result<[f64; 2], String> {
        let converted @ [t, p] = self.convert(theta, phi);
        check_angles(t, p).map(|()| converted).map_err(|what| match self {
            Angles::Fiber => what,
            Angles::Gantry => format!(
                "theta = {theta}, phi = {phi} in the gantry's coordinates: {what} (is this file in the fibre's own angles?)"
            ),
        })
    }
}

impl FromStr for Angles {
    type Err = Error;

    fn from_str(name: &str) -> Result<Self, Error> {
        match name {
            "fiber" => Ok(Angles::Fiber),
            "gantry" => Ok(Angles::Gantry),
            _ => Err(Error::Parameter(format!("expected {}", Angles::NAMES.join(" or ")))),
        }
    }
}

/// Angles of the centres of the first and the last row or column of an image, degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axis {
    /// The first row or column.
    pub first: f64,
    /// The last row or column.
    pub last: f64,
}

impl FromStr for Axis {
    type Err = Error;

    /// Parses FIRST:LAST.
    fn from_str(text: &str) -> Result<Self, Error> {
        let wrong = |what: String| Error::Parameter(what);
        let number = |x: &str| x.trim().parse::<f64>().map_err(|_| wrong(format!("'{x}' is not a number")));
        let (first, last) =
            text.split_once(':').ok_or_else(|| wrong("expected FIRST:LAST, such as 10:50".to_owned()))?;
        Ok(Axis { first: number(first)?, last: number(last)? })
    }
}

/// What the caller knows about a file. Text and CSV files may state it in comments: `# theta_o = -30`, `# angles =
/// fiber`, `# quantity = f-cos`, `# blur = 5,5`. A synthetic measurement has the parameters that were simulated:
/// `# simulated kappa = 0.88`.
#[derive(Clone, Copy, Debug, Default)]
pub struct Reading {
    /// Inclination of the fixed direction, degrees.
    pub theta_o: Option<f64>,
    /// The coordinates of the angles. Default: the gantry's for text without a header, the fibre's otherwise.
    pub angles: Option<Angles>,
    /// What the values are proportional to. Default: f·cos θ.
    pub quantity: Option<Quantity>,
    /// θ of an image's rows and φ of its columns.
    pub axes: Option<[Axis; 2]>,
    /// Widths over θ and φ of the cell of each value, [`Profile::blur`]. Default: 0.
    pub blur: Option<[f64; 2]>,
}

/// Parses the widths of a cell: one number for both, or `θ,φ`, in degrees.
///
/// # Errors
/// [`Error::Parameter`] for other text, and [`Error::Profile`] for a width out of range.
pub fn parse_blur(text: &str) -> Result<[f64; 2], Error> {
    let number = |x: &str| x.trim().parse::<f64>().map_err(|_| Error::Parameter(format!("'{x}' is not a number")));
    let widths = match text.split_once(',') {
        Some((theta, phi)) => [number(theta)?, number(phi)?],
        None => [number(text)?; 2],
    };
    check_blur(widths).map(|()| widths)
}

/// The largest file that is read: 1 GiB. The largest accepted array, 2²⁶ doubles, takes half of it.
const MOST_BYTES: u64 = 1 << 30;

/// Measurements, and what the comments of the file state.
struct Table {
    /// The name of the channel, if the file has any number of them.
    channel: String,
    channels: usize,
    points: Vec<Point>,
    missing: Vec<[f64; 2]>,
    negative: usize,
    known: Reading,
    simulated: Vec<(String, f64)>,
}

/// Reads a profile. Formats: `.txt` with lines `phi theta value` or `phi theta r g b`, `?` for a missing value;
/// `.csv` with the columns theta, phi, value or r, g, b, and if known sigma or sigma_r, sigma_g, sigma_b; `.npy` or
/// `.exr` with rows over θ, columns over φ, NaN for a missing value. A value of 0 counts as missing. So does a negative
/// one, which noise leaves where a background was subtracted; [`Profile::negative`] counts these.
///
/// # Errors
/// [`Error::Read`], [`Error::Line`] or [`Error::File`]. The message states the problem and its place. A file with
/// several channels is for [`read_channels`].
pub fn read(path: &Path, reading: &Reading) -> Result<Profile, Error> {
    let mut profiles = read_channels(path, reading)?;
    match (profiles.pop(), profiles.len()) {
        (Some(profile), 0) => Ok(profile),
        (_, more) => Err(Error::file(path, format!("it has {} channels: expected one profile", more + 1))),
    }
}

/// Reads a file of any number of channels: one grey profile for each, with its [`Profile::channel`]. The file is `.csv`
/// with the columns theta, phi, and value_NAME for each channel, and if known sigma or sigma_NAME for each channel. A
/// value may be missing in some channels. Other files give one profile, as in [`read()`].
///
/// # Errors
/// As [`read()`].
pub fn read_channels(path: &Path, reading: &Reading) -> Result<Vec<Profile>, Error> {
    let bytes = vellus_io::read_at_most(path, MOST_BYTES);
    let bytes = bytes.map_err(|source| Error::Read { path: path.to_owned(), source })?;
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
    let text = || {
        std::str::from_utf8(&bytes)
            .map(vellus_io::unmarked)
            .map_err(|e| Error::file(path, format!("byte {}: it is not UTF-8 text", e.valid_up_to())))
    };
    let tables = match extension.as_str() {
        "txt" => vec![lines(path, text()?, reading)?],
        "csv" => columns(path, text()?, reading)?,
        "npy" => vec![pixels(path, image::npy(&bytes), reading)?],
        "exr" => vec![pixels(path, image::exr(&bytes), reading)?],
        _ => return Err(Error::file(path, "unknown format: the name must end in .txt, .csv, .npy or .exr")),
    };
    tables.into_iter().map(|table| profile(path, table, reading)).collect()
}

fn profile(path: &Path, table: Table, reading: &Reading) -> Result<Profile, Error> {
    let profile = Profile {
        theta_o: reading.theta_o.or(table.known.theta_o).ok_or_else(|| {
            Error::file(path, "the inclination of the fixed direction is not in it: give --theta-o, in degrees")
        })?,
        quantity: reading.quantity.or(table.known.quantity).unwrap_or_default(),
        channels: table.channels,
        channel: table.channel,
        blur: reading.blur.or(table.known.blur).unwrap_or_default(),
        points: table.points,
        missing: table.missing,
        negative: table.negative,
        simulated: table.simulated,
    };
    match profile.validate() {
        Ok(()) => Ok(profile),
        Err(e) if profile.channel.is_empty() => Err(Error::file(path, e)),
        Err(e) => Err(Error::file(path, format!("channel {}: {e}", profile.channel))),
    }
}

/// Parses `# name = value` in a comment: what a reader needs, and the parameters that were simulated.
fn header(path: &Path, text: &str) -> Result<(Reading, Vec<(String, f64)>), Error> {
    let (mut known, mut simulated) = (Reading::default(), Vec::new());
    for (i, line) in text.lines().enumerate() {
        let Some((name, value)) = line.trim().strip_prefix('#').and_then(|rest| rest.split_once('=')) else { continue };
        let (name, value) = (name.trim(), value.trim());
        let wrong =
            |expected: &str| Error::line(path, i as u64 + 1, format!("{name} = '{value}': expected {expected}"));
        match name {
            "theta_o" => known.theta_o = Some(value.parse().map_err(|_| wrong("degrees"))?),
            "angles" => known.angles = Some(value.parse().map_err(|_| wrong("fiber or gantry"))?),
            "blur" => known.blur = Some(parse_blur(value).map_err(|_| wrong("one or two widths in degrees"))?),
            "quantity" => known.quantity = Some(value.parse().map_err(|_| wrong("f-cos or f"))?),
            _ => {
                if let Some(parameter) = name.strip_prefix(SIMULATED) {
                    simulated.push((parameter.to_owned(), value.parse().map_err(|_| wrong("a number"))?));
                }
            }
        }
    }
    Ok((known, simulated))
}

/// Parses a number; `None` for `?` and for an empty cell.
fn number(name: &str, cell: &str) -> Result<Option<f64>, String> {
    match cell {
        "?" | "" => Ok(None),
        _ => match cell.parse::<f64>() {
            Ok(x) if x.is_finite() => Ok(Some(x)),
            _ => Err(format!("{name} = '{cell}' is not a number (write ? for a missing value)")),
        },
    }
}

impl Table {
    fn new(channels: usize, known: Reading) -> Self {
        let (points, missing, simulated) = (Vec::new(), Vec::new(), Vec::new());
        Table { channel: String::new(), channels, points, missing, negative: 0, known, simulated }
    }

    /// Adds one measurement.
    fn add(&mut self, [theta, phi]: [f64; 2], values: &[Option<f64>], sigma: Option<[f64; 3]>) {
        self.negative += usize::from(values.iter().flatten().any(|x| *x < 0.0));
        let mut value = [0.0; 3];
        for (v, given) in value.iter_mut().zip(values) {
            *v = given.unwrap_or(0.0);
        }
        if value[..self.channels].iter().all(|&x| x > 0.0) {
            self.points.push(Point { theta, phi, value, sigma });
        } else {
            self.missing.push([theta, phi]);
        }
    }
}

fn lines(path: &Path, text: &str, reading: &Reading) -> Result<Table, Error> {
    let (known, simulated) = header(path, text)?;
    let angles = reading.angles.or(known.angles).unwrap_or(Angles::Gantry);
    let mut table: Option<Table> = None;
    for (i, line) in text.lines().enumerate() {
        let line_number = i as u64 + 1;
        let wrong = |what: String| Error::line(path, line_number, what);
        let line = line.trim();
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        let cells: Vec<&str> = line.split_whitespace().collect();
        let channels = match cells.len() {
            3 => 1,
            5 => 3,
            n => return Err(wrong(format!("{n} numbers: expected phi theta value, or phi theta r g b"))),
        };
        let table = table.get_or_insert_with(|| Table::new(channels, known));
        if table.channels != channels {
            return Err(wrong(format!("{} numbers, where the first line has {}", cells.len(), table.channels + 2)));
        }
        let angle = |name: &str, cell: &str| {
            number(name, cell).and_then(|x| x.ok_or_else(|| format!("{name} is missing"))).map_err(wrong)
        };
        let direction = angles.check(angle("theta", cells[1])?, angle("phi", cells[0])?).map_err(wrong)?;
        let values = cells[2..].iter().map(|c| number("value", c)).collect::<Result<Vec<_>, _>>().map_err(wrong)?;
        table.add(direction, &values, None);
    }
    Ok(Table { simulated, ..table.unwrap_or_else(|| Table::new(1, known)) })
}

/// The columns of the values and of the standard deviations of one profile. The latter are none, one for all values or
/// one for each.
struct Columns {
    table: Table,
    values: Vec<usize>,
    sigmas: Vec<usize>,
}

fn columns(path: &Path, text: &str, reading: &Reading) -> Result<Vec<Table>, Error> {
    const KNOWN: &str = "theta, phi, value or r, g, b, and sigma or sigma_r, sigma_g, sigma_b; or of each channel \
                         value_NAME, and sigma_NAME";
    let (known, simulated) = header(path, text)?;
    let angles = reading.angles.or(known.angles).unwrap_or(Angles::Fiber);
    let mut csv = csv::ReaderBuilder::new().trim(csv::Trim::All).comment(Some(b'#')).from_reader(text.as_bytes());
    let head = csv.headers().map_err(|e| Error::csv(path, &e))?.clone();
    let head_line = csv.position().line().saturating_sub(1).max(1);
    let at = |name: &str| head.iter().position(|h| h == name);
    let theta = at("theta").or_else(|| at("theta_i"));
    let named = |names: &[&str]| names.iter().filter_map(|name| at(name)).collect::<Vec<usize>>();
    let names: Vec<&str> = head.iter().filter_map(|h| h.strip_prefix("value_")).collect();
    let values = at("value").map_or_else(|| named(&["r", "g", "b"]), |value| vec![value]);
    let wrong = |what: String| Error::line(path, head_line, what);
    let (Some(theta), Some(phi), (1 | 3, 0) | (0, 1..=MOST_CHANNELS)) = (theta, at("phi"), (values.len(), names.len()))
    else {
        let (found, most): (Vec<&str>, _) = (head.iter().collect(), format!("at most {MOST_CHANNELS} channels"));
        return Err(wrong(format!("the columns are {}: expected {KNOWN}; {most}", found.join(", "))));
    };
    let sigmas = |names: &[&str]| at("sigma").map_or_else(|| named(names), |sigma| vec![sigma]);
    let mut all = Vec::new();
    if names.is_empty() {
        let table = Table { simulated: simulated.clone(), ..Table::new(values.len(), known) };
        all.push(Columns { table, values, sigmas: sigmas(&["sigma_r", "sigma_g", "sigma_b"]) });
    }
    for (i, &name) in names.iter().enumerate() {
        check_name(name, names[..i].iter().copied()).map_err(wrong)?;
        // What was simulated in all channels, or in this one.
        let own = |(parameter, x): &(String, f64)| match parameter.split_once('[') {
            Some((parameter, of)) => (of.strip_suffix(']') == Some(name)).then(|| (parameter.to_owned(), *x)),
            None => Some((parameter.clone(), *x)),
        };
        let simulated = simulated.iter().filter_map(own).collect();
        let table = Table { channel: name.to_owned(), simulated, ..Table::new(1, known) };
        let [value, sigma] = ["value", "sigma"].map(|what| format!("{what}_{name}"));
        all.push(Columns { table, values: named(&[&value]), sigmas: sigmas(&[&sigma]) });
    }
    let (found, expected) = all.iter().fold((0, 0), |(s, v), c| (s + c.sigmas.len(), v + c.values.len()));
    if at("sigma").is_none() && found != 0 && found != expected {
        return Err(wrong(format!("there are {found} columns of sigma for {expected} of values")));
    }
    // Another column might change the fit if it were used, so it is not left out without a word.
    let of_profile = |i: usize| all.iter().any(|c| c.values.contains(&i) || c.sigmas.contains(&i));
    if let Some((_, name)) = head.iter().enumerate().find(|(i, _)| *i != theta && *i != phi && !of_profile(*i)) {
        return Err(wrong(format!("cannot use the column '{name}': expected {KNOWN}")));
    }
    for record in csv.records() {
        let record = record.map_err(|e| Error::csv(path, &e))?;
        let line = record.position().map_or(0, csv::Position::line);
        let wrong = |what: String| Error::line(path, line, what);
        let cell = |i: usize| record.get(i).unwrap_or("");
        let angle = |name: &str, i: usize| {
            number(name, cell(i)).and_then(|x| x.ok_or_else(|| format!("{name} is missing"))).map_err(wrong)
        };
        let direction = angles.check(angle("theta", theta)?, angle("phi", phi)?).map_err(wrong)?;
        for Columns { table, values, sigmas } in &mut all {
            let given = values.iter().map(|&i| number(&head[i], cell(i)));
            let given = given.collect::<Result<Vec<_>, _>>().map_err(wrong)?;
            // A missing value needs no sigma.
            let sigma = match sigmas[..] {
                _ if given.contains(&None) => None,
                [] => None,
                _ => {
                    let cells = (0..3).map(|c| sigmas[c.min(sigmas.len() - 1)]);
                    let numbers = cells.map(|i| number(&head[i], cell(i)).map(|x| x.unwrap_or(f64::NAN)));
                    let numbers = numbers.collect::<Result<Vec<_>, _>>().map_err(wrong)?;
                    if let Some(x) = numbers.iter().find(|x| x.is_nan() || **x <= 0.0) {
                        return Err(wrong(format!("sigma = {x} is out of range: it must be above 0")));
                    }
                    Some(std::array::from_fn(|c| numbers[c]))
                }
            };
            table.add(direction, &given, sigma);
        }
    }
    Ok(all.into_iter().map(|columns| columns.table).collect())
}

fn pixels(path: &Path, image: Result<image::Pixels, String>, reading: &Reading) -> Result<Table, Error> {
    let image = image.map_err(|what| Error::file(path, what))?;
    let Some([theta, phi]) = reading.axes else {
        return Err(Error::file(
            path,
            "an image does not state its angles: give --theta FIRST:LAST of its rows and --phi of its columns",
        ));
    };
    let angles = reading.angles.unwrap_or(Angles::Fiber);
    let along = |axis: Axis, i: usize, count: usize| {
        let share = if count > 1 { i as f64 / (count - 1) as f64 } else { 0.0 };
        axis.first + (axis.last - axis.first) * share
    };
    let mut table = Table::new(image.channels, Reading::default());
    for row in 0..image.height {
        for column in 0..image.width {
            let wrong = |what: String| Error::file(path, format!("row {}, column {}: {what}", row + 1, column + 1));
            let direction =
                angles.check(along(theta, row, image.height), along(phi, column, image.width)).map_err(wrong)?;
            let start = (row * image.width + column) * image.channels;
            let values: Vec<Option<f64>> =
                image.values[start..start + image.channels].iter().map(|&x| (!x.is_nan()).then_some(x)).collect();
            if values.iter().flatten().any(|x| x.is_infinite()) {
                return Err(wrong("the value is infinite".to_owned()));
            }
            table.add(direction, &values, None);
        }
    }
    Ok(table)
}

//! Measured lamps: IES profiles (ANSI/IES LM-63), the luminous intensity of a lamp by direction.
//!
//! A profile becomes an image as [`vellus_scene::Profile`] describes it. `inputs:shaping:ies:angleScale` and
//! `inputs:shaping:ies:normalize` are applied here, as OpenUSD's own renderer hdEmbree does.

use super::pixels::Pixels;
use crate::error::Invalid;
use std::f64::consts::PI;
use std::fmt::Write;
use vellus_scene::Texture;

/// Rows of the image: one each quarter of a degree.
const ROWS: usize = 721;

/// Columns of the image of a lamp that is not the same all around: one each degree.
const COLUMNS: usize = 360;

/// How a light uses its profile.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Use {
    /// Whether the mean of the profile becomes 1, so that the light keeps its power.
    pub normalize: bool,
    /// The bits of the angle scale, a finite number. 0 is no scale.
    pub angle_scale: u32,
}

/// The table of a file, in degrees and candela.
struct Table {
    /// Angles from the axis, ascending.
    down: Vec<f64>,
    /// Angles around the axis, ascending.
    around: Vec<f64>,
    /// For each angle around the axis, those from it.
    candela: Vec<f64>,
}

/// Reads a profile as an image.
pub(crate) fn decode(bytes: &[u8], used: Use) -> Result<Pixels, Invalid> {
    let table = Table::read(&String::from_utf8_lossy(bytes))?;
    let mean = table.mean();
    if used.normalize && mean <= 0.0 {
        return Err("broken profile: the lamp is dark".into());
    }
    let factor = if used.normalize { mean.recip() } else { 1.0 };
    let columns = if table.around.len() == 1 { 1 } else { COLUMNS };
    let value = |i: usize| {
        let (row, column) = (i / columns, i % columns);
        let angle = scaled(180.0 * row as f64 / (ROWS - 1) as f64, f32::from_bits(used.angle_scale).into());
        [(factor * table.at(angle, 360.0 * column as f64 / columns as f64)) as f32; 3]
    };
    Ok(Pixels { width: columns, height: ROWS, rgb: (0..ROWS * columns).map(value).collect() })
}

/// The angle of the profile for an angle of the light, in degrees.
fn scaled(angle: f64, scale: f64) -> f64 {
    if scale > 0.0 {
        (angle / scale).min(180.0)
    } else if scale < 0.0 {
        180.0 + (angle - 180.0) / -scale
    } else {
        angle
    }
}

impl Table {
    fn read(text: &str) -> Result<Table, Invalid> {
        let (_, rest) = text.split_once("TILT=").ok_or("it is no IES profile: there is no line TILT=")?;
        let (tilt, rest) = rest.split_once('\n').ok_or("broken profile: there are no numbers")?;
        let mut numbers = rest.split(|c: char| c.is_whitespace() || c == ',').filter(|word| !word.is_empty());
        let mut next = || -> Result<f64, Invalid> {
            let word = numbers.next().ok_or("broken profile: numbers are missing")?;
            let number = word.parse().ok().filter(|x: &f64| x.is_finite());
            number.ok_or_else(|| format!("broken profile: {word:?} is no number").into())
        };
        if tilt.trim() == "INCLUDE" {
            // A table of factors for tilted lamps: a kind, and pairs of angles and factors.
            next()?;
            let pairs = next()?;
            (0..2 * count(pairs, text)?).try_for_each(|_| next().map(drop))?;
        }
        let [_lamps, _lumens, multiplier] = [next()?, next()?, next()?];
        let [rows, columns] = [count(next()?, text)?, count(next()?, text)?];
        let kind = next()?;
        if kind != 1.0 {
            return Err(format!("profiles of photometric type {kind} are not supported, only of type 1 (C)").into());
        }
        let [_units, _width, _length, _height] = [next()?, next()?, next()?, next()?];
        let [ballast, lamp, _watts] = [next()?, next()?, next()?];
        let mut list = |n: usize| (0..n).map(|_| next()).collect::<Result<Vec<f64>, _>>();
        let (down, around) = (list(rows)?, list(columns)?);
        for (angles, most) in [(&down, 180.0), (&around, 360.0)] {
            let ascend = angles.windows(2).all(|pair| pair[0] < pair[1]);
            let within = angles.first().is_some_and(|x| *x >= 0.0) && angles.last().is_some_and(|x| *x <= most);
            if !(ascend && within) {
                return Err(format!("broken profile: angles must ascend in [0, {most}]").into());
            }
        }
        if rows < 2 {
            return Err("broken profile: it needs two angles from its axis".into());
        }
        let total = rows.checked_mul(columns).filter(|total| *total <= text.len());
        let mut candela = list(total.ok_or("broken profile: numbers are missing")?)?;
        candela.iter_mut().for_each(|x| *x = (*x * multiplier * ballast * lamp).max(0.0));
        // Intensities that pixels can have, and means that their inverse has.
        if candela.iter().any(|x| *x > 1e30) {
            return Err("broken profile: an intensity is above 1e30 cd".into());
        }
        Ok(Table { down, around, candela })
    }

    /// The intensity in a direction, with linear interpolation. It is dark where the table does not reach.
    fn at(&self, down: f64, around: f64) -> f64 {
        let [first, last] = [self.around[0], self.around[self.around.len() - 1]];
        // Tables of a quarter or a half are mirrored.
        let around = match (first, last) {
            (0.0, 90.0) => 90.0 - (90.0 - around % 180.0).abs(),
            (0.0, 180.0) => 180.0 - (180.0 - around).abs(),
            (90.0, 270.0) if around < 90.0 => 180.0 - around,
            (90.0, 270.0) if around > 270.0 => 540.0 - around,
            _ => around,
        };
        let Some((row, t)) = between(&self.down, down) else { return 0.0 };
        let value = |column: usize, row: usize| self.candela[column * self.down.len() + row];
        let column = |column: usize| (1.0 - t) * value(column, row) + t * value(column, row + 1);
        let end = self.around.len() - 1;
        match between(&self.around, around) {
            Some((i, s)) => (1.0 - s) * column(i) + s * column((i + 1).min(end)),
            // Between the last angle and the first of the next turn.
            None => {
                let s = (around - last).rem_euclid(360.0) / (first + 360.0 - last);
                (1.0 - s) * column(end) + s * column(0)
            }
        }
    }

    /// The mean over the sphere, or over half of it for a table that has no more than a half.
    fn mean(&self) -> f64 {
        const STEPS: usize = 720;
        let around = if self.around.len() == 1 { 1 } else { COLUMNS };
        let ring = |i: usize| {
            let angle = 180.0 * (i as f64 + 0.5) / STEPS as f64;
            let sum: f64 = (0..around).map(|k| self.at(angle, 360.0 * k as f64 / around as f64)).sum();
            sum / around as f64 * angle.to_radians().sin()
        };
        let sphere = 0.5 * (0..STEPS).map(ring).sum::<f64>() * PI / STEPS as f64;
        // A tenth of a radian more than a half is still a half.
        let span = self.down[self.down.len() - 1] - self.down[0];
        if span.to_radians() > 0.5 * PI + 0.1 { sphere } else { 2.0 * sphere }
    }
}

/// A count, which is at most the length of the file.
fn count(number: f64, text: &str) -> Result<usize, Invalid> {
    if number >= 1.0 && number <= text.len() as f64 && number.fract() == 0.0 {
        Ok(number as usize)
    } else {
        Err(format!("broken profile: {number} is no possible count").into())
    }
}

/// The interval of a number among ascending ones, and where in it the number is.
fn between(numbers: &[f64], x: f64) -> Option<(usize, f64)> {
    let [first, .., last] = *numbers else { return Some((0, 0.0)) };
    let i = numbers.partition_point(|&number| number <= x).checked_sub(1)?.min(numbers.len() - 2);
    (first..=last).contains(&x).then(|| (i, (x - numbers[i]) / (numbers[i + 1] - numbers[i])))
}

/// Writes the image of a profile as a file.
pub(crate) fn encode(image: &Texture) -> String {
    let (width, height) = (image.width, image.height);
    // The last column is the first again.
    let columns = if width == 1 { 1 } else { width + 1 };
    let mut text = format!("IESNA:LM-63-2002\nTILT=NONE\n1 -1 1 {height} {columns} 1 2 0 0 0\n1 1 0\n");
    let mut line = |values: &mut dyn Iterator<Item = f64>| {
        // Lines of such files are short.
        for (i, value) in values.enumerate() {
            let gap = if i % 10 == 9 { '\n' } else { ' ' };
            write!(text, "{value}{gap}").expect("a string takes all");
        }
        text.push('\n');
    };
    line(&mut (0..height).map(|row| 180.0 * row as f64 / (height - 1).max(1) as f64));
    line(&mut (0..columns).map(|column| 360.0 * column as f64 / width as f64));
    for column in 0..columns {
        let value = |row: usize| image.pixels.get(row * width + column % width)[0];
        // The shortest decimal of single precision.
        line(&mut (0..height).map(|row| value(row).to_string().parse().unwrap_or(0.0)));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use vellus_scene::Wrap;

    const PLAIN: Use = Use { normalize: false, angle_scale: 0 };

    /// A lamp of an old file, without a first line, with a table of tilts. Numbers are on several lines, and some have
    /// commas.
    fn quarter() -> String {
        let tilt = "TILT=INCLUDE\r\n1\r\n2\r\n0 90\r\n1.0 0.9\r\n";
        format!(
            "A lamp\r\n{tilt}1 1000. 2.0 3 2 1 1 0.1,0.1, 0\r\n0.5 1 60\r\n0 45\r\n90\r\n0 90\r\n8 4 0\r\n80 40 0\r\n"
        )
    }

    fn image(text: &str, used: Use) -> Texture {
        let Pixels { width, height, rgb } = decode(text.as_bytes(), used).unwrap();
        Texture { name: String::new(), width, height, pixels: rgb, wrap: [Wrap::Repeat, Wrap::Clamp] }
    }

    /// The pixel at angles in degrees.
    fn at(image: &Texture, down: f64, around: usize) -> f32 {
        image.pixels.get((4.0 * down) as usize * image.width + around % image.width)[0]
    }

    #[test]
    fn a_quarter_is_mirrored_and_scaled() {
        let lamp = image(&quarter(), PLAIN);
        assert_eq!((lamp.width, lamp.height), (360, 721));
        for (around, factor) in [(0, 1.0), (90, 10.0), (180, 1.0), (270, 10.0), (45, 5.5), (315, 5.5), (10, 2.0)] {
            for (down, candela) in [(0.0, 8.0), (45.0, 4.0), (22.5, 6.0), (90.0, 0.0), (90.25, 0.0), (180.0, 0.0)] {
                assert!((at(&lamp, down, around) - factor * candela).abs() < 1e-5, "{down} {around}");
            }
        }
    }

    #[test]
    fn halves_and_whole_turns_have_their_columns() {
        let table = |angles: &str, values: &str| {
            let columns = angles.split(' ').count();
            image(&format!("TILT=NONE\n1 1 1 2 {columns} 1 2 0 0 0 1 1 1\n0 180 {angles} {values}"), PLAIN)
        };
        let around = |lamp: &Texture| [0, 90, 180, 270, 350].map(|around| at(lamp, 0.0, around));
        assert_eq!(around(&table("0", "7 7")), [7.0; 5]);
        assert_eq!(around(&table("0 90 180", "1 1 2 2 3 3")), [1.0, 2.0, 3.0, 2.0, 1.0 + 1.0 / 9.0]);
        assert_eq!(around(&table("90 180 270", "1 1 2 2 3 3")), [2.0, 1.0, 2.0, 3.0, 2.0 + 1.0 / 9.0]);
        assert_eq!(around(&table("0 90 180 270", "1 1 2 2 3 3 10 10")), [1.0, 2.0, 3.0, 10.0, 2.0]);
        assert_eq!(around(&table("0 180 360", "1 1 3 3 1 1")), [1.0, 2.0, 3.0, 2.0, 1.0 + 1.0 / 9.0]);
    }

    /// The mean is that of the sphere, or of the half that the table has.
    #[test]
    fn normalized_profiles_have_the_mean_1() {
        let normalized = Use { normalize: true, ..PLAIN };
        for (angles, values, mean) in [("0 90", "4 4", 4.0), ("0 180", "4 4", 4.0), ("0 90 90.01 180", "4 4 0 0", 2.0)]
        {
            let rows = angles.split(' ').count();
            let text = format!("TILT=NONE\n1 1 1 {rows} 1 1 2 0 0 0 1 1 1\n{angles} 0 {values}");
            let found = at(&image(&text, normalized), 45.0, 0);
            assert!((found - 4.0 / mean).abs() < 1e-3, "{angles}: {found}");
        }
    }

    /// A positive scale keeps the axis, a negative one the opposite direction.
    #[test]
    fn an_angle_scale_widens_the_lamp() {
        let text = "TILT=NONE\n1 1 1 2 1 1 2 0 0 0 1 1 1\n0 180 0 0 180";
        let lamp = |scale: f32| image(text, Use { angle_scale: scale.to_bits(), ..PLAIN });
        assert_eq!([at(&lamp(2.0), 90.0, 0), at(&lamp(0.5), 60.0, 0), at(&lamp(0.5), 120.0, 0)], [45.0, 120.0, 180.0]);
        assert_eq!([at(&lamp(-2.0), 90.0, 0), at(&lamp(-0.5), 120.0, 0), at(&lamp(-0.5), 30.0, 0)], [135.0, 60.0, 0.0]);
    }

    #[test]
    fn a_written_profile_is_the_same() {
        for columns in [1, COLUMNS] {
            let value = |i: usize| [1.0 / (1.0 + i as f32); 3];
            let pixels = (0..ROWS * columns).map(value).collect();
            let lamp = Texture {
                name: String::new(),
                width: columns,
                height: ROWS,
                pixels,
                wrap: [Wrap::Repeat, Wrap::Clamp],
            };
            assert_eq!(image(&encode(&lamp), PLAIN), lamp);
        }
    }

    #[test]
    fn broken_profiles_are_errors() {
        let whole = quarter();
        for end in 0..whole.trim_end().len() - 1 {
            assert!(decode(&whole.as_bytes()[..end], PLAIN).is_err() || end > whole.len() - 6, "{end}");
        }
        for at in 0..whole.len() {
            for byte in [b'9', b'-', b'e', b' ', 0xff] {
                let mut bytes = whole.clone().into_bytes();
                bytes[at] = byte;
                let _ = Table::read(&String::from_utf8_lossy(&bytes)).map(|table| table.mean());
            }
        }
        let error = |text: &str| decode(text.as_bytes(), PLAIN).unwrap_err().0;
        assert!(error("\u{89}PNG").contains("no IES profile"));
        let of_type = |kind: &str| format!("TILT=NONE\n1 1 1 2 1 {kind} 2 0 0 0 1 1 1\n0 90 0 1 1");
        assert!(error(&of_type("2")).contains("photometric type 2"));
        assert!(decode(of_type("1").as_bytes(), PLAIN).is_ok());
        assert!(error("TILT=NONE\n1 1 1 999999 9 1 2 0 0 0").contains("999999 is no possible count"));
        assert!(error("TILT=NONE\n1 1 1 2 1 1 2 0 0 0 1 1 1\n90 0 0 1 1").contains("ascend in [0, 180]"));
    }
}

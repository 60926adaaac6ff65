//! Values of splines (Ts): pieces between knots that are constant, linear or cubic, and how they go on outside.

use openusd::sdf::Value;

/// The largest number of knots that loops inside a spline may bring.
const MOST_KNOTS: usize = 1 << 16;

/// A point of a spline.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Knot {
    time: f64,
    value: f64,
    /// The value that the piece before it ends at.
    before: f64,
    /// Slopes of the tangents before and behind the knot.
    slopes: [f64; 2],
    /// Their lengths in time, for Bézier curves.
    widths: [f64; 2],
    piece: Piece,
}

/// The values between a knot and the next one.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Piece {
    Held,
    Linear,
    Curve,
    /// No value.
    Blocked,
}

/// The values before the first knot, or behind the last one.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Outside {
    Blocked,
    Held,
    Linear,
    Sloped(f64),
    Repeat,
    Reset,
    Oscillate,
}

/// A function of time.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Spline {
    /// At least one, in the order of their times.
    knots: Vec<Knot>,
    is_hermite: bool,
    outside: [Outside; 2],
}

impl Spline {
    /// The spline that a field of a layer has. `None` if it is not valid.
    pub fn of(field: &Value) -> Option<Self> {
        let Value::Dictionary(all) = field else { return None };
        let word = |value: Option<&Value>| value.and_then(Value::as_str).map(str::to_owned);
        let Value::ValueVec(knots) = all.get("knots")? else { return None };
        let mut knots: Vec<Knot> = knots.iter().map(knot).collect::<Option<_>>()?;
        knots.sort_by(|a, b| a.time.total_cmp(&b.time));
        if knots.is_empty() || knots.iter().any(|knot| !knot.is_finite()) {
            return None;
        }
        let outside = ["preExtrapolation", "postExtrapolation"].map(|name| match all.get(name) {
            Some(Value::Dictionary(mode)) => Some(match word(mode.get("mode"))?.as_str() {
                "held" => Outside::Held,
                "linear" => Outside::Linear,
                "sloped" => Outside::Sloped(number(mode, "slope").filter(|slope| slope.is_finite())?),
                "blocked" => Outside::Blocked,
                "loopRepeat" => Outside::Repeat,
                "loopReset" => Outside::Reset,
                "loopOscillate" => Outside::Oscillate,
                _ => return None,
            }),
            _ => Some(Outside::Held),
        });
        if let Some(Value::Dictionary(inner)) = all.get("loopParameters") {
            let [start, end, before, behind, offset] =
                ["protoStart", "protoEnd", "numPreLoops", "numPostLoops", "valueOffset"]
                    .map(|name| number(inner, name));
            knots = looped(knots, [start?, end?, offset?], [before?, behind?])?;
        }
        let is_hermite = word(all.get("curveType"))? == "hermite";
        Some(Spline { knots, is_hermite, outside: [outside[0]?, outside[1]?] })
    }

    /// The value at a time, if there is one.
    pub fn at(&self, time: f64) -> Option<f64> {
        let (first, last) = (self.knots[0], self.knots[self.knots.len() - 1]);
        let side = usize::from(time >= last.time);
        if time >= first.time && side == 0 {
            return self.inside(time);
        }
        let (knot, value) = if side == 0 { (first, first.before) } else { (last, last.value) };
        let period = last.time - first.time;
        // At the last knot itself, a loop has begun again.
        let turns = ((time - first.time) / period).floor();
        let within = (time - turns * period).clamp(first.time, last.time);
        match self.outside[side] {
            Outside::Blocked => None,
            Outside::Held => Some(value),
            Outside::Sloped(slope) => Some(value + slope * (time - knot.time)),
            Outside::Linear => Some(value + self.slope(side) * (time - knot.time)),
            _ if period <= 0.0 => Some(value),
            Outside::Repeat => Some(self.inside(within)? + turns * (last.value - first.value)),
            Outside::Reset => self.inside(within),
            Outside::Oscillate if turns.rem_euclid(2.0) == 1.0 => self.inside(first.time + last.time - within),
            Outside::Oscillate => self.inside(within),
        }
    }

    /// The slope at one end, with that of its piece. It is 0 where there are two values.
    fn slope(&self, side: usize) -> f64 {
        let count = self.knots.len();
        let pair = if side == 0 { self.knots.get(..2) } else { self.knots.get(count.wrapping_sub(2)..) };
        let Some(&[a, b]) = pair else { return 0.0 };
        let end = [a, b][side];
        match a.piece {
            _ if end.before != end.value => 0.0,
            Piece::Held | Piece::Blocked => 0.0,
            Piece::Linear => (b.before - a.value) / (b.time - a.time),
            Piece::Curve => end.slopes[1 - side],
        }
    }

    /// The value between the first and the last knot.
    fn inside(&self, time: f64) -> Option<f64> {
        let next = self.knots.partition_point(|knot| knot.time <= time);
        let a = &self.knots[next.checked_sub(1)?];
        let Some(b) = self.knots.get(next) else { return Some(a.value) };
        let span = b.time - a.time;
        let t = (time - a.time) / span;
        match a.piece {
            Piece::Blocked => None,
            Piece::Held => Some(a.value),
            Piece::Linear => Some(a.value + t * (b.before - a.value)),
            Piece::Curve if self.is_hermite => {
                let [from, to] = [a.slopes[1], b.slopes[0]].map(|slope| slope * span / 3.0);
                Some(bezier([a.value, a.value + from, b.before - to, b.before], t))
            }
            Piece::Curve => {
                let widths = not_backwards([a.widths[1] / span, b.widths[0] / span]);
                let [from, to] = [widths[0] * a.slopes[1], widths[1] * b.slopes[0]].map(|rise| rise * span);
                let u = parameter([0.0, widths[0], 1.0 - widths[1], 1.0], t);
                Some(bezier([a.value, a.value + from, b.before - to, b.before], u))
            }
        }
    }
}

impl Knot {
    fn is_finite(&self) -> bool {
        let [a, b] = self.slopes;
        let [c, d] = self.widths;
        [self.time, self.value, self.before, a, b, c, d].iter().all(|x| x.is_finite()) && c >= 0.0 && d >= 0.0
    }
}

fn number(all: &std::collections::HashMap<String, Value>, name: &str) -> Option<f64> {
    if let Some(Value::Double(x)) = all.get(name) { Some(*x) } else { None }
}

/// The parser calls the first number of a tangent its slope, but it is its width.
fn knot(value: &Value) -> Option<Knot> {
    let Value::Dictionary(all) = value else { return None };
    let of = |name: &str| number(all, name);
    Some(Knot {
        time: of("time")?,
        value: of("value")?,
        before: of("preValue")?,
        widths: [of("preTangentSlope")?, of("postTangentSlope")?],
        slopes: [of("preTangentWidth")?, of("postTangentWidth")?],
        piece: match all.get("nextInterpolationMode").and_then(Value::as_str)? {
            "held" => Piece::Held,
            "linear" => Piece::Linear,
            "curve" => Piece::Curve,
            "none" => Piece::Blocked,
            _ => return None,
        },
    })
}

/// The knots with copies of those from `start` on and before `end`, and of the first one behind the last copy. Other
/// knots at the times of copies are replaced.
fn looped(knots: Vec<Knot>, [start, end, offset]: [f64; 3], counts: [f64; 2]) -> Option<Vec<Knot>> {
    let period = end - start;
    let prototype: Vec<Knot> = knots.iter().copied().filter(|knot| (start..end).contains(&knot.time)).collect();
    let first = prototype.first().filter(|first| first.time == start);
    let (Some(first), true) = (first, period > 0.0 && offset.is_finite()) else { return Some(knots) };
    let [before, behind] = counts.map(|count| count.max(0.0).floor());
    if (before + behind + 1.0) * prototype.len() as f64 > MOST_KNOTS as f64 {
        return None;
    }
    let moved = |knot: &Knot, turn: f64| Knot {
        time: knot.time + turn * period,
        value: knot.value + turn * offset,
        before: knot.before + turn * offset,
        ..*knot
    };
    let (low, high) = (start - before * period, end + behind * period);
    let mut all: Vec<Knot> = knots.iter().copied().filter(|knot| knot.time < low).collect();
    for turn in -(before as i64)..=behind as i64 {
        all.extend(prototype.iter().map(|knot| moved(knot, turn as f64)));
    }
    let last = moved(first, behind + 1.0);
    let rest: Vec<Knot> = knots.iter().copied().filter(|knot| knot.time > high).collect();
    all.push(last);
    all.extend(rest);
    Some(all)
}

/// The lengths of two tangents, relative to the distance of their knots, at which the curve does not go back in time:
/// both become shorter by the same factor.
fn not_backwards([a, b]: [f64; 2]) -> [f64; 2] {
    let longest = a + b - (a * b).sqrt();
    if longest > 1.0 { [a / longest, b / longest] } else { [a, b] }
}

fn bezier([a, b, c, d]: [f64; 4], u: f64) -> f64 {
    let v = 1.0 - u;
    v * v * v * a + 3.0 * u * v * (v * b + u * c) + u * u * u * d
}

/// The parameter at which a curve that does not go back has a value in [0, 1].
fn parameter(points: [f64; 4], value: f64) -> f64 {
    let [mut low, mut high] = [0.0, 1.0];
    // Each step halves the interval, down to the precision of the numbers.
    for _ in 0..54 {
        let middle = 0.5 * (low + high);
        if bezier(points, middle) < value { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

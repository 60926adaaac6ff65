//! The fields of a request, checked.

use serde::Deserialize;
use serde_json::{Map, Value};
use vellus::glam::Vec3;
use vellus::{Bcsdf, FiberBuilder, Parameter, Window, direction};

/// The largest inclination, in degrees. At 90° the light runs along the fibre and never meets it.
const STEEPEST: f64 = 89.0;

/// The builder of a fibre that a page sends. With a reflectance, the absorption beside it does not count.
///
/// # Errors
/// A message about the fibre, if it is not valid.
pub fn builder(fiber: &Value) -> Result<FiberBuilder, String> {
    let mut fiber = fiber.clone();
    if let Some(fields) = fiber.as_object_mut().filter(|fields| fields.contains_key(Parameter::Reflectance.name())) {
        fields.retain(|name, _| ![Parameter::SigmaCa, Parameter::SigmaMa].iter().any(|p| p.name() == name));
    }
    FiberBuilder::deserialize(fiber).map_err(|e| format!("fiber: {e}"))
}

/// A request: an object with the field `ask` and others.
pub struct Request(Map<String, Value>);

impl Request {
    pub fn parse(text: &str) -> Result<Self, String> {
        match serde_json::from_str(text) {
            Ok(Value::Object(fields)) => Ok(Request(fields)),
            Ok(_) => Err("the request must be an object".to_owned()),
            Err(e) => Err(format!("the request is no JSON: {e}")),
        }
    }

    pub fn field(&self, name: &str) -> Option<&Value> {
        self.0.get(name).filter(|value| !value.is_null())
    }

    pub fn text(&self, name: &str) -> Result<&str, String> {
        self.field(name).and_then(Value::as_str).ok_or_else(|| format!("{name} is missing, or is no text"))
    }

    /// A number in a range, or its default.
    pub fn number(&self, name: &str, default: f64, range: [f64; 2]) -> Result<f64, String> {
        self.field(name).map_or(Ok(default), |value| within(name, value, range))
    }

    /// A whole number in a range, or its default.
    pub fn count(&self, name: &str, default: u32, [low, high]: [u32; 2]) -> Result<u32, String> {
        let x = self.number(name, f64::from(default), [f64::from(low), f64::from(high)])?;
        if x.fract() == 0.0 { Ok(x as u32) } else { Err(format!("{name} = {x} must be a whole number")) }
    }

    /// The fibre and the colours given for it. [`vellus::Fiber::hair`] without one.
    pub fn builder(&self) -> Result<FiberBuilder, String> {
        match self.field("fiber") {
            Some(fiber) => builder(fiber),
            None => Ok(FiberBuilder::default()),
        }
    }

    /// The model of the fibre.
    pub fn bcsdf(&self) -> Result<Bcsdf<'static>, String> {
        let fiber = self.builder()?.build().map_err(|e| format!("fiber: {e}"))?;
        Bcsdf::new(&fiber).map_err(|e| format!("fiber: {e}"))
    }

    /// θ_o in degrees.
    pub fn theta(&self) -> Result<f64, String> {
        self.number("theta", 0.0, [-STEEPEST, STEEPEST])
    }

    /// ω_o, at the azimuth 0.
    pub fn wo(&self) -> Result<Vec3, String> {
        Ok(direction(self.theta()?.to_radians(), 0.0))
    }

    /// The offset of the hit. It is 0 by default.
    pub fn h(&self) -> Result<f64, String> {
        self.number("h", 0.0, [-1.0, 1.0])
    }

    /// The hit: `window`, or one offset `h`, or the whole width.
    pub fn window(&self) -> Result<Window, String> {
        match (self.field("window"), self.field("h")) {
            (Some(_), Some(_)) => Err("give h or window, not both".to_owned()),
            (Some(window), None) => Window::deserialize(window).map_err(|e| format!("window: {e}")),
            (None, Some(_)) => Ok(Window::near(self.h()? as f32)),
            (None, None) => Ok(Window::far()),
        }
    }
}

fn within(name: &str, value: &Value, [low, high]: [f64; 2]) -> Result<f64, String> {
    match value.as_f64() {
        Some(x) if (low..=high).contains(&x) => Ok(x),
        _ => Err(format!("{name} = {value}: it must be a number in [{low}, {high}]")),
    }
}

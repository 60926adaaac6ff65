//! The table of parameters with labels, the presets, and fibres with their colours.

use crate::request::Request;
use serde_json::{Value, json};
use vellus::{Fiber, FiberBuilder, Lobe, Parameter, ParameterUnit, Species};

fn unit(unit: ParameterUnit) -> &'static str {
    match unit {
        ParameterUnit::PerRadius => "1/radius",
        other => other.sign(),
    }
}

/// `red-fox` as `Red fox`.
fn title(species: Species) -> String {
    let name = species.name().replace('-', " ");
    let mut letters = name.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// A fibre as an object with every parameter, also those that files of fibres leave out.
fn fiber_value(fiber: &Fiber) -> Result<Value, String> {
    let mut value = serde_json::to_value(fiber).map_err(|e| format!("fiber: {e}"))?;
    for parameter in Parameter::ALL {
        if let (None, Some(stored)) = (value.get(parameter.name()), parameter.get(fiber)) {
            let numbers = stored.map(|x| parameter.unit().from_stored(x));
            value[parameter.name()] = if parameter.channels() == 3 { json!(numbers) } else { json!(numbers[0]) };
        }
    }
    Ok(value)
}

/// The answer to `parameters`.
pub fn table() -> Result<Value, String> {
    let base = fiber_value(&Fiber::hair())?;
    let row = |parameter: Parameter| {
        let channels: Vec<String> = match parameter.channels() {
            1 => Vec::new(),
            n => (0..n).map(|c| parameter.channel_name(c)).collect(),
        };
        json!({
            "key": parameter.name(),
            "symbol": parameter.symbol(),
            "label": parameter.label(),
            "unit": unit(parameter.unit()),
            "range": [parameter.range().low, parameter.range().high],
            "channels": channels,
            "choices": parameter.choices(),
            "is_color": parameter.is_color(),
            "is_stored": parameter.default_value().is_some(),
            "description": parameter.description(),
            "default": base.get(parameter.name()),
        })
    };
    let preset = |species: Species| {
        let [fiber, published] = [Fiber::preset(species), Fiber::published(species)].map(|f| fiber_value(&f));
        Ok(json!({ "key": species.name(), "label": title(species), "fiber": fiber?, "published": published? }))
    };
    Ok(json!({
        "parameters": Parameter::ALL.map(row),
        "presets": Species::ALL.into_iter().map(preset).collect::<Result<Vec<_>, String>>()?,
        "lobes": Lobe::ALL.map(Lobe::key),
        "base": base,
    }))
}

/// The answer to `check`.
pub fn check(request: &Request) -> Result<Value, String> {
    describe(&request.builder()?)
}

/// The answer to `color`: the fibre with another colour.
pub fn color(request: &Request) -> Result<Value, String> {
    const WAYS: [Parameter; 3] = [Parameter::Melanin, Parameter::Reflectance, Parameter::HairReflectance];
    let given: Vec<_> = WAYS.into_iter().filter_map(|way| Some((way, request.field(way.name())?))).collect();
    let [(way, value)] = given[..] else {
        return Err(format!("give one of {}, not {}", WAYS.map(Parameter::name).join(", "), given.len()));
    };
    let mut builder = FiberBuilder::new(request.builder()?.build().map_err(|e| format!("fiber: {e}"))?);
    let numbers = match value {
        Value::Array(values) => values.iter().map(Value::as_f64).collect::<Option<Vec<_>>>(),
        value => value.as_f64().map(|x| vec![x]),
    };
    let numbers = numbers.ok_or_else(|| format!("{way} = {value}: it must be a number or an array of numbers"))?;
    let numbers: Vec<f32> = numbers.into_iter().map(|x| x as f32).collect();
    builder.set(way.name(), &numbers).map_err(|e| e.to_string())?;
    describe(&builder)
}

/// A fibre, the colour of its coat, and a note if no pigment reaches the colour that was given.
fn describe(builder: &FiberBuilder) -> Result<Value, String> {
    let fiber = builder.build().map_err(|e| format!("fiber: {e}"))?;
    let coat = fiber.coat_color().map_err(|e| format!("fiber: {e}"))?;
    let note = builder.out_of_reach().map_err(|e| format!("fiber: {e}"))?.map(|out| out.to_string());
    Ok(json!({ "fiber": fiber_value(&fiber)?, "coat": coat, "note": note }))
}

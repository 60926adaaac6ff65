//! A shader of another program while it is mapped to a fibre.

use crate::error::Error;
use crate::read::context::Reader;
use crate::read::look::{PRIMVAR_READER, Shaded};
use crate::read::network::{Input, Shader, Walk, input};
use crate::read::shading::value::Value;
use crate::read::shading::{image, materialx, nodes};
use crate::stage::Property;
use vellus::{Fiber, FiberBuilder, Parameter};
use vellus_scene::{Look, Texture, Tint, Value as Textured};

/// The largest number of nodes that compute one input from others, one behind another. A circle has no end.
const MOST_NESTED: usize = 16;

/// The largest number of nodes that are computed for a shader.
const MOST_COMPUTED: usize = 1024;

/// A shader of another program while it is mapped to a fibre.
pub(super) struct Mapping<'r, 'a> {
    pub reader: &'r mut Reader<'a>,
    /// The shader of the fibre.
    pub shader: Shader,
    builder: FiberBuilder,
    textured: Vec<(Parameter, Textured)>,
    /// Parameters and the inputs that they were set from, for the report.
    mapped: Vec<String>,
    /// What has no counterpart, for the report.
    lost: Vec<String>,
    /// Values that were moved into the range of their parameter.
    held: Vec<String>,
    /// Parameters that the shader reads from primvars, with their names.
    primvars: Vec<(Parameter, String)>,
    /// The name of the texture coordinates of the image that was read last.
    uv: Option<String>,
    /// The number of nodes around the one that is computed.
    nested: usize,
    /// The number of nodes that were computed.
    computed: usize,
}

impl<'r, 'a> Mapping<'r, 'a> {
    pub fn new(reader: &'r mut Reader<'a>, shader: Shader) -> Self {
        let builder = FiberBuilder::new(reader.options.network_base);
        Mapping {
            reader,
            shader,
            builder,
            textured: Vec::new(),
            mapped: Vec::new(),
            lost: Vec::new(),
            held: Vec::new(),
            primvars: Vec::new(),
            uv: None,
            nested: 0,
            computed: 0,
        }
    }

    /// Begins with the parameters of hair, and with the choices of the shader's inputs.
    pub fn begin_with_defaults(&mut self) -> Result<(), Error> {
        self.builder = FiberBuilder::new(Fiber::hair());
        for parameter in Parameter::ALL.into_iter().filter(|parameter| !parameter.choices().is_empty()) {
            let name = format!("inputs:{parameter}");
            if let Input::Value(at) = input(self.reader.stage, &self.shader.prim, &name)? {
                let word = self.reader.stage.words(&at.prim, &at.name)?.and_then(|words| words.into_iter().next());
                let set = self.builder.set_word(parameter.name(), &word.unwrap_or_default());
                set.map_err(|error| Error::prim(&self.shader.prim, error.to_string()))?;
            }
        }
        Ok(())
    }

    /// Sets a parameter, in radians for angles. `from` names the inputs for the report.
    pub fn set(&mut self, parameter: Parameter, value: Value, from: &str) {
        match value {
            Value::Constant(value) => {
                let value = value.map(|x| self.held(parameter, x as f32, from));
                self.builder.set_value(parameter, value);
            }
            Value::Image(_) if !parameter.varies() => {
                let what = format!("{parameter} is one number for all strands: its image is ignored");
                self.reader.warnings.add(&self.shader.prim, what);
                return;
            }
            Value::Image(mut texture) => {
                let (range, unit) = (parameter.range(), parameter.unit());
                let in_file = |x: f32| unit.from_stored(range.nearest(x));
                texture.pixels.map_each(|_, x| in_file(x));
                let texture = self.reader.add_texture(texture, self.uv.clone());
                self.textured.push((parameter, Textured { texture, scale: [1.0; 3] }));
            }
        }
        self.mapped.push(format!("{} from {from}", parameter.name()));
    }

    /// A value in the range of its parameter, in radians for angles. Reports one that is outside.
    fn held(&mut self, parameter: Parameter, value: f32, from: &str) -> f32 {
        let (range, unit) = (parameter.range(), parameter.unit());
        let given = unit.from_stored(value);
        if range.contains(given) {
            return value;
        }
        let (nearest, name, suffix) = (range.nearest(given), parameter.name(), unit.suffix());
        let gives = if from.contains(" and ") { "give" } else { "gives" };
        let what = format!(
            "inputs:{from} {gives} {name} = {given}: the range is {range}{suffix}, so it is clamped to {nearest}"
        );
        if !self.held.contains(&what) {
            self.held.push(what);
        }
        unit.to_stored(nearest)
    }

    /// Sets a parameter from a primvar of the curves if an input of the shader is connected to its reader. Curves
    /// without the primvar get the reader's fallback. Returns whether there is a reader.
    pub fn set_primvar(&mut self, parameter: Parameter, name: &str) -> Result<bool, Error> {
        let prim = self.shader.prim.clone();
        let Some(node) = self.node(&prim, name)?.filter(|node| node.id.starts_with(PRIMVAR_READER)) else {
            return Ok(false);
        };
        let varname = self.reader.prim(&node.prim)?.input_token("inputs:varname")?;
        let varname = varname.ok_or_else(|| Error::prim(&node.prim, "inputs:varname must name a primvar"))?;
        let fallback = self.value_of(&node.prim, "fallback", [0.0; 3])?;
        self.set(parameter, fallback, name);
        self.primvars.push((parameter, varname));
        Ok(true)
    }

    /// Reports something that has no counterpart: an input, or several in words.
    pub fn lose(&mut self, what: impl Into<String>) {
        let what = what.into();
        self.known(&[&what]);
        self.lost.push(what);
    }

    /// Notes that inputs are known. What happens with them is reported in other words.
    pub fn known(&mut self, names: &[&str]) {
        let names: Vec<String> = names.iter().map(|name| format!("inputs:{name}")).collect();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        // The shader's properties were read before: this cannot fail.
        let _ = self.reader.stage.know(&self.shader.prim, &names);
    }

    /// Notes that all inputs are known whose names begin with one of these.
    pub fn know_all(&mut self, beginnings: &[&str]) -> Result<(), Error> {
        let properties = self.reader.stage.properties(&self.shader.prim)?;
        let inputs = properties.iter().filter_map(|name| name.strip_prefix("inputs:"));
        let names: Vec<&str> =
            inputs.filter(|name| beginnings.iter().any(|beginning| name.starts_with(beginning))).collect();
        self.known(&names);
        Ok(())
    }

    /// Reports inputs of the shader that do not have the value at which they have no effect. `neutral` has the value of
    /// each channel.
    pub fn lose_unless(&mut self, neutral: f64, names: &[&str]) -> Result<(), Error> {
        for name in names {
            if self.has(name)? && self.value(name, [neutral; 3])? != Value::number(neutral) {
                self.lose(*name);
            }
        }
        Ok(())
    }

    /// Whether an input of the shader has a value or a connection.
    pub fn has(&self, name: &str) -> Result<bool, Error> {
        let prim = self.shader.prim.as_str();
        Ok(!matches!(input(self.reader.stage, prim, &format!("inputs:{name}"))?, Input::Unset))
    }

    /// The source of an input of a node, if that is an output of another node.
    pub fn node(&self, prim: &str, name: &str) -> Result<Option<Shader>, Error> {
        Ok(match input(self.reader.stage, prim, &format!("inputs:{name}"))? {
            Input::Shader(shader) => Some(shader),
            _ => None,
        })
    }

    /// The value of an input of the shader.
    pub fn value(&mut self, name: &str, default: [f64; 3]) -> Result<Value, Error> {
        let prim = self.shader.prim.clone();
        self.value_of(&prim, name, default)
    }

    /// The value of an input of the shader that is a number.
    pub fn number(&mut self, name: &str, default: f64) -> Result<Value, Error> {
        self.value(name, [default; 3])
    }

    /// As [`Mapping::value`], for a colour, or a number from 0 to 1. Reports a constant that is outside.
    pub fn share(&mut self, name: &str, default: [f64; 3]) -> Result<Value, Error> {
        let prim = self.shader.prim.clone();
        self.share_of(&prim, name, default)
    }

    /// As [`Mapping::value_of`], for a colour, or a number from 0 to 1. Reports a constant that is outside.
    pub fn share_of(&mut self, prim: &str, name: &str, default: [f64; 3]) -> Result<Value, Error> {
        let value = self.value_of(prim, name, default)?;
        let Value::Constant(color) = value else { return Ok(value) };
        // A conversion between colour spaces rounds.
        let allowed = -1e-6..=1.0 + 1e-6;
        if !color.iter().all(|x| allowed.contains(x)) {
            let [r, g, b] = color.map(|x| x as f32);
            let shown = if r == g && g == b { format!("{r}") } else { format!("({r}, {g}, {b}) in linear Rec. 709") };
            let what = format!("inputs:{name} is {shown}: it must be in [0, 1], and the nearest value is used");
            self.reader.complain(prim, what)?;
        }
        Ok(Value::Constant(color.map(|x| x.clamp(0.0, 1.0))))
    }

    /// The image of a node for normal maps, and its factors along u and v. `None` if it has no image.
    pub fn normal_map(&mut self, node: &str) -> Result<Option<(Texture, [f64; 2])>, Error> {
        let Value::Image(image) = self.value_of(node, "in", [0.5, 0.5, 1.0])? else { return Ok(None) };
        let scale = self.value_of(node, "scale", [1.0; 3])?;
        self.reader.stage.know(node, &["inputs:space", "inputs:normal", "inputs:tangent", "inputs:bitangent"])?;
        Ok(match scale {
            Value::Constant([x, y, _]) => Some((image, [x, y])),
            Value::Image(_) => None,
        })
    }

    /// The value of an input of the shader that is a number and cannot have an image.
    pub fn constant(&mut self, name: &str, default: f64) -> Result<f64, Error> {
        match self.number(name, default)? {
            Value::Constant([x, ..]) => Ok(x),
            Value::Image(_) => {
                let what = format!("inputs:{name} cannot have an image: {default} is used");
                self.reader.warnings.add(&self.shader.prim, what);
                Ok(default)
            }
        }
    }

    /// The value of an input of the shader that is true or false.
    pub fn flag(&self, name: &str) -> Result<bool, Error> {
        Ok(match input(self.reader.stage, &self.shader.prim, &format!("inputs:{name}"))? {
            Input::Value(at) => self.reader.stage.flag(&at.prim, &at.name)?.unwrap_or(false),
            _ => false,
        })
    }

    /// The value of an input of any node, with one or three channels. A node that is not an image or a constant gives a
    /// warning, and the input's own value or the default.
    pub fn value_of(&mut self, prim: &str, name: &str, default: [f64; 3]) -> Result<Value, Error> {
        let key = format!("inputs:{name}");
        let (mut walk, mut default) = (Walk::from(prim, &key), default);
        let found = loop {
            match walk.end(self.reader.stage)? {
                Input::Unset => break None,
                Input::Value(at) => break self.reader.colors(&at.prim, &at.name)?,
                Input::Shader(node) if node.id.starts_with("ND_constant_") => {
                    walk.go(Property { prim: node.prim, name: "inputs:value".to_owned() })?;
                    default = [0.0; 3];
                }
                Input::Shader(node) => {
                    if let Some((texture, uv)) = image::read(self.reader, &node)? {
                        self.uv = uv;
                        return Ok(Value::Image(texture));
                    }
                    if let Some(value) = self.computed(&node, &key)? {
                        return Ok(value);
                    }
                    self.reader.warnings.add(prim, format!("{key}: a {} is not mapped and is ignored", node.id));
                    break self.reader.colors(prim, &key)?;
                }
            }
        };
        let Some(found) = found else { return Ok(Value::Constant(default)) };
        let wrong = || Error::prim(prim, format!("{key} must be one finite number, or three"));
        match (found.len(), found.values.as_slice()) {
            (1, &[x]) if x.is_finite() => Ok(Value::number(f64::from(x))),
            (1, &[x, y, z] | &[x, y, z, _]) if [x, y, z].iter().all(|x| x.is_finite()) => {
                Ok(Value::Constant([x, y, z].map(f64::from)))
            }
            _ => Err(wrong()),
        }
    }

    /// The value of a node that computes it from other values, or `None` if the node is not known.
    fn computed(&mut self, node: &Shader, key: &str) -> Result<Option<Value>, Error> {
        (self.nested, self.computed) = (self.nested + 1, self.computed + 1);
        if self.nested > MOST_NESTED || self.computed > MOST_COMPUTED {
            let what =
                format!("{key}: more than {MOST_NESTED} nodes are nested, or more than {MOST_COMPUTED} computed");
            return Err(Error::prim(&node.prim, what));
        }
        let value = nodes::value(self, node);
        self.nested -= 1;
        value
    }

    /// The colour of a surface. Its texture is that of the image that was read last.
    pub fn tint(&mut self, value: Value) -> Tint {
        match value {
            Value::Constant(color) => Tint { color: color.map(|x| x as f32), texture: None },
            Value::Image(texture) => {
                let texture = self.reader.add_texture(texture, self.uv.clone());
                Tint { color: [1.0; 3], texture: Some(texture) }
            }
        }
    }

    /// The look, and a warning that reports what was mapped.
    pub fn finish(self, material: &str) -> Result<Option<Shaded>, Error> {
        let Mapping { reader, shader, builder, textured, mapped, lost, held, primvars, .. } = self;
        held.into_iter().try_for_each(|what| reader.complain(&shader.prim, what))?;
        let is_own = shader.id == materialx::OWN;
        if mapped.is_empty() && !is_own {
            let what = format!("a {} without inputs that say anything about a fibre is ignored", shader.id);
            reader.warnings.add(&shader.prim, what);
            return Ok(None);
        }
        let out_of_range = |error: vellus::Error| Error::prim(&shader.prim, error.to_string());
        if let Some(color) = builder.out_of_reach().map_err(out_of_range)? {
            reader.warnings.add(&shader.prim, color.to_string());
        }
        let fiber = builder.build().map_err(out_of_range)?;
        let look = Look { name: reader.name(material)?, fiber, textured };
        if is_own {
            return Ok(Some((look, primvars)));
        }
        let mut what = format!("{} is read as a fibre: {}.", shader.id, mapped.join(", "));
        what += " The other parameters are those of --fiber, or of hair without it";
        if fiber.kappa > 0.0 && fiber.sigma_ms == 0.0 {
            what += ". Its medulla does not scatter: choose a --fiber with one, such as red-fox";
        }
        if !lost.is_empty() {
            what += &format!(". Not mapped: {}", lost.join(", "));
        }
        reader.warnings.add(&shader.prim, what);
        reader.networks.push(look.name.clone());
        Ok(Some((look, primvars)))
    }
}

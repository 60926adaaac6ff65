//! What a stage says about the properties of a prim: values, connections, targets and metadata.

use super::spline::Spline;
use super::text::ascii;
use super::values::{numbers, precise};
use super::{Failure, Numbers, Property, Stage, When};
use crate::error::Error;
use crate::image::{TILES, tile_name};
use glam::DMat4;
use openusd::{sdf, usd};
use std::borrow::Cow;
use std::path::Path;

impl Stage {
    /// Reads numbers, vectors, or an array of them, in single precision.
    pub fn numbers(&self, prim: &str, name: &str, when: When) -> Result<Option<Numbers>, Error> {
        self.typed(prim, name, when, "numbers", numbers)
    }

    /// Reads one number, vector, quaternion (x, y, z, w) or matrix (column-major), in double precision.
    pub fn precise(&self, prim: &str, name: &str, when: When) -> Result<Option<Vec<f64>>, Error> {
        self.typed(prim, name, when, "a number, a vector or a matrix", precise)
    }

    /// Reads an array of numbers or vectors of double precision, one behind another, and the length of the vectors.
    pub fn doubles(&self, prim: &str, name: &str, when: When) -> Result<Option<(Vec<f64>, usize)>, Error> {
        self.typed(prim, name, when, "numbers of double precision", |value| match value {
            sdf::Value::DoubleVec(v) => Some((v, 1)),
            sdf::Value::Vec2dVec(v) => Some((v.into_iter().flat_map(<[f64; 2]>::from).collect(), 2)),
            sdf::Value::Vec3dVec(v) => Some((v.into_iter().flat_map(<[f64; 3]>::from).collect(), 3)),
            sdf::Value::Vec4dVec(v) => Some((v.into_iter().flat_map(<[f64; 4]>::from).collect(), 4)),
            _ => None,
        })
    }

    /// Reads an array of matrices.
    pub fn matrices(&self, prim: &str, name: &str, when: When) -> Result<Option<Vec<DMat4>>, Error> {
        self.typed(prim, name, when, "matrices", |value| match value {
            // USD multiplies row vectors, so its rows are the columns for column vectors.
            sdf::Value::Matrix4dVec(v) => Some(v.iter().map(|m| DMat4::from_cols_array(&m.0)).collect()),
            _ => None,
        })
    }

    /// Reads an array of integers.
    pub fn integers(&self, prim: &str, name: &str, when: When) -> Result<Option<Vec<i64>>, Error> {
        self.typed(prim, name, when, "integers", |value| match value {
            sdf::Value::IntVec(v) => Some(v.into_iter().map(i64::from).collect()),
            sdf::Value::UintVec(v) => Some(v.into_iter().map(i64::from).collect()),
            sdf::Value::Int64Vec(v) => Some(v),
            _ => None,
        })
    }

    /// Reads a token or string, or an array of them.
    pub fn words(&self, prim: &str, name: &str) -> Result<Option<Vec<String>>, Error> {
        self.typed(prim, name, When::Open, "tokens or strings", |value| match value {
            sdf::Value::TokenVec(v) => Some(v.iter().map(|t| t.as_str().to_owned()).collect()),
            sdf::Value::StringVec(v) => Some(v),
            other => other.as_str().map(|word| vec![word.to_owned()]),
        })
    }

    /// Reads a boolean. Numbers other than 0 are true.
    pub fn flag(&self, prim: &str, name: &str) -> Result<Option<bool>, Error> {
        self.typed(prim, name, When::Open, "a boolean", |value| match value {
            sdf::Value::Bool(flag) => Some(flag),
            other => precise(other).map(|v| v.first().is_some_and(|x| *x != 0.0)),
        })
    }

    /// The file that an attribute refers to, resolved against the layer of the reference. A file inside a package has
    /// the form `a.usdz[b.png]`.
    pub fn asset(&self, prim: &str, name: &str) -> Result<Option<String>, Error> {
        let Some(value) = self.value(prim, name, When::Open)? else { return Ok(None) };
        let (authored, resolved) = match &value {
            sdf::Value::AssetPath(asset) => (asset.asset_path(), asset.resolved_path().map(str::to_owned)),
            other => match other.as_str() {
                Some(path) => (path, self.resolved(prim, name, path)?),
                None => return Err(Error::prim(prim, format!("{name} must be the path of a file"))),
            },
        };
        match (authored, resolved) {
            ("", _) => Ok(None),
            (_, Some(resolved)) if !resolved.is_empty() => Ok(Some(resolved)),
            (authored, _) => Err(Error::prim(prim, format!("{name}: the file {authored} does not exist"))),
        }
    }

    /// The file that a string stands for, resolved against the layer that has the value.
    fn resolved(&self, prim: &str, name: &str, authored: &str) -> Result<Option<String>, Error> {
        self.ask(prim, |prim| {
            let graph = self.stage.prim_index(sdf::Path::new(prim)?).graph()?;
            for node in graph.all_nodes() {
                let property = node.path().append_property(name)?;
                for (layer, _) in self.stage.node_layer_stack(node) {
                    let Some(layer) = self.stage.layer_identifier(layer) else { continue };
                    let has_value = self.stage.layer(&layer).is_some_and(|layer| {
                        ["default", "timeSamples"]
                            .iter()
                            .any(|field| matches!(layer.data().try_field(&property, field), Ok(Some(_))))
                    });
                    if has_value {
                        return Ok(self.files.find(&layer, authored));
                    }
                }
            }
            Ok(None)
        })
    }

    /// The value of an attribute whose strongest value is a spline: `None` if it is not one, `Some(None)` if it has no
    /// value at this time. Within a layer, splines are stronger than the default value, and weaker than time samples.
    fn of_spline(&self, prim: &str, name: &str, time: f64) -> Result<Option<Option<f64>>, Failure> {
        let name = self.spelled(prim, name)?;
        let graph = self.stage.prim_index(sdf::Path::new(prim)?).graph()?;
        for node in graph.all_nodes() {
            let property = node.path().append_property(&*name)?;
            for (layer, offset) in self.stage.node_layer_stack(node) {
                let Some(layer) = self.stage.layer_identifier(layer) else { continue };
                let Some(layer) = self.stage.layer(&layer) else { continue };
                let field = |name: &str| layer.data().try_field(&property, name).ok().flatten();
                if field("timeSamples").is_some() {
                    return Ok(None);
                }
                if let Some(found) = field("spline") {
                    let spline =
                        Spline::of(&found).ok_or("its spline is not valid, or of a kind that is not supported")?;
                    let time = node.map_to_root().time_offset().inverse().apply(time);
                    return Ok(Some(spline.at(offset.inverse().apply(time))));
                }
                if field("default").is_some() {
                    return Ok(None);
                }
            }
        }
        Ok(None)
    }

    /// The bytes of a file that [`Stage::asset`] resolved.
    pub fn asset_bytes(&self, resolved: &str) -> Result<Vec<u8>, Error> {
        self.files.read(resolved).map_err(|what| Error::file(Path::new(resolved), what))
    }

    /// The numbers of the tiles of an image that [`Stage::asset`] resolved.
    pub fn tiles(&self, resolved: &str) -> Vec<usize> {
        TILES.filter(|&number| self.files.exists(&tile_name(resolved, number))).collect()
    }

    /// The time of the last sample of an attribute up to `time`, or of the first sample if all are later. `None` if the
    /// attribute has no samples.
    pub fn sample_before(&self, prim: &str, name: &str, time: f64) -> Result<Option<f64>, Error> {
        if !self.has_property(prim, name)? {
            return Ok(None);
        }
        self.ask(prim, |prim| {
            let around = self.attribute(prim, name)?.bracketing_time_samples(usd::TimeCode::new(time))?;
            Ok(around.map(|(before, _)| before))
        })
    }

    /// The time of the first sample of an attribute after `time`, if there is one.
    pub fn sample_after(&self, prim: &str, name: &str, time: f64) -> Result<Option<f64>, Error> {
        if !self.has_property(prim, name)? {
            return Ok(None);
        }
        self.ask(prim, |prim| {
            let later = usd::TimeCode::new(time + 1e-6 * time.abs().max(1.0));
            let around = self.attribute(prim, name)?.bracketing_time_samples(later)?;
            Ok(around.map(|(_, after)| after).filter(|after| *after > time))
        })
    }

    /// Whether a property is marked as one that no schema defines.
    pub fn is_custom(&self, prim: &str, name: &str) -> Result<bool, Error> {
        self.ask(prim, |prim| Ok(self.attribute(prim, name)?.get_metadata::<bool>("custom")?.unwrap_or(false)))
    }

    /// Whether a property has a value, a connection or a target.
    pub fn has_content(&self, prim: &str, name: &str) -> Result<bool, Error> {
        // A relationship has no connections, and an attribute no targets.
        Ok(self.has_value(prim, name)?
            || self.connection(prim, name).is_ok_and(|found| found.is_some())
            || self.targets(prim, name).is_ok_and(|targets| !targets.is_empty()))
    }

    /// Whether an attribute has a value.
    pub fn has_value(&self, prim: &str, name: &str) -> Result<bool, Error> {
        Ok(self.value(prim, name, When::Open)?.is_some())
    }

    /// A token in the metadata of a property, such as the interpolation of a primvar or the strength of a binding.
    pub fn metadata(&self, prim: &str, name: &str, key: &str) -> Result<Option<String>, Error> {
        if !self.has_property(prim, name)? {
            return Ok(None);
        }
        self.ask(prim, |prim| {
            // `get_metadata` only uses the path, so it works for relationships too.
            let value = self.attribute(prim, name)?.get_metadata::<sdf::Value>(key)?;
            Ok(value.and_then(|value| value.as_str().map(str::to_owned)))
        })
    }

    /// A number in the metadata of a property, such as the weight of a shape.
    pub fn metadata_number(&self, prim: &str, name: &str, key: &str) -> Result<Option<f64>, Error> {
        self.ask(prim, |prim| {
            let value = self.attribute(prim, name)?.get_metadata::<sdf::Value>(key)?;
            Ok(value.and_then(precise).and_then(|numbers| numbers.first().copied()))
        })
    }

    /// The property that an attribute is connected to.
    pub fn connection(&self, prim: &str, name: &str) -> Result<Option<Property>, Error> {
        if !self.has_property(prim, name)? {
            return Ok(None);
        }
        let instances = self.instances.borrow();
        self.ask(prim, |composed| {
            self.classes.check_targets(&self.stage, &self.files, composed, name)?;
            let connections = self.attribute(composed, name)?.connections()?;
            let property = connections.first().and_then(|path| path.as_str().rsplit_once('.'));
            Ok(property.map(|(to, name)| Property { prim: instances.seen_from(prim, to), name: name.to_owned() }))
        })
    }

    /// The instances of a PointInstancer that are not active, which is metadata of the prim.
    pub fn inactive_ids(&self, prim: &str) -> Result<Vec<i64>, Error> {
        self.ask(prim, |prim| {
            // `get_metadata` only uses the path, so it works for prims too.
            let value = self.stage.attribute(sdf::Path::new(prim)?).get_metadata::<sdf::Value>("inactiveIds")?;
            Ok(match value {
                Some(sdf::Value::Int64ListOp(list)) => list.flatten().into_iter().collect(),
                Some(sdf::Value::Int64Vec(ids)) => ids,
                _ => Vec::new(),
            })
        })
    }

    /// The targets of a relationship.
    pub fn targets(&self, prim: &str, name: &str) -> Result<Vec<String>, Error> {
        if !self.has_property(prim, name)? {
            return Ok(Vec::new());
        }
        let instances = self.instances.borrow();
        self.ask(prim, |composed| {
            self.classes.check_targets(&self.stage, &self.files, composed, name)?;
            let targets = self.stage.relationship(format!("{composed}.{name}")).targets()?;
            Ok(targets.iter().map(|path| instances.seen_from(prim, path.as_str())).collect())
        })
    }

    fn attribute(&self, prim: &str, name: &str) -> Result<usd::Attribute, Failure> {
        Ok(self.stage.attribute(format!("{prim}.{}", self.spelled(prim, name)?)))
    }

    /// The name of a property in the composed stage: text layers get names in ASCII.
    pub(super) fn spelled<'n>(&self, prim: &str, name: &'n str) -> Result<Cow<'n, str>, Error> {
        let is_known = name.is_ascii() || self.properties(prim)?.iter().any(|known| known == name);
        Ok(if is_known { name.into() } else { ascii(name) })
    }

    fn typed<T>(
        &self,
        prim: &str,
        name: &str,
        when: When,
        expected: &str,
        convert: impl FnOnce(sdf::Value) -> Option<T>,
    ) -> Result<Option<T>, Error> {
        let Some(value) = self.value(prim, name, when)? else { return Ok(None) };
        let converted = convert(value).ok_or_else(|| Error::prim(prim, format!("{name} must be {expected}")))?;
        Ok(Some(converted))
    }

    /// The value of an attribute, if a layer has one and it is not blocked. Within a layer, time samples precede the
    /// default value.
    fn value(&self, prim: &str, name: &str, when: When) -> Result<Option<sdf::Value>, Error> {
        if !self.has_property(prim, name)? {
            return Ok(None);
        }
        let time = match when {
            When::Open => self.clock().open,
            When::Close => self.clock().close,
            When::At(time) => time,
        };
        if self.files.splines.get()
            && let Some(value) = self.ask(prim, |prim| self.of_spline(prim, name, time))?
        {
            self.varies.set(self.varies.get().map(|_| true));
            return Ok(value.map(sdf::Value::Double));
        }
        self.ask(prim, |prim| {
            let attribute = self.attribute(prim, name)?;
            if self.varies.get() == Some(false) && attribute.value_might_be_time_varying()? {
                self.varies.set(Some(true));
            }
            let real = |value: &sdf::Value| !matches!(value, sdf::Value::None | sdf::Value::ValueBlock);
            Ok(attribute.get_at::<sdf::Value>(usd::TimeCode::new(time))?.filter(real))
        })
    }
}

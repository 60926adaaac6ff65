//! Curves, meshes, transforms, cameras and attributes as the library of Alembic writes them.

use super::{Form, ObjectId, Owner, PropertyId, Writer, invalid};
use crate::attribute::{Attribute, Scope, Values};
use crate::camera::Camera;
use crate::curves::{CurveBasis, CurveType, Curves};
use crate::mesh::Mesh;
use crate::property::Pod;
use crate::sample::to_half;
use crate::xform::Xform;
use std::collections::HashMap;
use std::io::{self, Write};

/// An object of a schema that is written: curves, a mesh, a transform or a camera.
///
/// Samples are added one after another. All of them have the properties of the first one.
#[derive(Debug)]
pub struct Geometry {
    /// The object.
    pub object: ObjectId,
    schema: PropertyId,
    times: u32,
    /// Whether there was no sample yet.
    is_first: bool,
    known: HashMap<String, PropertyId>,
}

/// Where a property is: of the schema, or in its attributes or the user's properties.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Place {
    Schema,
    Attributes,
    User,
}

impl Place {
    fn name(self) -> &'static str {
        match self {
            Place::Schema => "",
            Place::Attributes => ".arbGeomParams",
            Place::User => ".userProperties",
        }
    }
}

impl Geometry {
    fn new<W: Write>(
        writer: &mut Writer<W>,
        parent: ObjectId,
        name: &str,
        (schema, base, part): (&str, Option<&str>, &str),
        times: u32,
    ) -> io::Result<Self> {
        let title = format!("{schema}:{part}");
        let base = base.map(|base| ("schemaBaseType", base));
        let own: Vec<(&str, &str)> = [("schema", schema)].into_iter().chain(base).collect();
        let all: Vec<(&str, &str)> = own.iter().copied().chain([("schemaObjTitle", title.as_str())]).collect();
        let object = writer.object(parent, name, &all)?;
        let schema = writer.compound(Owner::Object(object), part, &own)?;
        Ok(Geometry { object, schema, times, is_first: true, known: HashMap::new() })
    }

    /// Begins curves. `times` is from [`Writer::times`], or 0.
    ///
    /// # Errors
    /// As [`Writer::object`].
    pub fn curves<W: Write>(writer: &mut Writer<W>, parent: ObjectId, name: &str, times: u32) -> io::Result<Self> {
        Geometry::new(writer, parent, name, ("AbcGeom_Curve_v2", BASE, ".geom"), times)
    }

    /// Begins polygons. `times` as in [`Geometry::curves`].
    ///
    /// # Errors
    /// As [`Writer::object`].
    pub fn polygons<W: Write>(writer: &mut Writer<W>, parent: ObjectId, name: &str, times: u32) -> io::Result<Self> {
        Geometry::new(writer, parent, name, ("AbcGeom_PolyMesh_v1", BASE, ".geom"), times)
    }

    /// Begins a subdivision surface. `times` as in [`Geometry::curves`].
    ///
    /// # Errors
    /// As [`Writer::object`].
    pub fn subdivision<W: Write>(writer: &mut Writer<W>, parent: ObjectId, name: &str, times: u32) -> io::Result<Self> {
        Geometry::new(writer, parent, name, ("AbcGeom_SubD_v1", BASE, ".geom"), times)
    }

    /// Begins a transform. `times` as in [`Geometry::curves`].
    ///
    /// # Errors
    /// As [`Writer::object`].
    pub fn xform<W: Write>(writer: &mut Writer<W>, parent: ObjectId, name: &str, times: u32) -> io::Result<Self> {
        Geometry::new(writer, parent, name, ("AbcGeom_Xform_v3", None, ".xform"), times)
    }

    /// Begins a camera. `times` as in [`Geometry::curves`].
    ///
    /// # Errors
    /// As [`Writer::object`].
    pub fn camera<W: Write>(writer: &mut Writer<W>, parent: ObjectId, name: &str, times: u32) -> io::Result<Self> {
        Geometry::new(writer, parent, name, ("AbcGeom_Camera_v1", None, ".geom"), times)
    }

    /// Adds a sample of curves, with attributes that the schema does not define.
    ///
    /// # Errors
    /// Those of the writer; if the sample has other properties than the first one.
    pub fn add_curves<W: Write>(
        &mut self,
        writer: &mut Writer<W>,
        curves: &Curves,
        attributes: &[Attribute],
    ) -> io::Result<()> {
        let kind = match curves.kind {
            CurveType::Cubic => 0,
            CurveType::Linear => 1,
            CurveType::VariableOrder => 2,
            CurveType::Unknown(other) => other,
        };
        let basis = match curves.basis {
            CurveBasis::None => 0,
            CurveBasis::Bezier => 1,
            CurveBasis::BSpline => 2,
            CurveBasis::CatmullRom => 3,
            CurveBasis::Hermite => 4,
            CurveBasis::Power => 5,
            CurveBasis::Unknown(other) => other,
        };
        self.points(writer, &curves.positions)?;
        self.numbers(writer, "nVertices", (Pod::I32, 1, true), &[], &bytes(&curves.counts, |n| n.to_le_bytes()))?;
        let form = [kind, u8::from(curves.periodic), basis, basis];
        self.numbers(writer, "curveBasisAndType", (Pod::U8, 4, false), &[], &form)?;
        if let Some(weights) = &curves.weights {
            let scope = [("geoScope", "vtx")];
            self.numbers(writer, "w", (Pod::F32, 1, true), &scope, &bytes(weights, |x| x.to_le_bytes()))?;
        }
        self.velocities(writer, curves.velocities.as_deref())?;
        if !curves.orders.is_empty() {
            self.numbers(writer, ".orders", (Pod::U8, 1, true), &[], &curves.orders)?;
        }
        if !curves.knots.is_empty() {
            let knots = bytes(&curves.knots, |x| x.to_le_bytes());
            self.numbers(writer, ".knots", (Pod::F32, 1, true), &[], &knots)?;
        }
        for (name, attribute) in [("width", &curves.widths), ("uv", &curves.uv), ("N", &curves.normals)] {
            if let Some(attribute) = attribute {
                self.attribute(writer, Place::Schema, name, attribute)?;
            }
        }
        self.finish(writer, attributes)
    }

    /// Adds a sample of a mesh, with attributes that the schema does not define.
    ///
    /// # Errors
    /// Those of the writer; if the sample has other properties than the first one.
    pub fn add_mesh<W: Write>(
        &mut self,
        writer: &mut Writer<W>,
        mesh: &Mesh,
        attributes: &[Attribute],
    ) -> io::Result<()> {
        self.points(writer, &mesh.positions)?;
        let whole = |numbers: &[u32]| bytes(numbers, |n| n.to_le_bytes());
        self.numbers(writer, ".faceIndices", (Pod::I32, 1, true), &[], &whole(&mesh.indices))?;
        self.numbers(writer, ".faceCounts", (Pod::I32, 1, true), &[], &whole(&mesh.counts))?;
        self.velocities(writer, mesh.velocities.as_deref())?;
        if let Some(scheme) = &mesh.scheme {
            for name in [".faceVaryingInterpolateBoundary", ".faceVaryingPropagateCorners", ".interpolateBoundary"] {
                self.numbers(writer, name, (Pod::I32, 1, false), &[], &0i32.to_le_bytes())?;
            }
            let property = self.property(writer, Place::Schema, ".scheme", (Pod::Text, 1, false), &[])?;
            writer.sample_text(property, &[scheme])?;
        }
        for (name, attribute) in [("uv", &mesh.uv), ("N", &mesh.normals)] {
            if let Some(attribute) = attribute {
                self.attribute(writer, Place::Schema, name, attribute)?;
            }
        }
        self.finish(writer, attributes)
    }

    /// Adds a sample of a transform: its operations as one matrix.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn add_xform<W: Write>(&mut self, writer: &mut Writer<W>, xform: &Xform) -> io::Result<()> {
        /// The number of a matrix among the operations.
        const MATRIX: u8 = 3 << 4;
        self.numbers(writer, ".inherits", (Pod::Bool, 1, false), &[], &[u8::from(xform.inherits)])?;
        self.numbers(writer, ".ops", (Pod::U8, 1, false), &[], &[MATRIX])?;
        let matrix = bytes(xform.matrix().as_flattened(), |x| x.to_le_bytes());
        self.numbers(writer, ".vals", (Pod::F64, 16, false), &[], &matrix)?;
        // Without it, readers take the transform as the identity.
        self.numbers(writer, "isNotConstantIdentity", (Pod::Bool, 1, false), &[], &[1])?;
        self.finish(writer, &[])
    }

    /// Adds a sample of a camera.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn add_camera<W: Write>(&mut self, writer: &mut Writer<W>, camera: &Camera) -> io::Result<()> {
        let core = bytes(&camera.core(), |x| x.to_le_bytes());
        self.numbers(writer, ".core", (Pod::F64, 16, false), &[], &core)?;
        self.finish(writer, &[])
    }

    /// Adds a property of the user to the object. It has no time.
    ///
    /// # Errors
    /// Those of the writer; if there is one of this name.
    pub fn user_property<W: Write>(&mut self, writer: &mut Writer<W>, attribute: &Attribute) -> io::Result<()> {
        let times = std::mem::take(&mut self.times);
        let added = self.attribute_of(writer, Place::User, &attribute.name, attribute, true);
        self.times = times;
        added
    }

    /// Says whether the object is visible, at all times.
    ///
    /// # Errors
    /// Those of the writer; if it was said before.
    pub fn visible<W: Write>(&mut self, writer: &mut Writer<W>, visible: bool) -> io::Result<()> {
        let form = Form::scalar(Pod::I8, 1, 0);
        let property = writer.property(Owner::Object(self.object), "visible", &[], form)?;
        writer.sample(property, &[u8::from(visible)])
    }

    fn finish<W: Write>(&mut self, writer: &mut Writer<W>, attributes: &[Attribute]) -> io::Result<()> {
        for attribute in attributes {
            self.attribute(writer, Place::Attributes, &attribute.name, attribute)?;
        }
        self.is_first = false;
        Ok(())
    }

    /// Positions with their bounds.
    fn points<W: Write>(&mut self, writer: &mut Writer<W>, positions: &[[f32; 3]]) -> io::Result<()> {
        let bound = |k: usize, pick: fn(f64, f64) -> f64| {
            positions.iter().map(|p| f64::from(p[k])).reduce(pick).unwrap_or_default()
        };
        let low = [0, 1, 2].map(|k| bound(k, f64::min));
        let high = [0, 1, 2].map(|k| bound(k, f64::max));
        let bounds = bytes(&[low, high].concat(), |x| x.to_le_bytes());
        self.numbers(writer, ".selfBnds", (Pod::F64, 6, false), &[("interpretation", "box")], &bounds)?;
        let metadata = [("geoScope", "vtx"), ("interpretation", "point")];
        self.numbers(writer, "P", (Pod::F32, 3, true), &metadata, &vectors(positions))
    }

    fn velocities<W: Write>(&mut self, writer: &mut Writer<W>, velocities: Option<&[[f32; 3]]>) -> io::Result<()> {
        let Some(velocities) = velocities else { return Ok(()) };
        let metadata = [("geoScope", "vtx"), ("interpretation", "vector")];
        self.numbers(writer, ".velocities", (Pod::F32, 3, true), &metadata, &vectors(velocities))
    }

    fn numbers<W: Write>(
        &mut self,
        writer: &mut Writer<W>,
        name: &str,
        form: (Pod, u8, bool),
        metadata: &[(&str, &str)],
        bytes: &[u8],
    ) -> io::Result<()> {
        let property = self.property(writer, Place::Schema, name, form, metadata)?;
        writer.sample(property, bytes)
    }

    fn attribute<W: Write>(
        &mut self,
        writer: &mut Writer<W>,
        place: Place,
        name: &str,
        attribute: &Attribute,
    ) -> io::Result<()> {
        self.attribute_of(writer, place, name, attribute, self.is_first)
    }

    /// Adds a sample of an attribute: an array, or with indices a compound of two.
    fn attribute_of<W: Write>(
        &mut self,
        writer: &mut Writer<W>,
        place: Place,
        name: &str,
        attribute: &Attribute,
        is_first: bool,
    ) -> io::Result<()> {
        let Attribute { scope, lanes, pod, interpretation, values, indices, .. } = attribute;
        // An extent is at most that of a matrix; longer rows are several values.
        let (extent, length) = if *lanes <= 16 { (*lanes, 1) } else { (1, *lanes) };
        let [extent_text, length_text] = [extent, length].map(|n| n.to_string());
        let scope = match scope {
            Scope::Constant => "con",
            Scope::Uniform => "uni",
            Scope::Varying => "var",
            Scope::Vertex => "vtx",
            Scope::FaceVarying => "fvr",
            Scope::Unknown => "",
        };
        let mut metadata = vec![("arrayExtent", length_text.as_str())];
        metadata.extend(Some(("geoScope", scope)).filter(|_| !scope.is_empty()));
        metadata.extend(Some(("interpretation", interpretation.as_str())).filter(|_| !interpretation.is_empty()));
        metadata.extend([("isGeomParam", "true"), ("podExtent", extent_text.as_str()), ("podName", pod.name())]);
        let form = (*pod, extent as u8, true);
        let was_first = std::mem::replace(&mut self.is_first, is_first);
        let mut add = || {
            let property = match indices {
                None => self.property(writer, place, name, form, &metadata)?,
                Some(indices) => {
                    let compound = self.compound(writer, place, name, &metadata)?;
                    let part = |geometry: &mut Geometry, writer: &mut Writer<W>, part: &str, form| {
                        geometry.inside(
                            writer,
                            compound,
                            &format!("{}{name}{part}", place.name()),
                            part,
                            form,
                            &metadata,
                        )
                    };
                    let vals = part(self, writer, ".vals", form)?;
                    let index = part(self, writer, ".indices", (Pod::U32, 1, true))?;
                    writer.sample(index, &bytes(indices, |n| n.to_le_bytes()))?;
                    vals
                }
            };
            match values {
                Values::Text(texts) => {
                    writer.sample_text(property, &texts.iter().map(String::as_str).collect::<Vec<_>>())
                }
                values => writer.sample(property, &encoded(values, *pod)),
            }
        };
        let added = add();
        self.is_first = was_first;
        added
    }

    fn compound<W: Write>(
        &mut self,
        writer: &mut Writer<W>,
        place: Place,
        name: &str,
        metadata: &[(&str, &str)],
    ) -> io::Result<PropertyId> {
        let key = format!("{}{name}", place.name());
        if let Some(&known) = self.known.get(&key) {
            return Ok(known);
        }
        let owner = self.owner(writer, place)?;
        let property = writer.compound(Owner::Compound(owner), name, metadata)?;
        self.known.insert(key, property);
        Ok(property)
    }

    fn owner<W: Write>(&mut self, writer: &mut Writer<W>, place: Place) -> io::Result<PropertyId> {
        match place {
            Place::Schema => Ok(self.schema),
            place => self.compound(writer, Place::Schema, place.name(), &[]),
        }
    }

    fn property<W: Write>(
        &mut self,
        writer: &mut Writer<W>,
        place: Place,
        name: &str,
        form: (Pod, u8, bool),
        metadata: &[(&str, &str)],
    ) -> io::Result<PropertyId> {
        let owner = self.owner(writer, place)?;
        self.inside(writer, owner, &format!("{}{name}", place.name()), name, form, metadata)
    }

    /// The property with a key. It is new in the first sample.
    fn inside<W: Write>(
        &mut self,
        writer: &mut Writer<W>,
        owner: PropertyId,
        key: &str,
        name: &str,
        (pod, extent, is_array): (Pod, u8, bool),
        metadata: &[(&str, &str)],
    ) -> io::Result<PropertyId> {
        if let Some(&known) = self.known.get(key) {
            return Ok(known);
        }
        if !self.is_first {
            return Err(invalid(format!("{name}: the first sample has no such property")));
        }
        let form = Form { pod, extent, is_array, times: self.times };
        let property = writer.property(Owner::Compound(owner), name, metadata, form)?;
        self.known.insert(key.to_owned(), property);
        Ok(property)
    }
}

const BASE: Option<&str> = Some("AbcGeom_GeomBase_v1");

fn bytes<T: Copy, const N: usize>(numbers: &[T], convert: impl Fn(T) -> [u8; N]) -> Vec<u8> {
    numbers.iter().flat_map(|number| convert(*number)).collect()
}

fn vectors(vectors: &[[f32; 3]]) -> Vec<u8> {
    bytes(vectors.as_flattened(), |x| x.to_le_bytes())
}

/// Numbers as they are in the file. What does not fit the type is cut off.
fn encoded(values: &Values, pod: Pod) -> Vec<u8> {
    let whole = |number: i64| -> Vec<u8> {
        let bytes = number.to_le_bytes();
        bytes[..pod.size().unwrap_or(8).min(8)].to_vec()
    };
    match (values, pod) {
        (Values::Single(values), Pod::F16) => bytes(values, |x| to_half(x).to_le_bytes()),
        (Values::Single(values), _) => bytes(values, |x| x.to_le_bytes()),
        (Values::Double(values), _) => bytes(values, |x| x.to_le_bytes()),
        (Values::Whole(values), _) => values.iter().flat_map(|x| whole(*x)).collect(),
        (Values::Text(_), _) => Vec::new(),
    }
}

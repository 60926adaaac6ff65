//! Writes archives: objects, properties and their samples.

mod hash;
mod schemas;

pub use schemas::Geometry;

use crate::property::Pod;
use crate::time::TimeSampling;
use hash::key;
use std::collections::HashMap;
use std::io::{self, Write};

/// The version of Alembic's library whose files these are like.
const LIBRARY: i32 = 10806;

/// Metadata that is longer is not shared.
const LONGEST_SHARED: usize = 255;

/// How many pieces of metadata are shared.
const MOST_SHARED: usize = 254;

/// The top bit of a position of data.
const DATA: u64 = 1 << 63;

/// An object that is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ObjectId(usize);

impl ObjectId {
    /// A number of its own.
    pub fn index(self) -> usize {
        self.0
    }
}

/// A property that is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PropertyId(usize);

/// What has properties.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Owner {
    /// An object.
    Object(ObjectId),
    /// A compound property.
    Compound(PropertyId),
}

/// What the samples of a property are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Form {
    /// The type of the numbers.
    pub pod: Pod,
    /// How many numbers a value has: 3 for a point.
    pub extent: u8,
    /// Whether a sample is a list of values, not one.
    pub is_array: bool,
    /// The index of the times, from [`Writer::times`]. 0 is for properties without time.
    pub times: u32,
}

impl Form {
    /// One value in each sample.
    pub fn scalar(pod: Pod, extent: u8, times: u32) -> Self {
        Form { pod, extent, is_array: false, times }
    }

    /// A list of values in each sample.
    pub fn array(pod: Pod, extent: u8, times: u32) -> Self {
        Form { pod, extent, is_array: true, times }
    }
}

/// Where data is in the file. Of arrays, the second position is that of its dimensions.
type Stored = [u64; 2];

#[derive(Debug)]
struct Samples {
    form: Form,
    count: u32,
    first_changed: u32,
    last_changed: u32,
    stored: Vec<Stored>,
    last: Option<([u8; 16], u64)>,
    /// Whether all samples have as many values, and one value each.
    same_length: bool,
    single: bool,
}

#[derive(Debug)]
enum Content {
    Compound(Vec<usize>),
    Samples(Samples),
}

#[derive(Debug)]
struct Property {
    name: String,
    metadata: String,
    content: Content,
}

#[derive(Debug)]
struct Object {
    name: String,
    metadata: String,
    properties: Vec<usize>,
    children: Vec<usize>,
}

/// Writes an archive (Ogawa) as it comes: samples go to `out` at once, and equal ones once. The tree with the positions
/// of samples is in memory until [`Writer::finish`].
///
/// ```no_run
/// use vellus_alembic::{Form, Owner, Pod, Writer};
/// # fn main() -> std::io::Result<()> {
/// let mut archive = Writer::new(std::fs::File::create("points.abc")?)?;
/// let object = archive.object(Writer::<std::fs::File>::ROOT, "points", &[])?;
/// let heights = archive.property(Owner::Object(object), "heights", &[], Form::array(Pod::F32, 1, 0))?;
/// archive.sample(heights, &1.5f32.to_le_bytes())?;
/// archive.finish(&[("_ai_Application", "an example")])?;
/// # Ok(()) }
/// ```
#[derive(Debug)]
pub struct Writer<W> {
    out: W,
    at: u64,
    times: Vec<(TimeSampling, u32)>,
    objects: Vec<Object>,
    properties: Vec<Property>,
    /// Positions of data by its key, its length and whether it is text.
    known: HashMap<([u8; 16], u64, bool), u64>,
}

fn invalid(what: impl Into<String>) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidInput, what.into())
}

/// The text of metadata in the file.
fn text(pairs: &[(&str, &str)]) -> io::Result<String> {
    let is_plain = |(name, value): &(&str, &str)| !name.contains([';', '=']) && !value.contains(';');
    if !pairs.iter().all(is_plain) {
        return Err(invalid("metadata must not contain ; nor = in a name"));
    }
    Ok(pairs.iter().map(|(name, value)| format!("{name}={value}")).collect::<Vec<_>>().join(";"))
}

impl<W: Write> Writer<W> {
    /// The object above all others.
    pub const ROOT: ObjectId = ObjectId(0);

    /// Begins an archive.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn new(mut out: W) -> io::Result<Self> {
        // The position of the root comes at the end. Until then, the file says that it is not closed.
        out.write_all(b"Ogawa\0\0\x01\0\0\0\0\0\0\0\0")?;
        let root =
            Object { name: String::new(), metadata: String::new(), properties: Vec::new(), children: Vec::new() };
        let none = TimeSampling::Uniform { start: 0.0, step: 1.0 };
        let times = vec![(none, 0)];
        Ok(Writer { out, at: 16, times, objects: vec![root], properties: Vec::new(), known: HashMap::new() })
    }

    /// The index of times of samples for [`Form::times`].
    pub fn times(&mut self, sampling: &TimeSampling) -> u32 {
        let known = self.times.iter().position(|(known, _)| known == sampling);
        known.unwrap_or_else(|| {
            self.times.push((sampling.clone(), 0));
            self.times.len() - 1
        }) as u32
    }

    /// Adds an object.
    ///
    /// # Errors
    /// If its name is empty, has a slash, or is that of another child of its parent.
    pub fn object(&mut self, parent: ObjectId, name: &str, metadata: &[(&str, &str)]) -> io::Result<ObjectId> {
        let siblings = self.objects[parent.0].children.iter().map(|&child| self.objects[child].name.as_str());
        check(name, siblings)?;
        let object =
            Object { name: name.to_owned(), metadata: text(metadata)?, properties: Vec::new(), children: Vec::new() };
        self.objects.push(object);
        let id = self.objects.len() - 1;
        self.objects[parent.0].children.push(id);
        Ok(ObjectId(id))
    }

    /// Adds a property that has other properties.
    ///
    /// # Errors
    /// As [`Writer::object`].
    pub fn compound(&mut self, owner: Owner, name: &str, metadata: &[(&str, &str)]) -> io::Result<PropertyId> {
        self.add(owner, name, metadata, Content::Compound(Vec::new()))
    }

    /// Adds a property with samples.
    ///
    /// # Errors
    /// As [`Writer::object`], and if its times do not exist.
    pub fn property(
        &mut self,
        owner: Owner,
        name: &str,
        metadata: &[(&str, &str)],
        form: Form,
    ) -> io::Result<PropertyId> {
        if form.times as usize >= self.times.len() {
            return Err(invalid(format!("{name}: there are no times {}", form.times)));
        }
        let samples = Samples {
            form,
            count: 0,
            first_changed: 0,
            last_changed: 0,
            stored: Vec::new(),
            last: None,
            same_length: true,
            single: true,
        };
        self.add(owner, name, metadata, Content::Samples(samples))
    }

    fn add(&mut self, owner: Owner, name: &str, metadata: &[(&str, &str)], content: Content) -> io::Result<PropertyId> {
        let metadata = text(metadata)?;
        let id = self.properties.len();
        let siblings = match owner {
            Owner::Object(object) => &self.objects[object.0].properties,
            Owner::Compound(compound) => match &self.properties[compound.0].content {
                Content::Compound(children) => children,
                Content::Samples(_) => return Err(invalid(format!("{name}: its owner is no compound"))),
            },
        };
        check(name, siblings.iter().map(|&index| self.properties[index].name.as_str()))?;
        match owner {
            Owner::Object(object) => self.objects[object.0].properties.push(id),
            Owner::Compound(compound) => {
                if let Content::Compound(children) = &mut self.properties[compound.0].content {
                    children.push(id);
                }
            }
        }
        self.properties.push(Property { name: name.to_owned(), metadata, content });
        Ok(PropertyId(id))
    }

    /// Adds a sample of numbers, little-endian.
    ///
    /// # Errors
    /// Those of `out`; if the property has text, or the number of bytes does not fit its form.
    pub fn sample(&mut self, property: PropertyId, bytes: &[u8]) -> io::Result<()> {
        let form = self.form(property)?;
        let size = form.pod.size().ok_or_else(|| invalid("a sample of text needs Writer::sample_text"))?;
        let value = size * usize::from(form.extent);
        if !bytes.len().is_multiple_of(value.max(1)) || (!form.is_array && bytes.len() != value) {
            let name = &self.properties[property.0].name;
            return Err(invalid(format!("{name}: a sample of {} bytes does not fit {form:?}", bytes.len())));
        }
        self.store(property, bytes, (bytes.len() / value.max(1)) as u64, false)
    }

    /// Adds a sample of texts.
    ///
    /// # Errors
    /// Those of `out`; if the property has numbers or one value, and there are more or fewer texts; if a text has a
    /// zero.
    pub fn sample_text(&mut self, property: PropertyId, texts: &[&str]) -> io::Result<()> {
        let form = self.form(property)?;
        let is_one = form.is_array || texts.len() == usize::from(form.extent);
        if form.pod != Pod::Text || !is_one || texts.iter().any(|text| text.contains('\0')) {
            let name = &self.properties[property.0].name;
            return Err(invalid(format!("{name}: {} texts do not fit {form:?}, or have a zero", texts.len())));
        }
        let bytes: Vec<u8> = texts.iter().flat_map(|text| text.bytes().chain([0])).collect();
        self.store(property, &bytes, texts.len() as u64, true)
    }

    fn form(&self, property: PropertyId) -> io::Result<Form> {
        match &self.properties[property.0].content {
            Content::Samples(samples) => Ok(samples.form),
            Content::Compound(_) => Err(invalid("a compound has no samples")),
        }
    }

    fn store(&mut self, property: PropertyId, bytes: &[u8], values: u64, is_text: bool) -> io::Result<()> {
        let key = key(bytes);
        // Keys are for lists as well as for single values, whose bytes have the same place.
        let entry = (key, bytes.len() as u64, is_text);
        let position = match self.known.get(&entry) {
            Some(&position) => position,
            None => {
                let position = if bytes.is_empty() { DATA } else { self.data(&[&key, bytes])? };
                self.known.insert(entry, position);
                position
            }
        };
        let Content::Samples(samples) = &mut self.properties[property.0].content else { unreachable!() };
        let is_first = samples.count == 0;
        samples.single &= values == 1;
        if samples.last != Some((key, values)) {
            let lengths = samples.last.map(|(_, before)| before == values);
            samples.same_length &= lengths.unwrap_or(true);
            // Text needs its dimensions, because its bytes do not tell them.
            let dimensions = if is_text && samples.form.is_array { values.to_le_bytes().to_vec() } else { Vec::new() };
            let repeated = samples.stored.last().copied();
            let missing = if samples.first_changed == 0 { 0 } else { samples.count - samples.last_changed - 1 };
            samples.stored.extend(repeated.into_iter().flat_map(|stored| (0..missing).map(move |_| stored)));
            samples.last = Some((key, values));
            if !is_first {
                samples.first_changed = if samples.first_changed == 0 { samples.count } else { samples.first_changed };
                samples.last_changed = samples.count;
            }
            let index = samples.stored.len();
            samples.stored.push([position, DATA]);
            if !dimensions.is_empty() {
                let place = self.data(&[&dimensions])?;
                let Content::Samples(samples) = &mut self.properties[property.0].content else { unreachable!() };
                samples.stored[index][1] = place;
            }
        }
        let Content::Samples(samples) = &mut self.properties[property.0].content else { unreachable!() };
        samples.count += 1;
        let times = &mut self.times[samples.form.times as usize].1;
        *times = (*times).max(if samples.last_changed == 0 { 1 } else { samples.count });
        Ok(())
    }

    /// Writes data, and returns its position.
    fn data(&mut self, parts: &[&[u8]]) -> io::Result<u64> {
        let size: usize = parts.iter().map(|part| part.len()).sum();
        if size == 0 {
            return Ok(DATA);
        }
        let position = self.at;
        self.out.write_all(&(size as u64).to_le_bytes())?;
        parts.iter().try_for_each(|part| self.out.write_all(part))?;
        self.at += 8 + size as u64;
        Ok(position | DATA)
    }

    fn group(&mut self, children: &[u64]) -> io::Result<u64> {
        if children.is_empty() {
            return Ok(0);
        }
        let position = self.at;
        self.out.write_all(&(children.len() as u64).to_le_bytes())?;
        children.iter().try_for_each(|child| self.out.write_all(&child.to_le_bytes()))?;
        self.at += 8 + 8 * children.len() as u64;
        Ok(position)
    }
}

impl<W: Write + io::Seek> Writer<W> {
    /// Writes the tree, and closes the archive.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn finish(mut self, metadata: &[(&str, &str)]) -> io::Result<W> {
        let mut shared = Shared::default();
        let mut pairs = vec![("_ai_AlembicVersion", "Alembic 1.8.6")];
        pairs.extend(metadata.iter().filter(|(name, _)| *name != "_ai_AlembicVersion"));
        let metadata = text(&pairs)?;
        let (objects, _) = self.write_object(0, &mut shared)?;
        let parts = [self.data(&[&0i32.to_le_bytes()])?, self.data(&[&LIBRARY.to_le_bytes()])?, objects];
        let described = self.data(&[metadata.as_bytes()])?;
        let mut times = Vec::new();
        for (sampling, most) in &self.times {
            times.extend(most.to_le_bytes());
            sampling.write(&mut times);
        }
        let times = self.data(&[&times])?;
        let shared = self.data(&[&shared.bytes])?;
        let root = self.group(&[parts[0], parts[1], parts[2], described, times, shared])?;
        self.out.seek(io::SeekFrom::Start(5))?;
        self.out.write_all(&[0xff])?;
        self.out.seek(io::SeekFrom::Start(8))?;
        self.out.write_all(&root.to_le_bytes())?;
        self.out.flush()?;
        Ok(self.out)
    }

    /// Writes an object. Returns its position, and its hash.
    fn write_object(&mut self, index: usize, shared: &mut Shared) -> io::Result<(u64, [u8; 16])> {
        let (properties, children) =
            (std::mem::take(&mut self.objects[index].properties), std::mem::take(&mut self.objects[index].children));
        let (own, own_hash) = self.write_compound(&properties, shared)?;
        let mut positions = vec![own];
        let (mut headers, mut hashes) = (Vec::new(), Vec::new());
        for child in children {
            let (position, hash) = self.write_object(child, shared)?;
            positions.push(position);
            hashes.extend(hash);
            let Object { name, metadata, .. } = &self.objects[child];
            headers.extend((name.len() as u32).to_le_bytes());
            headers.extend(name.bytes());
            let metadata = metadata.clone();
            let number = shared.number(&metadata);
            headers.push(number);
            if number == 255 {
                headers.extend((metadata.len() as u32).to_le_bytes());
                headers.extend(metadata.bytes());
            }
            hashes.extend(name.bytes());
        }
        let below = if hashes.is_empty() { [0; 16] } else { key(&hashes) };
        headers.extend(own_hash);
        headers.extend(below);
        positions.push(self.data(&[&headers])?);
        Ok((self.group(&positions)?, key(&[own_hash, below].concat())))
    }

    /// Writes properties. Returns the position of their group, and their hash.
    fn write_compound(&mut self, properties: &[usize], shared: &mut Shared) -> io::Result<(u64, [u8; 16])> {
        let (mut positions, mut headers, mut hashes) = (Vec::new(), Vec::new(), Vec::new());
        for &index in properties {
            let Property { name, metadata, content } = &mut self.properties[index];
            let (name, metadata) = (std::mem::take(name), std::mem::take(metadata));
            hashes.extend(name.bytes().chain(metadata.bytes()));
            let number = shared.number(&metadata);
            let mut numbers = Vec::new();
            let mut info = u32::from(number) << 20;
            let position = match content {
                Content::Compound(children) => {
                    let children = std::mem::take(children);
                    let (position, hash) = self.write_compound(&children, shared)?;
                    hashes.extend(hash);
                    position
                }
                Content::Samples(samples) => {
                    info |= samples.header(&mut numbers);
                    let is_array = samples.form.is_array;
                    let all = samples.stored.iter().flat_map(|[data, dimensions]| {
                        [Some(*data), Some(*dimensions).filter(|_| is_array)].into_iter().flatten()
                    });
                    let all: Vec<u64> = all.collect();
                    // Equal data has equal positions.
                    hashes.extend(all.iter().flat_map(|position| position.to_le_bytes()));
                    self.group(&all)?
                }
            };
            positions.push(position);
            numbers.push(name.len() as u32);
            let longest = numbers.iter().copied().max().unwrap_or(0).max(metadata.len() as u32);
            let hint = match longest {
                0..=255 => 0,
                256..=65_535 => 1,
                _ => 2,
            };
            headers.extend((info | hint << 2).to_le_bytes());
            let sized = |number: u32| number.to_le_bytes().into_iter().take(1 << hint);
            headers.extend(numbers.into_iter().flat_map(sized));
            headers.extend(name.bytes());
            if number == 255 {
                headers.extend(sized(metadata.len() as u32));
                headers.extend(metadata.bytes());
            }
        }
        if positions.is_empty() {
            return Ok((0, key(&[])));
        }
        positions.push(self.data(&[&headers])?);
        Ok((self.group(&positions)?, key(&hashes)))
    }
}

impl Samples {
    /// The bits of the header of a property (see [`crate::property::header`]), and the numbers that follow.
    fn header(&self, numbers: &mut Vec<u32>) -> u32 {
        let Form { pod, extent, is_array, times } = self.form;
        // 3 is an array whose samples have one value each.
        let kind = if is_array { 2 | u32::from(self.single) } else { 1 };
        let mut info = kind | pod.number() << 4 | u32::from(extent) << 12 | u32::from(self.same_length) << 10;
        numbers.push(self.count);
        if self.last_changed == 0 {
            info |= 1 << 11;
        } else if (self.first_changed, self.last_changed) != (1, self.count - 1) {
            info |= 1 << 9;
            numbers.extend([self.first_changed, self.last_changed]);
        }
        if times > 0 {
            info |= 1 << 8;
            numbers.push(times);
        }
        info
    }
}

/// Metadata that headers refer to by its number.
#[derive(Default)]
struct Shared {
    known: HashMap<String, u8>,
    bytes: Vec<u8>,
}

impl Shared {
    /// The number of metadata: 0 if it is empty, and 255 if it is written where it belongs.
    fn number(&mut self, metadata: &str) -> u8 {
        if metadata.is_empty() {
            return 0;
        }
        if let Some(&number) = self.known.get(metadata) {
            return number;
        }
        if metadata.len() > LONGEST_SHARED || self.known.len() >= MOST_SHARED {
            return 255;
        }
        let number = self.known.len() as u8 + 1;
        self.known.insert(metadata.to_owned(), number);
        self.bytes.push(metadata.len() as u8);
        self.bytes.extend(metadata.bytes());
        number
    }
}

fn check<'a>(name: &str, mut siblings: impl Iterator<Item = &'a str>) -> io::Result<()> {
    if name.is_empty() || name.contains('/') {
        return Err(invalid(format!("the name {name:?} must not be empty, nor have a slash")));
    }
    if siblings.any(|sibling| sibling == name) {
        return Err(invalid(format!("the name {name} is taken")));
    }
    Ok(())
}

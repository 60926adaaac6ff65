//! Writes small archives for tests.

/// A group or data of the container.
pub enum Node {
    Group(Vec<Node>),
    Data(Vec<u8>),
}

/// The numbers of types in the file.
pub const BOOL: u32 = 0;
pub const U8: u32 = 1;
pub const I8: u32 = 2;
pub const U32: u32 = 5;
pub const I32: u32 = 6;
pub const F32: u32 = 10;
pub const F64: u32 = 11;
pub const TEXT: u32 = 12;

/// A property.
#[derive(Clone, Default)]
pub struct Prop {
    name: String,
    metadata: String,
    children: Option<Vec<Prop>>,
    is_scalar: bool,
    pod: u32,
    extent: u32,
    stored: Vec<Vec<u8>>,
    /// The number of samples, and the first and the last one that change.
    range: Option<[u32; 3]>,
    times: u32,
}

/// An object.
#[derive(Clone, Default)]
pub struct Obj {
    name: String,
    metadata: String,
    props: Vec<Prop>,
    children: Vec<Obj>,
}

pub fn f32s(numbers: &[f32]) -> Vec<u8> {
    numbers.iter().flat_map(|x| x.to_le_bytes()).collect()
}

pub fn f64s(numbers: &[f64]) -> Vec<u8> {
    numbers.iter().flat_map(|x| x.to_le_bytes()).collect()
}

pub fn i32s(numbers: &[i32]) -> Vec<u8> {
    numbers.iter().flat_map(|x| x.to_le_bytes()).collect()
}

pub fn texts(texts: &[&str]) -> Vec<u8> {
    texts.iter().flat_map(|text| text.bytes().chain([0])).collect()
}

impl Prop {
    pub fn array(name: &str, pod: u32, extent: u32, sample: Vec<u8>) -> Self {
        Prop { name: name.into(), pod, extent, stored: vec![sample], ..Prop::default() }
    }

    pub fn scalar(name: &str, pod: u32, extent: u32, sample: Vec<u8>) -> Self {
        Prop { is_scalar: true, ..Prop::array(name, pod, extent, sample) }
    }

    pub fn compound(name: &str, children: Vec<Prop>) -> Self {
        Prop { name: name.into(), children: Some(children), ..Prop::default() }
    }

    /// Several samples with the time sampling 1.
    pub fn samples(mut self, stored: Vec<Vec<u8>>) -> Self {
        (self.stored, self.times) = (stored, 1);
        self
    }

    /// The number of samples, and the first and the last one that change.
    pub fn range(mut self, range: [u32; 3]) -> Self {
        self.range = Some(range);
        self
    }

    pub fn metadata(mut self, metadata: &str) -> Self {
        self.metadata = metadata.into();
        self
    }

    fn write(&self, headers: &mut Vec<u8>) -> Node {
        // Numbers of four bytes, and metadata of its own.
        let mut info = (2 << 2) | (255 << 20);
        let mut numbers = Vec::new();
        if self.children.is_none() {
            let samples = self.stored.len() as u32;
            info |= if self.is_scalar { 1 } else { 2 } | (self.pod << 4) | (1 << 8) | (self.extent << 12);
            match self.range {
                Some(range) => {
                    info |= 1 << 9;
                    numbers.extend(range);
                }
                None if samples <= 1 => {
                    info |= 1 << 11;
                    numbers.push(samples);
                }
                None => numbers.push(samples),
            }
            numbers.push(self.times);
        }
        numbers.push(self.name.len() as u32);
        headers.extend(info.to_le_bytes());
        numbers.iter().for_each(|number| headers.extend(number.to_le_bytes()));
        headers.extend(self.name.bytes());
        headers.extend((self.metadata.len() as u32).to_le_bytes());
        headers.extend(self.metadata.bytes());
        if let Some(children) = &self.children {
            return compound(children);
        }
        let mut nodes = Vec::new();
        for sample in &self.stored {
            nodes.push(Node::Data([&[0; 16], &sample[..]].concat()));
            if !self.is_scalar {
                nodes.push(Node::Data(Vec::new()));
            }
        }
        Node::Group(nodes)
    }
}

fn compound(props: &[Prop]) -> Node {
    let mut headers = Vec::new();
    let mut nodes: Vec<Node> = props.iter().map(|prop| prop.write(&mut headers)).collect();
    nodes.push(Node::Data(headers));
    Node::Group(nodes)
}

impl Obj {
    pub fn new(name: &str, schema: &str, props: Vec<Prop>, children: Vec<Obj>) -> Self {
        Obj { name: name.into(), metadata: format!("schema={schema}"), props, children }
    }

    /// An object that is an instance of another one.
    pub fn instance(name: &str, source: &str) -> Self {
        let props = vec![Prop::scalar(".instanceSource", TEXT, 1, texts(&[source]))];
        Obj { name: name.into(), metadata: "isInstance=1".into(), props, children: vec![] }
    }

    fn write(&self) -> Node {
        let mut headers = Vec::new();
        let mut nodes = vec![compound(&self.props)];
        for child in &self.children {
            headers.extend((child.name.len() as u32).to_le_bytes());
            headers.extend(child.name.bytes());
            headers.push(255);
            headers.extend((child.metadata.len() as u32).to_le_bytes());
            headers.extend(child.metadata.bytes());
            nodes.push(child.write());
        }
        headers.extend([0; 32]);
        nodes.push(Node::Data(headers));
        Node::Group(nodes)
    }
}

/// An archive with these objects. Time sampling 0 has no time, and 1 has `times` (acyclic).
pub fn archive(metadata: &str, times: &[f64], children: Vec<Obj>) -> Vec<u8> {
    let mut samplings = Vec::new();
    for (period, times) in [(1.0, &[0.0][..]), (f64::MAX / 32.0, times)] {
        samplings.extend(1u32.to_le_bytes());
        samplings.extend(f64::to_le_bytes(period));
        samplings.extend((times.len() as u32).to_le_bytes());
        samplings.extend(f64s(times));
    }
    container(&Node::Group(vec![
        Node::Data(i32s(&[0])),
        Node::Data(i32s(&[10800])),
        Obj { children, ..Obj::default() }.write(),
        Node::Data(metadata.into()),
        Node::Data(samplings),
        Node::Data(Vec::new()),
    ]))
}

/// A container with this root.
pub fn container(root: &Node) -> Vec<u8> {
    let mut bytes = b"Ogawa\xff\x00\x01\0\0\0\0\0\0\0\0".to_vec();
    let at = write(root, &mut bytes);
    bytes[8..16].copy_from_slice(&at.to_le_bytes());
    bytes
}

fn write(node: &Node, bytes: &mut Vec<u8>) -> u64 {
    match node {
        Node::Group(nodes) if nodes.is_empty() => 0,
        Node::Group(nodes) => {
            let positions: Vec<u64> = nodes.iter().map(|node| write(node, bytes)).collect();
            let at = bytes.len() as u64;
            bytes.extend((nodes.len() as u64).to_le_bytes());
            positions.iter().for_each(|position| bytes.extend(position.to_le_bytes()));
            at
        }
        Node::Data(data) if data.is_empty() => 1 << 63,
        Node::Data(data) => {
            let at = bytes.len() as u64;
            bytes.extend((data.len() as u64).to_le_bytes());
            bytes.extend(data);
            at | 1 << 63
        }
    }
}

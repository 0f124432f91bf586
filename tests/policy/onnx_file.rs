//! Writes ONNX files: the protocol buffers of its format, without a library for networks.

/// A message of the format, as bytes.
#[derive(Clone, Default)]
pub struct Message(Vec<u8>);

impl Message {
    fn varint(&mut self, mut number: u64) {
        while number >= 0x80 {
            self.0.push(number as u8 | 0x80);
            number >>= 7;
        }
        self.0.push(number as u8);
    }

    /// With a whole number.
    pub fn number(mut self, field: u64, value: u64) -> Self {
        self.varint(field << 3);
        self.varint(value);
        self
    }

    /// With bytes, a text or another message.
    pub fn bytes(mut self, field: u64, value: impl AsRef<[u8]>) -> Self {
        self.varint(field << 3 | 2);
        self.varint(value.as_ref().len() as u64);
        self.0.extend_from_slice(value.as_ref());
        self
    }
}

impl AsRef<[u8]> for Message {
    fn as_ref(&self) -> &[u8] {
        &self.0
    }
}

/// Number of the type of single precision.
pub const FLOAT: u64 = 1;

/// A size of a dimension; none: dynamic.
pub type Dims<'a> = &'a [Option<u64>];

/// An input or output.
pub fn value(name: &str, kind: u64, dims: Dims) -> Message {
    let mut shape = Message::default();
    for dim in dims {
        let dim = match dim {
            Some(size) => Message::default().number(1, *size),
            None => Message::default().bytes(2, "batch"),
        };
        shape = shape.bytes(1, dim);
    }
    let tensor = Message::default().number(1, kind).bytes(2, shape);
    Message::default().bytes(1, name).bytes(2, Message::default().bytes(1, tensor))
}

/// A constant with this shape, row by row.
pub fn constant(name: &str, dims: &[usize], numbers: &[f32]) -> Message {
    let raw: Vec<u8> = numbers.iter().flat_map(|x| x.to_le_bytes()).collect();
    let shape = dims.iter().fold(Message::default(), |message, dim| message.number(1, *dim as u64));
    shape.number(2, FLOAT).bytes(8, name).bytes(9, raw)
}

/// An operation.
pub fn node(kind: &str, inputs: &[&str], outputs: &[&str]) -> Message {
    let with_inputs = inputs.iter().fold(Message::default(), |message, name| message.bytes(1, name));
    outputs.iter().fold(with_inputs, |message, name| message.bytes(2, name)).bytes(3, outputs[0]).bytes(4, kind)
}

/// The file of a network.
pub fn file(inputs: &[Message], outputs: &[Message], constants: &[Message], nodes: &[Message]) -> Vec<u8> {
    let mut graph = nodes.iter().fold(Message::default(), |graph, node| graph.bytes(1, node)).bytes(2, "network");
    for (field, messages) in [(5, constants), (11, inputs), (12, outputs)] {
        graph = messages.iter().fold(graph, |graph, message| graph.bytes(field, message));
    }
    Message::default().number(1, 8).bytes(7, graph).bytes(8, Message::default().number(2, 17)).0
}

/// `y = x W + b` with one row x, W row by row.
pub fn affine(width: usize, weights: &[f32], bias: &[f32]) -> Vec<u8> {
    let outputs = bias.len();
    file(
        &[value("obs", FLOAT, &[None, Some(width as u64)])],
        &[value("actions", FLOAT, &[None, Some(outputs as u64)])],
        &[constant("W", &[width, outputs], weights), constant("b", &[outputs], bias)],
        &[node("Gemm", &["obs", "W", "b"], &["actions"])],
    )
}

/// `y = x`.
pub fn identity(width: usize) -> Vec<u8> {
    let diagonal = |i: usize| if i / width == i % width { 1.0 } else { 0.0 };
    affine(width, &(0..width * width).map(diagonal).collect::<Vec<_>>(), &vec![0.0; width])
}

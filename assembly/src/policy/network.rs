//! Interface between a policy and its network.

use std::error::Error;
use std::fmt;

/// A network that is ready to be evaluated.
pub trait Network: Send {
    /// Number of numbers in each state of a recurrent network.
    fn state_sizes(&self) -> &[usize];

    /// Evaluates the network. Writes its output to `action` and replaces the numbers in `state` by
    /// those after the evaluation. May allocate.
    ///
    /// # Errors
    /// The network could not be evaluated, for instance because it divides integers by zero.
    fn evaluate(
        &mut self,
        observation: &[f32],
        state: &mut [Vec<f32>],
        action: &mut [f32],
    ) -> Result<(), Box<dyn Error + Send + Sync>>;
}

/// What a policy requires of its network.
#[derive(Clone, Debug)]
pub struct Interface {
    /// Numbers that it receives.
    pub observation: usize,
    /// Numbers that it returns.
    pub action: usize,
    /// Name of the input for observations; none: the only one besides states.
    pub input: Option<String>,
    /// Name of the output for actions; none: the only one besides states.
    pub output: Option<String>,
    /// Names of input and output of each state.
    pub state: Vec<(String, String)>,
}

/// The part of a task that a network does not fit.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Part {
    /// The program: it was built without networks.
    Program,
    /// The file.
    File,
    /// The observations.
    Observations,
    /// The joints.
    Action,
    /// The name of the input.
    Input,
    /// The name of the output.
    Output,
    /// The state with this index.
    State(usize),
}

/// A network that cannot be used.
#[derive(Clone, PartialEq, Debug)]
pub struct LoadError {
    /// Where the error is.
    pub part: Part,
    /// What is wrong.
    pub message: String,
    /// What to do.
    pub help: Option<String>,
}

impl LoadError {
    /// An error without help.
    pub fn new(part: Part, message: impl Into<String>) -> Self {
        LoadError { part, message: message.into(), help: None }
    }
}

impl fmt::Display for LoadError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl Error for LoadError {}

/// Reads and checks the network of an ONNX file.
///
/// # Errors
/// The file is damaged, has an operator that is not supported, or does not fit `interface`.
#[cfg(feature = "policy")]
pub fn load(bytes: &[u8], interface: &Interface) -> Result<Box<dyn Network>, LoadError> {
    super::onnx::load(bytes, interface)
}

/// Reads and checks the network of an ONNX file.
///
/// # Errors
/// This program was built without networks.
#[cfg(not(feature = "policy"))]
pub fn load(_: &[u8], _: &Interface) -> Result<Box<dyn Network>, LoadError> {
    let help = "build it with them: `cargo build --release --features policy`; the Python package has them";
    let message = "this program was built without networks, which the type `policy` requires";
    Err(LoadError { part: Part::Program, message: message.into(), help: Some(help.into()) })
}

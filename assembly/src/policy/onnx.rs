//! Networks in ONNX files, evaluated by `tract-onnx`.
//!
//! The file is read, its dynamic dimensions are set to 1, and the plan of its operations is built
//! once, when the task is created. The crate would choose kernels by the instruction sets of the
//! processor, whose sums differ in their last bits. All kernels beyond the baseline of the
//! architecture are therefore disabled before its first use.

use super::network::{Interface, LoadError, Network, Part};
use crate::files::catch_panic;
use std::collections::BTreeSet;
use std::error::Error;
use std::sync::Once;
use tract_onnx::pb;
use tract_onnx::prelude::*;
use tract_onnx::tract_core::knobs;
use tract_onnx::tract_hir::infer::Factoid;
use tract_onnx::tract_hir::internal::DimLike;

/// Most numbers of one tensor of a network.
const MOST_NUMBERS: usize = 10_000_000;

/// Instruction sets with kernels of their own.
#[cfg(target_arch = "x86_64")]
const INSTRUCTIONS: &str = "-avx,-avx2,-fma,-f16c,-avx512f,-avx512vnni,-avx512fp16,-avxvnni,-amx-int8,-amx-bf16";
#[cfg(target_arch = "aarch64")]
const INSTRUCTIONS: &str = "-fp16,-dotprod,-sve2,-sme,-sme2,-apple-amx";
#[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
const INSTRUCTIONS: &str = "";

/// Operators whose results differ from call to call.
const RANDOM: [&str; 6] =
    ["Bernoulli", "Multinomial", "RandomNormal", "RandomNormalLike", "RandomUniform", "RandomUniformLike"];

/// A network of `tract-onnx`.
struct OnnxNetwork {
    state: TypedSimpleState,
    /// Shapes of the inputs in the model's order, each with its source.
    inputs: Vec<(Source, Vec<usize>)>,
    state_sizes: Vec<usize>,
}

/// Source of an input.
#[derive(Clone, Copy)]
enum Source {
    Observation,
    State(usize),
}

impl Network for OnnxNetwork {
    fn state_sizes(&self) -> &[usize] {
        &self.state_sizes
    }

    fn evaluate(
        &mut self,
        observation: &[f32],
        state: &mut [Vec<f32>],
        action: &mut [f32],
    ) -> Result<(), Box<dyn Error + Send + Sync>> {
        let tensor = |(source, shape): &(Source, Vec<usize>)| {
            let numbers = match source {
                Source::Observation => observation,
                Source::State(i) => &state[*i],
            };
            Ok(Tensor::from_shape(shape, numbers)?.into())
        };
        let inputs: TVec<TValue> = self.inputs.iter().map(tensor).collect::<TractResult<_>>()?;
        let outputs = self.state.run(inputs)?;
        let to = std::iter::once(action).chain(state.iter_mut().map(Vec::as_mut_slice));
        for (output, to) in outputs.iter().zip(to) {
            to.copy_from_slice(output.try_as_plain_ram()?.as_slice::<f32>()?);
        }
        Ok(())
    }
}

/// Reads and checks the network of an ONNX file; see [`super::load`].
pub(super) fn load(bytes: &[u8], interface: &Interface) -> Result<Box<dyn Network>, LoadError> {
    static KERNELS: Once = Once::new();
    KERNELS.call_once(|| {
        knobs::set_str("TRACT_CPU_ISA", INSTRUCTIONS);
    });
    match catch_panic(|| read(bytes, interface)) {
        Ok(network) => network,
        Err(panic) => Err(LoadError::new(Part::File, format!("the network cannot be read: {panic}"))),
    }
}

fn read(bytes: &[u8], interface: &Interface) -> Result<Box<dyn Network>, LoadError> {
    let broken = |error: TractError| LoadError::new(Part::File, format!("the network cannot be read: {error:#}"));
    let proto = <pb::ModelProto as prost::Message>::decode(bytes)
        .map_err(|error| LoadError::new(Part::File, format!("it is no ONNX file: {error}")))?;
    let graph =
        proto.graph.as_ref().ok_or_else(|| LoadError::new(Part::File, "it is no ONNX file: it has no graph"))?;
    check_graph(graph)?;
    let parsed = tract_onnx::onnx().parse(&proto, None).map_err(broken)?;
    if !parsed.unresolved_inputs.is_empty() {
        let names = parsed.unresolved_inputs.join("`, `");
        return Err(LoadError::new(Part::File, format!("the network uses values that it does not define: `{names}`")));
    }
    let mut model = parsed.model;
    check_operators(&model)?;
    let outputs = select_outputs(&mut model, graph, interface)?;
    let inputs = set_inputs(&mut model, interface)?;
    model.analyse(false).map_err(broken)?;
    check_size(&model)?;
    let model = model.into_typed().and_then(TypedModel::into_optimized).map_err(broken)?;
    check_outputs(&model, interface, &inputs, &outputs)?;
    let state = TypedSimplePlan::new(model).and_then(|plan| plan.spawn()).map_err(broken)?;
    let size = |i: usize| {
        let of_state = |input: &&(Source, Vec<usize>)| matches!(input.0, Source::State(j) if j == i);
        inputs.iter().find(of_state).map_or(0, |(_, shape)| shape.iter().product())
    };
    let state_sizes = (0..interface.state.len()).map(size).collect();
    Ok(Box::new(OnnxNetwork { state, inputs, state_sizes }))
}

/// Refuses data in other files, which no run key includes, and operators that draw random numbers.
fn check_graph(graph: &pb::GraphProto) -> Result<(), LoadError> {
    let external = pb::tensor_proto::DataLocation::External as i32;
    if let Some(tensor) = graph.initializer.iter().find(|tensor| tensor.data_location == Some(external)) {
        let message = format!("the numbers of `{}` are in another file", tensor.name);
        let help = "save the network with all its numbers in one file".to_owned();
        return Err(LoadError { part: Part::File, message, help: Some(help) });
    }
    match graph.node.iter().find(|node| RANDOM.contains(&node.op_type.as_str())) {
        Some(node) => {
            let message = format!("the operator `{}` draws random numbers, so runs would differ", node.op_type);
            Err(LoadError::new(Part::File, message))
        }
        None => Ok(()),
    }
}

fn check_operators(model: &InferenceModel) -> Result<(), LoadError> {
    let name = |op: String| op.trim_start_matches("Unimplemented(").trim_end_matches(')').to_owned();
    let ops = model.nodes().iter().map(|node| node.op().name().into_owned());
    let unknown: BTreeSet<String> = ops.filter(|op| op.starts_with("Unimplemented(")).map(name).collect();
    match unknown.is_empty() {
        true => Ok(()),
        false => {
            let names = Vec::from_iter(unknown).join("`, `");
            Err(LoadError::new(Part::File, format!("operators that are not supported: `{names}`")))
        }
    }
}

/// "`a`, `b`", or "none".
fn listed<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    let names: Vec<String> = names.into_iter().map(|name| format!("`{name}`")).collect();
    if names.is_empty() { "none".into() } else { names.join(", ") }
}

/// The name of the input or output that is neither named nor that of a state.
fn choose<'a>(
    kind: &str,
    part: Part,
    names: &[&'a str],
    (named, states): (Option<&String>, &[&str]),
) -> Result<&'a str, LoadError> {
    if let Some(i) = states.iter().position(|state| !names.contains(state)) {
        let message = format!("the network has no {kind} `{}`; it has {}", states[i], listed(names.iter().copied()));
        return Err(LoadError::new(Part::State(i), message));
    }
    if let Some(named) = named {
        return names.iter().find(|name| *name == named).copied().ok_or_else(|| {
            let message = format!("the network has no {kind} `{named}`; it has {}", listed(names.iter().copied()));
            LoadError::new(part, message)
        });
    }
    let rest: Vec<&str> = names.iter().copied().filter(|name| !states.contains(name)).collect();
    if let [name] = rest[..] {
        return Ok(name);
    }
    let message = format!("the network must have one {kind} besides states; it has {}", listed(rest));
    let help = format!("name it by `{kind}`, and states of a recurrent network by `state`");
    Err(LoadError { part, message, help: Some(help) })
}

/// Makes the action and then the states the outputs of the model; returns their names.
fn select_outputs(
    model: &mut InferenceModel,
    graph: &pb::GraphProto,
    interface: &Interface,
) -> Result<Vec<String>, LoadError> {
    let names: Vec<&str> = graph.output.iter().map(|output| output.name.as_str()).collect();
    let states: Vec<&str> = interface.state.iter().map(|(_, output)| output.as_str()).collect();
    let action = choose("output", Part::Output, &names, (interface.output.as_ref(), &states))?;
    let selected: Vec<String> = std::iter::once(action).chain(states).map(str::to_owned).collect();
    let outlets = model.outputs.clone();
    let outlet = |name: &String| names.iter().position(|n| n == name).and_then(|i| outlets.get(i).copied());
    model.outputs = selected.iter().filter_map(outlet).collect();
    Ok(selected)
}

/// Sets the shapes of all inputs; returns them.
fn set_inputs(model: &mut InferenceModel, interface: &Interface) -> Result<Vec<(Source, Vec<usize>)>, LoadError> {
    let outlets = model.inputs.clone();
    let names: Vec<String> = outlets.iter().map(|outlet| model.node(outlet.node).name.clone()).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let states: Vec<&str> = interface.state.iter().map(|(input, _)| input.as_str()).collect();
    let observation = choose("input", Part::Input, &names, (interface.input.as_ref(), &states))?;
    let mut inputs = Vec::new();
    for (i, name) in names.iter().enumerate() {
        let source = match states.iter().position(|state| state == name) {
            Some(state) => Source::State(state),
            None if *name == observation => Source::Observation,
            None => {
                let message = format!("the network also requires the input `{name}`");
                let help = "states of a recurrent network are named by `state`".to_owned();
                return Err(LoadError { part: Part::File, message, help: Some(help) });
            }
        };
        let shape = input_shape(model, outlets[i], name, source, interface.observation)?;
        let fact = f32::fact(&shape).into();
        let set = model.set_input_fact(i, fact);
        set.map_err(|error| LoadError::new(Part::File, format!("the input `{name}`: {error:#}")))?;
        inputs.push((source, shape));
    }
    Ok(inputs)
}

/// Shape of an input, dynamic dimensions set to 1, or to `width` for the last one of observations.
fn input_shape(
    model: &InferenceModel,
    outlet: OutletId,
    name: &str,
    source: Source,
    width: usize,
) -> Result<Vec<usize>, LoadError> {
    let part = match source {
        Source::Observation => Part::Observations,
        Source::State(i) => Part::State(i),
    };
    let fact = model.outlet_fact(outlet).map_err(|error| LoadError::new(Part::File, format!("{error:#}")))?;
    if let Some(kind) = fact.datum_type.concretize().filter(|kind| *kind != f32::datum_type()) {
        let message = format!("the input `{name}` takes numbers of type {kind:?}, supported is F32");
        return Err(LoadError::new(Part::File, message));
    }
    let Some(rank) = fact.shape.rank().concretize() else {
        return Err(LoadError::new(Part::File, format!("the number of dimensions of the input `{name}` is not known")));
    };
    let dims = (0..rank as usize).map(|k| {
        let size = fact.shape.dim(k).and_then(|dim| dim.concretize()).and_then(|dim| dim.to_usize().ok());
        size.filter(|size| *size > 0)
    });
    let dims: Vec<Option<usize>> = dims.collect();
    if let Source::State(_) = source {
        return Ok(dims.into_iter().map(|size| size.unwrap_or(1)).collect());
    }
    let others = &dims[..dims.len().saturating_sub(1)];
    let takes = dims.last().copied().flatten().unwrap_or(width);
    if dims.is_empty() || others.iter().any(|size| size.unwrap_or(1) != 1) {
        let shape: Vec<String> = dims.iter().map(|size| size.map_or("?".into(), |size| size.to_string())).collect();
        let message = format!("the input `{name}` has the shape [{}], supported is one row", shape.join(", "));
        return Err(LoadError::new(Part::File, message));
    }
    if takes != width {
        let message = format!("the input `{name}` of the network takes {takes} numbers, the observations have {width}");
        return Err(LoadError::new(part, message));
    }
    Ok(others.iter().map(|_| 1).chain([width]).collect())
}

/// Refuses tensors that need too much memory.
fn check_size(model: &InferenceModel) -> Result<(), LoadError> {
    for node in model.nodes() {
        for fact in node.outputs.iter().map(|outlet| &outlet.fact) {
            let Some(shape) = fact.shape.as_concrete_finite().ok().flatten() else { continue };
            if shape.iter().copied().fold(1_usize, usize::saturating_mul) > MOST_NUMBERS {
                let message = format!("`{}` of the network has more than {MOST_NUMBERS} numbers", node.name);
                return Err(LoadError::new(Part::File, message));
            }
        }
    }
    Ok(())
}

/// The output must have a number for each joint, states the size of their inputs.
fn check_outputs(
    model: &TypedModel,
    interface: &Interface,
    inputs: &[(Source, Vec<usize>)],
    names: &[String],
) -> Result<(), LoadError> {
    let state_size = |i: usize| {
        let of_state = |(source, _): &&(Source, Vec<usize>)| matches!(source, Source::State(j) if *j == i);
        inputs.iter().find(of_state).map_or(0, |(_, shape)| shape.iter().product())
    };
    for (k, name) in names.iter().enumerate() {
        let fact = model.output_fact(k).map_err(|error| LoadError::new(Part::File, format!("{error:#}")))?;
        if fact.datum_type != f32::datum_type() {
            let message = format!("the output `{name}` has numbers of type {:?}, supported is F32", fact.datum_type);
            return Err(LoadError::new(Part::File, message));
        }
        let Some(shape) = fact.shape.as_concrete() else {
            let message = format!("the shape of the output `{name}` depends on the numbers: {:?}", fact.shape);
            return Err(LoadError::new(Part::File, message));
        };
        let numbers: usize = shape.iter().product();
        let (part, wanted, whose) = match k {
            0 => (Part::Action, interface.action, "the action has"),
            _ => (Part::State(k - 1), state_size(k - 1), "its input has"),
        };
        if numbers != wanted {
            let message = format!("the output `{name}` of the network has {numbers} numbers, {whose} {wanted}");
            return Err(LoadError::new(part, message));
        }
    }
    Ok(())
}

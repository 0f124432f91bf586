//! Random samples of swept keys: [`draw`] gives numbers between 0 and 1, and a distribution's
//! quantile function maps them to values, so that each sampling method serves each distribution.

mod draw;
mod normal;

use super::axis::unify_numbers;
use crate::math;
use crate::scenario::format::random::{Distribution, RandomSpec, Sampling};
use crate::scenario::key_path::KeyPath;
use crate::text::toml_tree::{Node, Value};

/// Greatest number of samples of a Sobol sequence, by its table of direction numbers.
pub const SOBOL_SAMPLES: u32 = 1 << 16;
/// Greatest number of keys of a Sobol sequence, by the same table.
pub const SOBOL_KEYS: usize = sobol_burley::NUM_DIMENSIONS as usize;

/// The samples of one key, in order. `seed` is the scenario's, `index` the key's index among those
/// of `random`; `node` is the distribution in the file.
pub fn samples(spec: &RandomSpec, seed: u64, path: &KeyPath, index: usize, node: &Node) -> Vec<Node> {
    let Some((_, distribution)) = spec.keys.get(index) else { return Vec::new() };
    let n = spec.samples as usize;
    let draws = match spec.sampling {
        Sampling::Random => draw::independent(seed, path, n),
        Sampling::Lhs => draw::latin(seed, path, n),
        Sampling::Sobol => draw::sobol(seed, index as u32, n),
    };
    let real = |x: f64| Node::computed(Value::Float(x), &node.span);
    match distribution {
        Distribution::Uniform(a, b) => draws.into_iter().map(|u| real((a + u * (b - a)).clamp(*a, *b))).collect(),
        Distribution::LogUniform(a, b) => {
            let ratio = math::ln(b / a);
            draws.into_iter().map(|u| real((a * math::exp(u * ratio)).clamp(*a, *b))).collect()
        }
        Distribution::Normal(mean, deviation) => {
            draws.into_iter().map(|u| real(mean + deviation * normal::quantile(u))).collect()
        }
        Distribution::Integer(a, b) => {
            let whole = |u: f64| a + ((u * (b - a + 1) as f64) as i64).min(b - a);
            draws.into_iter().map(|u| Node::computed(Value::Integer(whole(u)), &node.span)).collect()
        }
        Distribution::Choice(_) => {
            let written = node.get("choice").map(Node::items).unwrap_or_default();
            let choices = unify_numbers(written.to_vec());
            let chosen = |u: f64| ((u * choices.len() as f64) as usize).min(choices.len() - 1);
            draws.into_iter().map(|u| choices[chosen(u)].clone()).collect()
        }
    }
}

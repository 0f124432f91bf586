//! Networks are evaluated by kernels that do not depend on the processor.

use stiction::policy::{Interface, load};

use super::onnx_file::{FLOAT, affine, constant, file, node, value};

fn evaluate(network: &[u8], observation: &[f32], outputs: usize) -> Vec<f32> {
    let interface =
        Interface { observation: observation.len(), action: outputs, input: None, output: None, state: Vec::new() };
    let mut network = load(network, &interface).unwrap_or_else(|e| panic!("{e}"));
    let mut action = vec![0.0; outputs];
    network.evaluate(observation, &mut [], &mut action).unwrap_or_else(|e| panic!("{e}"));
    action
}

/// Numbers whose sums round: multiples of the golden ratio, less their whole part.
fn numbers(count: usize, from: usize) -> Vec<f32> {
    (from..from + count).map(|i| ((i as f64 * 0.618_033_988_749_894_9).fract() - 0.5) as f32).collect()
}

/// A kernel for a special instruction set fuses multiplication and addition, or sums in another order. All bits
/// are those of the plain sum, for sizes with and without rest.
#[test]
fn sums_have_the_bits_of_the_plain_order() {
    for (width, outputs) in [(1, 1), (3, 2), (16, 4), (37, 19), (128, 64), (200, 33)] {
        let (weights, bias, x) = (numbers(width * outputs, 1), numbers(outputs, 7), numbers(width, 1000));
        let found = evaluate(&affine(width, &weights, &bias), &x, outputs);
        for (j, found) in found.into_iter().enumerate() {
            let sum = (0..width).fold(0.0_f32, |sum, k| sum + x[k] * weights[k * outputs + j]);
            assert_eq!(found.to_bits(), (sum + bias[j]).to_bits(), "{width} x {outputs}, output {j}");
        }
    }
}

/// Bits frozen on a processor with AVX-512. Its own kernel of `Tanh` gives others, and that of AVX2 further ones.
#[test]
fn activations_have_the_bits_of_the_portable_code() {
    let x = numbers(23, 5).into_iter().map(|x| 8.0 * x).collect::<Vec<_>>();
    let dims = [None, Some(23)];
    let elu = |x: f64| if x < 0.0 { x.exp_m1() } else { x };
    let tanh: fn(f64) -> f64 = f64::tanh;
    for (kind, reference, frozen) in [("Tanh", tanh, "666a9df690c7c438"), ("Elu", elu, "5da1bec01cb60f47")] {
        let network =
            file(&[value("obs", FLOAT, &dims)], &[value("y", FLOAT, &dims)], &[], &[node(kind, &["obs"], &["y"])]);
        let found = evaluate(&network, &x, 23);
        let mut hash = blake3::Hasher::new();
        found.iter().for_each(|y| {
            hash.update(&y.to_le_bytes());
        });
        for (x, y) in x.iter().zip(&found) {
            // The error of the rational and polynomial approximations, in single precision.
            assert!((f64::from(*y) - reference(f64::from(*x))).abs() < 1e-6, "{kind} {x}: {y}");
        }
        assert_eq!(hash.finalize().to_hex()[..16], *frozen, "{kind}");
    }
}

/// As in exports of an actor with a critic.
#[test]
fn one_output_of_several_is_chosen() {
    let dims = [None, Some(2)];
    let network = file(
        &[value("obs", FLOAT, &dims)],
        &[value("value", FLOAT, &dims), value("actions", FLOAT, &dims)],
        &[constant("two", &[1], &[2.0])],
        &[node("Add", &["obs", "two"], &["value"]), node("Mul", &["obs", "two"], &["actions"])],
    );
    let mut interface = Interface { observation: 2, action: 2, input: None, output: None, state: Vec::new() };
    let error = load(&network, &interface).err().expect("two outputs");
    assert_eq!(error.message, "the network must have one output besides states; it has `value`, `actions`");
    interface.output = Some("actions".into());
    let mut loaded = load(&network, &interface).unwrap_or_else(|e| panic!("{e}"));
    let mut action = [0.0; 2];
    loaded.evaluate(&[1.0, 3.0], &mut [], &mut action).expect("it runs");
    assert_eq!(action, [2.0, 6.0]);
}

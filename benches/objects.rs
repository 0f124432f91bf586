//! Boxes at rest, apart on the floor or in a stack, and HOAP-2 lying on it: fixed steps of 1 ms with `exact`.

use super::standing::{after, parsed};
use divan::Bencher;
use std::fmt::Write;
use stiction::sim::{NullObserver, Simulation};

/// A scene of fixed steps, after this number of them.
fn scene(name: &str, text: &str, steps: usize) -> Simulation {
    let root = crate::repository();
    let text = format!("duration = 1e6\nintegrator = {{ method = \"semi-implicit\", step = 1e-3 }}\n{text}");
    after(parsed(&root.join(name), &text), steps)
}

fn boxes(at: impl Fn(usize) -> [f64; 3], count: usize) -> Simulation {
    let mut text = "robot = { model = \"robots/ground/ground.urdf\" }\n".to_owned();
    for [x, y, z] in (0..count).map(at) {
        writeln!(
            text,
            "[[object]]\ntype = \"box\"\nsize = [0.2, 0.2, 0.1]\nmass = 1.0\nposition = [{x:?}, {y:?}, {z:?}]"
        )
        .expect("to a string");
    }
    scene("boxes.toml", &text, 20)
}

#[divan::bench(args = [1, 4, 16, 64])]
fn boxes_apart(bencher: Bencher, count: usize) {
    let mut sim = boxes(|i| [0.3 * (i % 8) as f64, 0.3 * (i / 8) as f64, 0.05], count);
    super::each(bencher, || sim.step(&mut NullObserver).is_ok());
}

#[divan::bench(args = [4, 20, 64])]
fn boxes_in_a_stack(bencher: Bencher, count: usize) {
    let mut sim = boxes(|i| [0.01 * (i % 2) as f64, 0.0, 0.05 + 0.1 * i as f64], count);
    super::each(bencher, || sim.step(&mut NullObserver).is_ok());
}

#[divan::bench]
fn lying_step(bencher: Bencher) {
    let text = std::fs::read_to_string(crate::repository().join("scenarios/hoap2-falls.toml"));
    let text = text.expect("the scenario is there");
    let kept: String = text.split("[[expect]]").next().expect("its first part").to_owned();
    let mut sim = scene("scenarios/bench.toml", &kept.replacen("duration = ", "# duration = ", 1), 5000);
    super::each(bencher, || sim.step(&mut NullObserver).is_ok());
}

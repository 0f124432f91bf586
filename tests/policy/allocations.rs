//! Evaluations of a network allocate its tensors; what a task holds does not grow.

use super::folder;
use super::onnx_file::identity;
use super::support::{hoap2, setup};
use crate::support::counting::{balance, count};
use stiction::sim::{NullObserver, Simulation};

#[test]
fn ticks_allocate_only_in_the_network_and_hold_no_more() {
    let folder = folder(identity(12));
    let decimated = |decimation: u32| {
        let task = format!(
            "decimation = {decimation}\nhistory = 2
            observations = [{{ term = \"gravity\" }}, {{ term = \"command\", values = [0, 0, 0] }}]
            action = {{ joints = [\"*_knee\", \"*_hip_*\", \"*_ankle_*\"], scale = 0.001 }}\n[log]\nrate = 0"
        );
        let mut sim = Simulation::new(setup(&folder, &hoap2(&task))).unwrap_or_else(|e| panic!("{e}"));
        sim.begin(&mut NullObserver).unwrap_or_else(|stop| panic!("{stop:?}"));
        let mut until = |time: f64| {
            while sim.plant().state.time < time {
                sim.step(&mut NullObserver).unwrap_or_else(|stop| panic!("{stop:?}"));
            }
        };
        until(0.2);
        let mut allocations = 0;
        let held = balance(|| allocations = count(|| until(0.6)));
        (allocations, held)
    };
    // 400 ticks of 1 kHz.
    let (every, held) = decimated(1);
    let (tenth, held_less) = decimated(10);
    println!("{every} allocations in 400 evaluations, {tenth} in 40; bytes more held: {held}, {held_less}");
    assert!(tenth <= every / 10 + 2 && every <= 400 * 100, "{every} and {tenth}");
    assert!(held.abs() < 10_000 && held_less.abs() < 10_000, "{held} and {held_less}");
}

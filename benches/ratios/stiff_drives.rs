//! Stiff servos with `dopri5`, `rosenbrock`, `bdf` and `auto`: processor time per simulated time of a continuing run.

use super::interleaved::{Values, rounds};
use crate::standing::{self, Servos, Standing};
use cpu_time::ThreadTime;
use stiction::sim::{NullObserver, Simulation};

const METHODS: [&str; 4] = ["dopri5", "rosenbrock", "bdf", "auto"];
const ROUNDS: usize = 5;
/// One period of the arms, s.
const SLICE: f64 = 1.0;

struct Motion {
    name: &'static str,
    kd: f64,
    swings: bool,
    interpolation: &'static str,
    absolute_tolerance: f64,
}

const MOTIONS: [Motion; 5] = [
    Motion { name: "stands", kd: 100.0, swings: false, interpolation: "hold", absolute_tolerance: 1e-8 },
    Motion { name: "arms swing", kd: 30.0, swings: true, interpolation: "hold", absolute_tolerance: 1e-8 },
    Motion { name: "arms swing, `cubic`", kd: 30.0, swings: true, interpolation: "cubic", absolute_tolerance: 1e-8 },
    Motion {
        name: "arms swing, `continuous`",
        kd: 30.0,
        swings: true,
        interpolation: "continuous",
        absolute_tolerance: 1e-8,
    },
    Motion { name: "the same, 1e-6", kd: 30.0, swings: true, interpolation: "continuous", absolute_tolerance: 1e-6 },
];

/// The servos of docs/scenario.md for G1; HOAP-2 weighs a fifth of it, and Talos more than such servos carry.
fn servos(robot: &Standing, motion: &Motion) -> Servos {
    if robot.name == "talos" {
        return Servos::ByWeight;
    }
    let scale = if robot.name == "hoap2" { 0.2 } else { 1.0 };
    Servos::Equal { kp: scale * 300.0, kd: scale * motion.kd, armature: scale * 0.015 }
}

fn simulation(robot: &Standing, motion: &Motion, method: &str) -> Simulation {
    let keys = format!(
        "integrator = {{ method = \"{method}\", absolute_tolerance = {} }}
        control = {{ interpolation = \"{}\" }}
        log = {{ rate = 0.0 }}",
        motion.absolute_tolerance, motion.interpolation
    );
    standing::after(robot.setup(&keys, &servos(robot, motion), motion.swings), 0)
}

pub fn print() {
    println!(
        "\n## Stiff drives, us of one core per simulated ms: minimum (median); ratios: median (least to greatest)\n"
    );
    println!("| robot | motion | {} | dopri5 / rosenbrock | dopri5 / bdf | dopri5 / auto |", METHODS.join(" | "));
    println!("|---|---|---|---|---|---|---|---|---|");
    for robot in &standing::robots() {
        for motion in &MOTIONS {
            row(robot, motion);
        }
    }
}

fn row(robot: &Standing, motion: &Motion) {
    let case = |method: &str| -> Box<dyn FnMut() -> f64> {
        let (mut sim, mut end) = (simulation(robot, motion, method), 0.0);
        Box::new(move || {
            end += SLICE;
            let begin = ThreadTime::now();
            sim.advance_to(end, &mut NullObserver).expect("it continues");
            begin.elapsed().as_secs_f64() / SLICE * 1e3
        })
    };
    let times = rounds(1, ROUNDS, &mut METHODS.map(case));
    let of = |value: &dyn Fn(&[f64]) -> f64| Values::new(times.iter().map(|round| value(round)).collect());
    let cells = [0, 1, 2, 3].map(|i| {
        let values = of(&|round| round[i]);
        format!("{:.1} ({:.1})", values.min(), values.median())
    });
    let ratios = [1, 2, 3].map(|i| of(&|round| round[0] / round[i]).to_string());
    println!("| {} | {} | {} | {} |", robot.name, motion.name, cells.join(" | "), ratios.join(" | "));
}

//! What a log at 200 Hz adds to the cheapest steps: HOAP-2 sways under a push, `one-step` in steps of 1 ms.

use super::interleaved::{Values, rounds};
use crate::{standing, watched};
use cpu_time::ThreadTime;
use stiction::sim::{NullObserver, Observer, Setup, Simulation};

const ROUNDS: usize = 19;
/// Simulated time of a round, s, and frames in it.
const SLICE: f64 = 1.0;
const FRAMES: f64 = 200.0;
/// Steps in a round.
const STEPS: f64 = 1000.0;

fn setup(rate: f64) -> Setup {
    let text = format!(
        "duration = 1e6
        robot = {{ model = \"robots/hoap2/hoap2.toml\" }}
        contact = {{ method = \"one-step\" }}
        integrator = {{ method = \"semi-implicit\", step = 1e-3 }}
        log = {{ rate = {rate:?} }}
        [[force]]
        type = \"push\"
        link = \"torso\"
        point = [0.0, 0.0, 0.1]
        force = [2.0, 1.0, 0.0]
        duration = 20.0
        profile = \"half-sine\"\n"
    );
    standing::parsed(&crate::repository().join("bench.toml"), &text)
}

/// Times a round, us.
fn advance(sim: &mut Simulation, observer: &mut dyn Observer, end: &mut f64) -> f64 {
    *end += SLICE;
    let begin = ThreadTime::now();
    sim.advance_to(*end, observer).expect("it continues");
    begin.elapsed().as_secs_f64() * 1e6
}

pub fn print() {
    let folder = tempfile::tempdir().expect("a folder");
    let logged = setup(200.0);
    let mut log = watched::log(&logged, Some(folder.path()), None);
    let mut run = Simulation::new(logged).expect("the physics can do it");
    run.begin(&mut log).expect("it begins");
    let mut without = standing::after(setup(0.0), 0);
    let (mut end, mut end_without) = (0.0, 0.0);
    let mut cases: [Box<dyn FnMut() -> f64>; 2] = [
        Box::new(|| advance(&mut without, &mut NullObserver, &mut end_without)),
        Box::new(|| advance(&mut run, &mut log, &mut end)),
    ];
    let times = rounds(1, ROUNDS, &mut cases);
    drop(cases);
    log.finish().expect("it is written");
    let size = std::fs::metadata(folder.path().join("log.mcap")).expect("a file").len();
    let of = |value: &dyn Fn(&[f64]) -> f64| Values::new(times.iter().map(|round| value(round)).collect());
    let step = of(&|round| round[0] / STEPS);
    let least = of(&|round| round[1]).min() - of(&|round| round[0]).min();
    println!("\n## Logs at 200 Hz, us of one core: minimum (median); ratio: median (least to greatest)\n");
    println!("| step without a log | frame of a log | kB a frame | with / without a log |");
    println!("|---|---|---|---|");
    println!(
        "| {:.2} ({:.2}) | {:.2} ({:.2}) | {:.2} | {} |",
        step.min(),
        step.median(),
        least / FRAMES,
        of(&|round| (round[1] - round[0]) / FRAMES).median(),
        1e-3 * size as f64 / (FRAMES * (ROUNDS + 1) as f64),
        of(&|round| round[1] / round[0])
    );
}

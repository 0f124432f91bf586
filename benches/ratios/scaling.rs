//! Whole batches on one thread and on two: wall-clock time of plan, runs, summary and report.
//!
//! Results are written below the folder of temporary files (`TMPDIR`). Rounds in which other processes took more than
//! `QUIET` of a processor are counted only if there are no others.

use super::interleaved::{Values, rounds};
use cpu_time::ProcessTime;
use std::num::NonZero;
use std::path::Path;
use std::time::Instant;
use stiction::{Options, run_batch};

struct Kind {
    name: &'static str,
    runs: usize,
    log: bool,
    rounds: usize,
    scenario: fn(&Path) -> String,
}

/// A push that no two runs share.
fn pushed(root: &Path, duration: f64) -> String {
    format!(
        "duration = {duration:?}
        robot = {{ model = {:?} }}
        [[force]]
        type = \"push\"
        link = \"torso\"
        force = [4.0, 1.0, 0.0]
        start = 0.01
        duration = 0.1
        [[task]]
        type = \"squat\"
        depth = 0.02
        period = 1.0
        repetitions = 1000
        [sweep.random]
        samples = 64
        \"force.0.force.0\" = {{ uniform = [-6.0, 6.0] }}\n",
        root.join("robots/hoap2/hoap2.toml")
    )
}

fn long(root: &Path) -> String {
    pushed(root, 4.0)
}

fn short(root: &Path) -> String {
    pushed(root, 0.03)
}

fn tiny(root: &Path) -> String {
    format!(
        "duration = 0.002\nrobot = {{ model = {:?} }}\nsweep = {{ repeat = 10000 }}\n",
        root.join("robots/block/block.toml")
    )
}

const KINDS: [Kind; 5] = [
    Kind { name: "10 000 tiny runs", runs: 10_000, log: false, rounds: 6, scenario: tiny },
    Kind { name: "64 short runs", runs: 64, log: false, rounds: 15, scenario: short },
    Kind { name: "64 short runs with logs", runs: 64, log: true, rounds: 15, scenario: short },
    Kind { name: "64 runs", runs: 64, log: false, rounds: 3, scenario: long },
    Kind { name: "64 runs with logs", runs: 64, log: true, rounds: 3, scenario: long },
];

/// Share of one processor that other processes may take.
const QUIET: f64 = 0.05;

/// Times of a batch, s.
struct Batch {
    wall: f64,
    /// Processor time of the process.
    cpu: f64,
    /// Processor time of all processes; 0 where it is unknown.
    all: f64,
}

impl Batch {
    fn is_quiet(&self) -> bool {
        // Ticks of the kernel are 10 ms.
        self.all - self.cpu <= QUIET * self.wall + 0.02
    }
}

/// Processor time of all processes since the start of the system, s; on Linux alone.
fn all_processes() -> f64 {
    let text = std::fs::read_to_string("/proc/stat").unwrap_or_default();
    let line = text.lines().next().unwrap_or_default();
    let ticks: Vec<f64> = line.split_whitespace().skip(1).filter_map(|cell| cell.parse().ok()).collect();
    // user, nice, system, then idle and iowait, then irq, softirq, steal.
    [0, 1, 2, 5, 6, 7].iter().filter_map(|i| ticks.get(*i)).sum::<f64>() / 100.0
}

fn batch(kind: &Kind, jobs: usize) -> Batch {
    let folder = tempfile::tempdir().expect("a folder");
    let scenario = folder.path().join("batch.toml");
    std::fs::write(&scenario, (kind.scenario)(crate::repository())).expect("it is written");
    let options = Options { output: folder.path().join("results"), jobs, log: kind.log, ..Options::default() };
    let (begin, cpu, all) = (Instant::now(), ProcessTime::now(), all_processes());
    let report = run_batch([&scenario], options).unwrap_or_else(|e| panic!("{e}"));
    let (wall, cpu) = (begin.elapsed().as_secs_f64(), cpu.elapsed().as_secs_f64());
    let times = Batch { wall, cpu, all: all_processes() - all };
    assert_eq!((report.statistics.runs(), report.unfinished), (kind.runs, 0), "every run passes");
    times
}

pub fn print() {
    if std::thread::available_parallelism().map_or(1, NonZero::get) < 2 {
        println!("\nscaling: skipped, since it needs two processors");
        return;
    }
    println!("\n## Scaling from one thread to two: medians; ratios: median (least to greatest)\n");
    println!(
        "| batch | -j 1, s | -j 2, s | per run, ms | ratio | of the minima | processor time -j 2 / -j 1 | quiet rounds |"
    );
    println!("|---|---|---|---|---|---|---|---|");
    KINDS.iter().for_each(row);
}

fn row(kind: &Kind) {
    let case = |jobs| -> Box<dyn FnMut() -> Batch + '_> { Box::new(move || batch(kind, jobs)) };
    let mut times = rounds(usize::from(kind.rounds > 3), kind.rounds, &mut [1, 2].map(case));
    let is_quiet = |round: &[Batch]| round.iter().all(Batch::is_quiet);
    let quiet = times.iter().filter(|round| is_quiet(round)).count();
    times.retain(|round| quiet == 0 || is_quiet(round));
    let of = |value: &dyn Fn(&[Batch]) -> f64| Values::new(times.iter().map(|round| value(round)).collect());
    let (one, two) = (of(&|round| round[0].wall), of(&|round| round[1].wall));
    let ratio = of(&|round| round[0].wall / round[1].wall);
    let cpu = of(&|round| round[1].cpu / round[0].cpu);
    println!(
        "| {} | {:.3} | {:.3} | {:.3} | {ratio} | {:.2} | {cpu} | {quiet} of {} |",
        kind.name,
        one.median(),
        two.median(),
        1e3 * one.median() / kind.runs as f64,
        one.min() / two.min(),
        kind.rounds
    );
}

//! Runs scenario text with the robots of the repository.

use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use stiction::assemble;
use stiction::robot;
use stiction::scenario;
use stiction::sim::{Metrics, NullObserver, Observer, Outcome, Setup, SimEvent, Simulation, Snapshot};

/// Tolerances of the validation runs (`docs/contact.md`, section 13).
pub const TIGHT: &str = "
    integrator = { relative_tolerance = 1e-9, absolute_tolerance = 1e-11 }
    contact = { distance_tolerance = 1e-8, velocity_tolerance = 1e-8, acceleration_tolerance = 1e-8 }
";

/// The repository's root.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).to_owned()
}

/// The setup of the only run of a scenario given as text; relative paths start at the repository's
/// root.
#[track_caller]
pub fn setup(text: &str) -> Setup {
    let file = scenario::parse(&root().join("test.toml"), text).unwrap_or_else(|e| panic!("{e}"));
    let runs = file.expand(&[]).unwrap_or_else(|e| panic!("{e}"));
    let robot = robot::load(&runs[0].resolve(&runs[0].scenario.robot.model)).unwrap_or_else(|e| panic!("{e}"));
    assemble::setup(&runs[0], &robot).unwrap_or_else(|e| panic!("{text}\n{e}"))
}

/// Prepares the only run of such a scenario.
pub fn simulation(text: &str) -> Simulation {
    Simulation::new(setup(text)).unwrap_or_else(|e| panic!("{e}"))
}

/// A case of `scenarios/studies/hard-pushes.toml`: a robot with this initial `base`, pushed once, with
/// `more` settings.
pub fn hard_push(robot: &str, base: &str, more: &str) -> String {
    let (link, magnitude) = match robot {
        "hoap2" => ("torso", [7.0, 55.9]),
        "cbi" => ("torso", [61.7, 493.5]),
        "quadruped" => ("body", [13.1, 105.0]),
        other => panic!("no push for {other}"),
    };
    format!(
        "contact.velocity_tolerance = 0.02
        control.rate = 500
        log.rate = 0
        robot = {{ model = \"robots/{robot}/{robot}.toml\", contact = \"soles\", base = {{ {base} }} }}
        force = [{{ type = \"random-pushes\", links = [\"{link}\"], number = 1, start = 0.2, duration = 0.4, magnitude = {magnitude:?}, push_duration = [0.02, 0.3], direction = \"any\", profile = \"half-sine\" }}]
        {more}\n"
    )
}

/// Runs a scenario and asserts that it passes.
pub fn run(text: &str) -> Metrics {
    finish(&mut simulation(text), &mut NullObserver)
}

/// Runs a scenario, asserts that it passes, and records its events and snapshots.
pub fn watch(text: &str) -> (Metrics, Recording) {
    let mut recording = Recording::default();
    let metrics = finish(&mut simulation(text), &mut recording);
    (metrics, recording)
}

/// Runs to the end and asserts that the run passes.
pub fn finish(sim: &mut Simulation, observer: &mut dyn Observer) -> Metrics {
    let (outcome, message) = sim.run(observer, &AtomicBool::new(false));
    assert_eq!(outcome, Outcome::Passed, "{message}\n{:?}", sim.metrics());
    sim.metrics().clone()
}

/// Events and snapshots of a run.
#[derive(Default)]
pub struct Recording {
    /// Events in order.
    pub events: Vec<SimEvent>,
    /// Snapshots in order.
    pub snapshots: Vec<Snapshot>,
}

impl Observer for Recording {
    fn snapshot(&mut self, snapshot: &Snapshot) -> Result<(), stiction::sim::ObserverError> {
        self.snapshots.push(snapshot.clone());
        Ok(())
    }

    fn event(&mut self, event: &SimEvent) -> Result<(), stiction::sim::ObserverError> {
        self.events.push(event.clone());
        Ok(())
    }
}

/// Fixed-step classical Runge-Kutta, the independent integrator of these tests.
pub fn rk4<const N: usize>(
    mut y: [f64; N],
    duration: f64,
    steps: usize,
    f: impl Fn(f64, &[f64; N]) -> [f64; N],
) -> [f64; N] {
    let h = duration / steps as f64;
    let go = |y: &[f64; N], k: &[f64; N], h: f64| std::array::from_fn(|i| y[i] + h * k[i]);
    for n in 0..steps {
        let t = n as f64 * h;
        let a = f(t, &y);
        let b = f(t + 0.5 * h, &go(&y, &a, 0.5 * h));
        let c = f(t + 0.5 * h, &go(&y, &b, 0.5 * h));
        let d = f(t + h, &go(&y, &c, h));
        y = std::array::from_fn(|i| y[i] + h / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]));
    }
    y
}

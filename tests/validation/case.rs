//! Validation scenarios for the tests: expanded runs with their boxes.

use std::path::PathBuf;

use stiction::robot::{Model, load};
use stiction::scenario::{self, BaseSpec, ForceSpec, PushForce, Run};

use crate::analytic::body::G;
use crate::support::runs::root;

/// The folder of validation scenarios.
pub fn folder() -> PathBuf {
    root().join("scenarios/validation")
}

/// Names and paths of all scenarios in it, in order.
pub fn files() -> Vec<(String, PathBuf)> {
    let mut found: Vec<_> = std::fs::read_dir(folder())
        .expect("the folder is there")
        .map(|entry| entry.expect("it can be read").path())
        .filter(|path| path.extension().is_some_and(|e| e == "toml"))
        .map(|path| (path.file_stem().expect("it has a name").to_string_lossy().into_owned(), path))
        .collect();
    found.sort();
    found
}

/// One run of a validation scenario with its robot.
pub struct Case {
    /// The run.
    pub run: Run,
    /// Its robot, loaded from its own files.
    pub model: Model,
}

/// All runs of a scenario.
pub fn cases(name: &str) -> Vec<Case> {
    let file = scenario::load(&folder().join(format!("{name}.toml"))).unwrap_or_else(|e| panic!("{e}"));
    let runs = file.expand(&[]).unwrap_or_else(|e| panic!("{e}"));
    assert!(!runs.is_empty(), "{name}");
    runs.into_iter()
        .map(|run| {
            let path = run.resolve(&run.scenario.robot.model);
            let model = load(&path).unwrap_or_else(|e| panic!("{}", e.render(false))).model;
            Case { run, model }
        })
        .collect()
}

impl Case {
    /// Half lengths of a box, m, from its own sole, which is its bottom face.
    pub fn half(&self) -> [f64; 3] {
        let sole = &self.model.soles[0].vertices;
        assert_eq!((self.model.soles.len(), sole.len(), self.model.links.len()), (1, 4, 1), "a box");
        let most = |i: usize| sole.iter().map(|v| v[i].abs()).fold(0.0, f64::max);
        [most(0), most(1), most(2)]
    }

    /// Mass with its payload, kg.
    pub fn mass(&self) -> f64 {
        self.model.mass() + self.run.scenario.robot.payload.iter().map(|p| p.mass).sum::<f64>()
    }

    /// Weight, N.
    pub fn weight(&self) -> f64 {
        self.mass() * G
    }

    /// Principal moments of inertia of a homogeneous box about its centre, kg m^2.
    pub fn inertia(&self) -> [f64; 3] {
        let [a, b, c] = self.half().map(|x| x * x * self.mass() / 3.0);
        [b + c, a + c, a + b]
    }

    /// Distance of a corner from the middle of the sole, m.
    pub fn radius(&self) -> f64 {
        let [a, b, _] = self.half();
        a.hypot(b)
    }

    /// Static friction coefficient.
    pub fn mu_s(&self) -> f64 {
        self.run.scenario.floor.friction.static_
    }

    /// Kinetic friction coefficient.
    pub fn mu_k(&self) -> f64 {
        self.run.scenario.floor.friction.kinetic
    }

    /// Initial position and velocity.
    pub fn base(&self) -> &BaseSpec {
        &self.run.scenario.robot.base
    }

    /// Initial height of a box's centre above its height on the floor, m.
    pub fn fall(&self) -> f64 {
        self.base().position.expect("it is dropped from somewhere")[2] - self.half()[2]
    }

    /// End of the run, s.
    pub fn duration(&self) -> f64 {
        self.run.scenario.duration
    }

    /// The only push.
    pub fn push(&self) -> &PushForce {
        match self.run.scenario.force.as_slice() {
            [ForceSpec::Push(push)] => push,
            other => panic!("one push, not {other:?}"),
        }
    }
}

#[test]
fn the_boxes_are_homogeneous() {
    for name in ["block", "brick", "die", "tower"] {
        let path = root().join(format!("robots/{name}/{name}.toml"));
        let model = load(&path).unwrap_or_else(|e| panic!("{}", e.render(false))).model;
        let half = [0, 1, 2].map(|i| model.soles[0].vertices.iter().map(|v| v[i].abs()).fold(0.0, f64::max));
        let [a, b, c] = half.map(|x| x * x * model.mass() / 3.0);
        let inertia = &model.links[0].inertia;
        for (i, truth) in [b + c, a + c, a + b].into_iter().enumerate() {
            // The file rounds to these digits.
            assert!((inertia[(i, i)] / truth - 1.0).abs() < 1e-15 * 8.0, "{name} {i} {inertia}");
        }
        assert!(model.links[0].com.norm() == 0.0 && inertia[(0, 1)] == 0.0);
    }
}

//! Cost of scripts compared with Rust: a task on HOAP-2 (25 joints) that commands each joint a
//! position and a velocity at every tick, and a force on one link.

use divan::Bencher;
use stiction::dynamics::{State, Workspace, kinematics};
use stiction::force::profile::{Profile, Shape};
use stiction::force::wrench::Wrench;
use stiction::force::{AppliedForces, Force, ForceContext};
use stiction::geometry::Plane;
use stiction::random::Stream;
use stiction::robot::{self, JointId, LinkId, Model};
use stiction::script::script_force::{Schedule, ScriptForce};
use stiction::script::script_task::ScriptTask;
use stiction::script::{Params, Purpose, RobotNames, Script};
use stiction::task::posture::Posture;
use stiction::task::server::TickInput;
use stiction::task::{Command, SensorReadings, Task, TaskServer};

const SINE: &str = "
local from = {}
function init(robot) for i, q in robot.desired.position do from[i] = q end end
function run(robot)
    local sin, cos = math.sin(robot.time), math.cos(robot.time)
    for i, q in from do
        robot.set_position(i, q + 0.1 * sin)
        robot.set_velocity(i, 0.1 * cos)
    end
end";

const PUSH: &str = "function run(robot) return { { link = \"torso\", force = { 1, 2, 3 } } } end";

fn hoap2() -> Model {
    let path = crate::repository().join("robots/hoap2/hoap2.toml");
    robot::load(&path).expect("our own robot").model
}

fn script(text: &str, purpose: Purpose, model: &Model) -> Script {
    Script::load("bench.luau", text, purpose, model, Stream::new(1, &["bench"])).expect("our own script")
}

/// A tick of the task server with one task.
fn tick(bencher: Bencher, task: impl FnOnce(&Model) -> Box<dyn Task>) {
    let model = hoap2();
    let (mut state, sensed) = (State::home(&model), SensorReadings::blank(&model));
    let mut server = TaskServer::new(1000.0, &model, Command::hold(&model, &model.home));
    server.add(0.0, task(&model));
    super::each(bencher, || {
        state.time += 1e-3;
        let floor = Plane::LEVEL;
        let now =
            TickInput { model: &model, gravity: nalgebra::Vector3::zeros(), floor, state: &state, sensed: &sensed };
        server.run(&now, |_, _| {}).is_ok()
    });
}

#[divan::bench]
fn task_built_in(bencher: Bencher) {
    tick(bencher, |model| {
        let targets = (0..model.nj()).map(|j| (JointId(j), model.home[j] + 0.1)).collect();
        Box::new(Posture::new(targets, 1e9))
    });
}

#[divan::bench]
fn task_script(bencher: Bencher) {
    tick(bencher, |model| {
        let script = script(SINE, Purpose::Task, model);
        Box::new(ScriptTask::new("bench".into(), script, Params::new(), Vec::new(), f64::INFINITY))
    });
}

fn evaluate(bencher: Bencher, force: impl FnOnce(&Model) -> Box<dyn Force>) {
    let model = hoap2();
    let (state, mut ws) = (State::home(&model), Workspace::new(&model));
    kinematics::update(&model, &state, &mut ws);
    let context = ForceContext {
        model: &model,
        state: &state,
        kinematics: &ws,
        gravity: nalgebra::Vector3::zeros(),
        time: 0.0,
        within: 0.0,
    };
    let mut force = force(&model);
    force.init(&context).expect("it begins");
    let (mut tau, mut arrows) = (vec![0.0; model.nv()], Vec::with_capacity(16));
    super::each(bencher, || {
        arrows.clear();
        force.evaluate(&context, &mut AppliedForces::new(&mut tau, &mut arrows));
    });
}

#[divan::bench]
fn force_built_in(bencher: Bencher) {
    evaluate(bencher, |_| {
        let (zero, force) = (nalgebra::Vector3::zeros(), nalgebra::Vector3::new(1.0, 2.0, 3.0));
        let profile = Profile::new(Shape::Always, 0.0, 1.0);
        Box::new(Wrench { link: LinkId(0), point: zero, force, moment: zero, axes: None, profile })
    });
}

#[divan::bench]
fn force_script(bencher: Bencher) {
    evaluate(bencher, |model| {
        let span = Profile::new(Shape::Always, 0.0, 1.0);
        let plan = Schedule { span, corners: Vec::new(), params: Params::new(), changes: Vec::new() };
        let script = script(PUSH, Purpose::Force, model);
        Box::new(ScriptForce::new("bench".into(), script, RobotNames::new(model), plan))
    });
}

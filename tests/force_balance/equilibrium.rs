//! The commanded efforts are in exact equilibrium with the planned contact forces.

use super::standing::HOAP;
use crate::analytic::body::G;
use crate::identities::random_tree::Random;
use crate::support::counting::count;
use crate::support::runs::{root, simulation};
use nalgebra::{UnitQuaternion, Vector3};
use stiction::dynamics::{State, Workspace, body, kinematics, link_force, rnea};
use stiction::geometry::Plane;
use stiction::robot::{DriveMode, Model, SoleId, load};
use stiction::task::balance::force_balance::{ForceBalance, Gains, Settings};
use stiction::task::{AugmentedData, Command, Context, SensorReadings, Task};

const GRAVITY: Vector3<f64> = Vector3::new(0.0, 0.0, -G);

fn settings(gains: Gains) -> Settings {
    Settings {
        duration: f64::INFINITY,
        com: gains,
        orientation: gains,
        joints: gains,
        offset: Vector3::zeros(),
        approach: 1.0,
        friction: 0.5,
        margin: 0.1,
        sensed: false,
    }
}

fn model(file: &str) -> Model {
    load(&root().join(file)).unwrap_or_else(|e| panic!("{e}")).model
}

/// One tick at `state`: the commanded efforts and the task.
fn tick(model: &Model, task: &mut ForceBalance, begin: &State, state: &State) -> (Command, AugmentedData) {
    let sensed = SensorReadings::blank(model);
    let mut data = AugmentedData::new(model);
    let mut command = Command::hold(model, &begin.joints);
    data.update(model, begin, &sensed, &GRAVITY, &Plane::LEVEL, task.needs());
    let context = Context {
        time: 0.0,
        start: 0.0,
        model,
        gravity: GRAVITY,
        floor: Plane::LEVEL,
        state: begin,
        sensed: &sensed,
        data: &data,
    };
    task.init(&context, &command).expect("it begins");
    data.update(model, state, &sensed, &GRAVITY, &Plane::LEVEL, task.needs());
    let context = Context {
        time: 0.0,
        start: 0.0,
        model,
        gravity: GRAVITY,
        floor: Plane::LEVEL,
        state,
        sensed: &sensed,
        data: &data,
    };
    let allocations = count(|| {
        task.run(&context, &mut command).expect("it runs");
    });
    assert_eq!(allocations, 0);
    (command, data)
}

/// `h - J^T f - S^T tau` at rest, which is zero in equilibrium: inverse dynamics without
/// acceleration.
fn unbalanced(model: &Model, state: &State, task: &ForceBalance, command: &Command) -> Vec<f64> {
    let mut ws = Workspace::new(model);
    kinematics::update(model, state, &mut ws);
    rnea::bias(&mut ws, &GRAVITY);
    let mut rest = ws.bias.clone();
    for (hold, f) in task.stance().footholds.iter().zip(task.forces()) {
        link_force::accumulate(&ws, model.soles[hold.sole.0].link, &hold.point, &-f, &Vector3::zeros(), &mut rest);
    }
    for (j, joint) in model.joints.iter().enumerate() {
        let rest = &mut rest[model.nb() + j];
        // The effort of a kinematic joint is not commanded.
        *rest = if joint.drive.mode == DriveMode::Kinematic { 0.0 } else { *rest - command.effort[j] };
    }
    rest
}

/// Home, leaning slightly: the weight's line of action stays inside the soles.
fn leaning(model: &Model, r: &mut Random) -> State {
    let mut state = State::home(model);
    state.rotation = UnitQuaternion::from_scaled_axis(r.vector(0.02));
    state.position = r.vector(1.0);
    state.joints.iter_mut().for_each(|q| *q += r.within(-0.03, 0.03));
    state
}

#[test]
fn efforts_and_planned_forces_are_in_equilibrium() {
    let mut r = Random::new(21);
    for file in ["robots/hoap2/hoap2.toml", "robots/cbi/cbi.toml"] {
        let model = model(file);
        let soles: Vec<_> = (0..model.soles.len()).map(SoleId).collect();
        let weight = model.mass() * G;
        for _ in 0..20 {
            let state = leaning(&model, &mut r);
            let mut task = ForceBalance::new("test", &model, soles.clone(), settings(Gains::default()), vec![]);
            let (command, _) = tick(&model, &mut task, &state, &state);
            let sum: Vector3<f64> = task.forces().iter().sum();
            assert!((sum - Vector3::z() * weight).norm() < 1e-12 * weight, "{sum}");
            let largest = unbalanced(&model, &state, &task, &command).iter().fold(0.0f64, |m, x| m.max(x.abs()));
            assert!(largest < 1e-10 * weight, "{file}: {largest:e} of {weight} N");
        }
    }
}

#[test]
fn a_desired_wrench_acts_at_the_centre_of_mass_and_on_the_base() {
    let model = model("robots/hoap2/hoap2.toml");
    let (mut r, weight) = (Random::new(22), model.mass() * G);
    for _ in 0..20 {
        let begin = leaning(&model, &mut r);
        let mut state = begin.clone();
        // Small enough for the friction cones, so the full wrench is feasible.
        let way: Vec<f64> = r.list(model.nv(), 5e-4);
        state.displace(&way);
        let gains = Gains { kp: 100.0, kd: 20.0 };
        let only = Settings { joints: Gains::default(), ..settings(gains) };
        let mut task = ForceBalance::new("test", &model, vec![SoleId(0), SoleId(1)], only, vec![]);
        let (command, data) = tick(&model, &mut task, &begin, &state);
        let sum: Vector3<f64> = task.forces().iter().sum();
        let pull = sum - Vector3::z() * weight;
        assert!(pull.norm() > 1e-4 * weight, "{pull}");
        let rest = unbalanced(&model, &state, &task, &command);
        // h + m J_c^T f_u + (0, N) = J^T f + S^T tau; what unbalanced() lacks is J_c^T f_u and N.
        let mut moment = Vector3::zeros();
        for (k, (rest, column)) in rest.iter().zip(data.com_jacobian.chunks_exact(3)).enumerate() {
            let left = rest + Vector3::from_column_slice(column).dot(&pull);
            if (3..6).contains(&k) {
                moment[k - 3] = -left;
            } else {
                assert!(left.abs() < 1e-10 * weight, "{k}: {left:e}");
            }
        }
        // N = I kp turn, with the robot's inertia about its centre of mass, column by column from
        // the kinetic energy of rotation.
        let turn = (begin.rotation * state.rotation.inverse()).scaled_axis();
        let expected = inertia(&model, &state) * turn * gains.kp;
        assert!((moment - expected).norm() < 1e-10 * weight, "{moment} {expected}");
    }
}

/// Inertia of the whole robot about its centre of mass, from the energies of rotation as one body.
fn inertia(model: &Model, state: &State) -> nalgebra::Matrix3<f64> {
    let mut ws = Workspace::new(model);
    kinematics::update(model, state, &mut ws);
    let c = body::center_of_mass(&ws) - state.position;
    let mut energy = |w: Vector3<f64>| {
        let mut turning = state.clone();
        turning.v.fill(0.0);
        turning.v[..3].copy_from_slice((-w.cross(&c)).as_slice());
        turning.v[3..6].copy_from_slice(w.as_slice());
        kinematics::update(model, &turning, &mut ws);
        body::kinetic_energy(model, &ws)
    };
    let e = |i: usize| Vector3::from_fn(|k, _| if k == i { 1.0 } else { 0.0 });
    let single: [f64; 3] = std::array::from_fn(|i| energy(e(i)));
    nalgebra::Matrix3::from_fn(
        |i, j| {
            if i == j { 2.0 * single[i] } else { energy(e(i) + e(j)) - single[i] - single[j] }
        },
    )
}

#[test]
fn the_floor_gives_the_planned_forces() {
    // The simulator's own contact forces at the first instant, without acceleration.
    let mut sim = simulation(&format!("{HOAP}[[task]]\ntype = \"gravity-compensation\"\n"));
    sim.begin(&mut stiction::sim::NullObserver).expect("it begins");
    let plant = sim.plant();
    let largest = plant.acceleration.iter().fold(0.0f64, |m, a| m.max(a.abs()));
    assert!(largest < 1e-9, "{largest:e}");
    let lift: f64 = (0..2).map(|s| plant.solution.wrench[6 * s + 2]).sum();
    assert!((lift - plant.model.mass() * G).abs() < 1e-9, "{lift}");
}

//! Objects of several links and of meshes, by closed forms and against the same mechanisms as robots.

use super::body::G;
use crate::support::runs::{finish, root, simulation};
use nalgebra::Vector3;
use std::path::PathBuf;
use stiction::dynamics::State;
use stiction::sim::{Metrics, NullObserver, Simulation};
use stiction::{assemble, robot, scenario};
use tempfile::TempDir;

/// No robot, and tolerances at which the closed forms below hold to 1e-9.
pub const ALONE: &str = "robot = { model = \"robots/ground/ground.urdf\" }
    integrator = { relative_tolerance = 1e-11, absolute_tolerance = 1e-13 }
    contact = { distance_tolerance = 1e-8, velocity_tolerance = 1e-8, acceleration_tolerance = 1e-8 }
    log = { rate = 0 }\n";

pub fn finished(scenario: &str) -> (Simulation, Metrics) {
    let mut sim = simulation(&format!("{ALONE}{scenario}"));
    let metrics = finish(&mut sim, &mut NullObserver);
    (sim, metrics)
}

pub fn object(sim: &Simulation, o: usize) -> &State {
    &sim.plant().objects.list[o].state
}

/// Velocity of the origin of a free object.
pub fn velocity(sim: &Simulation, o: usize) -> Vector3<f64> {
    Vector3::from_column_slice(&object(sim, o).v[..3])
}

/// A file in a folder of its own.
pub struct File(TempDir, &'static str);

impl File {
    pub fn new(name: &'static str, text: &str) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::write(folder.path().join(name), text).expect("written");
        File(folder, name)
    }

    pub fn path(&self) -> PathBuf {
        self.0.path().join(self.1)
    }
}

/// A link with a box for its collisions. `inertia`: about its centre of mass at `com`.
pub fn link(name: &str, mass: f64, com: [f64; 3], inertia: f64, size: Option<[f64; 3]>) -> String {
    let [x, y, z] = com;
    let shape = size.map_or(String::new(), |[a, b, c]| {
        format!("<collision><origin xyz=\"{x} {y} {z}\"/><geometry><box size=\"{a} {b} {c}\"/></geometry></collision>")
    });
    format!(
        "<link name=\"{name}\"><inertial><origin xyz=\"{x} {y} {z}\"/><mass value=\"{mass}\"/>
        <inertia ixx=\"{inertia}\" iyy=\"{inertia}\" izz=\"{inertia}\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial>{shape}</link>"
    )
}

/// A joint between links, at a position in the parent, with more elements.
pub fn joint(name: &str, kind: &str, links: [&str; 2], at: [f64; 3], axis: [f64; 3], more: &str) -> String {
    let [parent, child] = links;
    format!(
        "<joint name=\"{name}\" type=\"{kind}\"><parent link=\"{parent}\"/><child link=\"{child}\"/>
        <origin xyz=\"{} {} {}\"/><axis xyz=\"{} {} {}\"/>{more}</joint>",
        at[0], at[1], at[2], axis[0], axis[1], axis[2]
    )
}

/// One link on a joint fixed to the world.
pub fn jointed(link: &str, joint: &str) -> File {
    File::new("model.urdf", &format!("<robot name=\"model\"><link name=\"world\"/>{link}{joint}</robot>"))
}

const WIDE: &str = "<limit lower=\"-10\" upper=\"10\" effort=\"1000\" velocity=\"1000\"/>";

/// A pendulum of amplitude a has the period T = 4 K(k) / w, with w^2 = m g l / I and k = sin(a / 2). It
/// passes its lowest point at T / 4 with the speed 2 k w.
#[test]
fn a_pendulum_swings_with_the_period_of_the_elliptic_integral() {
    let (m, l, inertia, a) = (1.3, 0.4, 0.02, 2.0f64);
    let body = link("rod", m, [0.0, 0.0, -l], inertia, None);
    let hinge = joint("hinge", "continuous", ["world", "rod"], [0.1, 0.2, 1.5], [0.0, 1.0, 0.0], "");
    let file = jointed(&body, &hinge);
    let w = (m * G * l / (inertia + m * l * l)).sqrt();
    let k = (0.5 * a).sin();
    // K(k) = pi / (2 M(1, sqrt(1 - k^2))), M the mean of Gauss.
    let (mut x, mut y) = (1.0, (1.0 - k * k).sqrt());
    for _ in 0..10 {
        (x, y) = (0.5 * (x + y), (x * y).sqrt());
    }
    let period = 2.0 * std::f64::consts::PI / (x * w);
    for (part, angle, rate) in [(0.25, 0.0, -2.0 * k * w), (0.5, -a, 0.0), (1.0, a, 0.0)] {
        let (sim, metrics) = finished(&format!(
            "duration = {}
            object = [{{ type = \"model\", model = {:?}, posture = {{ hinge = {a} }}, position = [1, 2, 0.5], rpy = [0, 0, 0.7] }}]",
            part * period,
            file.path()
        ));
        let state = object(&sim, 0);
        // Tolerances of the integrator.
        assert!((state.joints[0] - angle).abs() < 1e-9, "{part}: {} {angle}", state.joints[0]);
        assert!((state.v[0] - rate).abs() < 1e-9, "{part}: {} {rate}", state.v[0]);
        assert!(metrics.energy_error_j.abs() < 1e-9, "{}", metrics.energy_error_j);
    }
}

/// The state of a mechanism as robot, with all else equal.
fn as_robot(settings: &str, model: &str, start: &str) -> State {
    let mut sim = simulation(&format!(
        "{settings}\nrobot = {{ model = {model}, soles = [], contact = \"bodies\", joint_default = {{ mode = \"passive\" }}, {start} }}"
    ));
    finish(&mut sim, &mut NullObserver);
    sim.plant().state.clone()
}

fn as_object(settings: &str, model: &str, start: &str) -> State {
    let mut sim = simulation(&format!(
        "{settings}\nrobot = {{ model = \"robots/ground/ground.urdf\" }}
        object = [{{ type = \"model\", model = {model}, {start} }}]"
    ));
    finish(&mut sim, &mut NullObserver);
    object(&sim, 0).clone()
}

fn distance(a: &State, b: &State) -> f64 {
    let apart = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    let turned = (a.rotation.coords - b.rotation.coords).norm();
    let motion = apart(&a.joints, &b.joints).max(apart(&a.v, &b.v)).max(apart(&a.actuators, &b.actuators));
    (a.position - b.position).norm().max(turned).max(motion)
}

/// Two links on a fixed base, with all that joints may have.
const ARM: &str = "
    [joint.shoulder]
    mode = \"position\"
    kp = 30.0
    kd = 1.0
    lag = 0.02
    armature = 0.03
    effort = 4.0
    [joint.elbow]
    mode = \"velocity\"
    kd = 0.2
    friction = { coulomb = 0.3, viscous = 0.05, static = 0.5 }
    stop = { stiffness = 500.0, damping = 1.0 }
    [joint.wrist]
    mode = \"position\"
    kp = 3.0
    kd = 0.02
    velocity = 2.0
    effort = 0.5
";

/// Motors of shoulder and elbow at their limits.
const MOTORS: &str = "
    [[transmission]]
    name = \"cables\"
    joints = [\"shoulder\", \"elbow\"]
    matrix = [[1.0, 0.3], [-0.2, 1.0]]
    gear_ratio = [20.0, 10.0]
    rotor_inertia = 1e-4
    effort = 0.05
    velocity = 30.0
";

fn arm(joints: &str) -> File {
    let limits = "<limit lower=\"-0.4\" upper=\"0.5\" effort=\"50\" velocity=\"50\"/>";
    let along = [0.0, 0.0, -0.3];
    let file = File::new("arm.toml", &format!("urdf = \"arm.urdf\"\n{joints}"));
    let urdf = format!(
        "<robot name=\"arm\"><link name=\"world\"/>{}{}{}{}{}{}</robot>",
        link("upper", 1.0, [0.02, 0.0, -0.15], 0.01, None),
        link("lower", 0.7, [0.0, 0.03, -0.15], 0.005, None),
        link("hand", 0.2, [0.0, 0.0, -0.05], 0.0005, None),
        joint("shoulder", "revolute", ["world", "upper"], [0.0, 0.0, 2.0], [0.0, 1.0, 0.0], WIDE),
        joint("elbow", "revolute", ["upper", "lower"], along, [0.6, 0.8, 0.0], limits),
        joint("wrist", "prismatic", ["lower", "hand"], along, [0.0, 0.6, 0.8], WIDE),
    );
    std::fs::write(file.path().with_file_name("arm.urdf"), urdf).expect("written");
    file
}

/// Fixed steps do not depend on what else there is, so that robot and object differ by rounding only.
#[test]
fn a_mechanism_moves_alike_as_robot_and_as_object() {
    moves_alike(ARM);
}

#[test]
fn a_mechanism_with_coupled_motors_moves_alike_as_robot_and_as_object() {
    moves_alike(&format!("{}{MOTORS}", ARM.replace("effort = 4.0", "").replace("armature = 0.03", "")));
}

fn moves_alike(joints: &str) {
    let file = arm(joints);
    let model = format!("{:?}", file.path());
    let start = "posture = { shoulder = 1.2, elbow = 0.3, wrist = 0.1 }, velocity = { shoulder = 0.5, elbow = 6.0, wrist = -1.0 }";
    for integrator in ["method = \"rk4\", step = 1e-3", "method = \"semi-implicit\", step = 1e-3"] {
        let settings = format!("duration = 0.7\nlog = {{ rate = 0 }}\nintegrator = {{ {integrator} }}");
        let (robot, object) = (as_robot(&settings, &model, start), as_object(&settings, &model, start));
        assert_eq!(object.actuators.len(), 1, "one actuator lags");
        // Rounding over 700 steps; stops amplify it by their stiffness.
        assert!(distance(&robot, &object) < 1e-12, "{integrator}: {:e}", distance(&robot, &object));
        // Stops and servos act: without them the result is another.
        let free = format!("{start}, joint_limits = \"ignore\"");
        let unlimited = as_object(&settings, &model, &free);
        assert!(distance(&unlimited, &object) > 1e-3, "the stop is reached");
        assert!(distance(&unlimited, &as_robot(&settings, &model, &free)) < 1e-12);
    }
}

/// A free mechanism falls on the floor with its links as the robot of the same links does: one link lands
/// flat and slides, then the other one. (A turn while both slide would depend on how each face shares its
/// load.)
#[test]
fn a_free_mechanism_lands_alike_as_robot_and_as_object() {
    let file = File::new(
        "gate.urdf",
        &format!(
            "<robot name=\"gate\">{}{}{}</robot>",
            link("left", 1.0, [-0.1, 0.0, 0.0], 0.004, Some([0.2, 0.1, 0.05])),
            link("right", 0.5, [0.1, 0.0, 0.0], 0.002, Some([0.2, 0.08, 0.05])),
            joint("hinge", "revolute", ["left", "right"], [0.0; 3], [0.0, 1.0, 0.0], WIDE)
        ),
    );
    let model = format!("{:?}", file.path());
    let rest = ALONE.lines().skip(1).collect::<Vec<_>>().join("\n");
    let joints = "posture = { hinge = -0.6 }";
    for (duration, sideways) in [(0.22, 0.3), (0.25, 0.0)] {
        let settings = format!("duration = {duration}\nfloor = {{ friction = 0.5 }}\n{rest}");
        let place = format!("position = [0, 0, 0.2], linear_velocity = [1.5, {sideways}, 0]");
        let robot = as_robot(&settings, &model, &format!("base = {{ {place} }}, {joints}"));
        let object = as_object(&settings, &model, &format!("{place}, {joints}"));
        // Steps of both differ, within the tolerances of the integrator.
        assert!(distance(&robot, &object) < 1e-9, "{:e}\n{robot:?}\n{object:?}", distance(&robot, &object));
        assert!(robot.v.iter().any(|v| v.abs() > 1e-3), "it still moves");
    }
}

/// Without gravity and friction a ball that meets a seesaw keeps its angular momentum about the hinge:
/// m v d = I w + m (r x u), and right after the plastic impact w = m v d / (I + m d^2).
#[test]
fn a_ball_on_a_seesaw_conserves_angular_momentum_about_the_hinge() {
    let (m, v, d, inertia, height) = (0.8, 1.5, 0.6, 0.4, 0.7);
    let beam = link("beam", 3.0, [0.0; 3], inertia, Some([2.0, 0.3, 0.1]));
    let hinge = joint("hinge", "continuous", ["world", "beam"], [0.0; 3], [0.0, 1.0, 0.0], "");
    let file = jointed(&beam, &hinge);
    let (sim, metrics) = finished(&format!(
        "duration = 0.3
        gravity = [0, 0, 0]
        floor = {{ friction = 0 }}
        object = [
            {{ type = \"model\", model = {:?}, position = [0, 0, {height}], friction = 0 }},
            {{ type = \"sphere\", radius = 0.1, mass = {m}, position = [{d}, 0, {}], linear_velocity = [0, 0, {}] }},
        ]",
        file.path(),
        height + 0.05 + 0.1 + 0.15,
        -v
    ));
    let after = m * v * d / (inertia + m * d * d);
    let loss = 0.5 * m * v * v - 0.5 * (inertia + m * d * d) * after * after;
    assert!((metrics.impact_loss_j - loss).abs() < 1e-9, "{} {loss}", metrics.impact_loss_j);
    let (r, u) = (object(&sim, 1).position - Vector3::z() * height, velocity(&sim, 1));
    let momentum = inertia * object(&sim, 0).v[0] + m * r.cross(&u).y;
    // Over the collision and 0.2 s of sliding.
    assert!((momentum - m * v * d).abs() < 1e-9, "{momentum} {}", m * v * d);
    assert!(object(&sim, 0).v[0] > 0.5 * after && metrics.energy_error_j.abs() < 1e-9, "{metrics:?}");
}

/// A ball hits a drawer in line: momentum, and Newton's restitution e.
#[test]
fn a_ball_pushes_a_drawer() {
    let (m, n, v, e) = (0.5, 2.0, 1.2, 0.4);
    let drawer = link("drawer", n, [0.0; 3], 0.01, Some([0.4, 0.3, 0.1]));
    let slide = joint("slide", "prismatic", ["world", "drawer"], [0.0; 3], [1.0, 0.0, 0.0], WIDE);
    let file = jointed(&drawer, &slide);
    let scenario = ALONE.replace("contact = {", &format!("contact = {{ restitution = {e},"));
    let mut sim = simulation(&format!(
        "{scenario}duration = 0.5
        gravity = [0, 0, 0]
        object = [
            {{ type = \"model\", model = {:?}, position = [0, 0, 1] }},
            {{ type = \"sphere\", radius = 0.1, mass = {m}, position = [-0.6, 0, 1], linear_velocity = [{v}, 0, 0] }},
        ]",
        file.path()
    ));
    let metrics = finish(&mut sim, &mut NullObserver);
    let after = m * (1.0 + e) / (m + n) * v;
    assert!((object(&sim, 0).v[0] - after).abs() < 1e-9, "{}", object(&sim, 0).v[0]);
    assert!((velocity(&sim, 1) - Vector3::x() * ((m - e * n) / (m + n) * v)).norm() < 1e-9, "{}", velocity(&sim, 1));
    let hit = 0.3 / v;
    assert!((object(&sim, 0).joints[0] - after * (0.5 - hit)).abs() < 1e-9);
    assert!(metrics.energy_error_j.abs() < 1e-9);
}

/// The root of a fixed object carries others, and stands on floor and terrain without touching them.
#[test]
fn a_fixed_root_carries_a_ball() {
    // A root named `world` without mass is fixed.
    let root = "<link name=\"world\"><collision><geometry><box size=\"1 1 0.2\"/></geometry></collision></link>";
    let leaf = link("leaf", 1.0, [0.2, 0.0, 0.0], 0.01, None);
    let hinge = joint("hinge", "continuous", ["world", "leaf"], [0.0; 3], [0.0, 0.0, 1.0], "");
    let file = File::new("model.urdf", &format!("<robot name=\"table\">{root}{leaf}{hinge}</robot>"));
    let (sim, metrics) = finished(&format!(
        "duration = 1.0
        floor = {{ friction = 0.5 }}
        terrain = [{{ type = \"box\", size = [0.4, 0.4, 0.4], position = [0.5, 0, 0] }}]
        object = [
            {{ type = \"model\", model = {:?}, position = [0, 0, 0.05] }},
            {{ type = \"sphere\", radius = 0.1, mass = 1.0, position = [0.1, 0.1, 0.25] }},
        ]",
        file.path()
    ));
    assert!((object(&sim, 1).position - Vector3::new(0.1, 0.1, 0.25)).norm() < 1e-12);
    let plant = sim.plant();
    let names: Vec<&str> = plant.polygons.iter().map(|polygon| polygon.name()).collect();
    assert_eq!(names.len(), 1, "{names:?}");
    assert!((plant.solution.wrench[2].abs() - G).abs() < 1e-9, "{}", plant.solution.wrench[2]);
    assert_eq!(metrics.inconsistent, 0);
}

/// A wedge of mass M on a floor without friction, under a block of mass m on its slope:
/// a = m g sin cos / (M + m sin^2), and the block slides down it with (M + m) g sin / (M + m sin^2).
#[test]
fn a_block_slides_down_a_free_wedge() {
    // Exact in single precision, with which meshes are read.
    let (length, height, width) = (1.0, 0.5, 0.25);
    let corners = [[0.0, 0.0], [length, 0.0], [length, height]];
    let vertices: String =
        [-width, width].into_iter().flat_map(|y| corners.map(|[x, z]| format!("v {x} {y} {z}\n"))).collect();
    let faces = "f 1 2 3\nf 4 6 5\nf 1 4 5\nf 1 5 2\nf 2 5 6\nf 2 6 3\nf 1 3 6\nf 1 6 4\n";
    let file = File::new("wedge.obj", &(vertices + faces));
    let (large, small, t) = (3.0, 1.0, 0.3);
    let angle = f64::atan2(height, length);
    let (sin, cos) = angle.sin_cos();
    let normal = Vector3::new(-sin, 0.0, cos);
    let start = Vector3::new(0.7 * length, 0.0, 0.7 * height) + normal * 0.05;
    let (sim, metrics) = finished(&format!(
        "duration = {t}
        floor = {{ friction = 0 }}
        object = [
            {{ type = \"mesh\", file = {:?}, mass = {large}, scale = 1.0 }},
            {{ type = \"box\", size = [0.2, 0.2, 0.1], mass = {small}, position = [{}, 0, {}], rpy = [0, {}, 0] }},
        ]",
        file.path(),
        start.x,
        start.z,
        -angle
    ));
    let a = small * G * sin * cos / (large + small * sin * sin);
    let down = (large + small) * G * sin / (large + small * sin * sin);
    let wedge = Vector3::x() * (0.5 * a * t * t);
    let block = wedge - Vector3::new(cos, 0.0, sin) * (0.5 * down * t * t);
    assert!((object(&sim, 0).position - wedge).norm() < 1e-9, "{} {wedge}", object(&sim, 0).position);
    assert!((object(&sim, 1).position - start - block).norm() < 1e-9, "{} {block}", object(&sim, 1).position - start);
    assert!((velocity(&sim, 0).x - a * t).abs() < 1e-9);
    assert!(metrics.energy_error_j.abs() < 1e-9 && metrics.max_penetration_m < 1e-9, "{metrics:?}");
}

/// The hull of a block's corners, off the origin of its file, tumbles as a box does.
#[test]
fn a_mesh_has_the_mass_properties_of_its_hull() {
    let (size, offset) = ([0.5, 0.25, 0.125], [1.0, -2.0, 0.5]);
    let corner = |k: usize| {
        let at = |axis: usize| offset[axis] + size[axis] * (((k >> axis) & 1) as f64 - 0.5);
        format!("v {} {} {}\n", 10.0 * at(0), 10.0 * at(1), 10.0 * at(2))
    };
    let faces =
        "f 1 5 7\nf 1 7 3\nf 2 4 8\nf 2 8 6\nf 1 2 6\nf 1 6 5\nf 3 7 8\nf 3 8 4\nf 1 3 4\nf 1 4 2\nf 5 6 8\nf 5 8 7\n";
    let file = File::new("block.obj", &((0..8).map(corner).collect::<String>() + faces));
    let (turn, offset) = (Vector3::new(0.5, 3.0, -2.0), Vector3::from(offset));
    let origin = turn.cross(&-offset);
    let settings = "duration = 1.0\ngravity = [0, 0, 0]\n";
    let (mesh, _) = finished(&format!(
        "{settings}object = [{{ type = \"mesh\", file = {:?}, scale = 0.1, mass = 2.0, position = {:?}, \
         angular_velocity = {:?}, linear_velocity = {:?} }}]",
        file.path(),
        [-offset.x, -offset.y, 5.0 - offset.z],
        turn.as_slice(),
        origin.as_slice()
    ));
    let (block, _) = finished(&format!(
        "{settings}object = [{{ type = \"box\", size = {size:?}, mass = 2.0, position = [0, 0, 5], angular_velocity = {:?} }}]",
        turn.as_slice()
    ));
    let (mesh, block) = (object(&mesh, 0), object(&block, 0));
    // Integration, and 7 digits of the coordinates, of which these need fewer.
    assert!(mesh.rotation.angle_to(&block.rotation) < 1e-9, "{}", mesh.rotation.angle_to(&block.rotation));
    assert!((mesh.position + mesh.rotation * offset - block.position).norm() < 1e-9);
    assert!((mesh.v[4] - block.v[4]).abs() < 1e-9 && (mesh.v[4] - turn.y).abs() > 1e-2, "it tumbles");
}

/// The only error of a scenario with this entry of an object.
fn refusal(entry: &str) -> String {
    let text = format!("[robot]\nmodel = \"robots/ground/ground.urdf\"\n[[object]]\n{entry}\n");
    let runs = scenario::parse(&root().join("test.toml"), &text).and_then(|f| f.expand(&[])).expect("it is sound");
    let robot = robot::load(&root().join("robots/ground/ground.urdf")).expect("it is there");
    let Err(wrong) = assemble::setup(&runs[0], &robot) else { panic!("accepted: {entry}") };
    let [_] = &wrong.0[..] else { panic!("{entry}\n{wrong}") };
    wrong.to_string()
}

#[test]
fn an_object_that_does_not_fit_its_file_is_refused_at_the_key() {
    let (arm, gone) = (arm(ARM), root().join("gone.urdf"));
    let flat = File::new("flat.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let kinematic = File::new("held.toml", "urdf = \"model.urdf\"\n[joint.hinge]\nmode = \"kinematic\"\n");
    let hinge = joint("hinge", "continuous", ["world", "leaf"], [0.0; 3], [0.0, 0.0, 1.0], "");
    let body = link("leaf", 1.0, [0.0; 3], 0.1, None);
    let urdf = format!("<robot name=\"model\"><link name=\"world\"/>{body}{hinge}</robot>");
    std::fs::write(kinematic.path().with_file_name("model.urdf"), urdf).expect("written");
    let model = |file: &PathBuf, more: &str| format!("name = \"it\"\ntype = \"model\"\nmodel = {file:?}\n{more}");
    for (entry, line, message) in [
        (model(&gone, ""), 6, "gone.urdf"),
        (model(&arm.path(), "posture = { elbo = 0.1 }"), 7, "the object `it` has no joint `elbo`"),
        (
            model(&arm.path(), "posture = { elbow = 0.6 }"),
            7,
            "`elbow` = 0.6000 rad is outside its range, -0.4000 to 0.5000",
        ),
        (model(&arm.path(), "target = { wrist = 11 }"), 7, "`wrist` = 11.0000 m is outside its range"),
        (model(&arm.path(), "velocity = { hand = 1 }"), 7, "the object `it` has no joint `hand`"),
        (model(&arm.path(), "target = { elbow = 0.1 }"), 7, "the joint `elbow` of the object `it` has no servo"),
        (
            model(&arm.path(), "servo = [{ joints = \"e?bo\", stiffness = 1 }]"),
            7,
            "no joint of the object `it` matches",
        ),
        (
            model(&arm.path(), "linear_velocity = [1, 0, 0]"),
            7,
            "is fixed to the world and cannot have `linear_velocity`",
        ),
        (model(&kinematic.path(), ""), 6, "the joint `hinge` of the object `it` is `kinematic` in its model"),
        (
            format!("type = \"mesh\"\nmass = 1\nfile = {:?}", flat.path()),
            6,
            "it is flat, so its convex hull has no volume",
        ),
        (format!("type = \"mesh\"\nmass = 1\nscale = 1e7\nfile = {:?}", flat.path()), 7, "it has coordinates beyond"),
    ] {
        let error = refusal(&entry);
        assert!(error.contains(message) && error.contains(&format!("test.toml:{line}:")), "{entry}\n{error}");
    }
}

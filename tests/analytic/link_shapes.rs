//! Links of several shapes, whose round ones touch with their exact surfaces: they roll.

use super::body::G;
use super::objects::assert_clean;
use crate::support::runs::{TIGHT, finish, simulation};
use nalgebra::{Rotation3, Vector3};
use std::fs;
use std::path::PathBuf;
use stiction::sim::{NullObserver, Simulation};
use tempfile::TempDir;

/// Writes a robot of one link with these moments of inertia and shapes.
fn urdf(folder: &TempDir, mass: f64, [ixx, iyy, izz]: [f64; 3], shapes: &[(&str, [f64; 3], [f64; 3])]) -> PathBuf {
    let shape = |(shape, xyz, rpy): &(&str, [f64; 3], [f64; 3])| {
        format!(
            r#"<collision><origin xyz="{} {} {}" rpy="{} {} {}"/><geometry>{shape}</geometry></collision>"#,
            xyz[0], xyz[1], xyz[2], rpy[0], rpy[1], rpy[2]
        )
    };
    let shapes: String = shapes.iter().map(shape).collect();
    let path = folder.path().join("body.urdf");
    let text = format!(
        r#"<robot name="body"><link name="body"><inertial><mass value="{mass}"/>
        <inertia ixx="{ixx}" ixy="0" ixz="0" iyy="{iyy}" iyz="0" izz="{izz}"/></inertial>{shapes}</link></robot>"#
    );
    fs::write(&path, text).expect("the folder is writable");
    path
}

fn ended(text: &str) -> Simulation {
    let mut sim = simulation(text);
    finish(&mut sim, &mut NullObserver);
    sim
}

const QUARTER: f64 = std::f64::consts::FRAC_PI_2;

/// Two wheels on an axle along y, with a box between them: radius 0.1 m, 2 kg, 0.007 kg m^2 about the axle.
fn axle(folder: &TempDir) -> PathBuf {
    let wheel = r#"<cylinder radius="0.1" length="0.04"/>"#;
    let shapes = [
        (r#"<box size="0.05 0.3 0.05"/>"#, [0.0; 3], [0.0; 3]),
        (wheel, [0.0, 0.17, 0.0], [QUARTER, 0.0, 0.0]),
        (wheel, [0.0, -0.17, 0.0], [QUARTER, 0.0, 0.0]),
    ];
    urdf(folder, 2.0, [0.02, 0.007, 0.02], &shapes)
}

const TILT: f64 = 0.2;

/// Acceleration of the axle down the slope, with I/(m R^2) = 0.35.
fn rolling() -> f64 {
    G * TILT.sin() / 1.35
}

fn slope() -> (Vector3<f64>, Vector3<f64>) {
    (Vector3::new(TILT.sin(), 0.0, TILT.cos()), Vector3::new(TILT.cos(), 0.0, -TILT.sin()))
}

fn list(v: &Vector3<f64>) -> String {
    format!("[{}, {}, {}]", v.x, v.y, v.z)
}

/// On terrain and on the floor, at the height that a start without a position finds.
#[test]
fn wheels_of_one_link_roll_down_an_incline() {
    let folder = TempDir::new().expect("a folder for the robot");
    let path = axle(&folder);
    let (up, down) = slope();
    let sim = ended(&format!(
        "duration = 0.5\nrobot = {{ model = {path:?}, base = {{ position = {}, rpy = [0, {TILT}, 0] }}, soles = [] }}
        floor = {{ plane = false }}\n{TIGHT}
        terrain = [{{ type = \"box\", size = [4, 1, 0.1], rpy = [0, {TILT}, 0], friction = 0.5 }}]",
        list(&(up * 0.15))
    ));
    let travel = 0.125 * rolling();
    let state = &sim.plant().state;
    assert!((state.position - up * 0.15 - down * travel).norm() < 1e-9, "{}", state.position);
    assert_clean(sim.metrics());
    let sim = ended(&format!(
        "duration = 0.5\nrobot = {{ model = {path:?}, base = {{ rpy = [0, {TILT}, 0] }}, soles = [] }}
        floor = {{ friction = 0.5, rpy = [0, {TILT}, 0] }}\n{TIGHT}"
    ));
    let start = Vector3::z() * (0.1 / TILT.cos());
    let state = &sim.plant().state;
    assert!((state.position - start - down * travel).norm() < 1e-9, "{}", state.position);
    assert_clean(sim.metrics());
}

/// Three wheels of 0.5 kg and 0.002 kg m^2 about their axles, radius 0.1 m, on a body of 3 kg. They turn by travel/R.
#[test]
fn a_cart_rolls_on_its_wheels() {
    let folder = TempDir::new().expect("a folder for the robot");
    let wheel = |name: &str, x: f64, y: f64| {
        format!(
            r#"<link name="{name}"><inertial><mass value="0.5"/>
            <inertia ixx="0.001" ixy="0" ixz="0" iyy="0.002" iyz="0" izz="0.001"/></inertial>
            <collision><origin rpy="{QUARTER} 0 0"/><geometry><cylinder radius="0.1" length="0.04"/></geometry></collision>
            </link><joint name="{name}" type="continuous"><parent link="cart"/><child link="{name}"/>
            <origin xyz="{x} {y} 0"/><axis xyz="0 1 0"/></joint>"#
        )
    };
    let wheels = [wheel("front", 0.3, 0.0), wheel("left", -0.2, 0.2), wheel("right", -0.2, -0.2)].concat();
    let text = format!(
        r#"<robot name="cart"><link name="cart"><inertial><mass value="3"/>
        <inertia ixx="0.05" ixy="0" ixz="0" iyy="0.05" iyz="0" izz="0.05"/></inertial>
        <collision><origin xyz="0 0 0.05"/><geometry><box size="0.6 0.3 0.05"/></geometry></collision></link>{wheels}</robot>"#
    );
    let path = folder.path().join("cart.urdf");
    fs::write(&path, text).expect("the folder is writable");
    let travel = 0.125 * G * TILT.sin() * 4.5 / (4.5 + 3.0 * 0.2);
    let (up, down) = slope();
    let terrain = format!(
        "base = {{ position = {}, rpy = [0, {TILT}, 0] }} }}\nfloor = {{ plane = false }}
        terrain = [{{ type = \"box\", size = [4, 1, 0.1], rpy = [0, {TILT}, 0], friction = 0.5 }}]",
        list(&(up * 0.15))
    );
    let floor = format!("base = {{ rpy = [0, {TILT}, 0] }} }}\nfloor = {{ friction = 0.5, rpy = [0, {TILT}, 0] }}");
    for (world, start) in [(terrain, up * 0.15), (floor, Vector3::z() * (0.1 / TILT.cos()))] {
        let sim = ended(&format!(
            "duration = 0.5\nrobot = {{ model = {path:?}, joint_default = {{ mode = \"passive\" }}, {world}\n{TIGHT}"
        ));
        let state = &sim.plant().state;
        assert!((state.position - start - down * travel).norm() < 1e-9, "{}", state.position);
        assert!(state.joints.iter().all(|angle| (angle - travel / 0.1).abs() < 1e-8), "{:?}", state.joints);
        assert_clean(sim.metrics());
    }
}

/// A rule for a pair holds for all shapes of a link: without friction the wheels slide.
#[test]
fn a_rule_for_a_link_holds_for_all_its_shapes() {
    let folder = TempDir::new().expect("a folder for the robot");
    let (up, down) = slope();
    let sim = ended(&format!(
        "duration = 0.5\nrobot = {{ model = {:?}, base = {{ position = {}, rpy = [0, {TILT}, 0] }}, soles = [] }}
        floor = {{ plane = false }}
        terrain = [{{ type = \"box\", size = [4, 1, 0.1], rpy = [0, {TILT}, 0], friction = 0.5 }}]
        integrator = {{ relative_tolerance = 1e-9, absolute_tolerance = 1e-11 }}
        contact = {{ distance_tolerance = 1e-8, velocity_tolerance = 1e-8, acceleration_tolerance = 1e-8,
            pair = [{{ bodies = [\"body\", \"terrain.0\"], friction = 0.0 }}] }}",
        axle(&folder),
        list(&(up * 0.15))
    ));
    let state = &sim.plant().state;
    let travel = 0.125 * G * TILT.sin();
    assert!((state.position - up * 0.15 - down * travel).norm() < 1e-9, "{}", state.position);
    assert_clean(sim.metrics());
}

/// The same link as an object.
#[test]
fn wheels_of_an_object_roll() {
    let folder = TempDir::new().expect("a folder for the object");
    let sim = ended(&format!(
        "duration = 0.5\nrobot = {{ model = {:?}, base = {{ position = [0, 5, 1] }} }}
        gravity = [{}, 0, {}]\nfloor = {{ friction = 0.5 }}\n{TIGHT}
        object = [{{ type = \"model\", model = {:?}, position = [0, 0, 0.1] }}]",
        concat!(env!("CARGO_MANIFEST_DIR"), "/robots/block/block.toml"),
        G * TILT.sin(),
        -G * TILT.cos(),
        axle(&folder)
    ));
    let position = sim.plant().objects.list[0].state.position;
    let expected = Vector3::new(0.125 * rolling(), 0.0, 0.1);
    assert!((position - expected).norm() < 1e-9, "{position} {expected}");
}

/// Balls with the radii r and R at the ends of a bar roll about the point where the line through their centres meets
/// the floor: the body turns about the line through both points of contact. With sin b = (R - r)/d it goes round with
/// W = w tan b, at a constant speed.
#[test]
fn two_balls_of_one_link_roll_as_a_cone() {
    let folder = TempDir::new().expect("a folder for the robot");
    let (small, large, d) = (0.1_f64, 0.15, 0.4);
    let (small_ball, large_ball) = (format!(r#"<sphere radius="{small}"/>"#), format!(r#"<sphere radius="{large}"/>"#));
    let shapes = [
        (r#"<box size="0.05 0.3 0.05"/>"#, [0.0; 3], [0.0; 3]),
        (small_ball.as_str(), [0.0, -0.5 * d, 0.0], [0.0; 3]),
        (large_ball.as_str(), [0.0, 0.5 * d, 0.0], [0.0; 3]),
    ];
    let path = urdf(&folder, 2.0, [0.05, 0.02, 0.05], &shapes);
    let lean = ((large - small) / d).asin();
    let spin = 3.0;
    let round = spin * lean.tan();
    // The middle of the bar, with the apex of the cone at the origin.
    let middle = Vector3::new(0.0, 0.5 * (small + large) / lean.tan(), 0.5 * (small + large));
    let omega = Vector3::y() * spin;
    let velocity = omega.cross(&(Vector3::z() * middle.z));
    let sim = ended(&format!(
        "duration = 1.0\nfloor = {{ friction = 0.8 }}\n{TIGHT}
        robot = {{ model = {path:?}, soles = [], base = {{ position = {}, rpy = [{lean}, 0, 0], linear_velocity = {},
            angular_velocity = {} }} }}",
        list(&middle),
        list(&velocity),
        list(&omega)
    ));
    // v = w h along x at the distance h/tan b from the apex: against the sense of z.
    let expected = Rotation3::from_axis_angle(&Vector3::z_axis(), -round) * middle;
    let position = sim.plant().state.position;
    assert!((position - expected).norm() < 1e-9, "{position} {expected}");
    assert_clean(sim.metrics());
}

/// On terrain the ball of a point foot rolls; on the floor its sole, a point, stands for it.
#[test]
fn the_ball_of_a_foot_rolls_on_terrain() {
    let folder = TempDir::new().expect("a folder for the robot");
    let path = urdf(&folder, 1.0, [0.004; 3], &[(r#"<sphere radius="0.1"/>"#, [0.0; 3], [0.0; 3])]);
    let robot = folder.path().join("foot.toml");
    let text = format!("urdf = {path:?}\n[[sole]]\nname = \"foot\"\nlink = \"body\"\npolygon = [[0, 0, -0.1]]\n");
    fs::write(&robot, text).expect("the folder is writable");
    let (up, down) = slope();
    let sim = ended(&format!(
        "duration = 0.5\nrobot = {{ model = {robot:?}, base = {{ position = {}, rpy = [0, {TILT}, 0] }} }}
        floor = {{ plane = false }}\n{TIGHT}
        terrain = [{{ type = \"box\", size = [4, 1, 0.1], rpy = [0, {TILT}, 0], friction = 0.5 }}]",
        list(&(up * 0.15))
    ));
    let travel = 0.125 * G * TILT.sin() / 1.4;
    let state = &sim.plant().state;
    assert!((state.position - up * 0.15 - down * travel).norm() < 1e-9, "{}", state.position);
    assert_clean(sim.metrics());
}

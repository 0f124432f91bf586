//! `convert`: files that read back to the same robot, MJCF, and what is refused.

use std::fs;
use std::path::Path;

use stiction::dynamics::{self, State, Workspace};
use stiction::nalgebra::{Matrix3, Vector3};
use stiction::robot::{Model, load};

use super::Place;

fn shipped(name: &str) -> String {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    folder.join(name).display().to_string()
}

/// The mass matrix at a posture that depends on the joints' names only.
fn mass(model: &Model, order: &[String]) -> Vec<f64> {
    // URDF has no armature.
    let mut model = model.clone();
    model.joints.iter_mut().for_each(|joint| joint.armature = 0.0);
    let model = &model;
    let mut state = State::home(model);
    let column: Vec<usize> = order.iter().map(|name| model.joint(name).unwrap().0).collect();
    for (k, &j) in column.iter().enumerate() {
        state.joints[j] = 0.3 * ((7 * k) % 5) as f64 - 0.5;
    }
    let mut ws = Workspace::new(model);
    dynamics::prepare(model, &state, &Vector3::zeros(), &mut ws).unwrap();
    let all: Vec<usize> = (0..model.nb()).chain(column.iter().map(|j| model.nb() + j)).collect();
    let pairs = all.iter().flat_map(|&i| all.iter().map(move |&j| (i.max(j), i.min(j))));
    pairs.map(|(i, j)| ws.mass.get(i, j)).collect()
}

/// Largest difference relative to the greatest entry.
fn difference(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    let scale = a.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    a.iter().zip(b).fold(0.0, |m: f64, (x, y)| m.max((x - y).abs())) / scale
}

#[test]
fn a_converted_urdf_reads_back_to_the_same_robot() {
    let place = Place::new();
    for (name, out) in [
        ("robots/hoap2/hoap2.urdf", "hoap2.urdf"),
        ("robots/cbi/cbi.urdf", "cbi.urdf"),
        ("robots/quadruped/quadruped.urdf", "quadruped.urdf"),
        ("robots/door/door.urdf", "door.urdf"),
        ("tests/robot/sdf/frames.sdf", "frames.urdf"),
        ("tests/robot/sdf/fixed_base.sdf", "fixed.urdf"),
        ("tests/robot/mjcf/arm.xml", "arm.urdf"),
        ("tests/robot/mjcf/biped.xml", "biped.urdf"),
    ] {
        place.runner(&["convert", &shipped(name), "-o", out]).exits(0);
        let (before, after) = (load(Path::new(&shipped(name))).unwrap().model, load(&place.path(out)).unwrap().model);
        assert_eq!(before.base, after.base, "{name}");
        assert_eq!(before.name, after.name, "{name}");
        let names: Vec<String> = before.joints.iter().map(|joint| joint.name.clone()).collect();
        assert_eq!(names, after.joints.iter().map(|joint| joint.name.clone()).collect::<Vec<_>>(), "{name}");
        for (a, b) in before.joints.iter().zip(&after.joints) {
            assert_eq!((a.kind, a.lower, a.upper), (b.kind, b.lower, b.upper), "{name} {}", a.name);
            assert_eq!((a.damping, a.friction), (b.damping, b.friction), "{name} {}", a.name);
            assert_eq!((a.effort_limit, a.velocity_limit), (b.effort_limit, b.velocity_limit), "{name} {}", a.name);
        }
        for (a, b) in before.links.iter().zip(&after.links) {
            assert!((a.mass - b.mass).abs() <= 1e-12 * a.mass || b.name == "world", "{name} {}", a.name);
            let merged = |model: &Model, name: &str| model.link(name).is_some();
            assert!(a.merged.iter().all(|m| merged(&after, &m.name)), "{name} {}", a.name);
            let shapes = |link: &stiction::robot::Link| (link.visuals.len(), link.collisions.len());
            assert_eq!(shapes(a), shapes(b), "{name} {}", a.name);
            let moments = |inertia: &Matrix3<f64>| inertia.symmetric_eigenvalues().max();
            let (m, n) = (moments(&a.inertia), moments(&b.inertia));
            assert!((m - n).abs() <= 1e-12 * m || b.name == "world", "{name} {}: {m} {n}", a.name);
        }
        let error = difference(&mass(&before, &names), &mass(&after, &names));
        assert!(error <= 1e-12, "{name}: mass matrices differ by {error}");
    }
}

#[test]
fn converting_twice_gives_the_same_bits() {
    let place = Place::new();
    place.runner(&["convert", "block/block.toml", "-o", "a.urdf"]).exits(0);
    place.runner(&["convert", "a.urdf", "-o", "b.urdf"]).exits(0);
    assert_eq!(fs::read(place.path("a.urdf")).unwrap(), fs::read(place.path("b.urdf")).unwrap());
}

/// Motors stay motors, limits that are missing stay so, and names stay unique.
#[test]
fn motors_limits_and_names_survive_both_formats() {
    let place = Place::new();
    let model = r#"<mujoco model="m"><compiler angle="radian"/><worldbody><body name="world_body">
        <joint name="i" axis="0 0 1"/><geom size="0.1"/><body name="b"><joint name="j" axis="0 1 0" actuatorfrcrange="-5 5"/><geom size="0.1"/>
        <body name="c"><joint name="k" axis="0 1 0"/><geom size="0.1" pos="0.1 0 0"/></body></body></body>
        <body name="d"><joint name="l" axis="1 0 0"/><geom size="0.1" pos="0 0.1 0"/></body>
        </worldbody><actuator><motor joint="j"/></actuator><contact><exclude body1="b" body2="d"/></contact></mujoco>"#;
    place.write("m.xml", model);
    let done = place.runner(&["convert", "m.xml", "-o", "n.xml"]).exits(0);
    assert!(done.stderr.contains("1 pair of links that are not checked"), "{}", done.stderr);
    let (before, after) = (load(&place.path("m.xml")).unwrap().model, load(&place.path("n.xml")).unwrap().model);
    for (a, b) in before.joints.iter().zip(&after.joints) {
        assert_eq!((a.drive.mode, a.drive_configured), (b.drive.mode, b.drive_configured), "{}", a.name);
        assert_eq!(a.effort_limit, b.effort_limit, "{}", a.name);
    }
    let text = fs::read_to_string(place.path("n.xml")).unwrap();
    assert!(text.contains("<body name=\"world_body\"") && text.contains("<body name=\"world_body_\""), "{text}");
    let done = place.runner(&["convert", "m.xml", "-o", "m.urdf"]).exits(0);
    assert!(done.stderr.contains("limits that joint `j` lacks are written as 1e16"), "{}", done.stderr);
    // Other readers refuse an effort limit without a velocity limit.
    let text = fs::read_to_string(place.path("m.urdf")).unwrap();
    assert_eq!(text.matches("<limit").count(), 1, "{text}");
    assert!(text.contains("<limit effort=\"5\" velocity=\"1e16\"/>"), "{text}");
    let joint = &load(&place.path("m.urdf")).unwrap().model.joints[1];
    assert_eq!((joint.effort_limit, joint.velocity_limit), (5.0, f64::INFINITY));
    // A folder is refused before anything is written.
    fs::create_dir(place.path("f.urdf")).unwrap();
    let done = place.runner(&["convert", "m.xml", "-o", "f.urdf"]).exits(2);
    assert!(done.stderr.contains("f.urdf is a folder") && !place.path("f_meshes").exists(), "{}", done.stderr);
}

const COUPLED: &str = r#"<sdf version="1.11"><model name="m">
  <link name="a"><inertial><mass>2</mass><inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz></inertia></inertial>
    <sensor name="i" type="imu"/><collision name="c"><geometry><mesh><uri>t.obj</uri></mesh></geometry></collision></link>
  <link name="b"><pose>1 0 0 0 0 0</pose></link><link name="c"><pose>2 0 0 0 0 0</pose></link>
  <joint name="j" type="revolute"><parent>a</parent><child>b</child><axis><xyz>0 0 1</xyz></axis></joint>
  <joint name="k" type="revolute"><parent>a</parent><child>c</child><axis><xyz>0 0 1</xyz>
    <mimic joint="j"><multiplier>2</multiplier><offset>0.5</offset></mimic></axis></joint>
  <joint name="close" type="ball"><pose>0.5 0 0 0 0 0</pose><parent>b</parent><child>c</child></joint>
</model></sdf>"#;
const MESH: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";

#[test]
fn mjcf_has_meshes_sensors_couplings_loops_and_drives() {
    let place = Place::new();
    place.write("m.sdf", COUPLED).write("t.obj", MESH);
    place.write("m.toml", "urdf = \"m.sdf\"\n[joint.j]\nkp = 20\nkd = 2\neffort = 3\narmature = 0.1\nlag = 0.01\n");
    let done = place.runner(&["convert", "m.toml", "-o", "out/m.xml"]).exits(0);
    let text = fs::read_to_string(place.path("out/m.xml")).unwrap();
    for expected in [
        "<mesh name=\"mesh0\" file=\"m_meshes/mesh0.obj\"",
        "<freejoint name=\"base\"/>",
        "<joint joint1=\"k\" joint2=\"j\" polycoef=\"0.5 2 0 0 0\"/>",
        "<connect site1=\"loop/close/0\" site2=\"loop/close/1\"/>",
        "<site name=\"loop/close/1\" pos=\"1.5 0 0\"",
        "<gyro name=\"imu/i/gyro\" site=\"imu/i\"/>",
        "armature=\"0.1\"",
        "<position name=\"j\" joint=\"j\" kp=\"20\" kv=\"2\" forcerange=\"-3 3\"/>",
        "<key name=\"home\" qpos=\"0 0 0 1 0 0 0 0 0.5\"/>",
    ] {
        assert!(text.contains(expected), "{expected}:\n{text}");
    }
    assert!(place.path("out/m_meshes/mesh0.obj").is_file());
    assert!(done.stderr.contains("warning: the lag of the actuator of joint `j` is not written"), "{}", done.stderr);
    // URDF holds the coupling, and lists the rest.
    let done = place.runner(&["convert", "m.toml", "-o", "out/m.urdf"]).exits(0);
    let text = fs::read_to_string(place.path("out/m.urdf")).unwrap();
    assert!(text.contains("<mimic joint=\"j\" multiplier=\"2\" offset=\"0.5\"/>"), "{text}");
    for lost in
        ["armature of joint `j`", "the drive of joint `j`", "the closed loop of constraint `close`", "the home posture"]
    {
        assert!(done.stderr.contains(lost), "{lost}: {}", done.stderr);
    }
    assert_eq!(load(&place.path("out/m.urdf")).unwrap().model.links[0].collisions.len(), 1);
}

#[test]
fn existing_files_and_inputs_are_kept() {
    let place = Place::new();
    place.runner(&["convert", "block/block.toml", "-o", "a.xml"]).exits(0);
    let before = fs::read(place.path("a.xml")).unwrap();
    place.write("a.xml", "mine");
    let done = place.runner(&["convert", "block/block.toml", "-o", "a.xml"]).exits(2);
    assert!(done.stderr.contains("exists"), "{}", done.stderr);
    assert_eq!(fs::read(place.path("a.xml")).unwrap(), b"mine");
    place.runner(&["convert", "block/block.toml", "-o", "a.xml", "--force"]).exits(0);
    assert_eq!(fs::read(place.path("a.xml")).unwrap(), before);
    let done = place.runner(&["convert", "block/block.toml", "-o", "block/block.urdf", "--force"]).exits(2);
    assert!(done.stderr.contains("a file of the robot itself"), "{}", done.stderr);
    for wrong in [&["convert", "block/block.toml", "-o", "a.sdf"][..], &["convert", "none.urdf", "-o", "b.urdf"]] {
        place.runner(wrong).exits(2);
    }
    assert!(!place.path("b.urdf").exists());
}

#[test]
fn a_scenario_with_a_world_is_replayed_without_the_world_file_and_resumed() {
    let place = Place::new();
    let step = |x: &str| {
        format!(
            "<sdf version=\"1.9\"><world name=\"w\"><model name=\"step\"><static>1</static><pose>{x} 0 0.05 0 0 0</pose>\
             <link name=\"l\"><collision name=\"c\"><geometry><box><size>4 4 0.1</size></box></geometry></collision></link>\
             </model></world></sdf>"
        )
    };
    place.write("w.sdf", step("0"));
    place.write("s.toml", "duration = 0.2\n[robot]\nmodel = \"block/block.toml\"\n[world]\nfile = \"w.sdf\"\n");
    place.runner(&["s.toml"]).exits(0);
    let done = place.runner(&["s.toml", "--resume"]).exits(0);
    assert!(!done.stderr.contains("[1/1]"), "{}", done.stderr);
    fs::remove_file(place.path("w.sdf")).unwrap();
    place.runner(&["replay", "results/s"]).exits(0);
    // A moved step is another run.
    place.write("w.sdf", step("0.5"));
    let done = place.runner(&["s.toml", "--resume"]).exits(0);
    assert!(done.stderr.contains("[1/1]"), "{}", done.stderr);
    // What the world holds is not swept over by a mistake in it.
    place.write("w.sdf", step("x"));
    let done = place.runner(&["check", "s.toml"]).exits(2);
    assert!(done.stderr.contains("w.sdf:1:") && done.stderr.contains("6 finite numbers"), "{}", done.stderr);
}

#[test]
fn a_log_of_another_format_holds_a_urdf_under_its_own_name_and_the_file() {
    let place = Place::new();
    for (file, urdf) in [("mjcf/shapes.xml", "shapes.urdf"), ("sdf/frames.sdf", "frames.urdf")] {
        let model = shipped(&format!("tests/robot/{file}"));
        place.write("s.toml", format!("duration = 0.002\n[robot]\nmodel = {model:?}\n"));
        place.runner(&["s.toml", "-o", urdf]).exits(0);
        let log =
            fs::read(place.path(urdf).join("s").join(place.summary(urdf).column("key")[0]).join("log.mcap")).unwrap();
        let read = mcap::Summary::read(&log).unwrap().unwrap();
        let names: Vec<&str> = read.attachment_indexes.iter().map(|attachment| attachment.name.as_str()).collect();
        assert_eq!(names, ["s.toml", urdf, Path::new(file).file_name().unwrap().to_str().unwrap()]);
        let attached = mcap::read::attachment(&log, &read.attachment_indexes[1]).unwrap();
        let text = String::from_utf8(attached.data.to_vec()).unwrap();
        let (original, again) =
            (load(Path::new(&model)).unwrap(), stiction::robot::parse("r.urdf".as_ref(), text, None));
        let joints = |model: &Model| model.joints.iter().map(|joint| joint.name.clone()).collect::<Vec<_>>();
        assert_eq!(joints(&again.unwrap().model), joints(&original.model));
    }
}

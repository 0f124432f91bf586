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
        "<connect name=\"close\" site1=\"loop/close/0\" site2=\"loop/close/1\"/>",
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

/// Links without mass, point masses and rods, of which MuJoCo requires least values.
#[test]
fn masses_that_mujoco_refuses_are_raised_and_listed() {
    let place = Place::new();
    let inertia = |mass: &str, moments: [&str; 3]| {
        let [xx, yy, zz] = moments;
        format!(
            "<inertial><mass value=\"{mass}\"/><inertia ixx=\"{xx}\" iyy=\"{yy}\" izz=\"{zz}\" ixy=\"0\" \
             ixz=\"0\" iyz=\"0\"/></inertial>"
        )
    };
    let link = |name: &str, inside: &str| format!("<link name=\"{name}\">{inside}</link>");
    let joint = |child: &str, axis: &str, parent: &str| {
        format!(
            "<joint name=\"{child}_joint\" type=\"continuous\"><parent link=\"{parent}\"/><child link=\"{child}\"/>\
             <axis xyz=\"{axis}\"/></joint>"
        )
    };
    let shape = "<visual><geometry><sphere radius=\"0.1\"/></geometry></visual>";
    let text = [
        "<robot name=\"m\">".to_owned(),
        link("base", ""),
        link("cross", shape),
        link("arm", &inertia("2", ["1", "1", "1"])),
        link("leg", &inertia("1", ["0.1", "0.1", "1e-20"])),
        link("plain", &inertia("1", ["0.1", "0.1", "0.1"])),
        joint("cross", "0 0 1", "base"),
        joint("arm", "1 0 0", "cross"),
        joint("leg", "0 1 0", "base"),
        joint("plain", "0 1 0", "base"),
        "</robot>".to_owned(),
    ];
    place.write("m.urdf", text.concat());
    let done = place.runner(&["convert", "m.urdf", "-o", "m.xml"]).exits(0);
    for expected in [
        "link `base` has mass 0 kg and least principal moment 0 kg m^2: MuJoCo requires 1e-15 of both",
        "link `cross` has mass 0 kg",
        "link `leg` has mass 1 kg and least principal moment 1e-20 kg m^2",
    ] {
        assert!(done.stderr.contains(expected), "{expected}: {}", done.stderr);
    }
    assert!(!done.stderr.contains("`plain`") && !done.stderr.contains("`arm`"), "{}", done.stderr);
    let text = fs::read_to_string(place.path("m.xml")).unwrap();
    let least = "mass=\"1e-15\" diaginertia=\"1e-15 1e-15 1e-15\"";
    assert_eq!(text.matches(least).count(), 2, "{text}");
    let models = ["m.urdf", "m.xml"].map(|name| load(&place.path(name)).unwrap().model);
    let names: Vec<String> = models[0].joints.iter().map(|joint| joint.name.clone()).collect();
    let error = difference(&mass(&models[0], &names), &mass(&models[1], &names));
    assert!(error <= 1e-12, "{error}");
}

/// A sensor on a link without mass and shapes keeps that link a body.
#[test]
fn sensors_of_links_without_mass_have_a_site() {
    let place = Place::new();
    place.write(
        "m.xml",
        r#"<mujoco><worldbody><body name="a"><joint name="i" axis="0 0 1"/><site name="s"/><body name="b">
        <joint name="j" axis="0 1 0" armature="0.1"/><geom size="0.1" pos="0.1 0 0"/></body></body></worldbody>
        <sensor><gyro site="s"/></sensor></mujoco>"#,
    );
    place.runner(&["convert", "m.xml", "-o", "n.xml"]).exits(0);
    let text = fs::read_to_string(place.path("n.xml")).unwrap();
    assert!(text.contains("<body name=\"a\"") && text.contains("<site name=\"imu/s\""), "{text}");
}

#[test]
fn loops_keep_their_names_and_pins_stay_pins() {
    let place = Place::new();
    let body = "<inertial pos=\"0 0 0\" mass=\"1\" diaginertia=\"1 1 1\"/>";
    let bodies = ["a", "b", "c"].map(|name| {
        format!(
            "<body name=\"{name}\">{body}<joint name=\"{name}\" axis=\"0 0 1\"/><site name=\"{name}\" pos=\"1 0 0\"/>\
             </body>"
        )
    });
    let text = format!(
        "<mujoco><worldbody>{}</worldbody><equality><connect name=\"knee\" site1=\"a\" site2=\"b\"/>\
         <weld name=\"grip\" site1=\"b\" site2=\"c\"/></equality></mujoco>",
        bodies.concat()
    );
    place.write("m.xml", text);
    let hip = "model = \"m.xml\"\n[[loop]]\nname = \"hip\"\ntype = \"pin\"\nlink = \"a\"\nto = \"c\"\n\
               position = [0.5, 0, 0]\naxis = [0, 1, 1]\nto_axis = [0, 1, 1]\n";
    place.write("m.toml", hip);
    place.runner(&["convert", "m.toml", "-o", "n.xml"]).exits(0);
    let models = ["m.toml", "n.xml"].map(|name| load(&place.path(name)).unwrap().model);
    let [before, after] = models.map(|model| model.loops.into_iter().map(|l| (l.name, l.kind, l.pose, l.other_pose)));
    for (a, b) in before.zip(after.collect::<Vec<_>>()) {
        assert_eq!((&a.0, a.1), (&b.0, b.1));
        for (a, b) in [(a.2, b.2), (a.3, b.3)] {
            assert!((a.to_homogeneous() - b.to_homogeneous()).amax() < 1e-15, "{a} {b}");
        }
    }
}

#[test]
fn an_effort_limit_of_0_stays_one() {
    let place = Place::new();
    let urdf = |limit: &str| {
        format!(
            "<robot name=\"m\"><link name=\"world\"/><link name=\"a\"><inertial><mass value=\"1\"/><inertia ixx=\"1\" \
             iyy=\"1\" izz=\"1\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial></link><joint name=\"j\" type=\"continuous\"><parent \
             link=\"world\"/><child link=\"a\"/><axis xyz=\"0 0 1\"/><limit {limit}/></joint></robot>"
        )
    };
    place.write("m.urdf", urdf("effort=\"0\" velocity=\"2\""));
    place.write("m.toml", "model = \"m.urdf\"\n[joint.j]\nkp = 20\nkd = 2\n");
    let done = place.runner(&["convert", "m.toml", "-o", "m.xml"]).exits(0);
    assert!(done.stderr.contains("the effort limit 0 of joint `j` is written as 1e-15"), "{}", done.stderr);
    let text = fs::read_to_string(place.path("m.xml")).unwrap();
    let range = "actuatorfrcrange=\"-1e-15 1e-15\"";
    assert!(text.contains(range) && text.contains("forcerange=\"-1e-15 1e-15\""), "{text}");
    assert_eq!(load(&place.path("m.xml")).unwrap().model.joints[0].effort_limit, 1e-15);
    place.runner(&["convert", "m.toml", "-o", "n.urdf"]).exits(0);
    assert_eq!(load(&place.path("n.urdf")).unwrap().model.joints[0].effort_limit, 0.0);
}

#[test]
fn a_urdf_that_would_lack_the_armature_it_needs_is_refused() {
    let place = Place::new();
    let text = |inside: &str| {
        format!(
            "<mujoco><worldbody><body name=\"a\"><joint name=\"i\" axis=\"0 0 1\"/><geom size=\"0.1\"/>\
             <body name=\"b\"><joint name=\"rotor\" axis=\"0 1 0\" armature=\"0.1\"/>{inside}</body></body></worldbody></mujoco>"
        )
    };
    place.write("m.xml", text(""));
    let done = place.runner(&["convert", "m.xml", "-o", "m.urdf"]).exits(2);
    let expected = "link `b` has no inertia but the armature of joint `rotor`, and a URDF holds no armature";
    assert!(done.stderr.contains(expected) && !place.path("m.urdf").exists(), "{}", done.stderr);
    place.runner(&["convert", "m.xml", "-o", "n.xml"]).exits(0);
    assert_eq!(load(&place.path("n.xml")).unwrap().model.joints[1].armature, 0.1);
    place.write("m.xml", text("<geom size=\"0.1\"/>"));
    place.runner(&["convert", "m.xml", "-o", "m.urdf"]).exits(0);
}

/// Capsules, which URDF lacks, are written as cylinders with balls, and read back as capsules.
#[test]
fn capsules_of_a_urdf_are_cylinders_with_balls() {
    let place = Place::new();
    let text = "<mujoco><worldbody><body name=\"a\"><freejoint/><geom type=\"capsule\" size=\"0.1 0.2\" pos=\"1 2 3\" \
                euler=\"10 20 30\" rgba=\"1 0 0 1\"/><geom size=\"0.1\" group=\"3\"/></body></worldbody></mujoco>";
    place.write("m.xml", text);
    place.runner(&["convert", "m.xml", "-o", "m.urdf"]).exits(0);
    let text = fs::read_to_string(place.path("m.urdf")).unwrap();
    assert!(!text.contains("capsule"), "{text}");
    assert_eq!((text.matches("<sphere").count(), text.matches("<cylinder").count()), (5, 2), "{text}");
    let models = ["m.xml", "m.urdf"].map(|name| load(&place.path(name)).unwrap().model);
    let [before, after] = models.map(|model| [model.links[0].visuals.clone(), model.links[0].collisions.clone()]);
    for (a, b) in before.iter().zip(&after) {
        assert_eq!(a.len(), b.len());
        for (a, b) in a.iter().zip(b) {
            assert_eq!(a.geometry, b.geometry);
            assert!((a.pose.to_homogeneous() - b.pose.to_homogeneous()).amax() < 1e-14);
        }
    }
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

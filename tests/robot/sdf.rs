//! SDFormat files as robots: what is read, what is reported, and files with one error each.

use super::{folder, load_toml};
use stiction::robot::{Base, JointKind, LoopKind, Robot, RobotError, load, parse};

const GOOD: &str = r#"<sdf version="1.9">
  <model name="m">
    <link name="a">
      <pose>0 0 1 0 0 0</pose>
      <inertial>
        <mass>2</mass>
        <inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz></inertia>
      </inertial>
      <collision name="c"><geometry><box><size>1 1 1</size></box></geometry></collision>
    </link>
    <link name="b">
      <pose relative_to="a">0 0 0.5 0 0 0</pose>
      <inertial>
        <mass>1</mass>
        <inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz></inertia>
      </inertial>
    </link>
    <joint name="j" type="revolute">
      <parent>a</parent>
      <child>b</child>
      <axis>
        <xyz>0 0 1</xyz>
        <limit><lower>-1</lower><upper>1</upper><effort>5</effort></limit>
      </axis>
    </joint>
  </model>
</sdf>
"#;

fn read(text: &str) -> Result<Robot, RobotError> {
    parse("robot.sdf".as_ref(), text, None)
}

fn notices(robot: &Robot) -> Vec<String> {
    robot.notices.iter().map(|notice| notice.brief()).collect()
}

/// Text, its replacement, the line that the error must name, text that the message must contain.
const CASES: &[(&str, &str, usize, &str)] = &[
    ("  </model>\n", "", 26, "not well-formed"),
    ("version=\"1.9\"", "version=\"2.0\"", 1, "1.3 to 1.12"),
    ("version=\"1.9\"", "", 1, "the version of the format is not known"),
    ("name=\"m\"", "name=\"\"", 2, "the name of <model> cannot be used"),
    ("name=\"b\"", "name=\"a\"", 11, "there are two of the name `a`"),
    ("name=\"b\"", "name=\"x::b\"", 11, "the name of <link> cannot be used"),
    ("name=\"j\"", "name=\"a\"", 18, "there are two of the name `a`"),
    ("0 0 1 0 0 0", "0 0 1 0 0", 4, "6 finite numbers"),
    ("0 0 1 0 0 0", "0 0 nan 0 0 0", 4, "6 finite numbers"),
    ("0 0 1 0 0 0", "0 0 1e9 0 0 0", 4, "coordinates of at most 1e4 m"),
    ("<pose>0 0 1", "<pose degrees=\"x\">0 0 1", 4, "`degrees` cannot be used"),
    ("<pose>0 0 1", "<pose rotation_format=\"q\">0 0 1", 4, "the rotation format is unknown"),
    ("<pose>0 0 1 0 0 0", "<pose rotation_format=\"quat_xyzw\">0 0 1 0 0 0 0", 4, "a quaternion of length 1"),
    ("relative_to=\"a\"", "relative_to=\"A\"", 12, "there is no frame `A`"),
    ("relative_to=\"a\"", "relative_to=\"b\"", 12, "the pose of `b` is relative to itself"),
    ("<pose>0 0 1", "<pose relative_to=\"b\">0 0 1", 4, "is relative to itself"),
    ("<mass>2</mass>", "<mass>-2</mass>", 6, "a mass in kg, not negative"),
    ("<mass>2</mass>", "<mass>two</mass>", 6, "a mass in kg, not negative"),
    ("<mass>2</mass>", "<mass>2</mass><mass>3</mass>", 6, "more than one <mass>"),
    ("<inertial>", "<inertial auto=\"true\">", 5, "inertias by shape and density are not available"),
    ("<ixx>1</ixx>", "<ixx>-1</ixx>", 5, "inertia of link `a` is not positive definite"),
    ("<ixx>1</ixx>", "<ixx>3</ixx>", 5, "triangle inequality"),
    ("<size>1 1 1</size>", "<size>1 0 1</size>", 9, "3 finite numbers above 0"),
    ("<size>1 1 1</size>", "", 9, "lacks <size>"),
    ("<box><size>1 1 1</size></box>", "", 9, "<geometry> must hold one shape"),
    ("type=\"revolute\"", "type=\"revolut\"", 18, "did you mean `revolute`"),
    ("type=\"revolute\"", "type=\"screw\"", 18, "screw joints are not available"),
    ("type=\"revolute\"", "type=\"gearbox\"", 18, "gearbox joints are not available"),
    ("<parent>a</parent>", "<parent>A</parent>", 19, "names an unknown parent: `A`"),
    ("<child>b</child>", "<child>x</child>", 18, "there is no frame `x`"),
    ("<child>b</child>", "", 18, "lacks <child>"),
    ("<child>b</child>", "<child>a</child>", 18, "connects a link with itself"),
    ("<xyz>0 0 1</xyz>", "<xyz>0 0 0</xyz>", 22, "a direction"),
    ("<xyz>0 0 1</xyz>", "<xyz expressed_in=\"c\">0 0 1</xyz>", 21, "there is no frame `c`"),
    ("<lower>-1</lower>", "<lower>4</lower>", 23, "the lower limit is above the upper: 4 > 1"),
    ("<effort>5</effort>", "<effort>many</effort>", 23, "a number"),
    ("</joint>", "</joint><link name=\"c\"/>", 25, "link `c` is the child of no joint"),
    ("</joint>", "</joint><include><uri>model://none</uri></include>", 25, "there is no none in"),
    ("</joint>", "</joint><include><uri>../../x</uri></include>", 25, "leads out of the folder"),
    ("</joint>", "</joint><include><uri>model://../x</uri></include>", 25, "has parts such as `..`"),
    ("</joint>", "</joint><include merge=\"1\"><uri>x</uri></include>", 25, "merged includes are not available"),
    ("</joint>", "</joint><frame name=\"f\" attached_to=\"g\"/><frame name=\"g\" attached_to=\"f\"/>", 25, "itself"),
];

#[test]
fn errors_name_their_line_and_cause() {
    read(GOOD).unwrap();
    for (text, replacement, line, needle) in CASES {
        assert!(GOOD.contains(text), "{text}");
        let error = match read(&GOOD.replacen(text, replacement, 1)) {
            Ok(_) => panic!("{text} -> {replacement}: read"),
            Err(error) => error.to_string(),
        };
        assert!(error.starts_with(&format!("robot.sdf:{line}:")), "{replacement}: line {line}: {error}");
        assert!(error.contains(needle), "{replacement}: {error}");
    }
}

#[test]
fn deep_nesting_is_refused() {
    let (open, close) = ("<model name=\"n\">".repeat(40), "</model>".repeat(40));
    let text = GOOD.replace("</joint>", &format!("</joint>{open}{close}"));
    assert!(read(&text).unwrap_err().to_string().contains("nested too deeply"));
}

#[test]
fn long_chains_of_frames_are_refused() {
    for (element, number, is_read) in [("frame", 500, true), ("frame", 3000, false), ("relative", 3000, false)] {
        let frame = |i: usize| {
            let before = if i == 0 { "a".to_owned() } else { format!("f{}", i - 1) };
            match element {
                "frame" => format!("<frame name=\"f{i}\" attached_to=\"{before}\"/>"),
                _ => format!("<frame name=\"f{i}\"><pose relative_to=\"{before}\">1 0 0 0 0 0</pose></frame>"),
            }
        };
        let chain: String = (0..number).map(frame).collect();
        match read(&GOOD.replace("</joint>", &format!("</joint>{chain}"))) {
            Ok(_) => assert!(is_read, "{element} {number}"),
            Err(error) => assert!(!is_read && error.to_string().contains("too many other frames"), "{error}"),
        }
    }
}

#[test]
fn a_file_that_includes_itself_is_refused() {
    let text = GOOD.replace("</joint>", "</joint><include><uri>robot.sdf</uri></include>");
    let folder = folder(&[("robot.sdf", &text)]);
    let error = load(&folder.path().join("robot.sdf")).unwrap_err().to_string();
    assert!(error.contains("files include each other"), "{error}");
}

#[test]
fn included_models_are_read_with_their_meshes_from_the_folder_and_its_siblings() {
    let tool = r#"<sdf version="1.9"><model name="tool"><link name="tip">
        <inertial><mass>0.5</mass><inertia><ixx>0.1</ixx><iyy>0.1</iyy><izz>0.1</izz></inertia></inertial>
        <collision name="c"><geometry><mesh><uri>model://tool/tip.obj</uri></mesh></geometry></collision>
        </link></model></sdf>"#;
    let mesh = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    let manifest =
        r#"<model><name>tool</name><sdf version="1.4">no.sdf</sdf><sdf version="1.9">tool.sdf</sdf></model>"#;
    let include = r#"</joint><include><uri>model://tool</uri><name>hand</name><pose relative_to="b">0 0 2 0 0 0</pose></include>
        <joint name="w" type="fixed"><parent>b</parent><child>hand::tip</child></joint>"#;
    let robot = GOOD.replace("</joint>", include);
    let folder = folder(&[
        ("arm/model.sdf", &robot),
        ("tool/model.config", manifest),
        ("tool/tool.sdf", tool),
        ("tool/tip.obj", mesh),
    ]);
    let robot = load(&folder.path().join("arm/model.sdf")).unwrap();
    assert_eq!(robot.files.len(), 3, "{:?}", robot.files);
    let b = &robot.model.links[1];
    assert_eq!((b.mass, b.merged[0].name.as_str(), b.collisions.len()), (1.5, "hand::tip", 1));
    assert_eq!(b.merged[0].pose.translation.vector.z, 2.0);
}

#[test]
fn limits_drives_and_defaults_are_those_of_the_format() {
    let robot = read(GOOD).unwrap();
    let joint = &robot.model.joints[0];
    assert_eq!((joint.kind, joint.lower, joint.upper), (JointKind::Revolute, -1.0, 1.0));
    assert_eq!((joint.effort_limit, joint.velocity_limit), (5.0, f64::INFINITY));
    assert_eq!(robot.model.base, Base::Floating);
    assert_eq!(robot.model.links[1].offset.z, 0.5);
    // Very large limits and negative efforts stand for none.
    let free = GOOD.replace("-1</lower><upper>1<", "-1e16</lower><upper>1e16<").replace(">5<", ">-1<");
    let joint = read(&free).unwrap().model.joints[0].clone();
    assert_eq!((joint.kind, joint.effort_limit), (JointKind::Continuous, f64::INFINITY));
    // A link without <inertial> has 1 kg and 1 kg m^2.
    let start = GOOD.find("      <inertial>\n        <mass>1").unwrap();
    let end = start + GOOD[start..].find("</inertial>\n").unwrap() + "</inertial>\n".len();
    let bare = read(&format!("{}{}", &GOOD[..start], &GOOD[end..])).unwrap();
    assert_eq!(bare.model.links[1].mass, 1.0);
    assert!(notices(&bare).iter().any(|n| n.contains("link `b` has no <inertial>")));
}

#[test]
fn sensors_are_mounted_where_they_are() {
    let imu = r#"<sensor name="i" type="imu"><pose>0.1 0 0 0 0 0</pose></sensor><sensor name="cam" type="camera"/>"#;
    let force = r#"<sensor name="f" type="force_torque"><pose>0 0.2 0 0 0 0</pose></sensor></joint>"#;
    let text = GOOD.replacen("<collision", &format!("{imu}<collision"), 1).replace("</joint>", force);
    let robot = read(&text.replacen("<parent>a", "<pose>0 0 0.3 0 0 0</pose><parent>a", 1)).unwrap();
    let sensors = &robot.model.sensors;
    assert_eq!((sensors.imu[0].name.as_str(), sensors.imu[0].mount.link.0), ("i", 0));
    assert_eq!(sensors.imu[0].mount.pose.translation.vector.x, 0.1);
    // The internal frame of b is at its joint.
    let force = &sensors.force[0].mount;
    assert_eq!((force.link.0, force.pose.translation.vector.y, force.pose.translation.vector.z), (1, 0.2, 0.0));
    assert!(notices(&robot).iter().any(|n| n.contains("<sensor type=\"camera\"> is ignored")));
}

#[test]
fn mimic_joints_become_couplings_and_their_homes_follow() {
    let second = r#"</joint><link name="c"><pose relative_to="b">0 1 0 0 0 0</pose></link>
      <joint name="k" type="revolute"><parent>b</parent><child>c</child><axis><xyz>1 0 0</xyz>
      <mimic joint="j"><multiplier>2</multiplier><offset>0.5</offset><reference>0.1</reference></mimic></axis></joint>"#;
    let robot = read(&GOOD.replace("</joint>", second)).unwrap();
    let coupling = &robot.model.couplings[0];
    assert_eq!((coupling.joint.0, coupling.leader.0), (1, 0));
    assert_eq!(coupling.coefficients, [0.5 - 2.0 * 0.1, 2.0, 0.0, 0.0, 0.0]);
    assert_eq!(robot.model.home[1], 0.5 - 2.0 * 0.1);
    let unknown = read(&GOOD.replace("</joint>", &second.replace("joint=\"j\"", "joint=\"x\""))).unwrap();
    assert!(unknown.model.couplings.is_empty());
    assert!(notices(&unknown).iter().any(|n| n.contains("mimics `x`, which is no moving joint")));
}

#[test]
fn a_second_joint_of_a_link_closes_a_loop() {
    let body = "<inertial><mass>1</mass><inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz></inertia></inertial>";
    for (kind, expected) in [("ball", LoopKind::Ball), ("fixed", LoopKind::Weld), ("revolute", LoopKind::Pin)] {
        let more = format!(
            r#"</joint><link name="c"><pose>1 0 1 0 0 0.3</pose>{body}</link>
            <joint name="k" type="revolute"><parent>a</parent><child>c</child><axis><xyz>0 0 1</xyz></axis></joint>
            <joint name="close" type="{kind}"><pose relative_to="c">0.2 0.1 0 0 0 0</pose>
            <parent>c</parent><child>b</child><axis><xyz>0 1 0</xyz></axis></joint>"#
        );
        let robot = read(&GOOD.replace("</joint>", &more)).unwrap();
        let closure = &robot.model.loops[0];
        assert_eq!((closure.name.as_str(), closure.kind), ("close", expected));
        // At home both frames coincide.
        let mut poses = vec![robot.model.links[0].urdf_frame.inverse()];
        for link in &robot.model.links[1..] {
            let turn = nalgebra::UnitQuaternion::from_matrix(&link.rotation);
            poses.push(poses[link.parent.unwrap().0] * nalgebra::Isometry3::from_parts(link.offset.into(), turn));
        }
        let on = |link: usize, pose: &nalgebra::Isometry3<f64>| (poses[link] * pose).to_homogeneous();
        let (one, other) = (on(closure.link.0, &closure.pose), on(closure.other.unwrap().0, &closure.other_pose));
        assert!((one - other).amax() < 1e-12, "{one} {other}");
        let axis = (poses[closure.link.0] * closure.pose).rotation * nalgebra::Vector3::z();
        let c = nalgebra::UnitQuaternion::from_euler_angles(0.0, 0.0, 0.3);
        assert!((axis - c * nalgebra::Vector3::y()).norm() < 1e-12 || kind != "revolute");
    }
    let slide = GOOD.replace(
        "</joint>",
        "</joint><joint name=\"k\" type=\"prismatic\"><parent>world</parent><child>b</child><axis/></joint>",
    );
    assert!(read(&slide).unwrap_err().to_string().contains("closes a loop, which prismatic joints cannot"));
}

#[test]
fn static_models_and_joints_of_the_world_are_fixed() {
    let text = GOOD.replace("<link name=\"a\">", "<static>true</static><link name=\"a\">");
    assert_eq!(read(&text).unwrap().model.base, Base::Fixed);
    let anchored = GOOD
        .replace("</joint>", "</joint><joint name=\"k\" type=\"fixed\"><parent>world</parent><child>a</child></joint>");
    let robot = read(&anchored).unwrap();
    assert_eq!((robot.model.base, robot.model.links[0].name.as_str()), (Base::Fixed, "world"));
    assert_eq!(robot.model.links[0].merged[0].pose.translation.vector.z, 1.0);
}

#[test]
fn ignored_elements_are_listed_once_a_kind_and_unknown_ones_with_a_suggestion() {
    let plugins = "<plugin name=\"p\" filename=\"x\"/><plugin name=\"q\" filename=\"y\"/></model>";
    let text = GOOD.replace("</model>", plugins).replacen("<mass>", "<mas>1</mas><mass>", 1);
    let found = notices(&read(&text).unwrap());
    assert!(
        found.iter().any(|n| n.contains("<plugin> of <model> is ignored (2 of them, the first is here)")),
        "{found:?}"
    );
    let unknown = "robot.sdf:6: unknown element <mas> of link `a` is ignored; did you mean <mass>?";
    assert!(found.iter().any(|n| n.contains(unknown)), "{found:?}");
}

#[test]
fn a_model_of_a_file_with_several_is_named_after_a_hash() {
    let world = format!(
        "<sdf version=\"1.9\"><world name=\"w\">{}{}</world></sdf>",
        "<model name=\"other\"><link name=\"x\"/></model>",
        &GOOD[GOOD.find("<model").unwrap()..GOOD.find("</sdf>").unwrap()]
    );
    let folder = folder(&[("w.sdf", &world)]);
    let file = folder.path().join("w.sdf");
    assert!(load(&file).unwrap_err().to_string().contains("the file has 2 models"));
    let at = |name: &str| file.with_file_name(format!("w.sdf#{name}"));
    assert_eq!(load(&at("m")).unwrap().model.name, "m");
    assert!(load(&at("mm")).unwrap_err().to_string().contains("did you mean `m`?"));
}

#[test]
fn a_robot_file_names_an_sdf_too() {
    let folder = folder(&[("robot.toml", "urdf = \"robot.sdf\"\nhome = { j = 0.5 }\n"), ("robot.sdf", GOOD)]);
    assert_eq!(load(&folder.path().join("robot.toml")).unwrap().model.home, [0.5]);
    // The root element decides, whatever the name.
    assert_eq!(load_toml("urdf = \"robot.urdf\"\n", GOOD).unwrap().model.name, "m");
}

#[test]
fn damaged_files_are_read_or_refused_without_a_panic() {
    let all = [GOOD, include_str!("sdf/frames.sdf"), include_str!("sdf/fixed_base.sdf")];
    for text in all {
        let mut seed = 1u64;
        for _ in 0..4000 {
            seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            let (at, length) = ((seed >> 33) as usize % text.len(), 1 + (seed >> 20) as usize % 12);
            let end = (at + length).min(text.len());
            let (before, after) = (&text[..at], &text[end..]);
            let from = (seed >> 40) as usize % (text.len() - 24);
            let damaged = match seed >> 62 {
                0 => format!("{before}{after}"),
                1 => format!("{before}{}{after}", &text[from..from + 24]),
                2 => format!("{before}-1e300{after}"),
                _ => text.replacen(&text[at..end], &text[from..from + length], 3),
            };
            let _ = read(&damaged);
        }
    }
}

//! Fixed joints: mass, centre and tensor of the union, frames and shapes of the welded links, and
//! the root.

use nalgebra::{Matrix3, Vector3};
use stiction::robot::{Base, LinkId};

use super::{BODY, assert_fault, load_toml, load_urdf};

fn box_inertial(mass: f64, [a, b, c]: [f64; 3], origin: &str) -> String {
    let i = |u: f64, v: f64| mass * (u * u + v * v) / 12.0;
    format!(
        "<inertial><origin {origin}/><mass value=\"{mass}\"/><inertia ixx=\"{}\" ixy=\"0\" ixz=\"0\" iyy=\"{}\" iyz=\"0\" izz=\"{}\"/></inertial>",
        i(b, c),
        i(a, c),
        i(a, b)
    )
}

/// A homogeneous bar of 3 kg, 0.6 x 0.1 x 0.2 m, cut at a third. One piece is the root, the other
/// is welded on with its frame rotated by 90 degrees about z and its inertial frame rotated back by
/// -90 degrees about x.
#[test]
fn a_bar_cut_and_welded_has_the_inertia_of_the_bar() {
    let first = box_inertial(1.0, [0.2, 0.1, 0.2], "xyz=\"0.1 0 0\"");
    // In the piece's frame its length is along -y. The inertial frame of the second piece has x' =
    // -y, and y', z' rotated further, so its edge lengths along its own axes are (0.4, 0.2, 0.1).
    let second =
        box_inertial(2.0, [0.4, 0.2, 0.1], "xyz=\"0 -0.2 0\" rpy=\"-1.5707963267948966 0 -1.5707963267948966\"");
    let text = format!(
        "<robot name=\"bar\"><link name=\"near\">{first}</link><link name=\"far\">{second}\
         <visual><origin xyz=\"0 -0.2 0\"/><geometry><box size=\"0.1 0.4 0.2\"/></geometry></visual></link>\
         <joint name=\"weld\" type=\"fixed\"><origin xyz=\"0.2 0 0\" rpy=\"0 0 1.5707963267948966\"/>\
         <parent link=\"near\"/><child link=\"far\"/></joint></robot>"
    );
    let model = load_urdf(&text).unwrap().model;
    assert_eq!(model.links.len(), 1);
    let bar = &model.links[0];
    let whole = Matrix3::from_diagonal(&Vector3::new(0.1f64.powi(2) + 0.04, 0.36 + 0.04, 0.36 + 0.01)) * (3.0 / 12.0);
    // Rounding of cos(pi/2) and of the sums.
    assert_eq!(bar.mass, 3.0);
    assert!((bar.com - Vector3::new(0.3, 0.0, 0.0)).norm() < 1e-15, "{}", bar.com);
    assert!((bar.inertia - whole).norm() < 1e-15, "{} {}", bar.inertia, whole);
    let far = &bar.merged[0];
    assert_eq!(far.name, "far");
    assert_eq!(model.link("far").unwrap().0, LinkId(0));
    assert!((far.pose.translation.vector - Vector3::new(0.2, 0.0, 0.0)).norm() < 1e-15);
    assert!((bar.visuals[0].pose.translation.vector - Vector3::new(0.4, 0.0, 0.0)).norm() < 1e-15);
}

#[test]
fn welding_massless_frames_changes_no_inertia() {
    let text = format!(
        "<robot name=\"r\"><link name=\"a\">{BODY}</link><link name=\"imu\"/>\
         <link name=\"imu2\"><inertial><mass value=\"0\"/><inertia ixx=\"0\" ixy=\"0\" ixz=\"0\" iyy=\"0\" iyz=\"0\" izz=\"0\"/></inertial></link>\
         <joint name=\"f\" type=\"fixed\"><origin xyz=\"1 2 3\"/><parent link=\"a\"/><child link=\"imu\"/></joint>\
         <joint name=\"g\" type=\"fixed\"><origin xyz=\"1 2 3\"/><parent link=\"imu\"/><child link=\"imu2\"/></joint></robot>"
    );
    let model = load_urdf(&text).unwrap().model;
    let link = &model.links[0];
    assert_eq!((link.mass, link.com, link.inertia), (1.0, Vector3::zeros(), Matrix3::identity()));
    assert_eq!(model.link("imu2").unwrap().1.translation.vector, Vector3::new(2.0, 4.0, 6.0));
}

#[test]
fn inertia_without_mass_counts_welded_or_moving() {
    let inertia = "<inertia ixx=\"0.3\" ixy=\"0\" ixz=\"0\" iyy=\"0.2\" iyz=\"0\" izz=\"0.1\"/>";
    let text = |kind: &str, last: &str| {
        format!(
            "<robot name=\"r\"><link name=\"a\">{BODY}</link>\n<link name=\"rotor\"><inertial><origin xyz=\"5 5 5\"/>\
             <mass value=\"0\"/>{inertia}</inertial></link><link name=\"c\">{last}</link>\n\
             <joint name=\"f\" type=\"{kind}\"><origin xyz=\"1 2 3\" rpy=\"0 0 1.5707963267948966\"/><parent link=\"a\"/>\
             <child link=\"rotor\"/><axis xyz=\"0 0 1\"/></joint>\
             <joint name=\"g\" type=\"fixed\"><parent link=\"rotor\"/><child link=\"c\"/></joint></robot>"
        )
    };
    // A quarter turn about z; it has no lever wherever it is welded.
    let robot = load_urdf(&text("fixed", "")).unwrap();
    let link = &robot.model.links[0];
    let expected = Matrix3::from_diagonal(&Vector3::new(1.2, 1.3, 1.1));
    assert_eq!((link.mass, link.com), (1.0, Vector3::zeros()));
    // Rounding of the quarter turn.
    assert!((link.inertia - expected).amax() < 1e-15, "{}", link.inertia);
    let notice = robot.notices.iter().find(|n| n.message.contains("link `rotor` has inertia but no mass"));
    assert!(notice.is_some_and(|n| n.line() == 2 && n.message.ends_with("which count")), "{notice:?}");
    // On its own joint, alone and with a mass welded to it.
    let rotor = Matrix3::from_diagonal(&Vector3::new(0.3, 0.2, 0.1));
    let alone = load_urdf(&text("continuous", "")).unwrap().model;
    assert_eq!((alone.links[1].mass, alone.links[1].inertia), (0.0, rotor));
    let loaded = load_urdf(&text("continuous", BODY)).unwrap().model;
    assert_eq!((loaded.links[1].com, loaded.links[1].inertia), (Vector3::zeros(), rotor + Matrix3::identity()));
}

fn world(kind: &str, extra: &str) -> String {
    format!(
        "<robot name=\"r\"><link name=\"world\"/>\n<joint name=\"j\" type=\"{kind}\"><parent link=\"world\"/>\
         <child link=\"a\"/><axis xyz=\"0 0 1\"/></joint>\n<link name=\"a\">{BODY}</link>{extra}</robot>"
    )
}

#[test]
fn the_root_is_fixed_or_floating_as_the_file_sets() {
    let extra = format!(
        "<joint name=\"k\" type=\"continuous\"><parent link=\"a\"/><child link=\"b\"/></joint><link name=\"b\">{BODY}</link>"
    );
    let base = |text: &str, word: &str| {
        let toml = format!("urdf = \"robot.urdf\"\nbase = \"{word}\"\n");
        load_toml(&toml, text).map(|r| (r.model.base, r.model.links[0].name.clone(), r.model.nv(), r.model.mass()))
    };
    let bare = |text: &str| {
        load_urdf(text).map(|r| (r.model.base, r.model.links[0].name.clone(), r.model.nv(), r.model.mass()))
    };
    let (fixed, floating, moving) = (world("fixed", &extra), world("floating", &extra), world("continuous", &extra));
    assert_eq!(bare(&fixed).unwrap(), (Base::Fixed, "world".into(), 1, 1.0));
    assert_eq!(bare(&moving).unwrap(), (Base::Fixed, "world".into(), 2, 2.0));
    assert_eq!(bare(&floating).unwrap(), (Base::Floating, "a".into(), 7, 2.0));
    assert_eq!(base(&fixed, "floating").unwrap(), (Base::Floating, "a".into(), 7, 2.0));
    assert_eq!(base(&floating, "fixed").unwrap(), (Base::Fixed, "a".into(), 1, 1.0));
    assert_fault(
        "moving",
        load_toml("urdf = \"robot.urdf\"\nbase = \"floating\"\n", &moving),
        "robot.urdf",
        1,
        "does not fit",
    );
    let free = world("fixed", &extra)
        .replace("\"world\"", "\"trunk\"")
        .replace("<link name=\"trunk\"/>", &format!("<link name=\"trunk\">{BODY}</link>"));
    assert_eq!(bare(&free).unwrap(), (Base::Floating, "trunk".into(), 7, 3.0));
    assert_eq!(base(&free, "fixed").unwrap(), (Base::Fixed, "trunk".into(), 1, 1.0));
}

/// Exporters write placeholder tensors on frames: they give a notice, and are harmless once welded
/// to a valid body.
#[test]
fn an_invalid_part_of_a_valid_body_is_a_warning() {
    let text = |weld: &str| {
        let flawed = "<inertial><mass value=\"0.001\"/>\n<inertia ixx=\"1e-6\" ixy=\"1e-6\" ixz=\"1e-6\" iyy=\"1e-6\" iyz=\"1e-6\" izz=\"1e-6\"/></inertial>";
        format!(
            "<robot><link name=\"a\">{BODY}</link>\n<link name=\"tip\">{flawed}</link>\n\
             <joint name=\"f\" type=\"{weld}\"><parent link=\"a\"/><child link=\"tip\"/></joint></robot>"
        )
    };
    let welded = load_urdf(&text("fixed")).unwrap();
    let notice =
        |needle: &str| welded.notices.iter().find(|n| n.message.contains(needle)).unwrap_or_else(|| panic!("{needle}"));
    assert_eq!(notice("link `tip` breaks the triangle inequality: principal moments").line(), 3);
    assert_eq!(notice("no name").line(), 1);
    assert_eq!(welded.model.name, "robot");
    assert_fault(
        "moving",
        load_urdf(&text("continuous")),
        "robot.urdf",
        3,
        "link `tip` breaks the triangle inequality",
    );
}

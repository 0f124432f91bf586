//! Notices: ignored or assumed elements are reported with their line.

use super::{BODY, folder, load_urdf};
use stiction::robot::{Geometry, JointKind, inspect, load};
use stiction::text::Severity;

#[test]
fn ignored_and_assumed_elements_are_reported_with_their_line() {
    let text = format!(
        r#"<robot name="r">
<link name="a" type="x">{BODY}<contact/></link>
<gazebo reference="a"/>
<transmission name="t"/>
<joint name="j" type="revolute">
<parent link="a"/><child link="b"/>
<limit lower="1" upper="2" velocity="3"/>
<safety_controller k_velocity="1"/><dynamics damping="0.1" friction="0.2" spring="1"/>
</joint>
<link name="b">{BODY}</link>
<joint name="k" type="continuous"><parent link="b"/><child link="c"/><axis xyz="0 0 2"/>
<limit lower="1" upper="2" effort="0" velocity="3"/></joint>
<link name="c">{BODY}
<collision><geometry><mesh filename="package://nowhere/foot.stl"/></geometry></collision>
<visual><geometry><mesh filename="foot.dae"/></geometry></visual></link>
<gazebo/>
</robot>"#
    );
    let folder = folder(&[("r.urdf", &text), ("foot.dae", "<COLLADA/>")]);
    let robot = load(&folder.path().join("r.urdf")).unwrap();
    let assert_notice = |line: usize, needle: &str, severity: Severity| {
        let found = robot.notices.iter().find(|n| n.message.contains(needle));
        let notice = found.unwrap_or_else(|| panic!("`{needle}` is silent: {:#?}", robot.notices));
        assert_eq!((notice.line(), notice.severity), (line, severity), "{notice}");
        assert!(inspect(&robot).contains(&notice.brief()));
    };
    use Severity::{Note, Warning};
    assert_notice(2, "attribute `type` of <link> is ignored", Note);
    assert_notice(2, "<contact> of link `a` is ignored", Note);
    assert_notice(3, "<gazebo> is ignored", Note);
    assert_notice(4, "<transmission> is ignored", Note);
    assert_notice(5, "joint `j` has no <axis>: 1 0 0 is used", Note);
    assert_notice(7, "joint `j` has no effort limit", Note);
    assert_notice(8, "<safety_controller> of joint `j` is ignored", Note);
    assert_notice(8, "attribute `spring` of <dynamics> is ignored", Note);
    assert_notice(11, "axis of joint `k` has length 2", Note);
    assert_notice(12, "limit of the continuous joint `k` are ignored", Note);
    assert_notice(12, "joint `k`: effort limit 0", Warning);
    assert_notice(
        14,
        "collision mesh `package://nowhere/foot.stl` of link `c` is left out: no folder `nowhere` with `foot.stl` in it is found in",
        Warning,
    );
    assert_notice(15, "visual mesh `foot.dae` of link `c` is left out", Warning);
    assert_eq!(robot.model.home, [1.0, 0.0], "0 is outside the limits of j");
    assert_notice(5, "0 is outside the limits of joint `j`", Note);
    assert_notice(1, "no soles", Warning);
    let [j, k] = &robot.model.joints[..] else { panic!() };
    assert_eq!((j.kind, j.lower, j.upper), (JointKind::Revolute, 1.0, 2.0));
    assert_eq!((j.effort_limit, j.velocity_limit), (f64::INFINITY, 3.0));
    assert_eq!((j.damping, j.friction), (0.1, 0.2));
    assert_eq!((k.kind, k.lower, k.upper), (JointKind::Continuous, f64::NEG_INFINITY, f64::INFINITY));
}

const TETRAHEDRON: &str = "solid t
facet normal 0 0 -1
outer loop
vertex 0 0 0
vertex 0 1 0
vertex 1 0 0
endloop
endfacet
facet normal 0 -1 0
outer loop
vertex 0 0 0
vertex 1 0 0
vertex 0 0 1
endloop
endfacet
facet normal -1 0 0
outer loop
vertex 0 0 0
vertex 0 0 1
vertex 0 1 0
endloop
endfacet
facet normal 1 1 1
outer loop
vertex 1 0 0
vertex 0 1 0
vertex 0 0 1
endloop
endfacet
endsolid t
";

#[test]
fn meshes_are_found_scaled_and_stored() {
    let text = format!(
        "<robot name=\"r\"><link name=\"a\">{BODY}\
         <visual><geometry><mesh filename=\"package://thing/meshes/t.stl\" scale=\"2 -3 4\"/></geometry></visual>\
         <visual><geometry><mesh filename=\"../meshes/t.obj\"/></geometry></visual>\
         <collision><geometry><mesh filename=\"../meshes/t.stl\"/></geometry></collision></link></robot>"
    );
    let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    let files =
        [("thing/urdf/r.urdf", text.as_str()), ("thing/meshes/t.stl", TETRAHEDRON), ("thing/meshes/t.obj", obj)];
    let folder = folder(&files);
    let robot = load(&folder.path().join("thing/urdf/r.urdf")).unwrap();
    let link = &robot.model.links[0];
    let volume = |g: &Geometry| {
        let Geometry::Mesh(points, triangles) = g else { panic!("not a mesh: {:?}", robot.notices) };
        assert_eq!((points.len(), triangles.len()), (4, 4), "equal vertices are one");
        let p = |i: u32| points[i as usize].coords;
        triangles.iter().map(|t| p(t[0]).cross(&p(t[1])).dot(&p(t[2])) / 6.0).sum::<f64>()
    };
    // Positive: the triangles face outward, also after the mirroring scale.
    assert_eq!(volume(&link.visuals[0].geometry), 24.0 / 6.0);
    assert!((volume(&link.visuals[1].geometry) - 1.0 / 6.0).abs() < 1e-15);
    assert!((volume(&link.collisions[0].geometry) - 1.0 / 6.0).abs() < 1e-15);
    let stl = robot.files.iter().filter(|(_, bytes)| bytes == TETRAHEDRON.as_bytes()).count();
    assert!(stl >= 1 && robot.files.iter().any(|(path, _)| path.ends_with("t.obj")), "mesh bytes are kept");
}

#[test]
fn a_broken_mesh_is_reported_and_left_out() {
    for (bytes, name) in
        [("", "m.stl"), ("solid x\nfacet", "m.stl"), ("v 0 0 0\nf 1 2 3\n", "m.obj"), ("f 1 1 1\n", "m.obj")]
    {
        let text = format!(
            "<robot name=\"r\"><link name=\"a\">{BODY}<visual><geometry><mesh filename=\"{name}\"/></geometry></visual></link></robot>"
        );
        let folder = folder(&[("r.urdf", &text), (name, bytes)]);
        let robot = load(&folder.path().join("r.urdf")).unwrap();
        assert!(robot.model.links[0].visuals.is_empty());
        assert!(robot.notices.iter().any(|n| n.message.contains("is left out")), "{bytes}: {:?}", robot.notices);
    }
    assert!(load_urdf("<robot name=\"r\"/>").is_err());
}

/// Elements that are not read may be incomplete, as may limits whose absence means "unlimited".
#[test]
fn incomplete_elements_that_are_not_read_are_accepted() {
    let joint = |inside: &str| {
        let urdf = format!(
            "<robot name=\"r\"><link name=\"a\">{BODY}</link><link name=\"b\">{BODY}</link><joint name=\"j\" type=\"revolute\">\
             <parent link=\"a\"/><child link=\"b\"/><axis xyz=\"0 0 1\"/>{inside}</joint></robot>"
        );
        load_urdf(&urdf).map_err(|e| format!("{inside}: {e}")).unwrap().model.joints[0].clone()
    };
    let limit = "<limit lower=\"-1\" upper=\"1\"/>";
    for more in [
        "",
        "<safety_controller/>",
        "<safety_controller k_velocity=\"x\"/>",
        "<calibration rising=\"x\"/>",
        "<dynamics/>",
    ] {
        let read = joint(&format!("{limit}{more}"));
        assert_eq!(
            (read.lower, read.upper, read.velocity_limit, read.effort_limit),
            (-1.0, 1.0, f64::INFINITY, f64::INFINITY)
        );
        assert_eq!((read.damping, read.friction), (0.0, 0.0));
    }
}

#[test]
fn a_home_given_by_the_robot_file_causes_no_notice() {
    let urdf = format!(
        "<robot name=\"r\"><link name=\"a\">{BODY}</link><joint name=\"j\" type=\"revolute\"><parent link=\"a\"/>\
         <child link=\"b\"/><axis xyz=\"0 0 1\"/><limit lower=\"1\" upper=\"2\" effort=\"1\" velocity=\"1\"/></joint>\
         <link name=\"b\">{BODY}</link></robot>"
    );
    let loaded = |toml: &str| {
        let robot = super::load_toml(toml, &urdf).unwrap();
        (robot.model.home[0], robot.notices.iter().any(|n| n.message.contains("outside the limits of joint `j`")))
    };
    assert_eq!(loaded("urdf = \"robot.urdf\"\nsole = []\n"), (1.0, true));
    assert_eq!(loaded("urdf = \"robot.urdf\"\nsole = []\n[home]\nj = 1.5\n"), (1.5, false));
}

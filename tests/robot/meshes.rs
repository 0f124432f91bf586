//! Mesh files: COLLADA scenes, binary STL with misleading headers, flat meshes, and the search
//! path.

use nalgebra::Point3;
use stiction::robot::{Geometry, Robot, Shape, load};

use super::{BODY, folder};

/// A right triangle whose corners differ in all coordinates that matter.
const TRIANGLE: &str = "1 0 0  0 2 0  0 0 3";

fn collada(unit: &str, geometry: &str, scene: &str) -> String {
    format!(
        "<?xml version=\"1.0\"?>\n<COLLADA xmlns=\"http://www.collada.org/2005/11/COLLADASchema\" version=\"1.4.1\">\
         <asset>{unit}<up_axis>Z_UP</up_axis></asset><library_geometries><geometry id=\"g\"><mesh>\
         <source id=\"p\"><float_array id=\"a\" count=\"9\">{TRIANGLE}</float_array><technique_common>\
         <accessor source=\"#a\" count=\"3\" stride=\"3\"/></technique_common></source>\
         <vertices id=\"v\"><input semantic=\"POSITION\" source=\"#p\"/></vertices>{geometry}</mesh></geometry>\
         </library_geometries><library_visual_scenes><visual_scene id=\"s\">{scene}</visual_scene>\
         </library_visual_scenes><scene><instance_visual_scene url=\"#s\"/></scene></COLLADA>"
    )
}

const ONE_FACE: &str =
    "<triangles count=\"1\"><input semantic=\"VERTEX\" source=\"#v\" offset=\"0\"/><p>0 1 2</p></triangles>";
const PLAIN: &str = "<node><instance_geometry url=\"#g\"/></node>";

/// A robot whose only visual is the file `name` with these bytes.
fn showing(name: &str, bytes: &[u8]) -> Robot {
    let text = format!(
        "<robot name=\"r\"><link name=\"a\">{BODY}<visual><geometry><mesh filename=\"{name}\"/></geometry></visual></link></robot>"
    );
    let folder = folder(&[("r.urdf", &text)]);
    std::fs::write(folder.path().join(name), bytes).unwrap();
    load(&folder.path().join("r.urdf")).unwrap()
}

fn corners(shape: &Shape) -> Vec<[Point3<f64>; 3]> {
    let Geometry::Mesh(points, triangles) = &shape.geometry else { panic!("{shape:?}") };
    triangles.iter().map(|t| t.map(|i| points[i as usize])).collect()
}

fn visual_triangles(dae: &str) -> Vec<[Point3<f64>; 3]> {
    let robot = showing("m.dae", dae.as_bytes());
    let shapes = &robot.model.links[0].visuals;
    assert_eq!(shapes.len(), 1, "{:?}", robot.notices);
    corners(&shapes[0])
}

fn assert_near(seen: &[[Point3<f64>; 3]], expected: &[[[f64; 3]; 3]]) {
    assert_eq!(seen.len(), expected.len(), "{seen:?}");
    for (a, b) in seen.iter().flatten().zip(expected.iter().flatten()) {
        // Rounding of a quarter turn and of products of numbers below 100.
        assert!((a - Point3::from(*b)).norm() < 1e-13, "{seen:?}\n{expected:?}");
    }
}

#[test]
fn a_collada_node_applies_its_transforms_in_the_order_of_the_file() {
    let plain = [[1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 3.0]];
    assert_near(&visual_triangles(&collada("", ONE_FACE, PLAIN)), &[plain]);
    // T R S p: scale by 2, a quarter turn about z (x to y, y to -x), then 10 along x.
    let steps = "<node><translate>10 0 0</translate><rotate>0 0 1 90</rotate><scale>2 2 2</scale>\
                 <instance_geometry url=\"#g\"/></node>";
    let expected = [[10.0, 2.0, 0.0], [6.0, 0.0, 0.0], [10.0, 0.0, 6.0]];
    assert_near(&visual_triangles(&collada("", ONE_FACE, steps)), &[expected]);
    // The same transforms split over nested nodes, one step as a matrix, in a file in millimetres.
    let nested = "<node><matrix>1 0 0 10 0 1 0 0 0 0 1 0 0 0 0 1</matrix><node><rotate>0 0 1 90</rotate>\
                  <node><scale>2 2 2</scale><instance_geometry url=\"#g\"/></node></node></node>";
    let millimetres = expected.map(|p| p.map(|x| 1e-3 * x));
    assert_near(&visual_triangles(&collada("<unit meter=\"0.001\"/>", ONE_FACE, nested)), &[millimetres]);
    // The other order: S T, 10 along x is scaled too.
    let other = "<node><scale>2 2 2</scale><translate>10 0 0</translate><instance_geometry url=\"#g\"/></node>";
    assert_near(
        &visual_triangles(&collada("", ONE_FACE, other)),
        &[[[22.0, 0.0, 0.0], [20.0, 4.0, 0.0], [20.0, 0.0, 6.0]]],
    );
}

#[test]
fn collada_faces_of_all_kinds_keep_their_orientation() {
    let [a, b, c] = [[1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 3.0]];
    // Two columns per corner, the second one the index of a normal; a mirrored node reverses the
    // face back outward.
    let input = "<input semantic=\"VERTEX\" source=\"#v\" offset=\"0\"/><input semantic=\"NORMAL\" source=\"#n\" offset=\"1\"/>";
    let polylist =
        format!("<polylist count=\"2\">{input}<vcount>3 3</vcount><p>0 9 1 9 2 9  0 9 2 9 1 9</p></polylist>");
    assert_near(&visual_triangles(&collada("", &polylist, PLAIN)), &[[a, b, c], [a, c, b]]);
    let polygons = format!("<polygons count=\"1\">{input}<p>0 9 1 9 2 9</p></polygons>");
    assert_near(&visual_triangles(&collada("", &polygons, PLAIN)), &[[a, b, c]]);
    let strip = format!("<tristrips count=\"1\">{input}<p>0 0 1 0 2 0 0 0</p></tristrips>");
    assert_near(&visual_triangles(&collada("", &strip, PLAIN)), &[[a, b, c], [c, b, a]]);
    let mirror = "<node><scale>-1 1 1</scale><instance_geometry url=\"#g\"/></node>";
    assert_near(&visual_triangles(&collada("", ONE_FACE, mirror)), &[[[-1.0, 0.0, 0.0], c, b]]);
}

#[test]
fn an_unsupported_collada_file_is_left_out_and_reported() {
    let loops = "<node id=\"n\"><instance_node url=\"#n\"/></node>";
    // Each of 40 nodes instances the next one twice.
    let doubling: String = (0..40)
        .map(|i| format!("<node id=\"n{i}\">{}</node>", format!("<instance_node url=\"#n{}\"/>", i + 1).repeat(2)))
        .collect();
    let doubling = format!("{doubling}<node id=\"n40\"/>");
    let outside = ONE_FACE.replace("0 1 2", "0 1 3");
    for (dae, why) in [
        (collada("", ONE_FACE, loops), "nest more than"),
        (collada("", ONE_FACE, &doubling), "has more than 100000 nodes"),
        (collada("", &outside, PLAIN), "a vertex that is not there"),
        (collada("", ONE_FACE, "<node><instance_geometry url=\"#h\"/></node>"), "`#h`, which is not in the file"),
        (collada("<unit meter=\"-1\"/>", ONE_FACE, PLAIN), "its unit is `-1` m"),
        (collada("", ONE_FACE, "<node><matrix>1 2</matrix></node>"), "16 numbers"),
        (collada("", ONE_FACE, "<node/>"), "no triangles"),
        (collada("", &ONE_FACE.replace("offset=\"0\"", "offset=\"18446744073709551615\""), PLAIN), "offset `1844"),
        (collada("", &ONE_FACE.replace("offset=\"0\"", "offset=\"-1\""), PLAIN), "offset `-1`"),
        ("<html/>".into(), "not <COLLADA>"),
    ] {
        let robot = showing("m.dae", dae.as_bytes());
        assert!(robot.model.links[0].visuals.is_empty(), "{why}");
        let notice = robot.notices.iter().any(|n| n.message.contains("`m.dae`") && n.message.contains(why));
        assert!(notice, "{why}: {:?}", robot.notices);
    }
}

#[test]
fn an_up_axis_is_reported_and_not_applied() {
    let dae = collada("", ONE_FACE, PLAIN).replace("Z_UP", "Y_UP");
    let robot = showing("m.dae", dae.as_bytes());
    assert!(robot.notices.iter().any(|n| n.message.contains("up-axis Y_UP")), "{:?}", robot.notices);
    assert_eq!(corners(&robot.model.links[0].visuals[0])[0][1], Point3::new(0.0, 2.0, 0.0));
}

#[test]
fn a_binary_stl_may_begin_like_text_and_be_flat() {
    let mut bytes = b"solid exported by a program".to_vec();
    bytes.resize(80, b' ');
    bytes.extend(2u32.to_le_bytes());
    for corners in
        [[[0.0f32, 0.0, 0.5], [1.0, 0.0, 0.5], [0.0, 1.0, 0.5]], [[1.0, 0.0, 0.5], [1.0, 1.0, 0.5], [0.0, 1.0, 0.5]]]
    {
        bytes.extend([0u8; 12]);
        bytes.extend(corners.as_flattened().iter().flat_map(|x| x.to_le_bytes()));
        bytes.extend([0u8; 2]);
    }
    let robot = showing("m.stl", &bytes);
    let Geometry::Mesh(points, triangles) = &robot.model.links[0].visuals[0].geometry else { panic!() };
    assert_eq!((points.len(), triangles.len()), (4, 2));
    // A plate without thickness also gives a sole.
    assert_eq!(robot.model.soles[0].vertices.len(), 4, "{:?}", robot.notices);
    // With one byte less the file is neither binary nor text.
    let broken = showing("m.stl", &bytes[..bytes.len() - 1]);
    assert!(broken.notices.iter().any(|n| n.message.contains("`m.stl`") && n.message.contains("left out")));
}

/// A mesh of one triangle, at a scale and by a name of the URDF, as a collision shape.
fn triangle(scale: &str, name: &str, file: &str) -> Robot {
    let text = format!(
        "<robot name=\"r\"><link name=\"a\">{BODY}<collision><geometry><mesh filename=\"{name}\" scale=\"{scale}\"/></geometry>\
         </collision></link></robot>"
    );
    let folder = folder(&[("r.urdf", &text), (file, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")]);
    load(&folder.path().join("r.urdf")).unwrap()
}

#[test]
fn degenerate_scales_are_reported() {
    for (scale, expected) in [
        ("0 0 0", "the scale 0 0 0 reduces it to nothing"),
        ("1 0 0", "the scale 1 0 0 reduces it to nothing"),
        ("1e200 1 1", "too large"),
    ] {
        let robot = triangle(scale, "m.obj", "m.obj");
        assert!(robot.model.links[0].collisions.is_empty() && robot.model.soles.is_empty(), "{scale}");
        assert!(robot.notices.iter().any(|n| n.message.contains(expected)), "{scale}: {:?}", robot.notices);
    }
    assert_eq!(triangle("1 2 0", "m.obj", "m.obj").model.links[0].collisions.len(), 1);
}

#[test]
fn encoded_names_are_decoded_if_no_file_has_the_literal_name() {
    for (name, file) in [
        ("left%20foot.obj", "left foot.obj"),
        ("left%20foot.obj", "left%20foot.obj"),
        ("package://p/100%25.obj", "p/100%.obj"),
        ("100%.obj", "100%.obj"),
        ("%C3%A9.obj", "\u{e9}.obj"),
    ] {
        assert_eq!(triangle("1 1 1", name, file).model.links[0].collisions.len(), 1, "{name}");
    }
    // An incomplete character is no valid text.
    assert_eq!(triangle("1 1 1", "%C3.obj", "m.obj").model.links[0].collisions.len(), 0);
}

#[test]
fn packages_are_found_from_the_urdf_upward() {
    let robot = |uri: &str| {
        format!(
            "<robot name=\"r\"><link name=\"a\">{BODY}<visual><geometry><mesh filename=\"{uri}\"/></geometry></visual></link></robot>"
        )
    };
    let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    let named = "<package><name>renamed</name></package>";
    for (uri, found) in [
        ("package://thing/m/t.obj", true),
        ("package:///thing/m/t.obj", true),
        ("model://thing/m/t.obj", true),
        ("package://top/thing/m/t.obj", true),
        ("package://renamed/m/t.obj", true),
        ("package://other/m/t.obj", false),
        ("package://thing", false),
        ("../m/t.obj", true),
    ] {
        let files = [
            ("top/thing/urdf/r.urdf", robot(uri)),
            ("top/thing/m/t.obj", obj.into()),
            ("top/thing/package.xml", named.into()),
        ];
        let place = folder(&files.each_ref().map(|(name, text)| (*name, text.as_str())));
        let robot = load(&place.path().join("top/thing/urdf/r.urdf")).unwrap();
        assert_eq!(!robot.model.links[0].visuals.is_empty(), found, "{uri}: {:?}", robot.notices);
        if uri.contains("other") {
            let notice = &robot.notices.iter().find(|n| n.message.contains("left out")).unwrap().message;
            // The searched locations: the URDF's own folder and those above it.
            for folder in ["top/thing/urdf", "top/thing", "top"] {
                assert!(notice.contains(&place.path().join(folder).display().to_string()), "{notice}");
            }
        }
    }
}

/// A bare file name has the current folder.
#[test]
fn packages_are_found_for_a_urdf_named_without_a_folder() {
    let place = crate::cli::Place::new();
    let mesh = "<mesh filename=\"package://thing/m/t.obj\"/>";
    let urdf = format!(
        "<robot name=\"r\"><link name=\"a\">{BODY}<collision><geometry>{mesh}</geometry></collision></link></robot>"
    );
    place.write("thing/m/t.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").write("thing/r.urdf", urdf);
    for (folder, name) in [("thing", "r.urdf"), ("thing", "./r.urdf"), ("thing/m", "../r.urdf"), (".", "thing/r.urdf")]
    {
        let done = place.shell(&format!("cd {folder} && exec \"$0\" inspect {name}")).exits(0);
        assert!(
            done.stdout.contains("1 collision shapes") && !done.stdout.contains("left out"),
            "{name}: {}",
            done.stdout
        );
    }
}

#[test]
fn a_mesh_of_many_triangles_becomes_a_hull() {
    // A grid on a half cylinder of radius 1, 40 x 40 cells.
    let mut obj = String::new();
    for i in 0..=40 {
        for j in 0..=40 {
            let angle = std::f64::consts::PI * f64::from(j) / 40.0;
            obj += &format!("v {} {} {}\n", f64::from(i) / 40.0, angle.cos(), angle.sin());
        }
    }
    for i in 0..40 {
        for j in 1..=40 {
            let (a, b) = (41 * i + j, 41 * (i + 1) + j);
            obj += &format!("f {a} {b} {}\nf {a} {} {}\n", b + 1, b + 1, a + 1);
        }
    }
    let robot = showing("m.obj", obj.as_bytes());
    let Geometry::Mesh(points, triangles) = &robot.model.links[0].visuals[0].geometry else { panic!() };
    assert!(triangles.len() < 400, "{}", triangles.len());
    let reach = points.iter().map(|p| p.z).fold(0.0, f64::max);
    assert!(reach > 0.99, "{reach}");
    assert!(robot.notices.iter().any(|n| n.message.contains("1 meshes of more than")), "{:?}", robot.notices);
}

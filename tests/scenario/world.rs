//! World files: the entries that they give, their positions in errors, and what is left out.

use std::path::Path;

use stiction::nalgebra::Vector3;
use stiction::scenario::{Diagnostics, Friction, ObjectSpec, Run, Severity, TerrainSpec, parse};
use stiction::{Scenario, Simulation};

const ROBOT: &str = "duration = 0.5\n";

/// A body of 2 kg: a cube of 0.2 m, 0.05 m above the floor, slightly turned.
const CRATE: &str = r#"<model name="crate"><pose>0.3 -0.2 0.16 0.1 0.2 0.3</pose><link name="l">
  <inertial><mass>2</mass><inertia><ixx>0.013333333333333334</ixx><iyy>0.013333333333333334</iyy><izz>0.013333333333333334</izz></inertia></inertial>
  <collision name="c"><geometry><box><size>0.2 0.2 0.2</size></box></geometry>
    <surface><friction><ode><mu>0.4</mu></ode></friction></surface></collision>
  </link></model>"#;

const STEP: &str = r#"<model name="step"><static>1</static><pose>1 0 0.05 0 0 0.5</pose><link name="l">
  <collision name="c"><geometry><box><size>0.4 0.4 0.1</size></box></geometry></collision></link></model>"#;

const GROUND: &str = r#"<model name="ground"><static>true</static><link name="l"><collision name="c">
  <geometry><plane><normal>0 0 1</normal></plane></geometry>
  <surface><friction><ode><mu>0.7</mu></ode></friction></surface></collision></link></model>"#;

fn world(models: &str) -> String {
    format!("<sdf version=\"1.9\"><world name=\"w\">\n{models}\n</world></sdf>")
}

/// The only run of a scenario next to a world file.
fn run_in(folder: &Path, text: &str, world: &str) -> Result<Run, Diagnostics> {
    std::fs::write(folder.join("w.sdf"), world).unwrap();
    let ground = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/ground/ground.urdf");
    let text = format!("{ROBOT}{text}\n[robot]\nmodel = {ground:?}\n");
    Ok(parse(&folder.join("s.toml"), text)?.expand(&[])?.remove(0))
}

fn run(text: &str, world: &str) -> Result<Run, Diagnostics> {
    run_in(tempfile::tempdir().unwrap().path(), text, world)
}

const WORLD: &str = "[world]\nfile = \"w.sdf\"";

#[test]
fn a_scene_of_a_world_file_gives_the_bits_of_the_same_scene_by_hand() {
    let by_hand = "gravity = [0, 0, -9.81]\n[floor]\nfriction = 0.7\n\
        [[terrain]]\ntype = \"box\"\nname = \"step\"\nsize = [0.4, 0.4, 0.1]\nposition = [1, 0, 0.05]\nrpy = [0, 0, 0.5]\n\
        [[object]]\ntype = \"box\"\nname = \"crate\"\nsize = [0.2, 0.2, 0.2]\nmass = 2\nfriction = 0.4\n\
        position = [0.3, -0.2, 0.16]\nrpy = [0.1, 0.2, 0.3]\n";
    let text = world(&format!("{GROUND}{STEP}{CRATE}"));
    let (a, b) = (run(WORLD, &text).unwrap(), run(by_hand, &text).unwrap());
    assert_eq!(a.resolved_toml, b.resolved_toml);
    assert_eq!(a.scenario, b.scenario);
    // A record holds the entries, so that a re-run needs no world file.
    assert!(!a.resolved_toml.contains("[world]"));
    let again = parse(&a.file, a.resolved_toml.clone()).unwrap().expand(&[]).unwrap().remove(0);
    assert_eq!(again.scenario, a.scenario);
}

#[test]
fn names_poses_and_kinds_follow_from_the_models() {
    let table = r#"<frame name="corner"><pose>2 0 0 0 0 0</pose></frame>
        <model name="table"><static>1</static><pose relative_to="corner">0 1 0 0 0 0</pose>
        <link name="l"><collision name="top"><pose>0 0 1 0 0 0</pose><geometry><box><size>1 1 0.1</size></box></geometry></collision>
        <collision name="leg"><geometry><box><size>0.1 0.1 1</size></box></geometry></collision></link></model>"#;
    let ball = r#"<model name="post"><static>1</static><pose>5 0 0 0 0 0</pose><link name="l"><pose>0 0 1 0 0 0</pose>
        <collision name="c"><geometry><sphere><radius>0.3</radius></sphere></geometry></collision></link></model>"#;
    // The tensor is not that of a homogeneous cube.
    let odd = CRATE.replace("<izz>0.013", "<izz>0.014").replace("\"crate\"", "\"odd\"");
    let spec = "[world]\nfile = \"w.sdf\"\nignore = [\"rob*\"]\n";
    let robot = "<model name=\"robot1\"><link name=\"x\"/></model>";
    let run = run(spec, &world(&format!("<gravity>0 0 -3</gravity>{table}{ball}{odd}{robot}"))).unwrap();
    let s = &run.scenario;
    let names: Vec<String> = s.terrain.iter().enumerate().map(|(i, spec)| spec.name(i)).collect();
    assert_eq!(names, ["table/top", "table/leg"]);
    assert_eq!(s.terrain[0].entry().position, [2.0, 1.0, 1.0]);
    let objects: Vec<_> =
        s.object.iter().map(|o| (o.entry().name.unwrap(), o.entry().position[2], o.model())).collect();
    assert_eq!(objects, [("post", 1.0, Some("w.sdf#post::l::c")), ("odd", 0.16, Some("w.sdf#odd"))]);
    assert_eq!(s.gravity, [0.0, 0.0, -3.0]);
    assert!(!s.floor.plane, "a world without a plane has no floor");
    assert!(run.warnings.0.is_empty(), "{}", run.warnings);
    assert_eq!(s.object[1].entry().friction, Some(Friction::coulomb(0.4, 0.4)));
}

#[test]
fn values_of_the_scenario_take_precedence_and_entries_are_appended() {
    let text = format!(
        "gravity = [0, 0, -1]\n{WORLD}\n[floor]\nheight = 0.01\n\
         [[terrain]]\ntype = \"box\"\nsize = [1, 1, 1]\nposition = [9, 9, 9]\n\
         [[contact.pair]]\nbodies = [\"crate\", \"st*\"]\nfriction = 0.1\n"
    );
    let run = run(&text, &world(&format!("<gravity>0 0 -3</gravity>{GROUND}{STEP}{CRATE}"))).unwrap();
    let s = &run.scenario;
    assert_eq!((s.gravity[2], s.floor.height, s.floor.friction), (-1.0, 0.01, Friction::default()));
    assert!(matches!(&s.terrain[..], [_, TerrainSpec::Box(step)] if step.name.as_deref() == Some("step")));
    assert!(matches!(&s.object[..], [ObjectSpec::Box(_)]));
    let note = run.warnings.0.iter().find(|w| w.message.contains("the plane is ignored")).unwrap();
    assert_eq!((note.severity, note.position.unwrap().line), (Severity::Note, 2));
    stiction::assemble::setup(&run, &stiction::robot::load(&run.resolve(&s.robot.model)).unwrap()).unwrap();
}

#[test]
fn what_is_left_out_is_listed_with_its_line() {
    let models = format!(
        "{}\n{}\n<light name=\"sun\" type=\"point\"/>\n{}",
        GROUND.replace("0 0 1<", "0 0.1 1<"),
        STEP.replace("<box><size>0.4 0.4 0.1</size></box>", "<heightmap><uri>h.png</uri></heightmap>"),
        CRATE.replace("<mu>0.4</mu>", "<mu>0.4</mu><mu2>0.5</mu2>")
    );
    let run = run(WORLD, &world(&models)).unwrap();
    let found: Vec<_> = run.warnings.0.iter().map(|w| (w.position.unwrap().line, w.message.as_str())).collect();
    for (line, text) in [
        (2, "only a level plane can be the floor"),
        (6, "there is no "),
        (7, "<light> of <world> is ignored"),
        (10, "mu2 = 0.5 is ignored"),
    ] {
        assert!(found.iter().any(|(l, m)| *l == line && m.contains(text)), "{line} {text}: {found:?}");
    }
    assert!(run.warnings.0.iter().all(|w| w.file.ends_with("w.sdf")));
}

#[test]
fn errors_point_into_the_world_file_or_to_its_key() {
    for (text, models, file, line, message) in [
        (WORLD, STEP.replace("0.4 0.4 0.1", "0.4 0.4"), "w.sdf", 3, "3 finite numbers above 0"),
        (WORLD, STEP.replace("0.4 0.4 0.1", "0.4 0.4 1e9"), "w.sdf", 3, "must be from"),
        (WORLD, format!("{STEP}\n{STEP}"), "w.sdf", 4, "there are two of the name `step`"),
        (WORLD, STEP.replace("<pose>", "<pose relative_to=\"none\">"), "w.sdf", 2, "there is no frame `none`"),
        (WORLD, "</x>".into(), "w.sdf", 2, "not well-formed"),
        (WORLD, "<include><uri>model://none</uri></include>".into(), "w.sdf", 2, "the URI"),
        ("[world]\nfile = \"x.sdf\"", String::new(), "s.toml", 3, "cannot read"),
        ("[world]\nfile = \"w.dae\"", String::new(), "s.toml", 3, "a .sdf, .world, .xml or .mjcf file"),
        ("[world]\nfiles = \"w.sdf\"", String::new(), "s.toml", 3, "files"),
        ("[world]\n", String::new(), "s.toml", 2, "file"),
    ] {
        let wrong = run(text, &world(&models)).expect_err(message);
        let first = &wrong.0[0];
        assert!(first.message.contains(message), "{first}");
        assert!(first.file.ends_with(file) && first.position.unwrap().line == line, "{first}");
    }
    // A missing model that is left out need not exist.
    let text = "[world]\nfile = \"w.sdf\"\nignore = [\"none\"]";
    let run_without = run(text, &world("<include><uri>model://none</uri></include>")).unwrap();
    let is_unmatched = |run: &Run| run.warnings.0.iter().any(|w| w.message.contains("nothing in the world matches"));
    assert!(!is_unmatched(&run_without));
    // An entry that matches nothing is a warning at its place.
    let unmatched = run("[world]\nfile = \"w.sdf\"\nignore = [\"non\"]", &world(STEP)).unwrap();
    assert!(is_unmatched(&unmatched), "{:?}", unmatched.warnings);
}

#[test]
fn a_mesh_of_a_world_is_an_input_of_the_run() {
    let folder = tempfile::tempdir().unwrap();
    let mesh = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    std::fs::create_dir(folder.path().join("meshes")).unwrap();
    std::fs::write(folder.path().join("meshes/t.obj"), mesh).unwrap();
    let shape = "<mesh><uri>meshes/t.obj</uri><scale>0.5 0.5 0.5</scale></mesh>";
    let text = world(&STEP.replace("<box><size>0.4 0.4 0.1</size></box>", shape));
    let run = run_in(folder.path(), WORLD, &text).unwrap();
    assert!(matches!(&run.scenario.terrain[0], TerrainSpec::Mesh(m) if m.file == "meshes/t.obj" && m.scale == 0.5));
    assert_eq!(run.input("terrain.0.file").unwrap().bytes.as_ref(), mesh.as_bytes());
}

/// The greatest value of the picture has the height of `size`, its first line the greatest y.
#[test]
fn a_heightmap_of_a_world_is_a_height_field() {
    let folder = tempfile::tempdir().unwrap();
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    std::fs::copy(here.join("tests/scenario/height_fields/red.png"), folder.path().join("h.png")).unwrap();
    let map = "<heightmap><uri>h.png</uri><size>5 2 0.5</size><pos>0 0 -0.1</pos></heightmap>";
    let text = world(&STEP.replace("<box><size>0.4 0.4 0.1</size></box>", map));
    let run = run_in(folder.path(), WORLD, &text).unwrap();
    assert!(run.warnings.0.is_empty(), "{}", run.warnings);
    let [TerrainSpec::HeightField(field)] = &run.scenario.terrain[..] else { panic!("{:?}", run.scenario.terrain) };
    let rows = field.heights.as_ref().unwrap();
    assert_eq!((rows.len(), rows[0].len(), field.size), (3, 6, Some([5.0, 2.0])));
    assert_eq!((field.position[0], field.rpy), (1.0, [0.0, 0.0, 0.5]));
    assert!((field.position[2] + 0.05).abs() < 1e-15, "{:?}", field.position);
    // Red values of the picture, from its last line to its first.
    let corners = [rows[0][0], rows[0][5], rows[2][0], rows[2][5]].map(|height| height * 253.0 / 0.5);
    for (found, red) in corners.iter().zip([210.0, 51.0, 209.0, 202.0]) {
        assert!((found - red).abs() < 1e-12, "{corners:?}");
    }
    // Without a size above 0 it is left out.
    let run = run_in(folder.path(), WORLD, &text.replace("5 2 0.5", "5 2 -0.5")).unwrap();
    assert!(run.warnings.0[0].message.contains("is not above 0"), "{}", run.warnings);
}

#[test]
fn worlds_can_be_swept() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.sdf"), world(&format!("{GROUND}{STEP}"))).unwrap();
    std::fs::write(folder.path().join("b.sdf"), world(&format!("{GROUND}{CRATE}"))).unwrap();
    let text = "[robot]\nmodel = \"r.urdf\"\n[world]\nfile = \"a.sdf\"\n[sweep]\ngrid = { \"world.file\" = [\"a.sdf\", \"b.sdf\"] }";
    let runs = parse(&folder.path().join("s.toml"), text).unwrap().expand(&[]).unwrap();
    let counts: Vec<_> = runs.iter().map(|run| (run.scenario.terrain.len(), run.scenario.object.len())).collect();
    assert_eq!(counts, [(1, 0), (0, 1)]);
}

#[test]
fn a_ball_rests_on_fixed_round_shapes_of_a_world() {
    let folder = tempfile::tempdir().unwrap();
    // A cylinder whose top is at 1 m.
    let post = r#"<model name="post"><static>1</static><link name="l"><pose>0 0 0.5 0 0 0</pose><collision name="d"><pose>3 0 0 0 0 0</pose>
        <geometry><sphere><radius>0.3</radius></sphere></geometry></collision><collision name="c">
        <geometry><cylinder><radius>0.3</radius><length>1</length></cylinder></geometry></collision></link></model>"#;
    let crate_ = CRATE.replace("0.3 -0.2 0.16 0.1 0.2 0.3", "0 0 1.1 0 0 0");
    std::fs::write(folder.path().join("w.sdf"), world(&format!("{post}{crate_}"))).unwrap();
    let ground = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/ground/ground.urdf");
    let text = format!("{WORLD}\n[robot]\nmodel = {ground:?}\n");
    let scenario = Scenario::parse(folder.path().join("s.toml"), text).unwrap();
    let mut simulation = Simulation::new(scenario.runs().unwrap()[0].setup().unwrap()).unwrap();
    simulation.advance_to(0.3, &mut ()).unwrap();
    let snapshot = simulation.snapshot();
    let at = snapshot.object_poses.last().unwrap().translation.vector;
    assert!((at - Vector3::new(0.0, 0.0, 1.1)).norm() < 1e-9, "{at}");
}

/// The only run of a scenario next to an MJCF file and a mesh.
fn mjcf_run(text: &str, world: &str) -> Result<Run, Diagnostics> {
    let folder = tempfile::tempdir().unwrap();
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    std::fs::write(folder.path().join("w.xml"), world).unwrap();
    std::fs::copy(here.join("tests/scenario/stone.obj"), folder.path().join("stone.obj")).unwrap();
    let text = format!("{ROBOT}{text}\n[robot]\nmodel = {:?}\n", here.join("robots/ground/ground.urdf"));
    let run = parse(&folder.path().join("s.toml"), text)?.expand(&[])?.remove(0);
    stiction::assemble::setup(&run, &stiction::robot::load(&run.resolve(&run.scenario.robot.model)).unwrap())?;
    Ok(run)
}

const MJCF: &str = include_str!("room.xml");

#[test]
fn bodies_of_an_mjcf_file_become_terrain_and_objects() {
    let run = mjcf_run("[world]\nfile = \"w.xml\"\nignore = [\"bell\"]\n", MJCF).unwrap();
    let s = &run.scenario;
    let terrain: Vec<_> = s.terrain.iter().enumerate().map(|(i, t)| (t.name(i), t.entry().position)).collect();
    let expected = [("geom1", [1.0, 0.0, 0.05]), ("stone", [-4.0, 0.0, 0.0]), ("table/top", [0.0, 3.0, 0.5])];
    assert_eq!(terrain, expected.map(|(name, position)| (name.to_owned(), position)));
    assert!(matches!(&s.terrain[0], TerrainSpec::Box(b) if b.size == [0.4, 0.4, 0.1]));
    assert!(matches!(&s.terrain[1], TerrainSpec::Mesh(m) if m.scale == 0.5 && m.file.ends_with("stone.obj")));
    assert!((s.terrain[0].entry().rpy[2] - 30f64.to_radians()).abs() < 1e-15);
    let objects: Vec<_> = s.object.iter().map(|o| (o.entry().name.unwrap(), o.entry().position, o.model())).collect();
    assert_eq!(
        objects,
        [
            ("post", [0.0; 3], Some("w.xml#post::world::post")),
            ("wedge", [0.0; 3], Some("w.xml#wedge::world::wedge")),
            ("table/leg", [0.0, 3.0, 0.5], Some("w.xml#table::table::leg")),
            ("crate", [0.0, -2.0, 0.5], None),
            ("door", [0.0; 3], Some("w.xml#door")),
            ("frame", [0.0, 6.0, 0.5], Some("w.xml#frame")),
        ]
    );
    let ObjectSpec::Box(crate_) = &s.object[3] else { panic!("{:?}", s.object[3]) };
    assert_eq!((crate_.size, crate_.mass), ([0.2; 3], 2.0));
    let friction = |x| Some(Friction::coulomb(x, x));
    assert_eq!(s.object[3].entry().friction, friction(0.4));
    assert_eq!(s.terrain[0].entry().friction, friction(0.6), "that of the class");
    assert_eq!((s.gravity, Some(s.floor.friction)), ([0.0, 0.0, -9.8], friction(0.7)));
}

#[test]
fn parts_of_an_mjcf_file_are_robots_by_name() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/scenario/room.xml");
    let part = |name: &str| stiction::robot::load(Path::new(&format!("{}#{name}", path.display())));
    let shapes = |name: &str| part(name).unwrap().model.links.iter().map(|link| link.collisions.len()).sum::<usize>();
    let sizes = ["crate", "bell", "door", "frame", "post::world::post", "table::table::leg"].map(shapes);
    assert_eq!(sizes, [1, 2, 1, 2, 1, 1]);
    let leg = part("table::table::leg").unwrap().model;
    assert_eq!((leg.base, leg.links.len(), leg.links[0].mass), (stiction::robot::Base::Fixed, 1, 0.0));
    assert_eq!(leg.links[0].collisions[0].pose.translation.vector, Vector3::new(0.0, 0.0, -0.25));
    let door = part("door").unwrap().model;
    assert_eq!(door.links.iter().map(|link| link.name.as_str()).collect::<Vec<_>>(), ["world", "door"]);
    for (name, text) in [("crat", "did you mean `crate`?"), ("leaf", "no body `leaf` under the world")] {
        let error = part(name).unwrap_err().to_string();
        assert!(error.contains(text) && error.contains("room.xml:8:"), "{error}");
    }
}

#[test]
fn what_an_mjcf_world_cannot_give_is_listed_with_its_line() {
    let text = "<mujoco>\n<asset><hfield name=\"h\" file=\"none.png\" size=\"1 1 1 1\"/></asset>\n<worldbody>\n\
        <geom type=\"hfield\" hfield=\"h\"/>\n<geom type=\"plane\" size=\"1 1 1\" euler=\"5 0 0\"/>\n\
        <body mocap=\"true\">\n<geom size=\"1\"/></body>\n</worldbody>\n\
        <equality>\n<weld body1=\"body1\"/></equality></mujoco>";
    let run = mjcf_run("[world]\nfile = \"w.xml\"\n", text).unwrap();
    let found: Vec<_> = run.warnings.0.iter().map(|w| (w.position.unwrap().line, w.message.as_str())).collect();
    for (line, text) in [
        (4, "a height field is left out: cannot read"),
        (5, "only a level plane can be the floor"),
        (6, "although it is a mocap body"),
    ] {
        assert!(found.iter().any(|(l, m)| *l == line && m.contains(text)), "{line} {text}: {found:?}");
    }
    let wrong = mjcf_run("[world]\nfile = \"w.xml\"\n", &text.replace("euler=\"5 0 0\"", "euler=\"5 0\"")).unwrap_err();
    assert!(wrong.to_string().contains("w.xml:5:"), "{wrong}");
}

#[test]
fn elements_without_effect_in_an_mjcf_world_are_listed_with_their_line() {
    let text = "<mujoco>\n<asset>\n\
        <texture name=\"t\" type=\"skybox\" builtin=\"flat\" width=\"4\" height=\"4\"/></asset>\n<worldbody>\n<light pos=\"0 0 3\"/><light/>\n<camera/>\n<geom name=\"g\" size=\"0.1\" friction=\"0.3\"/>\n\
        <body name=\"a\" pos=\"0 0 1\"><freejoint/><geom name=\"ga\" size=\"0.1\"/><site name=\"s\"/></body>\n\
        <body name=\"b\" pos=\"0 0 2\"><freejoint/><geom name=\"gb\" size=\"0.1\"/></body>\n</worldbody>\n\
        <contact>\n<pair geom1=\"ga\" geom2=\"gb\"/>\n<exclude body1=\"a\" body2=\"b\"/></contact>\n\
        <sensor>\n<gyro site=\"s\"/>\n<gyro site=\"s\"/></sensor>\n<tendon/>\n\
        <keyframe>\n<key name=\"k\"/></keyframe>\n<equality>\n<weld body1=\"a\" body2=\"b\"/>\n<connect body1=\"a\" anchor=\"0 0 0\"/></equality></mujoco>";
    let run = mjcf_run("[world]\nfile = \"w.xml\"\n", text).unwrap();
    let found: Vec<_> = run.warnings.0.iter().map(|w| (w.position.unwrap().line, w.message.as_str())).collect();
    for (line, text) in [
        (3, "<texture> is ignored"),
        (5, "<light> is ignored (2 times)"),
        (6, "<camera> is ignored"),
        (12, "<pair> of <contact> is ignored"),
        (13, "<exclude> of <contact> is ignored"),
        (15, "sensors <gyro> are ignored (2 times)"),
        (17, "<tendon> is ignored"),
        (19, "of <key> only the positions of joints count"),
        (21, "<weld> between different models of a world is ignored"),
    ] {
        assert!(found.iter().any(|(l, m)| *l == line && m.contains(text)), "{line} {text}: {found:?}");
    }
    assert!(!found.iter().any(|(line, _)| [7, 22].contains(line)), "{found:?}");
    // A body that a constraint holds is a model, whose reader knows the constraint.
    let models: Vec<_> = run.scenario.object.iter().map(|object| object.model()).collect();
    assert_eq!(models, [Some("w.xml#g::world::g"), Some("w.xml#a"), None]);
}

/// Friction and gravity of the file count for a world, and notices of its parts say so.
#[test]
fn notices_of_parts_of_an_mjcf_world_are_true() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/scenario/room.xml");
    let messages = |name: &str| {
        let robot = stiction::robot::load(Path::new(&format!("{}{name}", path.display()))).unwrap();
        robot.notices.into_iter().map(|notice| notice.message).collect::<Vec<_>>().join("\n")
    };
    let part = messages("#frame");
    assert!(part.contains("attribute `friction` of <geom> counts only for a `[world]`"), "{part}");
    assert!(part.contains("<option> is ignored, except for gravity, which counts for a `[world]`"), "{part}");
    assert!(!part.contains("`friction` of <geom> is ignored"), "{part}");
}

//! Tests of invalid scenario and robot files: each is refused with exit code 2 before anything runs
//! or is written. The message contains the line of the error. The mark `@@` is on that line, and is
//! removed before the file is written.

use std::fs;

use super::Place;

/// An invalid file: description, name of the file that it replaces, and text with the mark.
struct Invalid {
    what: &'static str,
    file: &'static str,
    text: String,
}

fn invalid(what: &'static str, file: &'static str, text: impl Into<String>) -> Invalid {
    Invalid { what, file, text: text.into() }
}

/// A scenario of the block followed by an invalid part.
fn invalid_scenario(what: &'static str, text: &str) -> Invalid {
    invalid(what, "s.toml", format!("[robot]\nmodel = \"block/block.toml\"\n{text}\n"))
}

/// The block's robot file with `from` replaced by `to`.
fn invalid_robot(what: &'static str, from: &str, to: &str) -> Invalid {
    invalid(what, "block/block.toml", replaced("block.toml", from, to))
}

/// The block's URDF with `from` replaced by `to`.
fn invalid_urdf(what: &'static str, from: &str, to: &str) -> Invalid {
    invalid(what, "block/block.urdf", replaced("block.urdf", from, to))
}

fn replaced(file: &str, from: &str, to: &str) -> String {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/block").join(file);
    let text = fs::read_to_string(path).unwrap();
    assert!(text.contains(from), "{file} has no {from}");
    text.replacen(from, to, 1)
}

/// The block's URDF with an arm on a joint of the given type, one element per line.
fn arm(what: &'static str, kind: &str, parent: &str, content: &str) -> Invalid {
    let inertia = r#"<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/>"#;
    let arm = format!(
        "<link name=\"arm\"><inertial><mass value=\"1\"/>{inertia}</inertial></link>\n\
         <joint name=\"hinge\" type={kind}\n{parent}\n<child link=\"arm\"/>\n{content}\n</joint>\n</robot>"
    );
    invalid_urdf(what, "</robot>", &arm)
}

const PARENT: &str = "<parent link=\"block\"/>";

fn table() -> Vec<Invalid> {
    vec![
        // Scenario: syntax and keys.
        invalid("TOML syntax", "s.toml", "[robot]\nmodel = block/block.toml #@@\n"),
        invalid("no robot", "s.toml", "duration = 1.0 #@@\n"),
        invalid("format version", "s.toml", "schema = 99 #@@\n[robot]\nmodel = \"block/block.toml\"\n"),
        invalid_scenario("unknown table", "[flor] #@@\nfriction = 0.5"),
        invalid_scenario("unknown key", "[floor]\nfrction = 0.5 #@@"),
        invalid_scenario("key twice", "[floor]\nheight = 0\nheight = 1 #@@"),
        // Scenario: types and ranges.
        invalid_scenario("wrong type", "[floor]\nheight = \"low\" #@@"),
        invalid_scenario("unknown word", "[contact]\nmethod = \"exakt\" #@@"),
        invalid_scenario("no such method", "[self_collision]\nmethod = 5 #@@"),
        invalid_scenario("negative friction", "[floor]\nfriction = -0.1 #@@"),
        invalid_scenario("not finite", "[floor]\nheight = inf #@@"),
        invalid_scenario("bad angle", "[floor]\nrpy = [0, \"30 dge\", 0] #@@"),
        invalid_scenario("unknown task", "[[task]]\ntype = \"posutre\" #@@"),
        invalid_scenario("unknown metric", "[[expect]]\nmetric = \"final_bas_x\" #@@\nmin = 0"),
        // Scenario: sweeps.
        invalid_scenario("swept key unknown", "[sweep]\ngrid = { \"floor.frction\" = [0.1, 0.2] } #@@"),
        invalid_scenario("swept value wrong", "[sweep.grid]\n\"floor.friction\" = [\n0.1,\n-0.2, #@@\n]"),
        invalid_scenario("too many runs", "[sweep]\nrepeat = 20000 #@@"),
        invalid_scenario(
            "swept column",
            "[sweep.grid]\nintegrator = [{ method = \"dopri5\" }, { method = \"semi-implicit\" }] #@@",
        ),
        // Scenario against robot.
        invalid("robot not there", "s.toml", "[robot]\nmodel = \"block/blok.toml\" #@@\n"),
        invalid_scenario("no such joint", "posture = { knee = 1.0 } #@@"),
        invalid_scenario(
            "no such link",
            "[[force]]\ntype = \"push\"\nlink = \"torso\" #@@\nforce = [1, 0, 0]\nduration = 0.1",
        ),
        invalid_scenario(
            "no such sole",
            "[contact]\nforced = [{ sole = \"left\", state = \"face-static\", to = 1 }] #@@",
        ),
        invalid_scenario("walk on one sole", "[[task]]\ntype = \"walk\" #@@"),
        invalid_scenario(
            "no such joint to balance",
            "[[task]]\ntype = \"balance\"\ncontrol = \"position\"\nposition = { mobility = { knee = 1.0 } } #@@",
        ),
        invalid_scenario("stepping method, adaptive integrator", "[contact]\nmethod = \"lcp\" #@@"),
        invalid_scenario(
            "stepping method, restitution",
            "[integrator]\nmethod = \"semi-implicit\"\n[contact]\nmethod = \"ncp\"\nrestitution = 0.5 #@@",
        ),
        invalid_scenario(
            "stepping method, imposed state",
            "[integrator]\nmethod = \"semi-implicit\"\n[contact]\nmethod = \"ncp\"\nforced = [{ sole = \"bottom\", state = \"face-static\" }] #@@",
        ),
        invalid_scenario(
            "no such state",
            "[contact]\nforced = [{ sole = \"bottom\", state = \"edge-9-static\", to = 1 }] #@@",
        ),
        invalid_scenario(
            "restitution by an event",
            "[integrator]\nmethod = \"semi-implicit\"\n[[event]]\nat = 0.1\nset = { \"contact.restitution\" = 0.5 } #@@",
        ),
        invalid_scenario(
            "friction without joints",
            "[[force]] #@@\ntype = \"joint-friction\"\nall = { coulomb = 1.0 }",
        ),
        invalid_scenario("name with a dot", "[[task]]\ntype = \"posture\"\n[task.joints]\n\"left.knee\" = 0.1 #@@"),
        invalid_scenario("joint with a dot", "[robot.joint]\n\"left.knee\" = { kp = 1.0 } #@@"),
        invalid_scenario("no place above an upright floor", "[floor]\nrpy = [\"90 deg\", 0, 0] #@@"),
        invalid_scenario(
            "payload of two sizes",
            "payload = [{ link = \"block\", mass = 1, inertia = [1, 1, 1, 0, 0, 0], size = [1, 1, 1] }] #@@",
        ),
        invalid_scenario("payload on no link", "payload = [{ link = \"torso\", mass = 1.0 }] #@@"),
        // Robot file.
        invalid_robot("robot: TOML syntax", "name = \"bottom\"", "name = bottom #@@"),
        invalid_robot("robot: unknown key", "name = \"bottom\"", "nam = \"bottom\" #@@"),
        invalid_robot("robot: no URDF there", "urdf = \"block.urdf\"", "urdf = \"blok.urdf\" #@@"),
        invalid_robot("robot: sole on no link", "link = \"block\"", "link = \"blok\" #@@"),
        invalid_robot(
            "robot: crossed polygon",
            "[0.1, 0.1, -0.05], [-0.1, 0.1, -0.05]]",
            "[-0.1, 0.1, -0.05], [0.1, 0.1, -0.05]] #@@",
        ),
        invalid_robot("robot: no such joint", "[[sole]]", "[joint.knee] #@@\nkp = 1.0\n[[sole]]"),
        invalid_robot("robot: no such kinematic joint", "[[sole]]", "kinematic = [\"eye*\"] #@@\n[[sole]]"),
        // URDF.
        invalid_urdf("URDF: XML syntax", "</inertial>", "</inertal><!--@@-->"),
        invalid_urdf("URDF: negative mass", "<mass value=\"1\"/>", "<mass value=\"-1\"/><!--@@-->"),
        invalid_urdf("URDF: no mass", "<mass value=\"1\"/>", "<mass value=\"0\"/><!--@@-->"),
        invalid_urdf("URDF: no number", "<mass value=\"1\"/>", "<mass value=\"heavy\"/><!--@@-->"),
        invalid_urdf(
            "URDF: comma in place of a number",
            "<box size=\"0.2 0.2 0.1\"/></geometry>\n      <material",
            "<box size=\"0.2,, 0.1\"/></geometry><!--@@-->\n      <material",
        ),
        invalid_urdf("URDF: impossible inertia", "izz=\"0.0066666666666666667\"/>", "izz=\"1.0\"/><!--@@-->"),
        arm("URDF: one limit", "\"revolute\">", PARENT, "<axis xyz=\"0 1 0\"/><limit lower=\"-1\"/><!--@@-->"),
        arm("URDF: joint type", "\"spherical\"><!--@@-->", PARENT, "<axis xyz=\"0 1 0\"/>"),
        arm("URDF: no such parent", "\"continuous\">", "<parent link=\"blok\"/><!--@@-->", ""),
    ]
}

#[test]
fn every_invalid_file_is_refused_at_its_line_and_nothing_is_written() {
    let table = table();
    assert!(table.len() >= 20);
    let mut wrong = Vec::new();
    for Invalid { what, file, text } in table {
        let place = Place::new();
        place.block("s.toml", "");
        let at = text.find("@@").unwrap_or_else(|| panic!("{what}: no mark"));
        let line = text[..at].matches('\n').count() + 1;
        let unmarked = text.replace(" #@@", "").replace("<!--@@-->", "");
        place.write(file, unmarked);
        for arguments in [&["run", "s.toml", "-o", "out"][..], &["check", "s.toml"]] {
            let done = place.runner(arguments);
            let named = done.stderr.contains(&format!("{file}:{line}:"));
            let written = place.path("out").exists() || place.path("results").exists();
            if done.code != Some(2) || !named || written || !done.stdout.is_empty() {
                wrong.push(format!(
                    "{what}: exit {:?}, expected {file}:{line}, written: {written}\n{}{}",
                    done.code, done.stdout, done.stderr
                ));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n\n"));
}

#[test]
fn the_unmodified_files_of_the_table_are_valid() {
    let place = Place::new();
    place.block("s.toml", "");
    place.runner(&["check", "s.toml"]).exits(0);
    let arm = arm("", "\"continuous\">", PARENT, "<axis xyz=\"0 1 0\"/>");
    place.write(arm.file, arm.text);
    place.runner(&["check", "s.toml"]).exits(0);
}

#[test]
fn text_that_is_not_utf8_is_refused() {
    let place = Place::new();
    place.write("s.toml", b"[robot]\nmodel = \"\xff\"\n");
    let done = place.runner(&["s.toml"]).exits(2);
    assert!(done.stderr.contains("s.toml:2:") && done.stderr.contains("UTF-8"), "{}", done.stderr);
}

#[test]
fn one_invalid_file_among_valid_files_prevents_all_runs() {
    let place = Place::new();
    place.block("a.toml", "").block("b.toml", "[floor]\nheight = \"low\"\n").block("c.toml", "postur = {}\n");
    let done = place.runner(&["a.toml", "b.toml", "c.toml"]).exits(2);
    assert!(
        done.stderr.contains("b.toml:4:") && done.stderr.contains("c.toml:3:"),
        "all files are reported: {}",
        done.stderr
    );
    assert!(done.stderr.contains("2 errors"), "{}", done.stderr);
    assert!(!place.path("results").exists());
}

#[test]
fn an_invalid_override_is_reported_as_set() {
    let place = Place::new();
    place.block("a.toml", "").block("b.toml", "");
    let done = place.runner(&["a.toml", "b.toml", "--set", "floor.friction=-1"]).exits(2);
    assert!(done.stderr.contains("--set:1:"), "{}", done.stderr);
    assert!(done.stderr.contains("1 error\n"), "reported once for both files: {}", done.stderr);
}

#[test]
fn names_with_the_same_results_folder_are_refused() {
    let place = Place::new();
    place.block("a.toml", "");
    place.write("b/a.toml", "[robot]\nmodel = \"../block/block.toml\"\n");
    let done = place.runner(&["a.toml", "b/a.toml"]).exits(2);
    assert!(done.stderr.contains("a.toml and b/a.toml are both scenario `a`"), "{}", done.stderr);
    assert!(done.stderr.contains("--> b/a.toml") && done.stderr.contains("rename one of them"), "{}", done.stderr);
    let done = place.runner(&["check", "a.toml", "b/a.toml", "--message-format", "json"]).exits(2);
    let message: serde_json::Value = serde_json::from_str(done.stdout.lines().next().unwrap()).unwrap();
    assert_eq!(message["file"], "b/a.toml");
    assert!(message["help"].as_str().unwrap().contains("an --output of its own"), "{message}");
    place.block("summary.csv.toml", "");
    let done = place.runner(&["summary.csv.toml"]).exits(2);
    assert!(done.stderr.contains("`summary.csv` is a file of the results"), "{}", done.stderr);
    assert!(!place.path("results").exists());
    // The same file with two paths is one scenario.
    let done = place.runner(&["check", "a.toml", "./a.toml"]).exits(0);
    assert!(done.stdout.contains("1 scenario, 1 run"), "{}", done.stdout);
}

#[test]
fn two_robots_with_equal_bytes_give_equal_runs() {
    let place = Place::new();
    for name in ["block.toml", "block.urdf"] {
        place.write(&format!("twin/{name}"), fs::read(place.path("block").join(name)).unwrap());
    }
    place.block("s.toml", "[sweep]\ngrid = { \"robot.model\" = [\"block/block.toml\", \"twin/block.toml\"] }\n");
    let done = place.runner(&["s.toml"]).exits(2);
    assert!(done.stderr.contains("runs 1 and 2 of s.toml are the same"), "{}", done.stderr);
}

#[test]
fn too_many_runs_over_all_files_are_refused() {
    let place = Place::new();
    let sweep = "[sweep]\nrepeat = 3\n";
    place.block("a.toml", sweep).block("b.toml", sweep);
    place.runner(&["check", "a.toml", "b.toml", "--max-runs", "6"]).exits(0);
    let done = place.runner(&["check", "a.toml", "b.toml", "--max-runs", "5"]).exits(2);
    assert!(done.stderr.contains("6 runs, 5 are allowed"), "{}", done.stderr);
}

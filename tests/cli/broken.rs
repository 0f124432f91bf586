//! Broken scenario and robot files: each is refused with exit code 2 before anything runs or is written, and the line
//! to look at is named. The mark `@@` stands on that line and is taken out before the file is written.

use std::fs;

use super::Place;

/// What is broken, the file to write in place of the sound one, and its text with the mark.
struct Broken {
    what: &'static str,
    file: &'static str,
    text: String,
}

fn broken(what: &'static str, file: &'static str, text: impl Into<String>) -> Broken {
    Broken { what, file, text: text.into() }
}

/// A scenario of the block with something broken below.
fn scenario(what: &'static str, text: &str) -> Broken {
    broken(what, "s.toml", format!("[robot]\nmodel = \"block/block.toml\"\n{text}\n"))
}

/// The block's robot file with something in place of `from`.
fn robot(what: &'static str, from: &str, to: &str) -> Broken {
    broken(what, "block/block.toml", replaced("block.toml", from, to))
}

/// The block's URDF with something in place of `from`.
fn urdf(what: &'static str, from: &str, to: &str) -> Broken {
    broken(what, "block/block.urdf", replaced("block.urdf", from, to))
}

fn replaced(file: &str, from: &str, to: &str) -> String {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/block").join(file);
    let text = fs::read_to_string(path).unwrap();
    assert!(text.contains(from), "{file} has no {from}");
    text.replacen(from, to, 1)
}

/// The block's URDF with an arm on a joint of the given type, element by element.
fn arm(what: &'static str, kind: &str, parent: &str, content: &str) -> Broken {
    let inertia = r#"<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/>"#;
    let arm = format!(
        "<link name=\"arm\"><inertial><mass value=\"1\"/>{inertia}</inertial></link>\n\
         <joint name=\"hinge\" type={kind}\n{parent}\n<child link=\"arm\"/>\n{content}\n</joint>\n</robot>"
    );
    urdf(what, "</robot>", &arm)
}

const PARENT: &str = "<parent link=\"block\"/>";

fn table() -> Vec<Broken> {
    vec![
        // Scenario: syntax and keys.
        broken("TOML syntax", "s.toml", "[robot]\nmodel = block/block.toml #@@\n"),
        broken("no robot", "s.toml", "duration = 1.0 #@@\n"),
        broken("format version", "s.toml", "schema = 99 #@@\n[robot]\nmodel = \"block/block.toml\"\n"),
        scenario("unknown table", "[flor] #@@\nfriction = 0.5"),
        scenario("unknown key", "[floor]\nfrction = 0.5 #@@"),
        scenario("key twice", "[floor]\nheight = 0\nheight = 1 #@@"),
        // Scenario: types and ranges.
        scenario("wrong type", "[floor]\nheight = \"low\" #@@"),
        scenario("unknown word", "[contact]\nmethod = \"exakt\" #@@"),
        scenario("no such method", "[self_collision]\nmethod = 5 #@@"),
        scenario("negative friction", "[floor]\nfriction = -0.1 #@@"),
        scenario("not finite", "[floor]\nheight = inf #@@"),
        scenario("bad angle", "[floor]\nrpy = [0, \"30 dge\", 0] #@@"),
        scenario("unknown task", "[[task]]\ntype = \"posutre\" #@@"),
        scenario("unknown metric", "[[expect]]\nmetric = \"final_bas_x\" #@@\nmin = 0"),
        // Scenario: sweeps.
        scenario("swept key unknown", "[sweep]\ngrid = { \"floor.frction\" = [0.1, 0.2] } #@@"),
        scenario("swept value wrong", "[sweep.grid]\n\"floor.friction\" = [\n0.1,\n-0.2, #@@\n]"),
        scenario("too many runs", "[sweep]\nrepeat = 20000 #@@"),
        scenario(
            "swept column",
            "[sweep.grid]\nintegrator = [{ method = \"dopri5\" }, { method = \"semi-implicit\" }] #@@",
        ),
        // Scenario against robot.
        broken("robot not there", "s.toml", "[robot]\nmodel = \"block/blok.toml\" #@@\n"),
        scenario("no such joint", "posture = { knee = 1.0 } #@@"),
        scenario("no such link", "[[force]]\ntype = \"push\"\nlink = \"torso\" #@@\nforce = [1, 0, 0]\nduration = 0.1"),
        scenario("no such sole", "[contact]\nforced = [{ sole = \"left\", state = \"face-static\", to = 1 }] #@@"),
        scenario("walk on one sole", "[[task]]\ntype = \"walk\" #@@"),
        scenario(
            "no such joint to balance",
            "[[task]]\ntype = \"balance\"\ncontrol = \"position\"\nposition = { mobility = { knee = 1.0 } } #@@",
        ),
        scenario("stepping method, adaptive integrator", "[contact]\nmethod = \"lcp\" #@@"),
        scenario(
            "stepping method, restitution",
            "[integrator]\nmethod = \"semi-implicit\"\n[contact]\nmethod = \"ncp\"\nrestitution = 0.5 #@@",
        ),
        scenario(
            "stepping method, imposed state",
            "[integrator]\nmethod = \"semi-implicit\"\n[contact]\nmethod = \"ncp\"\nforced = [{ sole = \"bottom\", state = \"face-static\" }] #@@",
        ),
        scenario("no such state", "[contact]\nforced = [{ sole = \"bottom\", state = \"edge-9-static\", to = 1 }] #@@"),
        scenario(
            "restitution by an event",
            "[integrator]\nmethod = \"semi-implicit\"\n[[event]]\nat = 0.1\nset = { \"contact.restitution\" = 0.5 } #@@",
        ),
        scenario("friction without joints", "[[force]] #@@\ntype = \"joint-friction\"\nall = { coulomb = 1.0 }"),
        scenario("name with a dot", "[[task]]\ntype = \"posture\"\n[task.joints]\n\"left.knee\" = 0.1 #@@"),
        scenario("joint with a dot", "[robot.joint]\n\"left.knee\" = { kp = 1.0 } #@@"),
        scenario("no place above an upright floor", "[floor]\nrpy = [\"90 deg\", 0, 0] #@@"),
        scenario(
            "payload of two sizes",
            "payload = [{ link = \"block\", mass = 1, inertia = [1, 1, 1, 0, 0, 0], size = [1, 1, 1] }] #@@",
        ),
        scenario("payload on no link", "payload = [{ link = \"torso\", mass = 1.0 }] #@@"),
        // Robot file.
        robot("robot: TOML syntax", "name = \"bottom\"", "name = bottom #@@"),
        robot("robot: unknown key", "name = \"bottom\"", "nam = \"bottom\" #@@"),
        robot("robot: no URDF there", "urdf = \"block.urdf\"", "urdf = \"blok.urdf\" #@@"),
        robot("robot: sole on no link", "link = \"block\"", "link = \"blok\" #@@"),
        robot(
            "robot: crossed polygon",
            "[0.1, 0.1, -0.05], [-0.1, 0.1, -0.05]]",
            "[-0.1, 0.1, -0.05], [0.1, 0.1, -0.05]] #@@",
        ),
        robot("robot: no such joint", "[[sole]]", "[joint.knee] #@@\nkp = 1.0\n[[sole]]"),
        robot("robot: no such kinematic joint", "[[sole]]", "kinematic = [\"eye*\"] #@@\n[[sole]]"),
        // URDF.
        urdf("URDF: XML syntax", "</inertial>", "</inertal><!--@@-->"),
        urdf("URDF: negative mass", "<mass value=\"1\"/>", "<mass value=\"-1\"/><!--@@-->"),
        urdf("URDF: no mass", "<mass value=\"1\"/>", "<mass value=\"0\"/><!--@@-->"),
        urdf("URDF: no number", "<mass value=\"1\"/>", "<mass value=\"heavy\"/><!--@@-->"),
        urdf(
            "URDF: comma in place of a number",
            "<box size=\"0.2 0.2 0.1\"/></geometry>\n      <material",
            "<box size=\"0.2,, 0.1\"/></geometry><!--@@-->\n      <material",
        ),
        urdf("URDF: impossible inertia", "izz=\"0.0066666666666666667\"/>", "izz=\"1.0\"/><!--@@-->"),
        arm("URDF: one limit", "\"revolute\">", PARENT, "<axis xyz=\"0 1 0\"/><limit lower=\"-1\"/><!--@@-->"),
        arm("URDF: joint type", "\"spherical\"><!--@@-->", PARENT, "<axis xyz=\"0 1 0\"/>"),
        arm("URDF: no such parent", "\"continuous\">", "<parent link=\"blok\"/><!--@@-->", ""),
    ]
}

#[test]
fn every_broken_file_is_refused_at_its_line_and_nothing_is_written() {
    let table = table();
    assert!(table.len() >= 20);
    let mut wrong = Vec::new();
    for Broken { what, file, text } in table {
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
                    "{what}: exit {:?}, wanted {file}:{line}, written: {written}\n{}{}",
                    done.code, done.stdout, done.stderr
                ));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n\n"));
}

#[test]
fn the_sound_files_that_the_table_breaks_are_sound() {
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
fn one_broken_file_among_sound_ones_stops_all() {
    let place = Place::new();
    place.block("a.toml", "").block("b.toml", "[floor]\nheight = \"low\"\n").block("c.toml", "postur = {}\n");
    let done = place.runner(&["a.toml", "b.toml", "c.toml"]).exits(2);
    assert!(done.stderr.contains("b.toml:4:") && done.stderr.contains("c.toml:3:"), "all are told: {}", done.stderr);
    assert!(done.stderr.contains("2 errors"), "{}", done.stderr);
    assert!(!place.path("results").exists());
}

#[test]
fn an_override_is_blamed_by_its_name() {
    let place = Place::new();
    place.block("a.toml", "").block("b.toml", "");
    let done = place.runner(&["a.toml", "b.toml", "--set", "floor.friction=-1"]).exits(2);
    assert!(done.stderr.contains("--set:1:"), "{}", done.stderr);
    assert!(done.stderr.contains("1 error\n"), "said once for both files: {}", done.stderr);
}

#[test]
fn names_that_would_share_a_place_in_the_results_are_refused() {
    let place = Place::new();
    place.block("a.toml", "");
    place.write("b/a.toml", "[robot]\nmodel = \"../block/block.toml\"\n");
    let done = place.runner(&["a.toml", "b/a.toml"]).exits(2);
    assert!(done.stderr.contains("a.toml and b/a.toml are both scenario `a`"), "{}", done.stderr);
    assert!(done.stderr.contains("--> b/a.toml") && done.stderr.contains("rename one of them"), "{}", done.stderr);
    let done = place.runner(&["check", "a.toml", "b/a.toml", "--message-format", "json"]).exits(2);
    let told: serde_json::Value = serde_json::from_str(done.stdout.lines().next().unwrap()).unwrap();
    assert_eq!(told["file"], "b/a.toml");
    assert!(told["help"].as_str().unwrap().contains("an --output of its own"), "{told}");
    place.block("summary.csv.toml", "");
    let done = place.runner(&["summary.csv.toml"]).exits(2);
    assert!(done.stderr.contains("`summary.csv` is a file of the results"), "{}", done.stderr);
    assert!(!place.path("results").exists());
    // The same file by two names is one scenario.
    let done = place.runner(&["check", "a.toml", "./a.toml"]).exits(0);
    assert!(done.stdout.contains("1 scenario, 1 run"), "{}", done.stdout);
}

#[test]
fn two_robots_of_equal_bytes_make_equal_runs() {
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

//! Tests of `--junit`: the report for continuous integration, read with an independent XML parser.

use roxmltree::{Document, Node};

use super::Place;

/// Two runs: the first passes, the second fails two of three expectations.
const SWEEP: &str = "[[expect]]\nmetric = \"duration_s\"\nmax = 0.15\n[[expect]]\nmetric = \"final_base_z\"\nvalue = 0.05\ntolerance = 1e-3\n\
    [[expect]]\nmetric = \"final_base_x\"\nvalue = 1.0\ntolerance = 10.0\n\
    [sweep]\nlist = [{ duration = 0.1 }, { duration = 0.2, \"floor.height\" = 0.5 }]\n";

fn read(place: &Place, file: &str) -> String {
    std::fs::read_to_string(place.path(file)).unwrap()
}

fn cases<'a>(document: &'a Document<'_>) -> Vec<Node<'a, 'a>> {
    document.descendants().filter(|n| n.has_tag_name("testcase")).collect()
}

fn property<'a>(case: Node<'a, 'a>, name: &str) -> Option<&'a str> {
    let found = case.descendants().find(|n| n.has_tag_name("property") && n.attribute("name") == Some(name));
    found.and_then(|n| n.attribute("value"))
}

fn child<'a>(case: Node<'a, 'a>, name: &str) -> Option<Node<'a, 'a>> {
    case.children().find(|n| n.has_tag_name(name))
}

/// Counts of tests, failures, errors and skipped tests.
fn counts(node: Node<'_, '_>) -> [u32; 4] {
    ["tests", "failures", "errors", "skipped"].map(|name| node.attribute(name).unwrap().parse().unwrap())
}

#[test]
fn each_scenario_is_a_suite_and_each_run_a_case_with_its_failures() {
    let place = Place::new();
    // The second run has a floor half a metre higher, so its base ends half a metre higher.
    place.block("sweep.toml", SWEEP).block("rest.toml", "");
    let done =
        place.runner(&["sweep.toml", "rest.toml", "--set", "log.rate=0", "--junit", "deep/er/junit.xml"]).exits(1);
    assert!(done.stdout.contains("  deep/er/junit.xml\n"), "{}", done.stdout);
    let text = read(&place, "deep/er/junit.xml");
    let document = Document::parse(&text).unwrap();
    let root = document.root_element();
    assert!(root.has_tag_name("testsuites"));
    assert_eq!(counts(root), [3, 1, 0, 0]);
    let suites: Vec<_> = root.children().filter(Node::is_element).collect();
    let named: Vec<_> = suites.iter().map(|s| (s.attribute("name").unwrap(), counts(*s))).collect();
    assert_eq!(named, [("sweep", [2, 1, 0, 0]), ("rest", [1, 0, 0, 0])]);

    let cases = cases(&document);
    let names: Vec<_> =
        cases.iter().map(|c| (c.attribute("classname").unwrap(), c.attribute("name").unwrap())).collect();
    // Values that a run of the list omits are the defaults.
    let expected = ["duration=0.1 floor.height=0.0", "duration=0.2 floor.height=0.5"];
    assert_eq!(names, [("sweep", expected[0]), ("sweep", expected[1]), ("rest", "rest")]);
    let summary = place.summary("results");
    for (case, (key, wall)) in cases.iter().zip(summary.column("key").iter().zip(summary.numbers("wall_s"))) {
        assert_eq!(property(*case, "key"), Some(*key));
        assert!(place.path(property(*case, "folder").unwrap()).join("run.json").is_file());
        let time: f64 = case.attribute("time").unwrap().parse().unwrap();
        assert!((time - wall).abs() <= 0.5e-3, "{time} and {wall}: times are rounded to milliseconds");
    }
    assert!(child(cases[0], "failure").is_none() && child(cases[0], "error").is_none());
    let failure = child(cases[1], "failure").unwrap();
    assert_eq!(failure.attribute("type"), Some("expectation"));
    let message = failure.attribute("message").unwrap();
    assert!(message.starts_with("2 broken expectations of 3: "), "{message}");
    let lines: Vec<&str> = failure.text().unwrap().lines().collect();
    assert_eq!(lines.len(), 2, "{lines:?}");
    assert!(lines[0].starts_with("duration_s: measured 0.2, expected at most 0.15, error 0.05"), "{}", lines[0]);
    assert!(lines[1].starts_with("final_base_z: measured 0.55"), "{}", lines[1]);
    assert!(lines[1].contains("expected 0.05 +- 0.001, error 0.5"), "{}", lines[1]);
}

#[test]
fn unfinished_runs_are_errors_and_runs_not_started_are_skipped() {
    let place = Place::new();
    place.block("fast.toml", "base = { linear_velocity = [1e7, 0, 0] }\n[sweep]\nrepeat = 3\n");
    let done = place.runner(&["fast.toml", "-j", "1", "--max-fail", "2", "--junit", "junit.xml"]).exits(3);
    assert!(done.stdout.contains("1 run not started"), "{}", done.stdout);
    let text = read(&place, "junit.xml");
    let document = Document::parse(&text).unwrap();
    assert_eq!(counts(document.root_element()), [3, 0, 2, 1]);
    let cases = cases(&document);
    assert_eq!(cases.iter().map(|c| c.attribute("name").unwrap()).collect::<Vec<_>>(), ["seed=1", "seed=2", "seed=3"]);
    let error = child(cases[0], "error").unwrap();
    assert_eq!(error.attribute("type"), Some("diverged"));
    assert!(error.attribute("message").unwrap().contains("velocity of base is "));
    assert_eq!(child(cases[2], "skipped").unwrap().attribute("message"), Some("not started"));
    assert_eq!(cases[2].attribute("time"), None);

    // A reference that times out leaves its run uncompared. Suites are in the order of the
    // scenarios.
    place.block("early.toml", "").block("late.toml", "[compare]\nreference = { duration = 1e9 }\n");
    let short = ["--set", "duration=0.1", "--set", "log.rate=1", "--timeout", "2", "--junit", "late.xml"];
    place.runner(&[&["early.toml", "late.toml"], &short[..]].concat()).exits(3);
    let text = read(&place, "late.xml");
    let document = Document::parse(&text).unwrap();
    assert_eq!(counts(document.root_element()), [3, 0, 1, 0]);
    let suites: Vec<_> = document.root_element().children().filter_map(|n| n.attribute("name")).collect();
    assert_eq!(suites, ["early", "late"]);
    let reference = document.descendants().find(|n| n.has_tag_name("error")).unwrap().parent().unwrap();
    assert!(reference.attribute("name").unwrap().starts_with("reference "));
    assert_eq!(property(reference, "outcome"), Some("timed-out"));
    let run =
        document.descendants().find(|n| n.attribute("name") == Some("late") && n.has_tag_name("testcase")).unwrap();
    assert!(child(run, "system-out").unwrap().text().unwrap().starts_with("not compared: its reference "));
}

#[test]
fn names_and_messages_are_escaped() {
    let place = Place::new();
    place.block("a&b.toml", "[sweep]\ngrid = { description = [\"x < \\\"y\\\" & 'z'\", \"tab\\tbell\\u0007\"] }\n");
    place.runner(&["a&b.toml", "--set", "duration=0.01", "--junit", "junit.xml"]).exits(0);
    let text = read(&place, "junit.xml");
    let document = Document::parse(&text).unwrap();
    let cases = cases(&document);
    assert_eq!(cases[0].attribute("classname"), Some("a&b"));
    assert_eq!(cases[0].attribute("name"), Some("description=x < \"y\" & 'z'"));
    // XML cannot represent the bell character.
    assert!(cases[1].attribute("name").unwrap().starts_with("description=tab"), "{text}");
    assert!(!text.contains('\u{7}'));
}

/// The names contain characters that XML cannot represent, and are equal without them.
#[cfg(unix)]
#[test]
fn scenarios_with_equal_xml_names_stay_separate_suites() {
    let place = Place::new();
    let names = ["a\u{1}.toml", "a\u{1b}.toml", "a\u{fffe}.toml", "a.toml"];
    names.iter().for_each(|name| _ = place.block(name, "[sweep]\nrepeat = 3\n"));
    let arguments = ["--set", "duration=0.01", "--junit", "junit.xml"];
    place.runner(&[&names[..], &arguments].concat()).exits(0);
    let text = read(&place, "junit.xml");
    let document = Document::parse(&text).unwrap();
    let suites: Vec<_> = document.root_element().children().filter(Node::is_element).collect();
    let named: Vec<_> = suites.iter().map(|s| (s.attribute("name").unwrap(), counts(*s)[0])).collect();
    assert_eq!(named, [("a", 3); 4]);
}

#[test]
fn an_unwritable_report_file_is_an_error_before_the_first_run() {
    let place = Place::new();
    place.block("s.toml", "").write("in-the-way", "");
    let done = place.runner(&["s.toml", "--junit", "in-the-way/junit.xml"]).exits(2);
    assert!(done.stderr.contains("error: in-the-way: File exists"), "{}", done.stderr);
    place.runner(&["s.toml", "--junit", "block"]).exits(2);
    assert!(!place.path("results").exists());
}

//! Tests of `--message-format json`: one message per line, valid by the schema, in a defined order.

use serde_json::Value;

use super::{Done, Place};

fn lines(done: &Done) -> Vec<Value> {
    let lines: Vec<Value> = done.stdout.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    for line in &lines {
        assert_eq!(line["schema"], 1);
        assert_conforms(line);
    }
    lines
}

fn events(lines: &[Value]) -> Vec<&str> {
    lines.iter().map(|line| line["event"].as_str().unwrap()).collect()
}

/// Asserts that a message has all fields that the schema requires, and no unknown ones.
fn assert_conforms(line: &Value) {
    let schema = stiction::batch::message_schema();
    let resolved = |part: &Value| match part["$ref"].as_str() {
        Some(path) => schema.pointer(path.trim_start_matches('#')).unwrap().clone(),
        None => part.clone(),
    };
    let same_event = |variant: &&Value| variant["properties"]["event"]["const"] == line["event"];
    let variant = schema["oneOf"].as_array().unwrap().iter().find(same_event).unwrap_or_else(|| panic!("{line}"));
    let parts = [schema.clone(), variant.clone(), resolved(variant)];
    let mut known = Vec::new();
    for part in &parts {
        known.extend(part["properties"].as_object().into_iter().flat_map(|p| p.keys().cloned()));
        for required in part["required"].as_array().into_iter().flatten() {
            assert!(line.get(required.as_str().unwrap()).is_some(), "{required} is missing in {line}");
        }
    }
    for key in line.as_object().unwrap().keys() {
        assert!(known.contains(key), "{key} of {} is not in the schema", line["event"]);
    }
}

#[test]
fn a_batch_reports_its_start_its_runs_and_its_exit_code() {
    let place = Place::new();
    place.block(
        "s.toml",
        "[compare]\nreference = { \"integrator.relative_tolerance\" = 1e-9 }\n[[expect]]\nmetric = \"duration_s\"\nmax = 0.15\n\
         [sweep]\ngrid = { duration = [0.1, 0.2], \"floor.friction\" = [0.4] }\n",
    );
    let arguments = ["s.toml", "--message-format", "json", "-j", "1", "--no-timing", "--junit", "junit.xml"];
    let done = place.runner(&arguments).exits(1);
    let lines = lines(&done);
    let run = ["run-started", "run-finished"];
    assert_eq!(events(&lines), [&["batch-started"][..], &run, &run, &run, &run, &["batch-finished"]].concat());
    let first = &lines[0];
    assert_eq!((&first["runs"], &first["references"], &first["jobs"]), (&2.into(), &2.into(), &1.into()));
    assert_eq!(first["files"], serde_json::json!(["s.toml"]));

    let finished: Vec<&Value> = lines.iter().filter(|l| l["event"] == "run-finished").collect();
    let references: Vec<bool> = finished.iter().map(|l| l["reference"].as_bool().unwrap()).collect();
    assert_eq!(references, [true, false, true, false]);
    let (good, bad) = (finished[1], finished[3]);
    assert_eq!((&good["outcome"], &good["accepted"]), (&"passed".into(), &true.into()));
    assert_eq!((&bad["outcome"], &bad["accepted"]), (&"failed".into(), &false.into()));
    assert_eq!(bad["parameters"], serde_json::json!({ "duration": 0.2, "floor.friction": 0.4 }));
    let expectation = &bad["expectations"][0];
    assert_eq!((&expectation["metric"], &expectation["measured"]), (&"duration_s".into(), &0.2.into()));
    assert_eq!((&expectation["max"], &expectation["held"]), (&0.15.into(), &false.into()));

    // The metrics equal those of the summary, with null for empty cells.
    let summary = place.summary("results");
    assert_eq!(summary.column("key"), [good["key"].as_str().unwrap(), bad["key"].as_str().unwrap()]);
    let not_metrics =
        ["scenario", "key", "outcome", "message", "method", "integrator", "seed", "duration", "floor.friction"];
    for (column, name) in summary.header.iter().enumerate().filter(|(_, name)| !not_metrics.contains(&name.as_str())) {
        let metric = &good["metrics"][name];
        let cell = &summary.rows[0][column];
        let agree = if cell.is_empty() { metric.is_null() } else { metric.as_f64() == cell.parse().ok() };
        assert!(agree, "{name}: {metric} and `{cell}`");
    }
    let folder = place.path(good["folder"].as_str().unwrap());
    assert!(folder.join("run.json").is_file() && folder.ends_with(good["key"].as_str().unwrap()));

    let last = lines.last().unwrap();
    assert_eq!((&last["exit_code"], &last["not_started"]), (&1.into(), &0.into()));
    assert_eq!(last["outcomes"], serde_json::json!({ "passed": 1, "failed": 1 }));
    for file in last["files"].as_array().unwrap() {
        assert!(place.path(file.as_str().unwrap()).is_file(), "{file}");
    }
    assert!(last["files"].as_array().unwrap().contains(&"junit.xml".into()));
}

#[test]
fn diagnostics_have_file_line_column_key_and_help() {
    let place = Place::new();
    place
        .block("a.toml", "[floor]\nfrction = 0.5\n")
        .block("b.toml", "[[task]]\ntype = \"posture\"\njoints = { knee = 1 }\n");
    for (command, last) in [("check", "check-finished"), ("run", "batch-finished")] {
        let done = place.runner(&[command, "a.toml", "b.toml", "--message-format", "json"]).exits(2);
        let lines = lines(&done);
        assert_eq!(events(&lines), ["diagnostic", "diagnostic", last]);
        let (a, b) = (&lines[0], &lines[1]);
        assert_eq!(
            (&a["severity"], &a["file"], &a["key"]),
            (&"error".into(), &"a.toml".into(), &"floor.frction".into())
        );
        assert_eq!((&a["line"], &a["column"]), (&4.into(), &1.into()));
        assert!(a["help"].as_str().unwrap().contains("did you mean `friction`?"), "{a}");
        assert!(a["rendered"].as_str().unwrap().contains("4 | frction = 0.5"), "{a}");
        assert_eq!((&b["line"], &b["key"]), (&5.into(), &"task.0.joints.knee".into()));
        assert_eq!(lines[2]["exit_code"], 2);
        assert!(done.stderr.contains("2 errors"), "standard error is as without JSON: {}", done.stderr);
    }

    // Diagnostics of a robot file, of a robot, of --set and of --filter.
    let robot = std::fs::read_to_string(place.path("block/block.toml")).unwrap();
    place.block("s.toml", "").write("block/block.toml", robot.replace("link = \"block\"", "link = \"blok\""));
    let check_messages = |arguments: &[&str], code| {
        lines(&place.runner(&[&["check", "--message-format", "json"], arguments].concat()).exits(code))
    };
    let message = &check_messages(&["s.toml"], 2)[0];
    assert_eq!(message["file"], "block/block.toml");
    assert!(message["line"].is_u64() && message["column"].is_u64() && message["key"].is_string(), "{message}");
    place.write("block/block.toml", robot);
    let message = &check_messages(&["s.toml", "--set", "floor.friction=-1"], 2)[0];
    assert_eq!((&message["file"], &message["key"]), (&"--set".into(), &"floor.friction".into()));
    let message = &check_messages(&["s.toml", "--filter", "seed = 1"], 2)[0];
    assert_eq!((&message["file"], &message["column"], &message["key"]), (&"--filter".into(), &6.into(), &Value::Null));
    let urdf = std::fs::read_to_string(place.path("block/block.urdf")).unwrap();
    place.write("block/block.urdf", urdf.replacen("<box size=\"0.2 0.2 0.1\"/>", "<mesh filename=\"none.stl\"/>", 1));
    let messages = check_messages(&["s.toml"], 0);
    assert_eq!((&messages[0]["severity"], &messages[0]["file"]), (&"warning".into(), &"block/block.urdf".into()));
    assert_eq!(messages.last().unwrap()["runs"], 1);
    let messages = check_messages(&["s.toml", "--strict"], 2);
    assert_eq!(events(&messages[messages.len() - 2..]), ["diagnostic", "check-finished"]);
    assert_eq!(messages[messages.len() - 2]["message"], "with --strict, warnings are errors");
}

#[test]
fn errors_of_the_batch_are_in_its_last_message() {
    let place = Place::new();
    place.block("s.toml", "").write("file", "");
    let done = place.runner(&["s.toml", "--message-format", "json", "-o", "file/results"]).exits(2);
    let lines = lines(&done);
    assert_eq!(events(&lines), ["batch-finished"]);
    assert!(lines[0]["error"].as_str().unwrap().contains("cannot write results into file/results"), "{}", lines[0]);
    let done = place.runner(&["s.toml", "--message-format", "json", "--filter", "seed == 9"]).exits(4);
    let lines = self::lines(&done);
    assert_eq!(events(&lines), ["diagnostic", "batch-finished"]);
    assert_eq!(lines[1]["exit_code"], 4);
}

#[test]
fn a_slow_run_is_reported_while_it_runs_and_at_the_end() {
    let place = Place::new();
    // The second run takes some hundred times as long as the first on every machine.
    place.block("s.toml", "[log]\nrate = 0\n[sweep]\ngrid = { duration = [1e-3, 1e9] }\n");
    let arguments = ["s.toml", "-j", "1", "--slow", "0.5", "--timeout", "1.5"];
    let done = place.runner(&[&arguments[..], &["--message-format", "json", "--junit", "junit.xml"]].concat()).exits(3);
    let lines = lines(&done);
    assert_eq!(
        events(&lines),
        ["batch-started", "run-started", "run-finished", "run-started", "run-slow", "run-finished", "batch-finished"]
    );
    assert_eq!((&lines[2]["slow"], &lines[5]["slow"]), (&false.into(), &true.into()));
    assert_eq!(lines[4]["after_s"], 0.5);
    assert_eq!(lines[4]["key"], lines[5]["key"]);
    assert!(done.stderr.contains("slow: s duration=1000000000.0 has been running for 0.5 s"), "{}", done.stderr);
    let junit = std::fs::read_to_string(place.path("junit.xml")).unwrap();
    assert_eq!(junit.matches("<property name=\"slow\" value=\"true\"/>").count(), 1);

    let done = place.runner(&arguments).exits(3);
    let key = lines[5]["key"].as_str().unwrap();
    assert!(done.stdout.contains(&format!("slow: s {key} took ")), "{}", done.stdout);
    assert_eq!(done.stdout.matches("slow: ").count(), 1);
}

#[test]
fn resumed_runs_are_reported_as_resumed() {
    let place = Place::new();
    place.block("s.toml", "[sweep]\nrepeat = 2\n");
    let short = ["s.toml", "--set", "duration=0.05"];
    place.runner(&[&short[..], &["--filter", "seed == 1"]].concat()).exits(0);
    let again = ["--resume", "--message-format", "json", "--junit", "junit.xml"];
    let done = place.runner(&[&short[..], &again].concat()).exits(0);
    let lines = lines(&done);
    assert_eq!(events(&lines), ["batch-started", "run-finished", "run-started", "run-finished", "batch-finished"]);
    assert_eq!((&lines[1]["resumed"], &lines[3]["resumed"]), (&true.into(), &false.into()));
    assert_eq!((&lines[1]["seed"], &lines[1]["accepted"]), (&1.into(), &true.into()));
    assert_eq!(lines[4]["outcomes"], serde_json::json!({ "passed": 2 }));
    let junit = std::fs::read_to_string(place.path("junit.xml")).unwrap();
    assert!(junit.contains("tests=\"2\" skipped=\"0\" failures=\"0\" errors=\"0\""), "{junit}");
    assert_eq!(junit.matches("<property name=\"resumed\" value=\"true\"/>").count(), 1);
}

#[test]
fn the_reason_for_an_empty_selection_is_reported() {
    let place = Place::new();
    place.block("s.toml", "").write("empty/read.me", "");
    for (arguments, exit, severity, message) in [
        (&["s.toml", "--filter", "seed > 1e6"][..], 4, "note", "nothing selected: the filter holds for none of 1 run"),
        (&["empty"], 4, "note", "nothing selected: no .toml file in empty"),
        (&["chekc"], 2, "error", "there is no file or command `chekc`; did you mean `runner check`?"),
    ] {
        for command in ["run", "check"] {
            let done = place.runner(&[&[command][..], arguments, &["--message-format", "json"]].concat()).exits(exit);
            let lines = lines(&done);
            let [diagnostic, last] = lines.as_slice() else { panic!("{}", done.stdout) };
            assert_eq!((&diagnostic["event"], &diagnostic["severity"]), (&"diagnostic".into(), &severity.into()));
            assert_eq!((&diagnostic["message"], &last["exit_code"]), (&message.into(), &exit.into()));
        }
    }
}

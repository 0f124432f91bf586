//! Sweeps and overrides: the runs, their order, and their values.

use stiction::scenario::{ForceSpec, parse_override};

use super::{FULL, SMALLEST, file, runs, wrong};

fn set(assignments: &[&str]) -> Vec<(String, toml::Value)> {
    assignments.iter().map(|a| parse_override(a).unwrap()).collect()
}

fn swept(text: &str, key: &str) -> Vec<f64> {
    runs(&format!("{SMALLEST}{text}"))
        .iter()
        .map(|run| {
            let (name, value) = &run.parameters[0];
            assert_eq!(name, key);
            value.as_float().or(value.as_integer().map(|whole| whole as f64)).unwrap()
        })
        .collect()
}

#[test]
fn the_last_key_of_the_file_changes_fastest() {
    let runs = runs(&format!(
        "{SMALLEST}[sweep.grid]\n\"integrator.step\" = [1e-3, 2e-3]\n\"contact.method\" = [\"exact\", \"one-step\"]\n\"floor.friction\" = [0.1, 0.2, 0.3]\n"
    ));
    assert_eq!(runs.len(), 12);
    let mut expected = Vec::new();
    for step in [1e-3, 2e-3] {
        for method in ["exact", "one-step"] {
            for friction in [0.1, 0.2, 0.3] {
                expected.push((step, method, friction));
            }
        }
    }
    for (i, (run, (step, method, friction))) in runs.iter().zip(expected).enumerate() {
        assert_eq!(run.index, i);
        let names: Vec<_> = run.parameters.iter().map(|p| p.0.as_str()).collect();
        assert_eq!(names, ["integrator.step", "contact.method", "floor.friction"]);
        assert_eq!(run.parameters[0].1.as_float(), Some(step));
        assert_eq!(run.parameters[1].1.as_str(), Some(method));
        assert_eq!(run.parameters[2].1.as_float(), Some(friction));
        // The parameters of a run equal the values of its scenario.
        assert_eq!(run.scenario.integrator.step, step);
        assert_eq!(run.scenario.contact.method.name(), method);
        assert_eq!(run.scenario.floor.friction.static_, friction);
        assert!(run.scenario.sweep.is_single());
    }
}

#[test]
fn repetitions_differ_in_their_seed_and_change_fastest() {
    let runs = runs(&format!("seed = 7\n{SMALLEST}[sweep]\nrepeat = 3\ngrid = {{ \"floor.height\" = [0, 1] }}\n"));
    let seeds: Vec<_> = runs.iter().map(|r| (r.scenario.floor.height, r.scenario.seed)).collect();
    assert_eq!(seeds, [(0.0, 7), (0.0, 8), (0.0, 9), (1.0, 7), (1.0, 8), (1.0, 9)]);
    let texts: std::collections::HashSet<_> = runs.iter().map(|r| &r.resolved_toml).collect();
    assert_eq!(texts.len(), 6, "every run has a text, and so a key, of its own");
}

#[test]
fn seeds_out_of_range_are_refused() {
    let found = wrong(&format!("seed = 9223372036854775807\n{SMALLEST}[sweep]\nrepeat = 2\n"), &[]);
    assert_eq!(found.0[0].location(), "scenarios/test.toml:1:8", "{found}");
    let found = wrong(&format!("{SMALLEST}[sweep]\nrepeat = 2\ngrid = {{ seed = [1, 2] }}\n"), &[]);
    assert!(found.to_string().contains("`seed` cannot be swept together with `repeat`"), "{found}");
}

#[test]
fn ranges_include_their_ends_exactly() {
    let range = |form: &str| swept(&format!("[sweep]\ngrid = {{ \"floor.friction\" = {form} }}\n"), "floor.friction");
    assert_eq!(range("{ linspace = [0, 1, 5] }"), [0.0, 0.25, 0.5, 0.75, 1.0]);
    assert_eq!(range("{ linspace = [0.1, 0.9, 9] }"), [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9]);
    assert_eq!(range("{ logspace = [1e-6, 1e-2, 5] }"), [1e-6, 1e-5, 1e-4, 1e-3, 1e-2]);
    // Integers stay integers, so that counts can be swept.
    let counts = |form: &str| {
        swept(&format!("[sweep]\ngrid = {{ \"contact.ncp.iterations\" = {form} }}\n"), "contact.ncp.iterations")
    };
    assert_eq!(counts("{ logspace = [1, 1000, 4] }"), [1.0, 10.0, 100.0, 1000.0]);
    assert_eq!(counts("{ linspace = [4, 16, 4] }"), [4.0, 8.0, 12.0, 16.0]);
    assert_eq!(range("{ step = [0.1, 0.7, 0.1] }"), [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7]);
    assert_eq!(range("{ step = [1.0, 0.0, -0.4] }"), [1.0, 0.6, 0.2]);
    assert_eq!(range("[0.5, 1]"), [0.5, 1.0], "a column is of one kind");
    // Every thousandth of a decimal range, compared with the same numbers written out.
    let thousandths = range("{ step = [0.001, 2.0, 0.001] }");
    let written: Vec<f64> = (1..=2000).map(|i| format!("{}e-3", i).parse().unwrap()).collect();
    assert_eq!(thousandths, written);
}

#[test]
fn integer_steps_stay_integers() {
    let runs = runs(&format!("{SMALLEST}[sweep]\ngrid = {{ \"seed\" = {{ step = [2, 8, 3] }} }}\n"));
    let seeds: Vec<_> = runs.iter().map(|r| r.scenario.seed).collect();
    assert_eq!(seeds, [2, 5, 8]);
}

#[test]
fn a_sweep_may_add_keys_and_reach_into_arrays() {
    let found = runs("[sweep]\ngrid = { \"robot.model\" = [\"a.urdf\", \"b.urdf\"] }\n");
    assert_eq!(found[1].scenario.robot.model, "b.urdf");
    let text = FULL.replace("\"contact.method\" = [\"exact\", \"one-step\"]", "\"force.0.force.0\" = [1, 2]");
    let forces: Vec<_> = runs(&text)
        .iter()
        .map(|run| match &run.scenario.force[0] {
            ForceSpec::Push(push) => push.force,
            other => panic!("{other:?}"),
        })
        .collect();
    assert_eq!((forces[0], forces[15]), ([1.0, 0.0, 0.0], [2.0, 0.0, 0.0]));
}

/// The values of every run under two keys.
fn pairs(text: &str, a: &str, b: &str) -> Vec<(f64, f64)> {
    let number = |run: &stiction::scenario::Run, key: &str| {
        let (_, value) = run.parameters.iter().find(|(name, _)| name == key).expect("it is swept");
        value.as_float().or(value.as_integer().map(|i| i as f64)).expect("a number")
    };
    runs(&format!("{SMALLEST}{text}")).iter().map(|run| (number(run, a), number(run, b))).collect()
}

#[test]
fn the_keys_of_a_zip_table_advance_together() {
    let text = "[sweep]\nzip = [{ \"floor.friction\" = [0.1, 0.2, 0.3], duration = { linspace = [1, 2, 3] } }]\n";
    assert_eq!(pairs(text, "floor.friction", "duration"), [(0.1, 1.0), (0.2, 1.5), (0.3, 2.0)]);
    // The run uses the swept values, including the true values of expectations.
    let text = format!(
        "{SMALLEST}[[expect]]\nmetric = \"final_base_x\"\nvalue = 0\ntolerance = 1e-9\n[sweep]\nzip = [{{ \"floor.friction\" = [0.1, 0.2], \"expect.0.value\" = [5.0, 2.5] }}]\n"
    );
    let found: Vec<_> =
        runs(&text).iter().map(|r| (r.scenario.floor.friction.kinetic, r.scenario.expect[0].value)).collect();
    assert_eq!(found, [(0.1, Some(5.0)), (0.2, Some(2.5))]);
}

#[test]
fn zip_tables_and_the_grid_are_nested_in_the_order_of_the_file() {
    let zips = "zip = [{ duration = [1, 2], \"floor.height\" = [10, 20] }, { \"floor.friction\" = [0.1, 0.2] }]\n";
    let grid = "grid = { \"integrator.step\" = [1e-3, 2e-3] }\n";
    let order = |text: String| {
        runs(&format!("{SMALLEST}[sweep]\n{text}"))
            .iter()
            .map(|r| {
                let s = &r.scenario;
                assert_eq!(s.floor.height, 10.0 * s.duration);
                (s.duration, s.floor.friction.static_, s.integrator.step)
            })
            .collect::<Vec<_>>()
    };
    let (mut inner, mut outer) = (Vec::new(), Vec::new());
    for duration in [1.0, 2.0] {
        for friction in [0.1, 0.2] {
            inner.extend([1e-3, 2e-3].map(|step| (duration, friction, step)));
        }
    }
    for step in [1e-3, 2e-3] {
        for duration in [1.0, 2.0] {
            outer.extend([0.1, 0.2].map(|friction| (duration, friction, step)));
        }
    }
    assert_eq!(order(format!("{zips}{grid}")), inner);
    assert_eq!(order(format!("{grid}{zips}")), outer);
}

#[test]
fn an_overridden_key_of_a_zip_table_is_constant_while_the_others_advance() {
    let text = format!("{SMALLEST}[sweep]\nzip = [{{ duration = [1, 2, 3], \"floor.friction\" = [0.1, 0.2, 0.3] }}]\n");
    let file = file(&text).unwrap();
    let values = |overrides: &[&str]| -> Vec<(f64, f64)> {
        let runs = file.expand(&set(overrides)).unwrap();
        runs.iter().map(|r| (r.scenario.duration, r.scenario.floor.friction.static_)).collect()
    };
    assert_eq!(values(&["floor.friction=0.7"]), [(1.0, 0.7), (2.0, 0.7), (3.0, 0.7)]);
    assert_eq!(values(&["floor.friction=0.7", "duration=5"]), [(5.0, 0.7)]);
    assert_eq!(file.expand_at_most(&[], 3).unwrap().len(), 3);
    assert!(file.expand_at_most(&[], 2).unwrap_err().to_string().contains("3 runs, 2 are allowed"));
    let found = wrong(&text, &set(&["floor.friction.static=0.7"]));
    assert!(found.to_string().contains("cannot be overridden in part"), "{found}");
}

#[test]
fn the_number_of_runs_is_limited() {
    let grid = "[sweep]\nrepeat = 3\ngrid = { \"floor.height\" = { linspace = [0, 1, 10] } }\n";
    let file = file(&format!("{SMALLEST}{grid}")).unwrap();
    assert_eq!(file.expand_at_most(&[], 30).unwrap().len(), 30);
    let found = file.expand_at_most(&[], 29).unwrap_err();
    assert!(found.to_string().contains("30 runs, 29 are allowed"), "{found}");
    // Refused before any run is built, at any number of runs.
    let huge = "[sweep]\ngrid = { \"floor.height\" = { step = [0, 1, 1e-300] }, \"floor.friction\" = { linspace = [0, 1, 4294967295] } }\n";
    assert!(wrong(&format!("{SMALLEST}{huge}"), &[]).to_string().contains("10000 are allowed"));
}

#[test]
fn overrides_do_not_silently_replace_each_other() {
    let file = file("[robot]\nmodel = \"r\"\n[floor]\nfriction = { static = 0.9, kinetic = 0.7 }\n").unwrap();
    // A value of the file is replaced as a whole; of several overrides of one key the last counts.
    let friction = |overrides: &[&str]| file.expand(&set(overrides)).unwrap()[0].scenario.floor.friction;
    assert_eq!((friction(&["floor.friction=0.4"]).static_, friction(&["floor.friction=0.4"]).kinetic), (0.4, 0.4));
    assert_eq!(friction(&["floor.friction.static=1", "floor.friction.static=0.8"]).static_, 0.8);
    // A number and a part of a table for one value are contradictory, in either order.
    for order in
        [["floor.friction.static=0.9", "floor.friction=0.4"], ["floor.friction=0.4", "floor.friction.static=0.9"]]
    {
        assert!(file.expand(&set(&order)).is_err(), "{order:?}");
    }
    let found = file.expand(&set(&["floor.friction.static=0.9", "floor.friction=0.4"])).unwrap_err().to_string();
    assert!(found.contains("`floor.friction` would replace `floor.friction.static`, which is set as well"), "{found}");
}

#[test]
fn overrides_replace_values() {
    let overrides = set(&[
        "contact.method=one-step",
        "duration = 2",
        "force.0.force = [10, 0, 0]",
        "floor.friction=0.3",
        "robot.joint.left_knee.kp=7",
        "robot.posture.\"odd.name\"=0.1",
        "description=a b",
        "duration=3",
        "robot.base.rpy=[\"45 deg\", 0, 0]",
        "sweep.repeat=1",
    ]);
    let runs = file(FULL).unwrap().expand(&overrides).unwrap();
    let s = &runs[0].scenario;
    assert_eq!(s.duration, 3.0, "the later one counts");
    assert_eq!(s.floor.friction.kinetic, 0.3);
    assert_eq!(s.robot.joint["left_knee"].kp, Some(7.0));
    assert_eq!(s.robot.joint["left_knee"].kd, Some(1.0), "its neighbours stay");
    assert_eq!(s.robot.posture["odd.name"], 0.1);
    assert_eq!(s.description, "a b");
    let ForceSpec::Push(push) = &s.force[0] else { panic!("{:?}", s.force[0]) };
    assert_eq!(push.force, [10.0, 0.0, 0.0]);
    // An overridden swept key has one value; its column stays.
    assert_eq!(runs.len(), 5);
    assert!(runs.iter().all(|r| r.parameters[0] == ("contact.method".into(), "one-step".into())));
    assert!(runs.iter().all(|r| r.scenario.contact.method.name() == "one-step"));
}

#[test]
fn overrides_of_nonexistent_keys_are_reported() {
    let table: &[(&str, &str, &str)] = &[
        ("floor.frction=1", "--set:1:7", "unknown key `frction` in `floor`"),
        ("durtion=1", "--set:1:1", "unknown key `durtion`"),
        ("duration=long", "--set:1:12", "`duration` must be a number, not the string \"long\""),
        ("duration=-1", "--set:1:12", "`duration` must be greater than 0"),
        ("duration=nan", "--set:1:12", "finite"),
        ("force.12.force=[1, 0, 0]", "--set:1:7", "there is no `force.12`: `force` has 12 entries"),
        ("force.first.force=[1, 0, 0]", "--set:1:7", "`first` must be an index"),
        ("force.0.force=[1, 0]", "--set:1:17", "`force.0.force` must be an array of length 3"),
        ("force.0.force.9=1", "--set:1:15", "there is no `force.0.force.9`"),
        ("duration.x=1", "--set:1:10", "`duration` is the number 5.0 and has no `x`"),
        ("self_collision.method=5", "--set:1:25", "must be from 0 to 4, not 5"),
        ("a b=1", "--set:1:1", "is not a dotted path"),
        ("floor.friction.kinetic=0.9", "--set:1:26", "must not be greater than `static` = 0.8"),
        ("schema=2", "--set:1:10", "schema = 2"),
    ];
    for (assignment, location, message) in table {
        let found = wrong(FULL, &set(&[assignment]));
        let first = found.iter().next().unwrap();
        assert_eq!(first.location(), *location, "{found}");
        assert!(first.message.contains(message), "{found}");
        assert!(found.to_string().contains(location), "{found}");
    }
    let found = wrong(SMALLEST, &set(&["event.0.at=1"]));
    assert!(found.to_string().contains("the file has no `event`"), "{found}");
    let found = wrong(FULL, &set(&["sweep.grid.\"contact.distance_tolerance\" = [0]", "contact=3"]));
    assert!(found.to_string().contains("cannot be overridden in part"), "{found}");
}

#[test]
fn assignments_are_parsed_as_typed() {
    let value = |text| parse_override(text).map(|(_, value)| value);
    assert_eq!(value("a=1"), Ok(1.into()));
    assert_eq!(value("a = 1.5 "), Ok(1.5.into()));
    assert_eq!(value("a=\"1\""), Ok("1".into()));
    assert_eq!(value("a=one-step"), Ok("one-step".into()));
    assert_eq!(value("a=../x=y.toml"), Ok("../x=y.toml".into()));
    assert_eq!(value("a=true"), Ok(true.into()));
    assert_eq!(value("a=1\nb=2"), Ok("1\nb=2".into()), "one assignment at a time");
    for bad in ["a", "=1", "a=[1, 2", "a={", "a=\"x"] {
        assert!(value(bad).is_err(), "{bad}");
    }
}

#[test]
fn later_errors_are_reported_at_the_value_of_that_run() {
    let text = format!(
        "{SMALLEST}[[force]]\ntype = \"push\"\nlink = \"a\"\nforce = [1, 0, 0]\n[[task]]\ntype = \"posture\"\njoints = {{ knee = 1 }}\n[sweep]\ngrid = {{ \"force.0.link\" = [\"b\", \"c\"] }}\n"
    );
    let file = file(&text).unwrap();
    let runs = file.expand(&[]).unwrap();
    let shown = runs[1].error_at("force.0.link", "the robot has no link `c`", Some("did you mean `b`?".into()));
    assert_eq!(shown.location(), "scenarios/test.toml:11:33");
    assert!(shown.to_string().contains("did you mean `b`?"));
    assert_eq!(
        runs[0].error_at_key("task.0.joints.knee", "no such joint", None).location(),
        "scenarios/test.toml:9:12"
    );
    assert_eq!(
        runs[0].error_at("robot.base.rpy", "x", None).location(),
        "scenarios/test.toml:1:1",
        "the nearest there is"
    );
    let runs = file.expand(&set(&["force.0.link=z"])).unwrap();
    assert_eq!(runs[0].error_at("force.0.link", "x", None).location(), "--set:1:16");
}

#[test]
fn a_swept_key_and_then_its_table_can_be_overridden() {
    let text = format!("{SMALLEST}[sweep]\ngrid = {{ \"floor.height\" = [0, 1] }}\n");
    let found = wrong(&text, &set(&["floor.height=2", "floor={}"]));
    assert!(found.to_string().contains("`floor` would replace `floor.height`, which is set as well"), "{found}");
}

#[test]
fn parameters_of_a_method_that_no_run_uses_give_a_warning() {
    let warnings = |text: &str, overrides: &[&str]| -> Vec<String> {
        let runs = file(&format!("{SMALLEST}{text}")).unwrap().expand(&set(overrides)).unwrap();
        runs.iter().flat_map(|r| r.warnings.iter()).map(|d| format!("{} {}", d.location(), d.message)).collect()
    };
    let idle = |key: &str, method: &str| format!("`contact.{key}` has no effect: `contact.method` is \"{method}\"");
    assert_eq!(
        warnings("[stop]\nat = 99\n", &[]),
        ["scenarios/test.toml:4:6 `stop.at` is at 99 s, but the run ends at 5 s, its `duration`"]
    );
    assert_eq!(warnings("[stop]\nat = 5\n", &[]), [""; 0]);
    assert_eq!(
        warnings("[contact.lcp]\nfacets = 6\n", &[]),
        [format!("scenarios/test.toml:3:10 {}", idle("lcp", "exact"))]
    );
    assert_eq!(
        warnings("[contact]\nmethod = \"lcp\"\nncp = { iterations = 3 }\n", &[]),
        [format!("scenarios/test.toml:5:1 {}", idle("ncp", "lcp"))]
    );
    // No warning if a sweep or an override selects the method, or if nothing is changed; one
    // warning for a swept parameter.
    let swept = "[sweep.grid]\n\"contact.method\" = [\"exact\", \"lcp\"]\n";
    assert_eq!(warnings(&format!("[contact.lcp]\nfacets = 6\n{swept}"), &[]), [""; 0]);
    assert_eq!(warnings("[contact.lcp]\nfacets = 6\n", &["contact.method=lcp"]), [""; 0]);
    assert_eq!(warnings("[contact.lcp]\nfacets = 8\n", &[]), [""; 0]);
    assert_eq!(warnings("[contact.penalty]\ndamping = 0\n", &[]).len(), 1);
    assert_eq!(warnings("[contact.penalty]\ndamping = 0\n", &["contact.method=penalty"]), [""; 0]);
    assert_eq!(warnings("[sweep.grid]\n\"contact.lcp.facets\" = [4, 6, 10]\n", &[]).len(), 1);
}

#[test]
fn events_change_the_scenario_in_order() {
    let text = "[[event]]\nat = 2\nset = { \"floor.friction.kinetic\" = 0.1, gravity = [0, 0, -1] }\n\
                [[event]]\nat = 1\nset = { \"floor.friction\" = { static = 0.5, kinetic = 0.4 } }\nsave = \"here\"\n\
                [[event]]\nat = 2\nrestore = \"here\"\n";
    let run = &runs(&format!("{SMALLEST}{text}"))[0];
    let at: Vec<(usize, f64)> = run.events.iter().map(|e| (e.index, e.at)).collect();
    assert_eq!(at, [(1, 1.0), (0, 2.0), (2, 2.0)], "by time, then as in the file");
    let friction = |k: usize| run.events[k].after.scenario.floor.friction;
    assert_eq!((run.scenario.floor.friction.static_, run.scenario.gravity), (0.8, [0.0, 0.0, -9.81]));
    assert_eq!((friction(0).static_, friction(0).kinetic), (0.5, 0.4));
    assert_eq!((friction(1).static_, friction(1).kinetic), (0.5, 0.1));
    assert_eq!(run.events[1].after.scenario.gravity, [0.0, 0.0, -1.0]);
    assert_eq!(run.events[0].save.as_deref(), Some("here"));
    assert_eq!(run.events[2].restore.as_deref(), Some("here"));
    assert_eq!(friction(2), friction(1));
    assert_eq!(run.events[0].set, ["floor.friction"]);
}

#[test]
fn times_and_values_of_events_can_be_swept() {
    let text = "[[event]]\nat = 1\nset = { \"floor.friction\" = 0.5 }\n[sweep.grid]\n\"event.0.at\" = [0.5, 1.5]\n\
                'event.0.set.\"floor.friction\"' = [0.2, 0.3]\n";
    let runs = runs(&format!("{SMALLEST}{text}"));
    let found: Vec<(f64, f64)> =
        runs.iter().map(|r| (r.events[0].at, r.events[0].after.scenario.floor.friction.static_)).collect();
    assert_eq!(found, [(0.5, 0.2), (0.5, 0.3), (1.5, 0.2), (1.5, 0.3)]);
    assert_eq!(runs[1].parameters[1].0, "event.0.set.\"floor.friction\"");
    // A wrong value is reported at its position in the sweep.
    let wrong = wrong(&format!("{SMALLEST}{}", text.replace("[0.2, 0.3]", "[0.2, -3]")), &[]);
    assert!(wrong.0[0].location().contains(":8:"), "{}", wrong.0[0].location());
}

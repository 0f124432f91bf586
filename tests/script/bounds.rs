//! Bounds on what scripts hand over, and metamethods, which cannot pass the budget of a call.

use super::{FORCE, ScriptedRun, TASK, pendulum};
use stiction::script::{MAX_FORCES, MAX_NAME, MAX_POINTS, MAX_TABLES};
use stiction::sim::{NullObserver, Outcome};

fn task(script: &str) -> ScriptedRun {
    ScriptedRun::new(&pendulum(0.05, "mode = \"position\"", TASK), script)
}

fn force(script: &str) -> ScriptedRun {
    ScriptedRun::new(&pendulum(0.05, "mode = \"passive\"", FORCE), script)
}

#[track_caller]
fn refused(run: &ScriptedRun, expected: &str) {
    let Err(found) = run.build() else { panic!("accepted, expected: {expected}") };
    let text = found.to_string();
    assert!(text.contains(expected), "{text}\nexpected: {expected}");
    assert!(text.len() < 1000, "{} bytes", text.len());
}

#[track_caller]
fn fails(run: &ScriptedRun, expected: &str) {
    let (outcome, message) = run.end(&mut NullObserver);
    assert!(outcome == Outcome::Error && message.contains(expected), "{message}\nexpected: {expected}");
    assert!(message.len() < 1000, "{} bytes", message.len());
}

#[track_caller]
fn passes(run: &ScriptedRun) {
    let (outcome, message) = run.end(&mut NullObserver);
    assert_eq!(outcome, Outcome::Passed, "{message}");
}

#[test]
fn lists_of_names_are_bounded() {
    // Before, the program copied three million names, 3.6 GB.
    let expected =
        "s.luau: the list `links` has 3000000 entries, at most 3 are allowed: the number of the robot's links";
    for end in ["function run() end", "function run() return {} end"] {
        refused(&task(&format!("links = table.create(3e6, \"block\")\n{end}")), expected);
    }
    refused(&force("links = table.create(3e6, \"base\")\nfunction run() end"), expected);
    refused(
        &task("needs = table.create(16, \"com\")\nfunction run() end"),
        "s.luau: the list `needs` has 16 entries, at most 15 are allowed: the number of parts",
    );
    let points =
        |n: usize| task(&format!("points = {{}}\nfor i = 1, {n} do points[i] = \"p\" .. i end\nfunction run() end"));
    passes(&points(MAX_POINTS));
    refused(&points(MAX_POINTS + 1), "the list `points` has 257 entries, at most 256 are allowed");
}

#[test]
fn names_are_bounded() {
    let points = |bytes: usize| task(&format!("points = {{ \"a\", string.rep(\"b\", {bytes}) }}\nfunction run() end"));
    passes(&points(MAX_NAME));
    refused(&points(MAX_NAME + 1), "s.luau: `points[2]` has 4097 bytes, at most 4096 are allowed");
    refused(&task("links = { string.rep(\"b\", 2e7) }\nfunction run() end"), "`links[1]` has 20000000 bytes");
}

#[test]
fn returned_forces_are_bounded() {
    let joints =
        |n: usize| force(&format!("function run()\nreturn table.create({n}, {{ joint = 1, effort = 0 }}) end"));
    passes(&joints(MAX_FORCES));
    fails(&joints(MAX_FORCES + 1), "s.luau:1: `run` returned 4097 forces, at most 4096 are allowed");
    // Messages show the beginning of a long text.
    for (entry, expected) in [
        ("{ link = string.rep(\"b\", 2e7) }", "the robot has no link \"bbb"),
        ("{ joint = string.rep(\"b\", 2e7) }", "the robot has no joint \"bbb"),
        ("{ [string.rep(\"b\", 2e7)] = 1 }", "unknown key \"bbb"),
        ("{ link = \"upper_arm\", frame = string.rep(\"b\", 2e7) }", "(20000000 bytes)"),
        ("string.rep(\"b\", 2e7)", "force 1 must be a table, not \"bbb"),
    ] {
        let names = stiction::robot::load(super::robot("pendulum/pendulum.urdf").as_ref()).unwrap();
        let link = names.model.links[0].name.clone();
        fails(&force(&format!("function run() return {{ {} }} end", entry.replace("upper_arm", &link))), expected);
    }
    fails(&task("function run() return string.rep(\"b\", 2e7) end"), "\"done\" or false to end, not \"bbb");
}

#[test]
fn the_tables_of_a_force_are_bounded() {
    let tables = |n: usize| force(&format!("all = {{}}\nfor i = 1, {n} do all[i] = {{}} end\nfunction run() end"));
    // The globals themselves and the list are tables too.
    passes(&tables(MAX_TABLES - 2));
    refused(&tables(MAX_TABLES + 1), "s.luau: its globals hold more than 100000 tables");
    let later = "function init()\nall = {}\nfor i = 1, 2e5 do all[i] = {} end\nend\nfunction run() end";
    fails(&force(later), "its globals hold more than 100000 tables");
    // A table that is found many times counts once.
    passes(&force("all = table.create(1e6, {})\nfunction run() end"));
}

#[test]
fn the_work_of_library_functions_is_counted_by_raw_lengths() {
    let expected = "more than 1000000 calls and loop iterations in one call";
    let run = |first: &str, body: &str| task(&format!("{first}\nfunction run()\nfor i = 1, 9e5 do\n{body}\nend\nend"));
    let shorter = "local t = setmetatable(table.create(3e5, 0), { __len = function() return 0 end })";
    let bytes = "local b = buffer.create(6e6)";
    for (first, body) in [
        (shorter, "table.find(t, 1)"),
        (shorter, "table.sort(t)"),
        (shorter, "table.insert(t, 1, 0) table.remove(t, 1)"),
        (shorter, "table.maxn(t)"),
        // Numbers in text, which library functions accept too.
        (bytes, "buffer.fill(b, \"0\", 1, \"6e6\")"),
        (bytes, "buffer.copy(b, 0, b, 0, \"6e6\")"),
        ("local n = string.rep(\"0\", 3e6) .. \"1\"", "buffer.create(n)"),
    ] {
        // Without the limit each takes minutes.
        fails(&run(first, body), expected);
    }
}

#[test]
fn metamethods_run_within_the_budget_of_the_call() {
    let endless = "function() while true do end end";
    let expected = "more than 1000000 calls and loop iterations in one call";
    let all = format!(
        "local trap = {{ __len = {endless}, __index = {endless}, __iter = {endless}, __tostring = {endless}, \
         __call = {endless}, __eq = {endless}, __concat = {endless}, __newindex = {endless} }}\n"
    );
    // The program reads all that it is given without a metamethod.
    passes(&task(&format!(
        "{all}links = setmetatable({{ \"upper\" }}, trap)\nneeds = setmetatable({{}}, trap)\nfunction run() end"
    )));
    passes(&force(&format!(
        "{all}function run() return setmetatable({{ setmetatable({{ joint = 1, effort = 0 }}, trap) }}, trap) end"
    )));
    let vector = "{ setmetatable({ joint = 1, effort = setmetatable({}, trap) }, trap) }";
    fails(&force(&format!("{all}function run() return {vector} end")), "`effort` must be a finite number, not a table");
    fails(&task(&format!("{all}function run() return setmetatable({{}}, trap) end")), "not a table");
    refused(&task(&format!("{all}run = setmetatable({{}}, trap)")), "`run` must be a function, not a table");
    refused(
        &task(&format!("{all}links = {{ setmetatable({{}}, trap) }}\nfunction run() end")),
        "`links` must be a list of strings",
    );
    let point = "points = { \"a\" }\nfunction run(robot) robot.set_point(\"a\", setmetatable({ 1, 2, 3 }, trap)) end";
    passes(&task(&format!("{all}{point}")));
    // The text of an error is made within the call.
    for error in ["error(setmetatable({}, trap))", "robot.set_mode(1, setmetatable({}, trap))"] {
        let (outcome, message) = task(&format!("{all}function run(robot) {error} end")).end(&mut NullObserver);
        assert_eq!(outcome, Outcome::Error, "{message}");
    }
    fails(&task(&format!("{all}function run(robot) robot.set_mode(1, setmetatable({{}}, trap)) end")), expected);
}

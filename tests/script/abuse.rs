//! Misbehaving scripts: each ends its run with file, line and message, or is refused before the
//! run.

use super::{ScriptedRun, TASK, pendulum};
use stiction::sim::{NullObserver, Outcome};

fn scripted(script: &str) -> ScriptedRun {
    ScriptedRun::new(&pendulum(0.05, "mode = \"position\"", TASK), script)
}

#[track_caller]
fn ends(script: &str, expected: &str) {
    let (outcome, message) = scripted(script).end(&mut NullObserver);
    assert_eq!(outcome, Outcome::Error, "{script}\n{message}");
    assert!(message.contains(expected), "{script}\n{message}\nexpected: {expected}");
}

#[track_caller]
fn refused(script: &str, expected: &str) {
    let Err(found) = scripted(script).build() else { panic!("accepted:\n{script}") };
    let text = found.to_string();
    assert!(text.contains(expected) && text.contains("s.toml:6:"), "{script}\n{text}\nexpected: {expected}");
}

#[test]
fn endless_loops_end() {
    ends("function run()\nlocal i = 0\nwhile true do\ni += 1\nend\nend", "s.luau:");
    ends("function run()\nwhile true do end\nend", "s.luau:2: more than 1000000 calls and loop iterations in one call");
    ends("function init()\nrepeat until false\nend\nfunction run() end", "s.luau:2: more than 1000000");
    // The error ends the run even if the script catches it.
    ends("function run()\npcall(function() while true do end end)\nend", "s.luau:3: more than 1000000");
    ends("function run()\nwhile true do pcall(function() while true do end end) end\nend", "s.luau:2: more than");
    // A pattern with exponential backtracking.
    ends(
        "local s = string.rep(\"a\", 40)\nfunction run()\nstring.find(s, string.rep(\"a-\", 30) .. \"b\")\nend",
        "s.luau:3:",
    );
    refused("while true do end\nfunction run() end", "s.luau:1: more than 1000000");
}

#[test]
fn processing_long_data_counts() {
    let expected = "more than 1000000 calls and loop iterations in one call";
    let run = |first: &str, body: &str| format!("{first}\nfunction run()\nfor i = 1, 9e5 do\n{body}\nend\nend");
    let long = "local s = string.rep(\"x\", 3e6)";
    let many = "local t = table.create(3e5, 0)";
    let bytes = "local b = buffer.create(6e6)";
    for (first, body) in [
        (bytes, "buffer.fill(b, 0, 1)"),
        (bytes, "buffer.copy(b, 0, b, 0)"),
        (bytes, "local x = buffer.tostring(b)"),
        (long, "utf8.len(s)"),
        (long, "local x = string.upper(s)"),
        (long, "local x = s:reverse()"),
        (long, "local x = string.sub(s, 1, -2)"),
        (long, "local x = s .. i"),
        (long, "local x = string.format(\"%s%d\", s, i)"),
        (long, "string.find(s, \"y\", 1, true)"),
        (long, "string.match(s, \"x*y\")"),
        (long, "for w in string.gmatch(s, \"x*y\") do end"),
        ("local s = string.rep(\"1\", 3e6)", "local x = tonumber(s)"),
        ("local t = table.create(3e5, \"\")", "table.concat(t)"),
        (many, "table.sort(t)"),
        (many, "table.find(t, 1)"),
        (many, "table.insert(t, 1, 0) table.remove(t, 1)"),
        (many, "table.move(t, 1, 3e5 - 1, 2)"),
        (many, "local x = table.clone(t)"),
        ("", "local x = table.create(3e5, 0)"),
        ("", "local x = string.rep(\"x\", 3e6)"),
    ] {
        // Without the limit each takes minutes.
        ends(&run(first, body), expected);
    }
    refused("local b = buffer.create(6e6) for i = 1, 9e5 do buffer.fill(b, 0, 1) end\nfunction run() end", expected);
    // Short data counts as the few calls that it takes.
    let script =
        "function run() for i = 1, 1e4 do local x = string.rep(\"ab\", 8):sub(2, 5):find(\"a\") end return false end";
    assert_eq!(scripted(script).end(&mut NullObserver).0, Outcome::Passed);
    // Errors in such functions carry the position of the call.
    ends("function run()\n\nstring.rep()\nend", "s.luau:3: missing argument #1 to 'rep'");
    ends("function run()\nlocal s = nil\nlocal x = string.upper(s)\nend", "s.luau:3: invalid argument #1 to 'upper'");
}

#[test]
fn an_interruption_ends_scripts() {
    let flag = std::sync::Arc::new(std::sync::atomic::AtomicBool::new(false));
    let script = "function init()\nfor i = 1, 9e5 do end\nend\nfunction run() end";
    let scripted = scripted(script);
    let mut sim = stiction::script::interruptible(flag.clone(), || scripted.simulation());
    flag.store(true, std::sync::atomic::Ordering::Relaxed);
    // Only the script reads the flag, not the run loop.
    let (outcome, message) = sim.run(&mut NullObserver, &std::sync::atomic::AtomicBool::new(false));
    assert!(outcome == Outcome::Error && message.contains("interrupted"), "{outcome:?} {message}");
    flag.store(false, std::sync::atomic::Ordering::Relaxed);
    let mut sim = stiction::script::interruptible(flag.clone(), || scripted.simulation());
    flag.store(true, std::sync::atomic::Ordering::Relaxed);
    assert_eq!(sim.run(&mut NullObserver, &flag).0, Outcome::Cancelled);
}

#[test]
fn the_budget_applies_to_one_call() {
    // Three ticks of half the budget each.
    let script = "local n = 0\nfunction run() for i = 1, 500000 do end n += 1 return n < 3 end";
    assert_eq!(scripted(script).end(&mut NullObserver).0, Outcome::Passed);
}

#[test]
fn memory_is_limited() {
    ends(
        "local all = {}\nfunction run()\nfor i = 1, 1e5 do all[#all + 1] = table.create(1000, 0) end\nend",
        "not enough memory: a script may use 64 MiB",
    );
    ends("function run()\nlocal s = string.rep(\"x\", 2^30)\nend", "s.luau");
    ends("function run()\nlocal s = \"x\"\nfor i = 1, 40 do s = s .. s end\nend", "not enough memory");
    ends("function run()\nlocal b = buffer.create(2^28)\nend", "not enough memory");
    refused("local s = \"x\"\nfor i = 1, 40 do s = s .. s end\nfunction run() end", "not enough memory");
}

/// 16 and 24 MB of live data, allocated at each of 50 ticks.
#[test]
fn garbage_does_not_count_as_memory() {
    for n in ["1e6", "1.5e6"] {
        let script = format!("local t\nfunction run() t = table.create({n}, 0) end");
        let (outcome, message) = scripted(&script).end(&mut NullObserver);
        assert_eq!(outcome, Outcome::Passed, "{n}: {message}");
    }
    // Live data count: 10 MB more at every tick.
    ends(
        "local all = {}\nfunction run()\nall[#all + 1] = buffer.create(1e7)\nend",
        "not enough memory: a script may use 64 MiB",
    );
}

#[test]
fn recursion_is_limited() {
    ends("local function f(n) return 1 + f(n + 1) end\nfunction run()\nf(1)\nend", "s.luau:1: stack overflow");
    ends("local function f() pcall(f) pcall(f) end\nfunction run()\nf()\nend", "s.luau:");
}

#[test]
fn errors_carry_their_line() {
    ends("function init()\n\nerror(\"no\")\nend\nfunction run() end", "s.luau:3: no");
    ends("function run(robot)\nlocal x = robot.nothing.there\nend", "s.luau:2: attempt to index nil with 'there'");
    ends("function run(robot)\nerror({ 1 })\nend", "s.luau");
    let change = format!("{TASK}change = [{{ at = 0.01, params = {{}} }}]");
    let text = pendulum(0.05, "mode = \"position\"", &change);
    let (outcome, message) =
        ScriptedRun::new(&text, "function run() end\nfunction change()\nerror(\"no\") end").end(&mut NullObserver);
    assert_eq!((outcome, message.contains("s.luau:3: no")), (Outcome::Error, true), "{message}");
}

#[test]
fn invalid_commands_are_reported_at_the_call() {
    for (call, expected) in [
        ("set_position(\"knee\", 1)", "the robot has no joint \"knee\""),
        ("set_position(3, 1)", "the robot has no joint 3"),
        ("set_position(1.5, 1)", "the robot has no joint 1.5"),
        ("set_position(nil, 1)", "the robot has no joint nil"),
        ("set_position(1, 0/0)", "a position must be a finite number, not nan"),
        ("set_velocity(1, \"fast\")", "a velocity must be a number, not string"),
        ("set_effort(1, math.huge)", "an effort must be a finite number, not inf"),
        ("set_gains(1, -1, 0)", "gains must not be negative"),
        ("set_gains(1, 1)", "kd must be a number, not nil"),
        ("set_mode(1, \"servo\")", "a mode is one of position, velocity, force, kinematic, passive, not servo"),
    ] {
        ends(&format!("function run(robot)\n\nrobot.{call}\nend"), &format!("s.luau:3: {expected}"));
    }
    ends(
        "function init(robot)\nrobot.set_position(1, 0)\nend\nfunction run() end",
        "s.luau:2: joints are commanded in `run`",
    );
    ends("-- 5 is no answer.\nfunction run()\nreturn 5\nend", "s.luau:2: it must return nothing or true");
    ends("function init() return {} end\nfunction run() end", "s.luau:1: it must return nothing or true");
}

#[test]
fn scripts_cannot_reach_the_machine() {
    for name in [
        "io",
        "os",
        "require",
        "loadstring",
        "load",
        "dofile",
        "loadfile",
        "getfenv",
        "setfenv",
        "collectgarbage",
        "newproxy",
        "print",
        "package",
        "debug",
        "jit",
        "ffi",
        "coroutine",
        "gcinfo",
    ] {
        refused(&format!("assert({name} ~= nil, \"closed\")\nfunction run() end"), "closed");
    }
    refused("assert(math.random ~= nil, \"closed\")\nfunction run() end", "closed");
    refused("math.pi = 3\nfunction run() end", "s.luau:1: attempt to modify a readonly table");
    refused("string.rep = nil\nfunction run() end", "s.luau:1: attempt to modify a readonly table");
    refused("getmetatable(\"\").__index = {}\nfunction run() end", "s.luau:1:");
}

#[test]
fn invalid_scripts_are_found_before_the_run() {
    refused("function run(\nend", "s.luau:2: Expected");
    refused("function go() end", "s.luau: there is no function `run`");
    refused("run = 3", "s.luau: `run` must be a function, not 3");
    refused("run = 3\ninit = \"x\"\nfunction run() end", "s.luau: `init` must be a function, not \"x\"");
    refused("needs = { \"con\" }\nfunction run() end", "`needs` has no part \"con\"; did you mean `com`?");
    refused("needs = \"com\"\nfunction run() end", "`needs` must be a list of strings");
    refused("links = { \"lnik\" }\nfunction run() end", "the robot `pendulum` has no link \"lnik\"");
    refused("\u{1b}LuaS", "s.luau");
}

#[test]
fn a_script_cannot_change_the_data_of_the_next_call() {
    let script = "
        function run(robot)
            if robot.time > 0 then
                assert(#robot.q == 2 and math.abs(robot.q[1]) < 1, \"filled again\")
                assert(robot.joint.elbow == 2)
            end
            robot.desired.position[1] = 1e9
        end";
    let mut sim = scripted(script).simulation();
    let (outcome, message) = sim.run(&mut NullObserver, &std::sync::atomic::AtomicBool::new(false));
    assert_eq!(outcome, Outcome::Passed, "{message}");
    assert_eq!(sim.plant().command.position[0], 0.4, "only the functions command");
}

#[test]
fn the_robot_table_is_read_only() {
    for statement in [
        "robot.q = nil",
        "robot.q[1] = 1e9",
        "robot.q[3] = 7",
        "robot.joint = nil",
        "robot.joint.elbow = 7",
        "robot.joints[1] = \"x\"",
        "robot.base.position = nil",
        "robot.base.rotation[1][1] = 5",
        "robot.gravity[3] = 5",
        "robot.set_position = nil",
        "robot.mine = (robot.mine or 0) + 1",
        "robot.desired = {}",
        "robot.desired.position = nil",
        "robot.imu = nil",
        "table.insert(robot.q, 1)",
        "rawset(robot, \"q\", nil)",
        "setmetatable(robot, {})",
    ] {
        for time in ["true", "robot.time > 0.01"] {
            let script = format!("function run(robot)\nif {time} then\n{statement}\nend\nend");
            let (outcome, found) = scripted(&script).end(&mut NullObserver);
            assert_eq!(outcome, Outcome::Error, "{statement}");
            assert!(found.contains("s.luau:3: ") && found.contains("readonly table"), "{statement}: {found}");
        }
    }
    // A script may test its read-only tables with `table.isfrozen`.
    let script = "function run(robot) assert(table.isfrozen(robot) and table.isfrozen(robot.q)) end";
    assert_eq!(scripted(script).end(&mut NullObserver).0, Outcome::Passed);
}

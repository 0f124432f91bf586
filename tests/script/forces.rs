//! Forces in Luau.

use super::{FORCE, ScriptedRun, passes, pendulum};
use crate::analytic::body::Body;
use crate::support::runs::{Recording, TIGHT};
use nalgebra::Vector3;
use std::sync::atomic::AtomicBool;
use stiction::sim::{NullObserver, Outcome};

fn floating(body: &Body, base: &str, rest: &str) -> String {
    format!("gravity = [0, 0, 0]\n{}{TIGHT}{rest}", body.floating(base))
}

#[test]
fn a_body_under_an_inverse_square_force_follows_an_ellipse() {
    let script = "
        links = { \"block\" }
        local strength
        function init(robot, params) strength = params.strength end
        function run(robot)
            local x, y, z = table.unpack(robot.link.block.position)
            local r = math.sqrt(x * x + y * y + z * z)
            local f = -strength / (r * r * r)
            return { { link = \"block\", force = { f * x, f * y, f * z } } }
        end";
    let body = Body::new([0.1, 0.1, 0.05], 2.0);
    // Kepler: with mu = 4 pi^2 a^3 the period is 1 s; from the nearest point, speed sqrt(mu (1 + e)
    // / (1 - e) / a).
    let (a, e) = (1.0_f64, 0.5_f64);
    let mu = 4.0 * std::f64::consts::PI.powi(2);
    let speed = (mu * (1.0 + e) / (1.0 - e) / a).sqrt();
    for (part, place, velocity) in [
        (1.0, Vector3::new(a * (1.0 - e), 0.0, 0.0), speed),
        (0.5, Vector3::new(-a * (1.0 + e), 0.0, 0.0), -speed * (1.0 - e) / (1.0 + e)),
    ] {
        let base = format!("position = [{}, 0, 0], linear_velocity = [0, {speed}, 0]", a * (1.0 - e));
        let params = format!("{FORCE}params = {{ strength = {} }}\n", mu * body.mass);
        let tight = "integrator = { relative_tolerance = 1e-12, absolute_tolerance = 1e-13 }";
        let text = floating(&body, &base, &params).replace(TIGHT, &format!("\n{tight}\n"));
        let sim = passes(&format!("duration = {part:?}\n{text}"), script);
        let (position, v) = (sim.plant().state.position, &sim.plant().state.v);
        // Integration at relative tolerance 1e-12 over some 500 steps, whose phase errors add up.
        assert!((position - place).norm() < 1e-8, "{position}");
        assert!((v[1] - velocity).abs() < 1e-7, "{v:?}");
        assert!(sim.metrics().max_energy_error_j < 1e-8, "{}", sim.metrics().max_energy_error_j);
    }
}

#[test]
fn a_script_gives_the_same_bits_as_the_built_in_force() {
    let body = Body::new([0.1, 0.1, 0.05], 2.0);
    let script = "function run() return { { link = \"block\", point = { 0.1, 0, 0 }, force = { 1, 2, 3 },
        moment = { 0, 0.1, 0 }, frame = \"link\" } } end";
    let span = "start = 0.1\nduration = 0.3\n";
    let native = "[[force]]\ntype = \"constant\"\nlink = \"block\"\npoint = [0.1, 0, 0]\nforce = [1, 2, 3]
        moment = [0, 0.1, 0]\nframe = \"link\"\n";
    let of = |force: &str| {
        let sim = passes(
            &format!("duration = 0.5\n{}", floating(&body, "position = [0, 0, 1]", &format!("{force}{span}"))),
            script,
        );
        (sim.plant().state.clone(), sim.metrics().steps)
    };
    assert_eq!(of(native), of(FORCE));
}

#[test]
fn joints_are_driven_and_parameters_change_at_corners() {
    // A torque on the elbow that changes its sign: the events are at the changes, and the energy
    // balance closes.
    let script = "
        local torque
        function init(robot, params) torque = params.torque end
        function change(robot, params) torque = params.torque end
        function run(robot) return { { joint = \"elbow\", effort = torque }, { joint = 1, effort = -0.1 * robot.qd[1] } } end";
    let rest = format!("{FORCE}params = {{ torque = 0.2 }}\nchange = [{{ at = 0.15, params = {{ torque = -0.2 }} }}]");
    let mut recorded = Recording::default();
    let mut sim = ScriptedRun::new(&pendulum(0.4, "mode = \"passive\"", &rest), script).simulation();
    let (outcome, message) = sim.run(&mut recorded, &AtomicBool::new(false));
    assert_eq!(outcome, Outcome::Passed, "{message}");
    let messages: Vec<_> =
        recorded.events.iter().filter(|e| e.kind == "force").map(|e| (e.time, e.message.as_str())).collect();
    assert_eq!(messages, [(0.15, "changes")]);
    // Integration at relative tolerance 1e-9 of some J; steps end at the change.
    assert!(sim.metrics().max_energy_error_j < 1e-8, "{}", sim.metrics().max_energy_error_j);
    assert!(sim.metrics().external_work_j.abs() > 1e-3, "{}", sim.metrics().external_work_j);
}

#[test]
fn parameters_set_by_an_event_stay_until_a_later_change() {
    let script = "
        local a, b
        function init(robot, params) a, b = params.a, params.b end
        function change(robot, params) a, b = params.a, params.b end
        function run() return { { link = \"block\", force = { a, b, 0 } } } end";
    let body = Body::new([0.1, 0.1, 0.05], 2.0);
    let change = "change = [{ at = 0.1, params = { a = 2, b = 3 } }, { at = 0.3, params = { a = 7 } }]";
    for (set, [x, y]) in [
        // 0.1 s of 1, 0.1 s of 2, then the value set by the event until the change at 0.3 s; to 0.4
        // s.
        ("\"force.0.params.a\" = 5", [0.1 + 0.2 + 0.5 + 0.7, 0.1 + 0.9]),
        ("\"force.0.params\" = { a = 5, b = 4 }", [0.1 + 0.2 + 0.5 + 0.7, 0.1 + 0.3 + 0.8]),
        // Another value does not reset the changed parameters.
        ("\"force.0.duration\" = 9", [0.1 + 0.2 + 0.2 + 0.7, 0.1 + 0.9]),
    ] {
        let events = format!(
            "[[event]]\nat = 0.2\nset = {{ {set} }}\n[[event]]\nat = 0.35\nset = {{ \"force.0.corners\" = [] }}"
        );
        let rest = format!("{FORCE}params = {{ a = 1, b = 1 }}\n{change}\n{events}\n");
        let text = format!("duration = 0.4\n{}", floating(&body, "position = [0, 0, 1]", &rest));
        let mut recorded = Recording::default();
        let mut sim = ScriptedRun::new(&text, script).simulation();
        let (outcome, message) = sim.run(&mut recorded, &AtomicBool::new(false));
        assert_eq!(outcome, Outcome::Passed, "{message}");
        let v = &sim.plant().state.v;
        // Constant forces between corners, where steps end: rounding.
        assert!((v[0] * 2.0 - x).abs() + (v[1] * 2.0 - y).abs() < 1e-12, "{set}: {v:?}");
        let messages: Vec<f64> = recorded.events.iter().filter(|e| e.kind == "force").map(|e| e.time).collect();
        assert_eq!(messages, [0.1, 0.3], "{set}");
    }
}

#[test]
fn forces_are_functions_of_time_and_state() {
    let body = Body::new([0.1, 0.1, 0.05], 2.0);
    let force = "return { { link = \"block\", force = { x, 0, 0 } } }";
    for (script, expected) in [
        // A counter in a local variable: detected by evaluating twice.
        (format!("local x = 0\nfunction run()\nx += 1\n{force} end"), "s.luau: `run` returned different forces"),
        // Globals are read-only; the error has their line.
        (format!("x = 0\nfunction run()\nx += 1\n{force} end"), "s.luau:3: attempt to modify a readonly table"),
        (format!("function run()\nlocal x = random()\n{force} end"), "s.luau:2: random numbers are drawn at load"),
        (
            format!("function run(robot)\nlocal x = 0\nrobot.set_position(1, 2)\n{force} end"),
            "s.luau:3: attempt to call",
        ),
    ] {
        let text = format!("duration = 0.1\n{}", floating(&body, "position = [0, 0, 1]", FORCE));
        let (outcome, message) = ScriptedRun::new(&text, &script).end(&mut NullObserver);
        assert_eq!(outcome, Outcome::Error, "{script}");
        assert!(message.starts_with(expected), "{script}\n{message}");
        assert!(message.ends_with(" s"), "with its time: {message}");
    }
    // A number drawn before the force acts is a constant.
    let script = format!("local x\nfunction init() x = random() end\nfunction run() {force} end");
    let text = format!("duration = 0.1\n{}", floating(&body, "position = [0, 0, 1]", FORCE));
    assert_eq!(ScriptedRun::new(&text, &script).end(&mut NullObserver).0, Outcome::Passed);
}

#[test]
fn wrong_return_values_end_the_run_at_the_function() {
    let body = Body::new([0.1, 0.1, 0.05], 2.0);
    for (answer, expected) in [
        ("5", "`run` must return a list of forces, not 5"),
        ("{ link = \"block\" }", "`run` must return a list of forces: { { link"),
        ("{ 3 }", "force 1 must be a table, not 3"),
        ("{ { force = { 1, 0, 0 } } }", "force 1: needs `link`, the name of a link, or `joint`; `link` is nil"),
        ("{ { link = \"blok\" } }", "force 1: the robot has no link \"blok\""),
        ("{ { link = \"block\", force = { 1, 2 } } }", "force 1: `force` must be { x, y, z }, three finite numbers"),
        ("{ { link = \"block\", force = { 1, 2, 0/0 } } }", "force 1: `force[3]` must be a finite number, not NaN"),
        ("{ { link = \"block\", force = { 1, 2, \"3\" } } }", "force 1: `force[3]` must be a finite number, not \"3\""),
        ("{ { link = \"block\", forc = { 1, 2, 3 } } }", "force 1: unknown key \"forc\"; known here: link"),
        ("{ { link = \"block\", frame = \"base\" } }", "force 1: `frame` must be \"world\" or \"link\""),
        ("{ { joint = \"knee\", effort = 1 } }", "force 1: the robot has no joint \"knee\""),
    ] {
        let text = format!("duration = 0.1\n{}", floating(&body, "position = [0, 0, 1]", FORCE));
        let script = format!("-- A force.\n\nfunction run() return {answer} end");
        let (outcome, message) = ScriptedRun::new(&text, &script).end(&mut NullObserver);
        assert_eq!(outcome, Outcome::Error, "{answer}");
        assert!(message.starts_with(&format!("s.luau:3: {expected}")), "{answer}\n{message}");
    }
}

#[test]
fn tables_in_globals_are_read_only() {
    let ends =
        |script: &str| ScriptedRun::new(&pendulum(0.05, "mode = \"passive\"", FORCE), script).end(&mut NullObserver);
    let expected = "s.luau:3: attempt to modify a readonly table";
    for (first, body) in [
        ("memory = { n = 0 }", "memory.n += 1"),
        ("memory = { deep = { list = {} } }", "table.insert(memory.deep.list, 1)"),
        ("a = {} b = { [a] = a } a.b = b", "b[a].x = 1"),
    ] {
        let (outcome, message) = ends(&format!("{first}\nfunction run()\n{body}\nend"));
        assert!(outcome == Outcome::Error && message.contains(expected), "{body}: {message}");
    }
    // `init` and `change` may write; tables frozen by the script itself stay frozen.
    let script = "memory = { n = 0 } own = table.freeze({})
        function init() memory.n = 5 assert(table.isfrozen(own)) end
        function run() assert(memory.n == 5 and table.isfrozen(own)) return {} end";
    assert_eq!(ends(script).0, Outcome::Passed);
}

#[test]
fn scripts_read_the_current_gravity() {
    let event = format!("{FORCE}[[event]]\nat = 0.03\nset = {{ gravity = [0, 0, -1.62] }}\n");
    let script = "function run(robot)
            local g = robot.gravity[3]
            assert(if robot.time < 0.03 then g == -9.81 elseif robot.time > 0.031 then g == -1.62 else true, \"g = \" .. g)
            return {}
        end";
    let (outcome, message) =
        ScriptedRun::new(&pendulum(0.05, "mode = \"passive\"", &event), script).end(&mut NullObserver);
    assert_eq!(outcome, Outcome::Passed, "{message}");
}

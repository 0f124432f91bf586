//! Tasks in Luau: their data and commands.

use super::{ScriptedRun, TASK, passes, pendulum, robot};
use crate::support::runs::Recording;
use std::sync::atomic::AtomicBool;
use stiction::sim::{NullObserver, Outcome};

/// `posture`, reimplemented in Luau.
const POSTURE: &str = "
local start, from, goal, duration = 0, {}, {}, 0

function init(robot, params)
    start, duration = robot.time, params.duration
    for name, q in params.joints do
        local joint = robot.joint[name]
        goal[joint] = q
        from[joint] = robot.desired.position[joint]
    end
end

function run(robot)
    local t = robot.time - start
    if t >= duration then
        for joint, q in goal do
            robot.set_position(joint, q)
            robot.set_velocity(joint, 0)
        end
        return \"done\"
    end
    local s = t / duration
    for joint, q in goal do
        local way = q - from[joint]
        robot.set_position(joint, from[joint] + way * s * s * s * (10 + s * (6 * s - 15)))
        robot.set_velocity(joint, way * 30 * s * s * (1 - s) * (1 - s) / duration)
    end
end
";

#[test]
fn a_posture_task_in_luau_moves_like_the_built_in_one() {
    let scenario = |kind: &str| {
        let hoap2 = robot("hoap2/hoap2.toml");
        let joints = "joints = { left_knee = 0.9, right_knee = 0.9, waist_pitch = 0.1 }";
        let task = match kind {
            "script" => format!("file = \"s.luau\"\nparams = {{ duration = 0.3, {joints} }}"),
            _ => format!("duration = 0.3\n{joints}"),
        };
        format!("duration = 0.5\nrobot = {{ model = {hoap2:?} }}\n[[task]]\ntype = {kind:?}\nstart = 0.1\n{task}\n")
    };
    let (native, script) = (passes(&scenario("posture"), POSTURE), passes(&scenario("script"), POSTURE));
    let (a, b) = (&native.plant().state, &script.plant().state);
    let gap = a.joints.iter().zip(&b.joints).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    // The same formulas: the difference is rounding, amplified by the integrator's steps.
    assert!(gap < 1e-12, "{gap}");
    assert!((b.joints[native.plant().model.joint("left_knee").expect("a joint").0] - 0.9).abs() < 0.05, "it moved");
}

#[test]
fn efforts_against_gravity_hold_a_pendulum_still() {
    let script = "
        needs = { \"gravity_effort\" }
        function init(robot)
            assert(robot.desired.mode[1] == \"passive\", robot.desired.mode[1])
        end
        function run(robot)
            for i in robot.joints do
                robot.set_mode(i, \"force\")
                robot.set_effort(i, robot.gravity_effort[i])
            end
        end";
    let sim = passes(&pendulum(0.5, "mode = \"passive\"", TASK), script);
    let state = &sim.plant().state;
    // In equilibrium; no direction is unstable, and the effort is exact to rounding.
    assert!((state.joints[0] - 0.4).abs() < 1e-12 && (state.joints[1] - 0.3).abs() < 1e-12, "{state:?}");
    let free = passes(&pendulum(0.5, "mode = \"passive\"", TASK), "function run() end");
    assert!((free.plant().state.joints[0] - 0.4).abs() > 0.1, "without it falls");
}

#[test]
fn data_of_a_script_task_are_consistent() {
    // The script itself checks all data against each other while the robot falls over.
    let script = "
        needs = { \"com\", \"com_jacobian\", \"com_jacobian_base\", \"mass_matrix\", \"bias\", \"gravity_effort\", \"soles\",
                  \"sole_jacobians\", \"vertex_jacobians\", \"end_effectors\", \"loads\", \"contacts\", \"zmp\", \"support\",
                  \"stable_point\" }
        links = { \"torso\" }
        local function near(a, b, what)
            -- Sums of some thirty products of numbers up to 100.
            if math.abs(a - b) > 1e-10 then error(`{what}: {a} {b}`) end
        end
        local ticks, loaded = 0, 0
        function run(robot)
            ticks += 1
            local v = { robot.base.linear_velocity[1], robot.base.linear_velocity[2], robot.base.linear_velocity[3],
                        robot.base.angular_velocity[1], robot.base.angular_velocity[2], robot.base.angular_velocity[3] }
            for i, rate in robot.qd do v[6 + i] = rate end
            local function times(matrix, row)
                local sum = 0
                for k, x in matrix[row] do sum += x * v[k] end
                return sum
            end
            for i = 1, 3 do
                near(times(robot.com_jacobian, i), robot.com_velocity[i], \"com velocity\")
                near(robot.link.torso.position[i], robot.base.position[i], \"torso\")
                near(robot.link.torso.linear_velocity[i], robot.base.linear_velocity[i], \"torso velocity\")
                for k = 1, 3 do near(robot.link.torso.rotation[i][k], robot.base.rotation[i][k], \"torso axes\") end
            end
            local force = { 0, 0, 0 }
            for name, sole in robot.sole do
                assert(#sole.jacobian == 6 and #sole.vertex_jacobian_1 == 3 and #sole.vertices == #sole.vertex_forces)
                for i = 1, 3 do
                    force[i] += sole.force[i]
                    local sum = 0
                    for _, f in sole.vertex_forces do sum += f[i] end
                    near(sum, sole.force[i], \"sole force\")
                end
            end
            local seen = 0
            for _, contact in robot.contacts do seen += contact[6] end
            near(seen, force[3], \"contacts\")
            -- Mass times gravity from the mass matrix.
            near(robot.gravity_effort[3], -robot.mass_matrix[3][3] * robot.gravity[3], \"weight\")
            for i, row in robot.mass_matrix do
                for k, x in row do near(x, robot.mass_matrix[k][i], \"symmetry\") end
            end
            if robot.zmp then
                loaded += 1
                assert(#robot.zmp == 3 and #robot.support_polygon >= 1 and robot.stable_radius >= 0)
                assert(#robot.stable_point == 3)
            else
                assert(force[3] == 0, \"no zero-moment point only where nothing presses\")
            end
            if robot.time > 0.39 then
                assert(ticks > 390 and loaded > 300, `{ticks} {loaded}`)
                return \"done\"
            end
        end";
    let hoap2 = robot("hoap2/hoap2.toml");
    let push = "[[force]]\ntype = \"push\"\nlink = \"torso\"\nforce = [30, 10, 0]\nduration = 0.2\n";
    let text = format!("duration = 0.4\nrobot = {{ model = {hoap2:?} }}\n{TASK}{push}");
    let (mut sim, mut recorded) = (ScriptedRun::new(&text, script).simulation(), Recording::default());
    let (outcome, message) = sim.run(&mut recorded, &AtomicBool::new(false));
    assert_eq!(outcome, Outcome::Passed, "{message}");
    assert!(
        recorded.events.iter().any(|e| e.kind == "task" && e.message == "task script s.luau ends"),
        "it got to its end"
    );
}

#[test]
fn parameters_change_and_tasks_end() {
    let script = "
        local goal
        function init(robot, params)
            assert(robot.time == 0.1 and params.list[2] == \"b\" and params.yes and params.inner.x == 1.5)
            goal = params.goal
        end
        function change(robot, params)
            assert(params.list[1] == \"a\", \"what does not change stays\")
            goal = params.goal
        end
        function run(robot)
            robot.set_position(\"elbow\", goal)
            return robot.time < 0.5
        end";
    let params = "start = 0.1\nparams = { goal = 0.5, list = [\"a\", \"b\"], yes = true, inner = { x = 1.5 } }
        change = [{ at = 0.2, params = { goal = 0.6 } }, { at = 0.3, params = { goal = 0.7 } }, { at = 0.7, params = { goal = 9 } }]";
    let text = pendulum(0.8, "mode = \"position\", kp = 10.0, kd = 1.0", &format!("{TASK}{params}"));
    let mut recorded = Recording::default();
    let mut sim = ScriptedRun::new(&text, script).simulation();
    let (outcome, message) = sim.run(&mut recorded, &AtomicBool::new(false));
    assert_eq!(outcome, Outcome::Passed, "{message}");
    let tasks: Vec<_> =
        recorded.events.iter().filter(|e| e.kind == "task").map(|e| (e.time, e.message.clone())).collect();
    let expected = |what: &str| format!("task script s.luau {what}");
    let times = [(0.1, "begins"), (0.2, "changes"), (0.3, "changes"), (0.5, "ends")];
    assert_eq!(tasks, times.map(|(t, what)| (t, expected(what))));
    let desired = |t: f64| {
        let s = recorded.snapshots.iter().find(|s| s.time > t).expect("an instant of the log");
        s.q_desired[1]
    };
    assert_eq!([0.05, 0.15, 0.25, 0.35, 0.6].map(desired), [0.3, 0.5, 0.6, 0.7, 0.7]);
}

#[test]
fn later_tasks_win_and_read_earlier_commands() {
    let script = "
        function run(robot)
            local desired = robot.desired.position[1]
            if robot.time > 0 then assert(desired == 0.8, desired) end
            robot.set_position(\"elbow\", desired + 0.1)
            robot.set_gains(2, 20, 2)
            assert(robot.desired.position[2] == desired + 0.1 and robot.desired.kp[2] == 20)
        end";
    let posture = "[[task]]\ntype = \"posture\"\nduration = 1e-4\njoints = { shoulder = 0.8, elbow = 0.1 }\n";
    let sim = passes(&pendulum(0.1, "mode = \"position\"", &format!("{posture}{TASK}")), script);
    let command = &sim.plant().command;
    assert_eq!((command.position[0], command.position[1]), (0.8, 0.8 + 0.1));
    assert_eq!((command.kp[1], command.kd[1], command.kp[0]), (20.0, 2.0, 100.0));
}

#[test]
fn random_numbers_come_from_the_seed() {
    let script = "
        local drawn = {}
        function init() for i = 1, 100 do
            drawn[i] = random()
            assert(0 < drawn[i] and drawn[i] < 1)
            local die = random(6)
            assert(die % 1 == 0 and 1 <= die and die <= 6)
            local between = random(-3, -1)
            assert(-3 <= between and between <= -1)
        end end
        function run(robot) robot.set_position(1, drawn[1] + random()) end";
    let drawn = |seed: u64, tasks: usize| {
        let text = format!("seed = {seed}\n{}", pendulum(0.01, "mode = \"position\"", &TASK.repeat(tasks)));
        passes(&text, script).plant().command.position[0]
    };
    assert_eq!(drawn(1, 1), drawn(1, 1));
    assert_ne!(drawn(1, 1), drawn(2, 1));
    assert_ne!(drawn(1, 1), drawn(1, 2), "each entry has its own");
}

#[test]
fn a_task_may_end_before_it_runs() {
    let text = pendulum(0.1, "mode = \"position\"", &format!("{TASK}duration = 0.05"));
    let script = "function init() return \"done\" end function run() error(\"not called\") end";
    assert_eq!(ScriptedRun::new(&text, script).end(&mut NullObserver).0, Outcome::Passed);
    // It ends at the latest when its duration is over.
    let script = "function run(robot) assert(robot.time < 0.05) end";
    assert_eq!(ScriptedRun::new(&text, script).end(&mut NullObserver).0, Outcome::Passed);
}

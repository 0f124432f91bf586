//! Points that tasks display.

use super::{FORCE, ScriptedRun, TASK, pendulum};
use nalgebra::Vector3;
use stiction::sim::{Observer, Outcome, SimEvent, Snapshot};

/// Collects the points of every snapshot.
#[derive(Default)]
struct Shown(Vec<(f64, Vec<Option<Vector3<f64>>>)>);

impl Observer for Shown {
    fn snapshot(&mut self, snapshot: &Snapshot) -> Result<(), stiction::sim::ObserverError> {
        let names: Vec<_> = snapshot.points.iter().map(|p| p.name.as_str()).collect();
        assert_eq!(names, ["goal", "now and then"]);
        self.0.push((snapshot.time, snapshot.points.iter().map(|p| p.position).collect()));
        Ok(())
    }

    fn event(&mut self, _: &SimEvent) -> Result<(), stiction::sim::ObserverError> {
        Ok(())
    }
}

#[test]
fn points_are_at_the_positions_set_by_a_running_task() {
    let script = "
        points = { \"goal\", \"now and then\" }
        function run(robot)
            robot.set_point(\"goal\", { robot.time, 2, -3 })
            robot.set_point(\"now and then\", if robot.time < 0.2495 then { 1, 1, 1 } else nil)
            if robot.time > 0.3995 then return \"done\" end
        end";
    let scenario = pendulum(0.5, "mode = \"passive\"", &format!("log = {{ rate = 100 }}\n{TASK}start = 0.1\n"));
    let mut shown = Shown::default();
    let (outcome, message) = ScriptedRun::new(&scenario, script).end(&mut shown);
    assert_eq!(outcome, Outcome::Passed, "{message}");
    assert_eq!(shown.0.len(), 51);
    // A log instant that is also a tick may be reported before or after the tick.
    let sure = |time: &f64| [0.1, 0.25, 0.4].iter().all(|jump| (time - jump).abs() > 0.0015);
    for (time, points) in shown.0.into_iter().filter(|(time, _)| sure(time)) {
        assert_eq!(points[0].is_some(), 0.1 < time && time < 0.4, "{time}");
        // The last tick is at most one period of 1 ms ago.
        let late = points[0].map_or(0.0, |goal| (goal - Vector3::new(time, 2.0, -3.0)).norm());
        assert!(late < 1.001e-3, "{time}: {late}");
        assert_eq!(points[1], (0.1 < time && time < 0.25).then_some(Vector3::repeat(1.0)), "{time}");
    }
}

#[test]
fn errors_carry_their_line() {
    let error = |points: &str, call: &str| {
        let script = format!("points = {points}\nfunction run(robot)\n    robot.set_point({call})\nend\n");
        let (outcome, message) =
            ScriptedRun::new(&pendulum(0.1, "mode = \"passive\"", TASK), &script).end(&mut stiction::sim::NullObserver);
        assert_eq!(outcome, Outcome::Error, "{call}");
        assert!(message.contains("s.luau:3: "), "{message}");
        message
    };
    assert!(error("{ \"a\" }", "\"b\", { 0, 0, 0 }").contains("the list `points` has no \"b\""));
    assert!(error("{ \"a\" }", "nil, { 0, 0, 0 }").contains("the list `points` has no nil"));
    assert!(error("{ \"a\" }", "\"a\", { 0, 0 }").contains("a point is {x, y, z}"));
    assert!(error("{ \"a\" }", "\"a\", 1").contains("a point is {x, y, z}"));
    assert!(error("{ \"a\" }", "\"a\", { 0, 0, 0 / 0 }").contains("a coordinate must be a finite number"));
    assert!(error("{ \"a\" }", "\"a\", { 0, 0, \"x\" }").contains("a coordinate must be a number"));
}

#[test]
fn invalid_points_are_refused_before_the_run() {
    let refused = |what: &str, script: &str| {
        let scenario = pendulum(0.1, "mode = \"passive\"", what);
        ScriptedRun::new(&scenario, script).build().err().expect("it is refused").to_string()
    };
    let twice = refused(TASK, "points = { \"a\", \"a\" }\nfunction run() end");
    assert!(twice.contains("names \"a\" twice"), "{twice}");
    let expected = refused(TASK, "points = 1\nfunction run() end");
    assert!(expected.contains("`points` must be a list of strings"), "{expected}");
    let force = refused(FORCE, "points = { \"a\" }\nfunction run() return {} end");
    assert!(force.contains("only tasks show points"), "{force}");
}

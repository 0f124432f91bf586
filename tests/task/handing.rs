//! Hand-over between tasks: modes, efforts, positions, and the instants of beginning and end.

use super::super::motion::{Folder, robot_of};
use stiction::assemble;
use stiction::dynamics::State;
use stiction::robot::DriveMode;
use stiction::task::server::TickInput;
use stiction::task::{Command, SensorReadings};

const CBI: &str = "duration = 1.0
robot = { model = \"ROBOTS/cbi/cbi.toml\", joint_default = { mode = \"position\", kp = 500, kd = 20 } }
";
const HOAP: &str = "duration = 1.5\nrobot = { model = \"ROBOTS/hoap2/hoap2.toml\" }\n";

/// Joint commands with their times.
type Commands = Vec<(f64, Command)>;

/// Joint commands at ticks up to `end` seconds, and the ends of the tasks. The robot stays in its
/// initial state.
fn ticks(folder: &Folder, text: &str, end: f64) -> (Commands, Vec<(String, f64)>) {
    ticks_with_request(folder, text, end, f64::INFINITY, 0)
}

/// The same; from the time `request` on, s, the end of task number `task` is requested.
fn ticks_with_request(
    folder: &Folder,
    text: &str,
    end: f64,
    request: f64,
    task: usize,
) -> (Commands, Vec<(String, f64)>) {
    let run = folder.run(text).unwrap_or_else(|e| panic!("{e}"));
    let mut setup = assemble::setup(&run, &robot_of(&run)).unwrap_or_else(|e| panic!("{e}"));
    let mut state = State::home(&setup.model);
    (state.position, state.rotation) = (setup.start.position, setup.start.rotation);
    state.joints.copy_from_slice(&setup.start.joints);
    let sensed = SensorReadings::blank(&setup.model);
    let (mut commands, mut ended) = (Vec::new(), Vec::new());
    while let Some(time) = setup.tasks.next_tick().filter(|t| *t <= end + 1e-9) {
        state.time = time;
        if time > request - 1e-9 {
            setup.tasks.end(task);
        }
        let now = TickInput {
            model: &setup.model,
            gravity: setup.gravity,
            floor: setup.floor.plane(),
            state: &state,
            sensed: &sensed,
        };
        let hear = |what: &str, name: &str| {
            if what == "ends" {
                ended.push((name.to_owned(), time));
            }
        };
        setup.tasks.run(&now, hear).unwrap_or_else(|e| panic!("{e}"));
        commands.push((time, setup.tasks.command.clone()));
    }
    (commands, ended)
}

/// Position and velocity of the elbow of `PENDULUM` at a tick.
fn elbow_at(commands: &[(f64, Command)], time: f64) -> (f64, f64) {
    let tick = commands.iter().find(|(t, _)| (t - time).abs() < 1e-9).expect("a tick");
    (tick.1.position[1], tick.1.velocity[1])
}

/// Greatest change of the elbow's position from a tick to the next.
fn greatest_step(commands: &[(f64, Command)]) -> f64 {
    commands.windows(2).map(|w| (w[1].1.position[1] - w[0].1.position[1]).abs()).fold(0.0, f64::max)
}

fn force(kind: &str, start: f64, duration: f64) -> String {
    let control = if kind == "balance" { "control = \"force\"\n" } else { "" };
    format!("[[task]]\ntype = \"{kind}\"\n{control}start = {start}\nduration = {duration}\n")
}

#[test]
fn modes_and_efforts_are_restored_in_any_order() {
    let compensate = |start, duration| force("gravity-compensation", start, duration);
    let balance = |start, duration| force("balance", start, duration);
    let folder = Folder::with(&[]);
    for tasks in [
        format!("{}{}", balance(0.0, 0.04), compensate(0.03, 0.03)),
        format!("{}{}", balance(0.0, 0.06), compensate(0.02, 0.02)),
        format!("{}{}", compensate(0.03, 0.03), balance(0.0, 0.03)),
        format!("{}{}", compensate(0.0, 0.03), balance(0.03, 0.03)),
    ] {
        let (commands, _) = ticks(&folder, &format!("{CBI}{tasks}"), 1.0);
        let own = &commands.last().unwrap().1.mode;
        assert!(own.iter().filter(|m| **m == DriveMode::Position).count() > 20 && !own.contains(&DriveMode::Force));
        for (time, command) in &commands {
            // Kinematic joints stay kinematic.
            let lent = |m: &DriveMode| if *m == DriveMode::Position { DriveMode::Force } else { *m };
            let expected = own.iter().map(|m| if *time < 0.06 - 1e-9 { lent(m) } else { *m });
            assert!(command.mode.iter().copied().eq(expected), "{time}:\n{tasks}");
        }
        let last = |before: f64| &commands.iter().rev().find(|(t, _)| *t < before - 1e-9).unwrap().1;
        let (first, end) = (&commands.iter().find(|(t, _)| *t > 0.06 - 1e-9).unwrap().1, &commands.last().unwrap().1);
        // The efforts continue as feed-forward and decay: with servos alone the robot would sag.
        assert_eq!(first.effort, last(0.06).effort, "{tasks}");
        assert!(first.effort.iter().any(|e| e.abs() > 1.0));
        assert!(end.effort.iter().all(|e| *e == 0.0), "{tasks}");
        assert!((commands.last().unwrap().0 - 0.56).abs() < 1e-9, "it ticks on until they have faded");
    }
}

#[test]
fn efforts_of_a_squat_decay_after_its_end() {
    let task = "[[task]]\ntype = \"squat\"\ndepth = 0.005\nperiod = 0.2\nsettle = 0.1\n";
    let follows = "[[task]]\ntype = \"posture\"\nstart = 0.3\njoints = { left_elbow = -0.5 }\n";
    let (commands, ended) = ticks(&Folder::with(&[]), &format!("{HOAP}{task}{follows}"), 1.5);
    assert_eq!(ended[0].0, "squat");
    let most = |c: &Command| c.effort.iter().fold(0.0, |m: f64, e| m.max(e.abs()));
    let at = |time: f64| &commands.iter().find(|(t, _)| (t - time).abs() < 1e-9).unwrap().1;
    assert!(most(at(0.3)) > 0.5 && most(at(0.8)) == 0.0, "{} {}", most(at(0.3)), most(at(0.8)));
    // A quintic decreases by at most 15/8 of the mean: over 0.5 s and ticks of 1 ms.
    for pair in commands.windows(2).filter(|w| w[0].0 > 0.3 - 1e-9) {
        let steps = pair[0].1.effort.iter().zip(&pair[1].1.effort).map(|(a, b)| (a - b).abs());
        assert!(steps.fold(0.0, f64::max) < 1.01 * 15.0 / 8.0 / 500.0 * most(at(0.3)), "{}", pair[0].0);
    }
}

const PENDULUM: &str = "duration = 4.0
robot = { model = \"ROBOTS/pendulum/pendulum.urdf\", posture = { shoulder = 0.3, elbow = -0.2 } }
";

#[test]
fn an_earlier_task_resumes_a_joint_without_a_jump() {
    let tasks = "[[task]]\ntype = \"posture\"\nstart = 0.1\nduration = 0.7\njoints = { shoulder = -1.3, elbow = 6 }
        [[task]]\ntype = \"posture\"\nstart = 0.5\nduration = 0.2\njoints = { elbow = 0.5 }\n";
    let (commands, _) = ticks(&Folder::with(&[]), &format!("{PENDULUM}{tasks}"), 2.0);
    // The later task releases the joint at 0.7 s, some 5 rad from the position of the earlier one.
    // Both and the fade have speeds of at most 15/8 of 6.2 rad in 0.7 s, of 3 rad in 0.2 s and of
    // 5.5 rad in 0.5 s, including the difference of speeds.
    let moving = |w: &&[(f64, Command)]| w[0].0 > 0.5 + 1e-9;
    let steps = commands.windows(2).filter(moving).map(|w| (w[1].1.position[1] - w[0].1.position[1]).abs());
    assert!(steps.clone().fold(0.0, f64::max) < 0.06, "{}", steps.fold(0.0, f64::max));
    // Velocities are consistent with positions, through both ends.
    for w in commands.windows(3).filter(|w| w[0].0 > 0.503) {
        let slope = (w[2].1.position[1] - w[0].1.position[1]) / 2e-3;
        // Second differences of a path with accelerations of some 10 / 0.2^2 rad/s^2.
        assert!((slope - w[1].1.velocity[1]).abs() < 0.15, "{}: {slope} {}", w[1].0, w[1].1.velocity[1]);
    }
    let (time, last) = commands.last().unwrap();
    assert!((last.position[1] - 6.0).abs() < 1e-12 && last.velocity[1] == 0.0, "{time} {last:?}");
    assert!((time - 1.2).abs() < 1e-9, "{time}");
}

const SINE: &str = "[[task]]\ntype = \"sine\"\nramp = 0\n";

#[test]
fn a_joint_rests_where_a_task_is_ended() {
    let sine = |file: &str| format!("{file}{SINE}joints = {{ elbow = {{ amplitude = 0.5, frequency = 1 }} }}\n");
    let (commands, ended) = ticks_with_request(&Folder::with(&[]), &sine(PENDULUM), 2.0, 0.3, 0);
    assert_eq!(ended, [("sine".to_owned(), 0.3)]);
    let [.., (_, moving), (_, held)] = &commands[..] else { panic!("two ticks") };
    assert!(moving.velocity[1] < -0.9, "{moving:?}");
    assert_eq!((held.position[1], held.velocity[1]), (moving.position[1], 0.0));

    // Nothing holds a position in mode `velocity`: a wheel turns on.
    let wheel = PENDULUM.replace("posture =", "joint.elbow = { mode = \"velocity\", kd = 5 }, posture =");
    let (commands, _) = ticks_with_request(&Folder::with(&[]), &sine(&wheel), 2.0, 0.3, 0);
    let [.., (_, moving), (_, held)] = &commands[..] else { panic!("two ticks") };
    assert_eq!(moving.velocity[1], held.velocity[1]);
}

#[test]
fn an_earlier_task_resumes_a_joint_without_a_jump_when_the_later_one_is_ended() {
    let below = format!("{SINE}joints = {{ elbow = {{ amplitude = 0.5, frequency = 0.5 }} }}\n");
    let above = "[[task]]\ntype = \"posture\"\nduration = 5\njoints = { elbow = 3 }\n";
    let text = format!("{PENDULUM}{below}{above}");
    let (commands, ended) = ticks_with_request(&Folder::with(&[]), &text, 4.0, 2.2, 1);
    assert!((ended[0].1 - 2.2).abs() < 1e-9 && ended[0].0 == "posture", "{ended:?}");
    // Speeds: 1.6 rad/s of the sine, and 15/8 of less than 2 rad in 0.5 s; 1 ms between ticks.
    assert!(greatest_step(&commands) < 1e-2, "{}", greatest_step(&commands));
    // Half a second later the sine alone commands the joint, from its initial angle.
    let (sine, slope) = (std::f64::consts::PI * 2.7).sin_cos();
    let (q, v) = elbow_at(&commands, 2.7);
    assert!((q - (-0.2 + 0.5 * sine)).abs() < 1e-12, "{q}");
    assert!((v - 0.5 * std::f64::consts::PI * slope).abs() < 1e-12, "{v}");
}

#[test]
fn two_tasks_end_in_one_tick_without_a_jump() {
    let below = format!("{SINE}joints = {{ elbow = {{ amplitude = 0.5, frequency = 0.5 }} }}\n");
    let middle = "[[task]]\ntype = \"posture\"\nduration = 0.3\njoints = { elbow = 0.7 }\n";
    let above = format!("{SINE}joints = {{ elbow = {{ amplitude = 0.4, frequency = 1 }} }}\n");
    let text = format!("{PENDULUM}{middle}{above}");
    let (commands, ended) = ticks_with_request(&Folder::with(&[]), &text, 0.4, 0.3, 1);
    assert!(ended.len() == 2 && ended.iter().all(|(_, time)| (time - 0.3).abs() < 1e-9), "{ended:?}");
    // The later one held the joint, half a radian from the goal of the other.
    let last = elbow_at(&commands, 0.299).0;
    assert!((last - (-0.2 + 0.4 * (std::f64::consts::TAU * 0.299).sin())).abs() < 1e-12);
    assert_eq!(elbow_at(&commands, 0.3), (last, 0.0));

    let text = format!("{PENDULUM}{below}{middle}{above}");
    let (commands, _) = ticks_with_request(&Folder::with(&[]), &text, 1.0, 0.3, 2);
    // At 0.3 s the sine below has another position by 0.02 rad, the posture by 0.5 rad. Speeds are below 3 rad/s.
    assert!(greatest_step(&commands) < 3e-3, "{}", greatest_step(&commands));
    let sine = -0.2 + 0.5 * (std::f64::consts::PI * 0.9).sin();
    assert!((elbow_at(&commands, 0.9).0 - sine).abs() < 1e-12, "{:?} {sine}", elbow_at(&commands, 0.9));
}

#[test]
fn a_velocity_that_a_script_repeats_ends_with_it() {
    let folder = Folder::with(&[("s.luau", "function run(robot) robot.set_velocity(\"elbow\", 1.5) end")]);
    let task = "[[task]]\ntype = \"script\"\nfile = \"s.luau\"\nduration = 0.2\n";
    let (commands, _) = ticks(&folder, &format!("{PENDULUM}{task}"), 0.5);
    let [.., (_, moving), (_, held)] = &commands[..] else { panic!("two ticks") };
    assert_eq!((moving.velocity[1], held.velocity[1]), (1.5, 0.0));
}

#[test]
fn servos_hold_the_present_posture_where_a_task_by_force_is_ended() {
    let posture = "[[task]]\ntype = \"posture\"\nduration = 0.1\njoints = { elbow = 0.4 }\n";
    let compensation = "[[task]]\ntype = \"gravity-compensation\"\nstart = 0.2\n";
    let text = format!("{PENDULUM}{posture}{compensation}");
    let (commands, ended) = ticks_with_request(&Folder::with(&[]), &text, 0.4, 0.3, 1);
    assert_eq!(ended[1].0, "gravity-compensation");
    // The robot of `ticks` does not move; its elbow is where it was at first.
    assert_eq!((elbow_at(&commands, 0.299).0, elbow_at(&commands, 0.3).0), (0.4, -0.2));
}

#[test]
fn tasks_end_at_their_end_times() {
    let script = "function run() end";
    let folder = Folder::with(&[("s.luau", script), ("m.csv", "time,left_elbow\n0,0\n0.2,-0.1\n")]);
    let span = "start = 0.5\nduration = 0.2\n";
    let tasks = [
        format!("type = \"posture\"\njoints = {{ left_elbow = -0.3 }}\n{span}"),
        format!("type = \"sine\"\njoints = {{ head_pan = {{ amplitude = 0.1 }} }}\nramp = 0.05\n{span}"),
        format!("type = \"script\"\nfile = \"s.luau\"\n{span}"),
        format!("type = \"balance\"\ncontrol = \"force\"\n{span}"),
        format!("type = \"gravity-compensation\"\n{span}"),
        format!("type = \"balance\"\ncontrol = \"position\"\n{span}"),
        "type = \"squat\"\ndepth = 0.001\nperiod = 0.1\nsettle = 0.1\nstart = 0.5\n".to_owned(),
        "type = \"playback\"\nfile = \"m.csv\"\nblend = 0.2\nstart = 0.5\n".to_owned(),
        "type = \"mocap\"\nfile = \"m.csv\"\nblend = 0.2\nsmoothing = 0\nmap = { left_elbow = { joint = \"left_elbow\" } }\n\
         start = 0.5\n"
            .to_owned(),
    ];
    for task in tasks {
        let (_, ended) = ticks(&folder, &format!("{HOAP}[[task]]\n{task}"), 1.0);
        assert_eq!(ended.len(), 1, "{task}");
        // 0.5 + 0.2 is not 0.7 to the last bit; the tick at 0.7 s is still the end.
        assert!((ended[0].1 - 0.7).abs() < 1e-9, "{task}{ended:?}");
    }
}

#[test]
fn a_start_between_two_ticks_is_time_0() {
    let folder = Folder::with(&[("m.csv", "time,elbow\n0,-0.2\n1,0.8\n")]);
    let quintic = |s: f64| s * s * s * (10.0 + s * (6.0 * s - 15.0));
    for (task, path) in [
        ("type = \"posture\"\njoints = { elbow = 0.8 }\n", &quintic as &dyn Fn(f64) -> f64),
        ("type = \"playback\"\nfile = \"m.csv\"\nblend = 0\n", &quintic),
        (
            "type = \"mocap\"\nfile = \"m.csv\"\nblend = 0\nsmoothing = 0\nmap = { elbow = { joint = \"elbow\" } }\n",
            &|t| t,
        ),
    ] {
        let text = format!("{PENDULUM}[control]\nrate = 100\n[[task]]\n{task}start = 0.5037\n");
        let (commands, _) = ticks(&folder, &text, 2.0);
        assert!((commands[0].0 - 0.51).abs() < 1e-12);
        for (time, command) in commands.iter().filter(|(t, _)| *t < 1.5) {
            let expected = -0.2 + path(time - 0.5037);
            // Rounding, including the minimum-jerk curve.
            assert!((command.position[1] - expected).abs() < 1e-12, "{task}{time}: {} {expected}", command.position[1]);
        }
    }
}

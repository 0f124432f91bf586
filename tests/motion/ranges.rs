//! Goals outside joints' ranges, joints that ignore commands, and swings too fast for the ticks.

use super::{Folder, PENDULUM, TickCommand, commands, robot_of, unsteadiness};
use stiction::assemble;

const HOAP: &str = "duration = 0.1\nrobot = { model = \"ROBOTS/hoap2/hoap2.toml\" }\n";

#[track_caller]
fn refused(text: &str, expected: &str) {
    let found = Folder::with(&[]).refused(text).to_string();
    assert!(found.contains(expected) && found.contains("s.toml:"), "{text}{found}");
}

fn notes(text: &str) -> Vec<String> {
    let run = Folder::with(&[]).run(text).unwrap_or_else(|e| panic!("{e}"));
    assemble::setup(&run, &robot_of(&run)).unwrap_or_else(|e| panic!("{e}")).notes
}

#[test]
fn goals_are_within_ranges() {
    let range = "is outside its range, -0.0175 to 2.2689 rad";
    let posture = |q: &str| format!("[[task]]\ntype = \"posture\"\njoints = {{ left_knee = {q} }}\n");
    let sine = |swing: &str| format!("[[task]]\ntype = \"sine\"\njoints = {{ left_knee = {{ {swing} }} }}\n");
    refused(&format!("{HOAP}{}", posture("5.0")), &format!("the goal `left_knee` = 5.0000 rad {range}"));
    refused(&format!("{HOAP}{}", posture("\"-10 deg\"")), range);
    refused(&format!("{HOAP}{}", sine("amplitude = 5")), range);
    refused(
        &format!("{HOAP}{}", sine("amplitude = -0.5, offset = 2.0")),
        "the oscillation of `left_knee` = 2.5000 rad",
    );
    let change = "change = [{ at = 0.05, joints = { left_knee = { offset = 2.1 } } }]\nramp = 0.01\n";
    refused(
        &format!("{HOAP}{}{change}", sine("amplitude = 0.3, offset = 1.0")),
        "the oscillation of `left_knee` = 2.4000 rad",
    );
    let start = HOAP.replace("hoap2.toml\"", "hoap2.toml\", posture = { left_knee = 3.0 }");
    refused(&start, &format!("the initial posture `left_knee` = 3.0000 rad {range}"));
    // Without end stops there is no range.
    let free = HOAP.replace("hoap2.toml\"", "hoap2.toml\", joint_limits = \"ignore\", posture = { left_knee = 3.0 }");
    notes(&format!("{free}{}{}", posture("5.0"), sine("amplitude = 5")));
    // At a limit, in degrees.
    notes(&format!("{HOAP}{}", posture("\"130 deg\"")));
    // The middle is known only when the task begins.
    let text = format!("{HOAP}{}", sine("amplitude = 1.1"));
    let run = Folder::with(&[]).run(&text).unwrap();
    let setup = assemble::setup(&run, &robot_of(&run)).unwrap_or_else(|e| panic!("{e}"));
    let mut sim = stiction::sim::Simulation::new(setup).unwrap_or_else(|e| panic!("{e}"));
    let (outcome, expected) = sim.run(&mut stiction::sim::NullObserver, &std::sync::atomic::AtomicBool::new(false));
    assert_eq!(outcome, stiction::sim::Outcome::Error);
    assert!(expected.contains("the oscillation of `left_knee`, 1.1000 about"), "{expected}");
}

#[test]
fn ignored_commands_are_reported() {
    let with =
        |mode: &str| PENDULUM.replace("posture", &format!("joint = {{ elbow = {{ mode = \"{mode}\" }} }}, posture"));
    let posture = "[[task]]\ntype = \"posture\"\njoints = { elbow = 0.5 }\n";
    for mode in ["force", "passive"] {
        let notes = notes(&format!("{}{posture}", with(mode)));
        assert_eq!(notes, [format!("task.0: `elbow` is in mode `{mode}` and does not follow positions")]);
    }
    assert!(notes(&format!("{PENDULUM}{posture}")).is_empty());
    let fast = "[[task]]\ntype = \"sine\"\njoints = { elbow = { amplitude = 0.1, frequency = 500 } }\n";
    let notes = notes(&format!("{PENDULUM}{fast}"));
    assert!(notes.len() == 1 && notes[0].contains("500 Hz is not below half of `control.rate`"), "{notes:?}");
}

#[test]
fn a_loop_that_starts_late_starts_at_its_beginning() {
    let folder = Folder::with(&[("m.csv", "time,elbow\n0.5,0.2\n0.8,0.5\n1.2,-0.1\n1.5,0.2\n")]);
    let text = format!("{PENDULUM}[[task]]\ntype = \"playback\"\nfile = \"m.csv\"\nloop = true\nblend = 0.3\n");
    let commanded: Vec<TickCommand> = commands(&folder, &text);
    let (apart, step) = unsteadiness(&commanded, 1, &[]);
    // Speeds of some 3 rad/s that change within 0.1 s, in ticks of 1 ms; the third derivative of
    // the fade.
    assert!(apart < 1e-2 && step < 0.1, "{apart} {step}");
    assert!((commanded[1200].position[1] + 0.1).abs() < 1e-12 && (commanded[2200].position[1] + 0.1).abs() < 1e-12);
}

#[test]
fn a_byte_order_mark_is_not_part_of_a_name() {
    let text = format!("{PENDULUM}[[task]]\ntype = \"playback\"\nfile = \"m.csv\"\n");
    let table = "\u{feff}time,elbow\n0,0\n1,0.5\n";
    let commanded = commands(&Folder::with(&[("m.csv", table)]), &text);
    assert!((commanded[2000].position[1] - 0.5).abs() < 1e-12);
}

#[test]
fn captured_motions_have_bounds() {
    let folder = Folder::with(&[("m.csv", "time,a\n0,0\n100,1\n")]);
    let map = "map = { a = { joint = \"elbow\" } }\n[control]\nrate = 1e6\n";
    let found = folder.refused(&format!("{PENDULUM}[[task]]\ntype = \"mocap\"\nfile = \"m.csv\"\n{map}")).to_string();
    assert!(found.contains("at most 10000000 are allowed"), "{found}");
}

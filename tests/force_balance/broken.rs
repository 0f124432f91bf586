//! Entries that do not fit the robot are refused with their positions.

use crate::support::runs::root;
use stiction::{assemble, robot, scenario};

/// The error of a scenario.
fn wrong(text: &str) -> String {
    let found = scenario::parse(&root().join("test.toml"), text).and_then(|file| {
        let runs = file.expand(&[])?;
        let robot = robot::load(&runs[0].resolve(&runs[0].scenario.robot.model)).unwrap_or_else(|e| panic!("{e}"));
        assemble::setup(&runs[0], &robot)
    });
    found.err().map_or_else(|| panic!("accepted:\n{text}"), |e| e.to_string())
}

#[test]
fn invalid_entries_are_errors() {
    let block = "robot = { model = \"robots/block/block.toml\" }\n";
    let task = "[[task]]\ntype = \"balance\"\ncontrol = \"force\"\n";
    let cases = [
        (format!("{block}{task}soles = [\"bottom\", \"hand\"]\n"), "test.toml:5:20", "has no sole `hand`"),
        (format!("{block}{task}soles = [\"bottom\", \"bottom\"]\n"), "test.toml:5:20", "named twice"),
        (format!("{block}{task}soles = []\n"), "test.toml:5:9", "must name at least one sole"),
        (block.replace(" }", ", soles = [] }") + task, "test.toml:3:8", "has no soles to stand on"),
        (format!("{block}[[task]]\ntype = \"balance\"\n"), "test.toml:2:1", "lacks the key `control`"),
        (format!("{block}{task}force = {{ friction = 0 }}\n"), "test.toml:5:22", "must be greater than 0"),
        (format!("{block}{task}force = {{ margin = 1.5 }}\n"), "test.toml:5:20", "must be between 0 and 1"),
        (format!("{block}{task}force = {{ com = {{ kp = -1, kd = 0 }} }}\n"), "test.toml:5:24", "must be 0 or greater"),
        (format!("{block}{task}force = {{ com = {{ kp = 1 }} }}\n"), "test.toml:5:17", "lacks the key `kd`"),
        (format!("{block}{task}force = {{ contacts = \"felt\" }}\n"), "test.toml:5:22", "cannot be \"felt\""),
        (format!("{block}{task}duration = 0\n"), "test.toml:5:12", "must be greater than 0"),
        (
            format!("{block}{task}change = [{{ at = 1, position = {{ damping = 1 }} }}]\n"),
            "test.toml:5:32",
            "has no meaning with `control = \"force\"`",
        ),
        (format!("{block}{task}change = [{{ at = 1 }}]\n"), "test.toml:5:11", "`task.0.change.0` needs `force`"),
        (
            format!("{block}{task}start = 2\nchange = [{{ at = 1, force = {{ margin = 0 }} }}]\n"),
            "test.toml:6:18",
            "must not be before `start` = 2",
        ),
        (
            format!("{block}{task}change = [{{ at = 1, force = {{}} }}, {{ at = 1, force = {{}} }}]\n"),
            "test.toml:5:42",
            "must be after the previous change, at 1",
        ),
        (
            format!("{block}{task}change = [{{ at = 1, force = {{ contacts = \"sensed\" }} }}]\n"),
            "test.toml:5:31",
            "unknown key `contacts`",
        ),
        (
            format!("{block}[[task]]\ntype = \"gravity-compensation\"\nchange = [{{ at = 1, damping = -1 }}]\n"),
            "test.toml:4:31",
            "must be 0 or greater",
        ),
        (
            format!("{block}[[task]]\ntype = \"gravity-compensation\"\ndampin = 1\n"),
            "test.toml:4:1",
            "unknown key `dampin`",
        ),
    ];
    for (text, place, message) in cases {
        let found = wrong(&text);
        assert!(found.contains(place) && found.contains(message), "expected {place} {message}\n{found}");
    }
}

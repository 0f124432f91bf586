//! Robot files, URDFs and MJCF files as input of users.

mod adjust;
mod broken_file;
mod broken_mjcf;
mod broken_urdf;
mod cbi;
mod closed_loops;
mod convention;
mod example_robots;
mod figures;
mod finding;
mod hoap2;
mod inspect_json;
mod joints;
mod meshes;
mod mjcf;
mod notices;
mod payload;
mod quadruped;
mod repair;
mod sdf;
mod transmissions;
mod welding;

use std::path::{Path, PathBuf};

use stiction::robot::{Robot, RobotError, load};

/// A link of 1 kg with a spherical inertia.
pub const BODY: &str =
    r#"<inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>"#;

/// A robot that ships with the program.
pub fn shipped(path: &str) -> Robot {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots").join(path);
    load(&path).unwrap_or_else(|e| panic!("{}", e.render(false)))
}

/// Files written into a temporary folder.
pub fn folder(files: &[(&str, &str)]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in files {
        let path = folder.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    }
    folder
}

/// Loads a URDF given as text.
pub fn load_urdf(text: &str) -> Result<Robot, RobotError> {
    let folder = folder(&[("robot.urdf", text)]);
    load(&folder.path().join("robot.urdf"))
}

/// Loads an MJCF file given as text.
pub fn load_mjcf(text: &str) -> Result<Robot, RobotError> {
    let folder = folder(&[("robot.xml", text)]);
    load(&folder.path().join("robot.xml"))
}

/// Loads a robot file given as text, next to its URDF.
pub fn load_toml(toml: &str, urdf: &str) -> Result<Robot, RobotError> {
    let folder = folder(&[("robot.toml", toml), ("robot.urdf", urdf)]);
    load(&folder.path().join("robot.toml"))
}

/// Asserts that loading fails with this line and text, and that the message quotes the line.
pub fn assert_fault(case: &str, result: Result<Robot, RobotError>, file: &str, line: usize, needle: &str) {
    let error = match result {
        Ok(_) => panic!("{case}: loaded"),
        Err(error) => error,
    };
    let shown = error.render(false);
    let diagnostic = error.diagnostic();
    let (source, _) = diagnostic.marked().unwrap_or_else(|| panic!("{case}: no position in {shown}"));
    let marked = source.text().lines().nth(diagnostic.line() - 1).unwrap_or_default();
    assert_eq!(diagnostic.line(), line, "{case}: wrong line in\n{shown}");
    assert_eq!(source.path().file_name(), PathBuf::from(file).file_name(), "{case}: {shown}");
    assert!(error.to_string().contains(needle), "{case}: `{needle}` is not in `{error}`");
    assert!(shown.contains(&format!("{file}:{line}:")), "{case}: no place in\n{shown}");
    assert!(shown.contains(marked.trim()), "{case}: the line is not shown in\n{shown}");
    assert!(shown.contains('^'), "{case}: no caret in\n{shown}");
}

//! World files: expanded into a scenario, which is prepared up to its start. The first byte selects
//! the format. The reader opens files, so the bytes are written to one.

use std::path::Path;

use stiction::{robot, scenario};

use super::scratch;

/// Formats by letter: the file's extension.
pub const KINDS: [(u8, &str); 2] = [(b's', "sdf"), (b'm', "xml")];

/// Reads a world; the first byte is the letter of its format.
pub fn take(data: &[u8]) {
    let Some((kind, bytes)) = data.split_first() else { return };
    let Some((_, extension)) = KINDS.iter().find(|(k, _)| k == kind) else { return };
    let folder = scratch::folder("world");
    scratch::write(&folder.join(format!("world.{extension}")), bytes);
    let ground = "<robot name=\"ground\"><link name=\"world\"/></robot>";
    scratch::write(&folder.join("ground.urdf"), ground.as_bytes());
    let text = format!("duration = 0.1\n[robot]\nmodel = \"ground.urdf\"\n[world]\nfile = \"world.{extension}\"\n");
    prepare(&folder, &text);
}

/// Prepares the run of a scenario as far as it is valid.
fn prepare(folder: &Path, text: &str) {
    let file = scenario::parse(&folder.join("fuzzed.toml"), text).expect("a valid scenario");
    let runs = match file.expand(&[]) {
        Ok(runs) => runs,
        Err(errors) => return drop(errors.to_string()),
    };
    for run in &runs {
        let _ = run.warnings.to_string();
        let robot = robot::load(&run.resolve(&run.scenario.robot.model)).expect("a valid robot");
        if let Err(errors) = stiction::assemble::setup(run, &robot) {
            let _ = errors.to_string();
        }
    }
}

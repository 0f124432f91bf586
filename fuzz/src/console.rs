//! Lines of a console session. Files are written only to a folder of the target, for which `OUT`
//! stands in the input.

use std::path::PathBuf;

use stiction::batch;
use stiction::console::{Session, complete};

use super::{scratch, tree};

/// Most lines of a session, and most bytes of a line.
const MOST_LINES: usize = 12;
const MOST_BYTES: usize = 400;

/// Most slices of time for the run or playback of a line.
const MOST_SLICES: usize = 3;

const SCENARIO: &str = r#"
duration = 1.0
control.rate = 100.0
[robot]
model = "MODEL"
base = { position = [0, 0, 0.05], linear_velocity = [1, 0, 0] }
[log]
rate = 100
"#;

/// A session with a block, held at its start.
pub fn session() -> Session {
    let path = scratch::folder("console").join("s.toml");
    if !path.exists() {
        let model = tree::root().join("robots/block/block.toml");
        scratch::write(&path, SCENARIO.replace("MODEL", model.to_str().expect("UTF-8")).as_bytes());
    }
    let (plan, _) = batch::prepare(&[path], &[], 1).expect("a sound scenario");
    Session::new(plan.job(0), 10.0, None).expect("a session")
}

/// Executes the lines of a session.
pub fn take(data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else { return };
    let out = scratch::folder("console-out");
    let mut session = session();
    for line in text.lines().take(MOST_LINES).filter(|line| line.len() <= MOST_BYTES) {
        if writes_elsewhere(line) {
            continue;
        }
        let line = line.replace("OUT", out.to_str().expect("UTF-8"));
        let names = session.names();
        for end in (0..=line.len()).filter(|end| line.is_char_boundary(*end)).take(64) {
            let _ = complete(&names, &line, end);
        }
        execute(&mut session, &line);
        let _ = session.prompt();
        if session.has_ended() {
            break;
        }
    }
    session.end_stream();
    let saved = out.join("session.toml");
    if saved.exists() {
        stiction::scenario::load(&saved).and_then(|file| file.expand(&[])).expect("a saved session is a scenario");
        let _ = std::fs::remove_file(saved);
    }
}

/// True if the line may write a file that is not in the folder of the target.
fn writes_elsewhere(line: &str) -> bool {
    let plain: String = line.chars().filter(|c| !matches!(c, '"' | '\'' | '\\' | '\u{feff}')).collect();
    let writes = ["save", "export"].iter().any(|name| plain.contains(name));
    let own = ["save session OUT/session.toml", "save recording OUT/r.mcap", "export OUT/t.csv", "export OUT/t.dat"];
    writes && (!own.iter().any(|begin| line.starts_with(begin)) || line.contains("../"))
}

/// Executes a line and some of the run or playback that it starts.
pub fn execute(session: &mut Session, line: &str) {
    if let Err(error) = session.execute(line) {
        let _ = (error.to_string(), error.render(false), error.render(true));
    }
    for _ in 0..MOST_SLICES {
        if session.due().is_none() {
            break;
        }
        let _ = session.work(&mut |_| ());
    }
    let _ = session.hold();
}

/// Lines of sessions: those of the tests, and one of each command.
pub fn seeds() -> Vec<String> {
    let all: PathBuf = tree::root().join("fuzz/seeds/console");
    let mut files: Vec<_> = std::fs::read_dir(all).expect("seeds").map(|file| file.expect("a file").path()).collect();
    files.sort();
    files.iter().map(|file| super::samples::text(file)).collect()
}

//! Folders in which the program runs, and what it leaves there.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use tempfile::TempDir;

/// A temporary folder with a copy of the block's robot files in `block/`.
pub struct Place {
    folder: TempDir,
}

impl Place {
    pub fn new() -> Self {
        let place = Place { folder: tempfile::tempdir().unwrap() };
        fs::create_dir(place.path("block")).unwrap();
        for name in ["block.toml", "block.urdf"] {
            let from = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/block").join(name);
            fs::copy(from, place.path("block").join(name)).unwrap();
        }
        place
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Writes a file and creates its folder if it does not exist.
    pub fn write(&self, name: &str, text: impl AsRef<[u8]>) -> &Self {
        let path = self.path(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
        self
    }

    /// Writes a scenario of the block: `text` follows the first line of its `[robot]` table.
    pub fn block(&self, name: &str, text: &str) -> &Self {
        self.write(name, format!("[robot]\nmodel = \"block/block.toml\"\n{text}"))
    }

    pub fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_runner"));
        command.args(arguments).current_dir(self.folder.path()).env("NO_COLOR", "1");
        command
    }

    /// Runs the program and waits for its end.
    pub fn runner(&self, arguments: &[&str]) -> Done {
        Done::from(self.command(arguments).output().unwrap())
    }

    /// Runs a shell command in this folder. In it, `$0` is the program.
    #[cfg(unix)]
    pub fn shell(&self, line: &str) -> Done {
        let mut shell = Command::new("sh");
        shell.args(["-c", line, env!("CARGO_BIN_EXE_runner")]).current_dir(self.folder.path()).env("NO_COLOR", "1");
        Done::from(shell.output().unwrap())
    }

    /// Reads the summary of a folder of results.
    pub fn summary(&self, results: &str) -> Table {
        Table::read(&self.path(results).join("summary.csv"))
    }
}

/// Exit code and output of the program.
pub struct Done {
    pub code: Option<i32>,
    pub stdout: String,
    pub stderr: String,
}

impl From<Output> for Done {
    fn from(output: Output) -> Self {
        let text = |bytes| String::from_utf8(bytes).unwrap();
        Done { code: output.status.code(), stdout: text(output.stdout), stderr: text(output.stderr) }
    }
}

impl Done {
    /// Asserts the exit code and prints the output if it differs.
    #[track_caller]
    pub fn exits(self, code: i32) -> Self {
        assert_eq!(self.code, Some(code), "stdout:\n{}\nstderr:\n{}", self.stdout, self.stderr);
        self
    }
}

/// A CSV file with every cell as text.
pub struct Table {
    pub header: Vec<String>,
    pub rows: Vec<Vec<String>>,
}

impl Table {
    pub fn read(path: &Path) -> Self {
        Self::parse(&fs::read_to_string(path).unwrap())
    }

    /// Parses CSV text whose cells contain no line breaks.
    pub fn parse(text: &str) -> Self {
        let mut lines = text.lines().map(cells);
        Table { header: lines.next().expect("a header"), rows: lines.collect() }
    }

    /// The cells of a column, top to bottom.
    #[track_caller]
    pub fn column(&self, name: &str) -> Vec<&str> {
        let at = self.header.iter().position(|h| h == name).unwrap_or_else(|| panic!("no column {name}"));
        self.rows.iter().map(|r| r[at].as_str()).collect()
    }

    #[track_caller]
    pub fn numbers(&self, name: &str) -> Vec<f64> {
        self.column(name).iter().map(|cell| cell.parse().unwrap()).collect()
    }
}

fn cells(line: &str) -> Vec<String> {
    let mut cells = vec![String::new()];
    let mut quoted = false;
    for c in line.chars() {
        match c {
            // A doubled quote toggles twice. The quote character itself is dropped.
            '"' => quoted = !quoted,
            ',' if !quoted => cells.push(String::new()),
            c => cells.last_mut().unwrap().push(c),
        }
    }
    cells
}

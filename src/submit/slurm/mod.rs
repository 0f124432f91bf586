//! Slurm: a job array, and a job that depends on it.

mod controller;
mod options;
mod script;

use super::tool::{Tool, ended};
use super::{Jobs, SUBMIT_SCHEMA, SubmitError, Sweep};
use crate::files::{RecordError, atomic};
use crate::results::PROGRAM;
use std::io::{BufRead, BufReader, Read, Write};
use std::path::PathBuf;
use std::process::Stdio;

pub use options::Options;

/// Its name in words.
const NAME: &str = "Slurm";

/// Its name in `jobs.json`.
const ENGINE: &str = "slurm";

/// Names of the scripts.
const SCRIPTS: [&str; 2] = ["array.sbatch", "merge.sbatch"];

/// A sweep as jobs of Slurm.
#[derive(Debug)]
pub struct Submission<'a> {
    sweep: &'a Sweep,
    /// Texts of the two scripts.
    scripts: [String; 2],
}

impl<'a> Submission<'a> {
    /// Makes the scripts; nothing is written.
    ///
    /// # Errors
    /// A word cannot stand in a script, or an option is not to be chosen.
    pub fn new(sweep: &'a Sweep, options: &Options) -> Result<Self, SubmitError> {
        options.check()?;
        Ok(Submission { sweep, scripts: [script::array(sweep, options)?, script::merge(sweep, options)?] })
    }

    /// Is a controller there, does it take so many parts, and have the folder's earlier jobs ended?
    ///
    /// # Errors
    /// Not so.
    pub fn check(&self) -> Result<(), SubmitError> {
        controller::takes(self.sweep.parts.get())?;
        let Some(earlier) = Jobs::read(&self.sweep.scripts())?.filter(|jobs| jobs.engine == ENGINE) else {
            return Ok(());
        };
        let ids: Vec<String> = [Some(earlier.array), earlier.merge].into_iter().flatten().collect();
        let alive = controller::alive(&ids)?;
        if alive.is_empty() {
            return Ok(());
        }
        let command = format!("scancel {}", ids.join(" "));
        Err(SubmitError::Alive { folder: self.sweep.folder.clone(), jobs: alive, command })
    }

    /// Writes the scripts; returns where.
    ///
    /// # Errors
    /// They cannot be written.
    pub fn write(&self) -> Result<[PathBuf; 2], SubmitError> {
        let paths = SCRIPTS.map(|name| self.sweep.scripts().join(name));
        for (path, text) in paths.iter().zip(&self.scripts) {
            atomic::write(path, |out| out.write_all(text.as_bytes()).map_err(RecordError::io(path)))?;
        }
        Ok(paths)
    }

    /// The commands that submit, as somebody would type them.
    pub fn commands(&self) -> [String; 2] {
        let [array, merge] = SCRIPTS.map(|name| super::text::shell(&super::shown(&self.sweep.scripts().join(name))));
        [format!("sbatch --parsable {array}"), format!("sbatch --dependency=afterany:ARRAY {merge}")]
    }

    /// Writes the scripts, has Slurm look at them, and submits both jobs, the second to begin when all tasks of the first
    /// have ended. `wait` is for somebody who wants to know how the second ends.
    ///
    /// # Errors
    /// A file cannot be written; Slurm refuses a script: then no job is left, unless the message says so.
    pub fn submit(&self, wait: bool) -> Result<Submitted, SubmitError> {
        let paths = self.write()?;
        for path in &paths {
            sbatch(&["--test-only"], path).accepted("nothing was submitted")?;
        }
        let [array_script, merge_script] = &paths;
        let array = id(&sbatch(&["--parsable"], array_script).accepted("nothing was submitted")?.stdout);
        let mut jobs = self.jobs(array.clone());
        // From here on somebody must know of the array, whatever becomes of this program.
        if let Err(error) = jobs.write(&self.sweep.scripts()) {
            return match cancel(&array) {
                Ok(_) => Err(error.into()),
                Err(left) => Err(SubmitError::Left { error: Box::new(error), left }),
            };
        }
        let dependency = format!("--dependency=afterany:{array}");
        let words: &[&str] = if wait { &["--parsable", "--wait", &dependency] } else { &["--parsable", &dependency] };
        let waiting = match Waiting::start(sbatch(words, merge_script)) {
            Ok(waiting) => waiting,
            Err(refusal) => {
                let left = cancel(&array);
                if left.is_ok() {
                    // No job is left to be told of.
                    let _ = std::fs::remove_file(self.sweep.scripts().join(super::jobs::JOBS));
                }
                return Err(refusal.into_error(left.unwrap_or_else(|left| left)));
            }
        };
        jobs.merge = Some(waiting.id.clone());
        jobs.write(&self.sweep.scripts())?;
        Ok(Submitted { jobs, waiting })
    }

    fn jobs(&self, array: String) -> Jobs {
        Jobs {
            schema: SUBMIT_SCHEMA,
            program: PROGRAM.to_owned(),
            engine: ENGINE.to_owned(),
            parts: self.sweep.parts.get(),
            runs: self.sweep.runs,
            plan: self.sweep.plan.clone(),
            command: script::command(self.sweep),
            array,
            merge: None,
        }
    }
}

/// What Slurm has taken.
pub struct Submitted {
    /// As `jobs.json` has it.
    pub jobs: Jobs,
    waiting: Waiting,
}

impl Submitted {
    /// Waits for the end of the job that merges, if that was wanted: its exit code, or words for what it ended with.
    ///
    /// # Errors
    /// In words: it did not end by itself.
    pub fn wait(self) -> Result<u8, String> {
        let (mut child, mut stderr) = (self.waiting.child, String::new());
        let status = child.wait().map_err(|error| error.to_string())?;
        if let Some(mut pipe) = child.stderr.take() {
            // What it says besides is of no interest when it cannot be read.
            let _ = pipe.read_to_string(&mut stderr);
        }
        match status.code().and_then(|code| u8::try_from(code).ok()) {
            Some(code) => Ok(code),
            None => Err(format!("{} {stderr}", ended(&status)).trim().to_owned()),
        }
    }
}

/// An `sbatch` that has told the number of its job.
struct Waiting {
    child: std::process::Child,
    id: String,
}

/// Why there is no job to merge.
enum Refusal {
    Absent(SubmitError),
    Refused { tool: Tool, status: std::process::ExitStatus, said: String },
}

impl Refusal {
    fn into_error(self, left: String) -> SubmitError {
        match self {
            Refusal::Absent(error) => error,
            Refusal::Refused { tool, status, said } => tool.refused(&status, &said, &left),
        }
    }
}

impl Waiting {
    /// Starts it and reads the number. With `--wait` it goes on from there until the job has ended.
    fn start(tool: Tool) -> Result<Self, Refusal> {
        let spawned = controller::unswayed(tool.command()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn();
        let mut child = spawned.map_err(|source| Refusal::Absent(tool.absent(source)))?;
        let mut line = String::new();
        if let Some(pipe) = child.stdout.take() {
            // What cannot be read is no number, as is seen below.
            let _ = BufReader::new(pipe).read_line(&mut line);
        }
        let id = id(line.trim());
        if !id.is_empty() {
            return Ok(Waiting { child, id });
        }
        let absent = |source| Refusal::Absent(tool.absent(source));
        let output = child.wait_with_output().map_err(absent)?;
        let said = String::from_utf8_lossy(&output.stderr).trim().to_owned();
        Err(Refusal::Refused { tool, status: output.status, said })
    }
}

fn sbatch(words: &[&str], script: &std::path::Path) -> Tool {
    let arguments = words.iter().map(|word| (*word).to_owned()).chain([super::shown(script)]).collect();
    Tool { engine: NAME, program: "sbatch", arguments }
}

/// `ID;CLUSTER`, or `ID` alone.
fn id(said: &str) -> String {
    said.split(';').next().unwrap_or_default().trim().to_owned()
}

/// Ends an array that nothing would merge; in words, what is left, as an error if that is the array.
fn cancel(array: &str) -> Result<String, String> {
    let tool = Tool { engine: NAME, program: "scancel", arguments: vec![array.to_owned()] };
    match tool.run() {
        Ok(answer) if answer.status.success() => Ok(format!("the job array {array} was cancelled; nothing is left")),
        _ => Err(format!("the job array {array} is left and could not be cancelled: end it with `scancel {array}`")),
    }
}

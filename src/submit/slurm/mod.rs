//! Submits a sweep to Slurm: a job array, and a merge job that depends on it.

mod batch_scripts;
mod controller;
mod options;

use super::engine_command::{EngineCommand, status_text};
use super::{Jobs, SUBMIT_SCHEMA, SubmitError, Sweep, WaitError};
use crate::files::{RecordError, atomic};
use crate::results::PROGRAM;
use std::fmt;
use std::io::{BufRead, BufReader, Read, Write};
use std::path::PathBuf;
use std::process::Stdio;

pub use options::Options;

/// Name of the engine in messages.
const NAME: &str = "Slurm";

/// Name of the engine in `jobs.json`.
const ENGINE: &str = "slurm";

/// File names of the scripts.
const SCRIPTS: [&str; 2] = ["array.sbatch", "merge.sbatch"];

/// A sweep with its two batch scripts.
#[derive(Debug)]
pub struct Submission<'a> {
    sweep: &'a Sweep,
    /// Texts of the two scripts.
    scripts: [String; 2],
}

impl<'a> Submission<'a> {
    /// Creates the texts of the scripts; writes no file.
    ///
    /// # Errors
    /// A text cannot be written into a script, or an option is reserved.
    pub fn new(sweep: &'a Sweep, options: &Options) -> Result<Self, SubmitError> {
        options.check()?;
        Ok(Submission {
            sweep,
            scripts: [batch_scripts::array(sweep, options)?, batch_scripts::merge(sweep, options)?],
        })
    }

    /// Checks that a controller answers, accepts the number of parts, and that earlier jobs of the
    /// folder have ended.
    ///
    /// # Errors
    /// A check failed.
    pub fn check(&self) -> Result<(), SubmitError> {
        controller::check_array_size(self.sweep.parts.get())?;
        let Some(earlier) = Jobs::read(&self.sweep.scripts())?.filter(|jobs| jobs.engine == ENGINE) else {
            return Ok(());
        };
        let ids: Vec<String> = [Some(earlier.array), earlier.merge].into_iter().flatten().collect();
        let unfinished = controller::unfinished(&ids)?;
        if unfinished.is_empty() {
            return Ok(());
        }
        let command = format!("scancel {}", ids.join(" "));
        Err(SubmitError::Unfinished { folder: self.sweep.folder.clone(), jobs: unfinished, command })
    }

    /// Writes the scripts and returns their paths.
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

    /// The commands that submit both jobs, as text for a shell.
    pub fn commands(&self) -> [String; 2] {
        let [array, merge] =
            SCRIPTS.map(|name| super::quoting::shell(&super::display(&self.sweep.scripts().join(name))));
        [format!("sbatch --parsable {array}"), format!("sbatch --dependency=afterany:ARRAY {merge}")]
    }

    /// Writes the scripts, has Slurm validate them, and submits both jobs; the merge begins when
    /// all tasks of the array have ended. With `wait`, [`Submitted::wait`] returns the outcome of
    /// the merge.
    ///
    /// # Errors
    /// A file cannot be written, or Slurm rejects a script. No job remains then, unless the message
    /// names one.
    pub fn submit(&self, wait: bool) -> Result<Submitted, SubmitError> {
        let paths = self.write()?;
        for path in &paths {
            sbatch(&["--test-only"], path).run_checked("nothing was submitted")?;
        }
        let [array_script, merge_script] = &paths;
        let array = id(&sbatch(&["--parsable"], array_script).run_checked("nothing was submitted")?.stdout);
        let mut jobs = self.jobs(array.clone());
        // Recorded before the merge is submitted, so that the array can be found if this program
        // dies.
        if let Err(error) = jobs.write(&self.sweep.scripts()) {
            return Err(match cancel(&array) {
                Cancellation::Cancelled(_) => error.into(),
                failed => SubmitError::JobRemains { error: Box::new(error), remaining: failed.to_string() },
            });
        }
        let dependency = format!("--dependency=afterany:{array}");
        let arguments: &[&str] =
            if wait { &["--parsable", "--wait", &dependency] } else { &["--parsable", &dependency] };
        let merge = match MergeJob::submit(sbatch(arguments, merge_script)) {
            Ok(merge) => merge,
            Err(refusal) => {
                let cancellation = cancel(&array);
                if let Cancellation::Cancelled(_) = cancellation {
                    // No job remains to be recorded.
                    let _ = std::fs::remove_file(self.sweep.scripts().join(super::jobs::JOBS));
                }
                return Err(refusal.into_error(&cancellation.to_string()));
            }
        };
        jobs.merge = Some(merge.id.clone());
        jobs.write(&self.sweep.scripts())?;
        Ok(Submitted { jobs, merge })
    }

    fn jobs(&self, array: String) -> Jobs {
        Jobs {
            schema: SUBMIT_SCHEMA,
            program: PROGRAM.to_owned(),
            engine: ENGINE.to_owned(),
            parts: self.sweep.parts.get(),
            runs: self.sweep.runs,
            plan: self.sweep.plan.clone(),
            files: self.sweep.files.clone(),
            command: batch_scripts::command(self.sweep),
            array,
            merge: None,
        }
    }
}

/// The submitted jobs.
pub struct Submitted {
    /// The contents of `jobs.json`.
    pub jobs: Jobs,
    merge: MergeJob,
}

impl Submitted {
    /// Waits until the merge has ended, if submitted with `wait`. Returns its exit code.
    ///
    /// # Errors
    /// The system cannot wait for it, or a signal terminated it.
    pub fn wait(self) -> Result<u8, WaitError> {
        let (mut child, mut output) = (self.merge.child, String::new());
        let status = child.wait()?;
        if let Some(mut pipe) = child.stderr.take() {
            // The output only completes an error message.
            let _ = pipe.read_to_string(&mut output);
        }
        let code = status.code().and_then(|code| u8::try_from(code).ok());
        code.ok_or_else(|| WaitError::Signal { status: status_text(&status), output })
    }
}

/// The `sbatch` process of the merge and the number of its job.
struct MergeJob {
    child: std::process::Child,
    id: String,
}

/// Why the merge was not submitted.
enum Refusal {
    NotStarted(SubmitError),
    Refused { command: EngineCommand, status: std::process::ExitStatus, output: String },
}

impl Refusal {
    fn into_error(self, remaining: &str) -> SubmitError {
        match self {
            Refusal::NotStarted(error) => error,
            Refusal::Refused { command, status, output } => command.refused(&status, &output, remaining),
        }
    }
}

impl MergeJob {
    /// Starts `sbatch` and reads the job's number. With `--wait` the process continues until the
    /// job has ended.
    fn submit(command: EngineCommand) -> Result<Self, Refusal> {
        let spawned = controller::without_inherited_options(command.command())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn();
        let not_started = |source| Refusal::NotStarted(command.not_found(source));
        let mut child = spawned.map_err(not_started)?;
        let mut line = String::new();
        if let Some(pipe) = child.stdout.take() {
            // An unreadable line leaves the number empty, which is handled below.
            let _ = BufReader::new(pipe).read_line(&mut line);
        }
        let id = id(line.trim());
        if !id.is_empty() {
            return Ok(MergeJob { child, id });
        }
        let output = child.wait_with_output().map_err(not_started)?;
        let text = String::from_utf8_lossy(&output.stderr).trim().to_owned();
        Err(Refusal::Refused { command, status: output.status, output: text })
    }
}

fn sbatch(options: &[&str], script: &std::path::Path) -> EngineCommand {
    let arguments = options.iter().map(|option| (*option).to_owned()).chain([super::display(script)]).collect();
    EngineCommand { engine: NAME, program: "sbatch", arguments }
}

/// The job number in `ID;CLUSTER` or `ID`.
fn id(output: &str) -> String {
    output.split(';').next().unwrap_or_default().trim().to_owned()
}

/// Outcome of cancelling a job array, by its number.
enum Cancellation {
    Cancelled(String),
    Failed(String),
}

impl fmt::Display for Cancellation {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Cancellation::Cancelled(array) => write!(f, "the job array {array} was cancelled"),
            Cancellation::Failed(array) => {
                write!(f, "the job array {array} remains and could not be cancelled: cancel it with `scancel {array}`")
            }
        }
    }
}

/// Cancels an array without a merge.
fn cancel(array: &str) -> Cancellation {
    let command = EngineCommand { engine: NAME, program: "scancel", arguments: vec![array.to_owned()] };
    match command.run() {
        Ok(output) if output.status.success() => Cancellation::Cancelled(array.to_owned()),
        _ => Cancellation::Failed(array.to_owned()),
    }
}

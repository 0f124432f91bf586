//! `runner submit`: runs a batch as a cluster job array.

use std::num::NonZero;
use std::path::PathBuf;

use crate::submit::slurm::{Options, Submission, Submitted};
use crate::submit::{SubmitError, Sweep};
use clap::{Args, ValueEnum, ValueHint};

use crate::cli::arguments::message_format::MessageFormat;
use crate::cli::arguments::numbers;
use crate::cli::arguments::run_options::Each;
use crate::cli::arguments::scenario_files;
use crate::cli::arguments::selection::Selection;
use crate::cli::terminal::{complain, complain_of, plural, print};
use crate::cli::{Exit, exit, program};

/// Text below the help.
pub fn help() -> String {
    format!(
        "{}\n\nThe folder gets part-0, part-1, ... with the results of the parts, results with those of\nall, and submit with scripts, \
         jobs.json and the output of the jobs. The same command again\ncompletes what is missing. See docs/scale.md.",
        exit::help("submit")
    )
}

/// Scheduler that runs the jobs.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum Engine {
    /// Slurm: a job array, and a merge job that depends on it
    Slurm,
}

/// Arguments of `submit`.
#[derive(Args, Debug)]
pub struct Submit {
    /// Scheduler that runs the jobs
    #[arg(long, value_enum)]
    engine: Engine,
    /// Number of parts, one job each
    #[arg(long, value_name = "N", value_parser = numbers::count::<NonZero<u64>>, allow_negative_numbers = true)]
    parts: NonZero<u64>,
    /// Folder of parts, scripts and results, on a file system that all nodes share
    #[arg(short, long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    output: PathBuf,
    /// Processors of each part
    #[arg(long, value_name = "C", default_value = "1", value_parser = numbers::count::<NonZero<u32>>, allow_negative_numbers = true)]
    cpus: NonZero<u32>,
    /// Time limit of each job in Slurm's format, such as 30 (minutes), 2:00:00 or 1-12:00:00
    #[arg(long, value_name = "T")]
    time: Option<String>,
    /// Partition of the cluster
    #[arg(long, value_name = "P")]
    partition: Option<String>,
    /// Account to charge
    #[arg(long, value_name = "A")]
    account: Option<String>,
    /// Memory of each job, such as 2G
    #[arg(long, value_name = "M")]
    mem: Option<String>,
    /// Further option of both jobs, as written after #SBATCH, such as --sbatch=--qos=low; may be
    /// repeated
    #[arg(long, value_name = "OPT", allow_hyphen_values = true)]
    sbatch: Vec<String>,
    /// Write the scripts and print the commands that would submit them; needs no cluster
    #[arg(long, conflicts_with = "wait")]
    dry_run: bool,
    /// Wait for the merge and exit with its exit code
    #[arg(long)]
    wait: bool,
    /// Parallel runs of each part [default: its processors]
    #[arg(short, long, value_name = "N", value_parser = numbers::count::<NonZero<usize>>, allow_negative_numbers = true)]
    jobs: Option<NonZero<usize>>,
    #[command(flatten)]
    scenarios: Selection,
    #[command(flatten)]
    each: Each,
}

impl Submit {
    /// Checks everything, then submits.
    pub fn execute(self) -> Result<Exit, Exit> {
        let Engine::Slurm = self.engine;
        let refused = |error: SubmitError| {
            complain_of(error);
            Exit::Invalid
        };
        let plan = self.scenarios.prepare(usize::MAX, MessageFormat::Human)?;
        let sweep = Sweep {
            runner: program()?,
            arguments: [self.each.to_arguments(), self.scenarios.to_arguments()?].concat(),
            jobs: self.jobs,
            folder: PathBuf::from(scenario_files::absolute_text(&self.output)?),
            parts: self.parts,
            runs: plan.runs(),
            plan: plan.hash(),
            files: plan.used_files().clone(),
        };
        // Freed, as a plan may be large and waiting may take long.
        drop(plan);
        sweep.check_parts().map_err(refused)?;
        let submission = Submission::new(&sweep, &self.options()).map_err(refused)?;
        // Before the lock, which writes into the folder, and again when the submissions before this one are known.
        sweep.check_folder().map_err(refused)?;
        let lock = sweep.lock().map_err(refused)?;
        sweep.check_folder().map_err(refused)?;
        if self.dry_run {
            submission.write().map_err(refused)?;
            print(&format!("{}\nto submit:\n  {}\n", counted(&sweep), submission.commands().join("\n  ")))?;
            return Ok(Exit::Success);
        }
        submission.check().map_err(refused)?;
        let submitted = submission.submit(self.wait).map_err(refused)?;
        drop(lock);
        print(&submission_text(&sweep, &submitted))?;
        match self.wait {
            true => wait_for_merge(&sweep, submitted),
            false => Ok(Exit::Success),
        }
    }

    fn options(&self) -> Options {
        Options {
            cpus: self.cpus,
            time: self.time.clone(),
            partition: self.partition.clone(),
            account: self.account.clone(),
            mem: self.mem.clone(),
            more: self.sbatch.clone(),
        }
    }
}

/// Path of this program, which the jobs run too.
fn program() -> Result<PathBuf, Exit> {
    program::path().map_err(|error| {
        complain_of(format!("cannot find this program, which the jobs must run: {error}"));
        Exit::Invalid
    })
}

fn counted(sweep: &Sweep) -> String {
    format!("{} in {}", plural(sweep.runs, "run"), plural(sweep.parts.get() as usize, "part"))
}

fn submission_text(sweep: &Sweep, submitted: &Submitted) -> String {
    let jobs = &submitted.jobs;
    let (merge, last) = (jobs.merge.as_deref().unwrap_or_default(), sweep.parts.get() - 1);
    let tasks = if last == 0 { "task-0.txt".to_owned() } else { format!("task-0.txt to task-{last}.txt") };
    format!(
        "{}: job array {}, then job {merge} to merge them\n  results: {}\n  scripts and output of the jobs ({tasks}, merge.txt): {}\n",
        counted(sweep),
        jobs.array,
        sweep.results().display(),
        sweep.scripts().display()
    )
}

/// Waits for the merge and returns its exit code.
fn wait_for_merge(sweep: &Sweep, submitted: Submitted) -> Result<Exit, Exit> {
    let output = sweep.scripts().join("merge.txt");
    let exit = match submitted.wait() {
        Ok(0) => return Ok(Exit::Success),
        Ok(1) => Exit::Failed,
        Ok(2) => Exit::Invalid,
        Ok(3) => Exit::Unfinished,
        Ok(5) => Exit::Undecided,
        Ok(code) => {
            complain_of(format!("the merge ended with exit code {code}, which merge does not use"));
            Exit::Invalid
        }
        Err(why) => {
            complain_of(format!("waiting for the merge: {why}"));
            Exit::Invalid
        }
    };
    complain(&format!("the merge did not end with exit code 0; see {}", output.display()));
    Ok(exit)
}

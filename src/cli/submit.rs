//! `runner submit`: a batch as jobs of a cluster.

use std::num::NonZero;
use std::path::PathBuf;

use clap::{Args, ValueEnum, ValueHint};
use stiction::submit::slurm::{Options, Submission, Submitted};
use stiction::submit::{SubmitError, Sweep};

use super::each::Each;
use super::machine::MessageFormat;
use super::prepare::Selection;
use super::terminal::{complain, complain_of, plural, print};
use super::{Exit, exit, inputs, numbers};

/// Below the help.
pub fn help() -> String {
    format!(
        "{}\n\nThe folder gets part-0, part-1, ... with the results of the parts, results with those of\nall, and submit with scripts, \
         jobs.json and what the jobs say. The same command again\ncompletes what is missing. See docs/scale.md.",
        exit::help("submit")
    )
}

/// What runs the jobs.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum Engine {
    /// Slurm: an array of jobs, and a job that depends on it
    Slurm,
}

/// Arguments of `submit`.
#[derive(Args, Debug)]
pub struct Submit {
    /// What runs the jobs
    #[arg(long, value_enum)]
    engine: Engine,
    /// Number of parts, each a job
    #[arg(long, value_name = "N", value_parser = numbers::count::<NonZero<u64>>, allow_negative_numbers = true)]
    parts: NonZero<u64>,
    /// Folder of parts, scripts and results, on a file system that all nodes share
    #[arg(short, long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    output: PathBuf,
    /// Processors of each part
    #[arg(long, value_name = "C", default_value = "1", value_parser = numbers::count::<NonZero<u32>>, allow_negative_numbers = true)]
    cpus: NonZero<u32>,
    /// Time limit of each job, as Slurm writes it, such as 30 (minutes), 2:00:00 or 1-12:00:00
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
    /// Another option of both jobs, as it would follow #SBATCH, such as --sbatch=--qos=low; may be repeated
    #[arg(long, value_name = "OPT", allow_hyphen_values = true)]
    sbatch: Vec<String>,
    /// Write the scripts and say how they would be submitted; asks no cluster
    #[arg(long, conflicts_with = "wait")]
    dry_run: bool,
    /// Wait for the merge, and end with its exit code
    #[arg(long)]
    wait: bool,
    /// Runs of a part side by side [default: its processors]
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
            arguments: [self.each.words(), self.scenarios.words()?].concat(),
            jobs: self.jobs,
            folder: PathBuf::from(inputs::absolute_text(&self.output)?),
            parts: self.parts,
            runs: plan.runs(),
            plan: plan.hash(),
        };
        // It may be large, and waiting may take long.
        drop(plan);
        sweep.check_parts().map_err(refused)?;
        let submission = Submission::new(&sweep, &self.options()).map_err(refused)?;
        sweep.check_folder().map_err(refused)?;
        if self.dry_run {
            submission.write().map_err(refused)?;
            print(&format!("{}\nto submit:\n  {}\n", counted(&sweep), submission.commands().join("\n  ")))?;
            return Ok(Exit::Success);
        }
        submission.check().map_err(refused)?;
        let submitted = submission.submit(self.wait).map_err(refused)?;
        print(&told(&sweep, &submitted))?;
        match self.wait {
            true => merged(&sweep, submitted),
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

/// The program that is running, for jobs that run it too.
fn program() -> Result<PathBuf, Exit> {
    let found = std::env::current_exe().and_then(|path| path.metadata().map(|_| path));
    found.map_err(|error| {
        complain_of(format!("cannot tell where this program is, which the jobs must run: {error}"));
        Exit::Invalid
    })
}

fn counted(sweep: &Sweep) -> String {
    format!("{} in {}", plural(sweep.runs, "run"), plural(sweep.parts.get() as usize, "part"))
}

fn told(sweep: &Sweep, submitted: &Submitted) -> String {
    let jobs = &submitted.jobs;
    let (merge, last) = (jobs.merge.as_deref().unwrap_or_default(), sweep.parts.get() - 1);
    let tasks = if last == 0 { "task-0.txt".to_owned() } else { format!("task-0.txt to task-{last}.txt") };
    format!(
        "{}: job array {}, then job {merge} to merge them\n  results: {}\n  scripts and what the jobs say ({tasks}, merge.txt): {}\n",
        counted(sweep),
        jobs.array,
        sweep.results().display(),
        sweep.scripts().display()
    )
}

/// Waits for the merge.
fn merged(sweep: &Sweep, submitted: Submitted) -> Result<Exit, Exit> {
    let said = sweep.scripts().join("merge.txt");
    let exit = match submitted.wait() {
        Ok(0) => return Ok(Exit::Success),
        Ok(1) => Exit::Failed,
        Ok(2) => Exit::Invalid,
        Ok(3) => Exit::Unfinished,
        Ok(code) => {
            complain_of(format!("the merge ended with exit code {code}, which is none of its own"));
            Exit::Invalid
        }
        Err(why) => {
            complain_of(format!("waiting for the merge: {why}"));
            Exit::Invalid
        }
    };
    complain(&format!("the merge did not end with exit code 0; {} says why", said.display()));
    Ok(exit)
}

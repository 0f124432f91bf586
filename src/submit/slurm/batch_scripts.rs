//! Writes the texts of the two batch scripts.
//!
//! `sbatch` reads the lines of `#SBATCH`: double quotes group words, a backslash escapes the next
//! character. A shell reads the rest. In the path of `--output`, `%` is special and must be
//! doubled; a backslash disables that, so the folder must not contain one (observed with Slurm
//! 22.05).
//!
//! The merge depends on the array by `afterany`, since exit code 1, for a failed expectation, is a
//! failure for Slurm. `--signal=B:INT@60` sends SIGINT a minute or two before the time limit, and
//! `exec` passes it on. With `--time=1 --signal=B:INT@30` it came after 29 s; the 32 runs finished
//! by then had summary and report.

use std::path::Path;

use super::super::quoting::{self, path};
use super::super::{SubmitError, Sweep};
use super::Options;

/// The script of the job array, one task per part.
pub(super) fn array(sweep: &Sweep, options: &Options) -> Result<String, SubmitError> {
    let last = sweep.parts.get() - 1;
    let mut lines = vec![
        "#!/bin/sh".to_owned(),
        "# A part of a sweep, written by `runner submit`. --resume lets a preempted or requeued task continue;"
            .to_owned(),
        "# SIGINT a minute before the end of its time lets it finish its running runs, and reaches it because of exec."
            .to_owned(),
        format!("#SBATCH --array=0-{last}"),
        format!("#SBATCH --cpus-per-task={}", options.cpus),
        "#SBATCH --signal=B:INT@60".to_owned(),
        "#SBATCH --requeue".to_owned(),
    ];
    lines.extend(common(sweep, options, "", "task-%a.txt")?);
    let run = quoting::command(&checked(sweep)?);
    let jobs = sweep.jobs.map_or_else(|| "\"$SLURM_CPUS_PER_TASK\"".to_owned(), |jobs| jobs.to_string());
    // The shell expands only the number of the part.
    let part = quoting::shell(&format!("{}/part-", path("the folder", &sweep.folder)?));
    lines.push(format!("exec {run} --shard env --resume --jobs {jobs} --output {part}\"$SLURM_ARRAY_TASK_ID\""));
    Ok(lines.join("\n") + "\n")
}

/// The script of the merge.
pub(super) fn merge(sweep: &Sweep, options: &Options) -> Result<String, SubmitError> {
    let mut lines = vec![
        "#!/bin/sh".to_owned(),
        "# Submitted with --dependency=afterany: for Slurm an array has failed if a task found a failed expectation."
            .to_owned(),
        "# The merge checks that the parts are complete.".to_owned(),
        "#SBATCH --requeue".to_owned(),
    ];
    lines.extend(common(sweep, options, "-merge", "merge.txt")?);
    let mut arguments = vec![path("the program", &sweep.runner)?.to_owned(), "merge".to_owned()];
    for number in 0..sweep.parts.get() {
        arguments.push(path("the folder", &sweep.part(number))?.to_owned());
    }
    // What the parts keep against power failures, the merge keeps too.
    arguments.extend(sweep.arguments.iter().filter(|argument| *argument == "--durable").cloned());
    arguments.extend(["--output".to_owned(), path("the folder", &sweep.results())?.to_owned()]);
    lines.push(format!("exec {}", quoting::command(&arguments)));
    Ok(lines.join("\n") + "\n")
}

/// The command of all parts, without the number of the part.
pub(super) fn command(sweep: &Sweep) -> Vec<String> {
    let program = [super::super::display(&sweep.runner), "run".to_owned()];
    program.into_iter().chain(sweep.arguments.iter().cloned()).collect()
}

fn checked(sweep: &Sweep) -> Result<Vec<String>, SubmitError> {
    path("the program", &sweep.runner)?;
    let arguments = command(sweep);
    arguments.iter().try_for_each(|argument| quoting::line("an argument", argument).map(|_| ()))?;
    Ok(arguments)
}

/// Lines of both scripts: name, folder, output and the chosen options.
fn common(sweep: &Sweep, options: &Options, suffix: &str, output: &str) -> Result<Vec<String>, SubmitError> {
    let folder = path("the folder", &sweep.folder)?;
    if folder.contains('\\') {
        let (what, why) = ("the folder", "a backslash, which Slurm does not accept in file names");
        return Err(SubmitError::Text { what, why, text: folder.to_owned() });
    }
    let scripts = sweep.scripts();
    let scripts = path("the folder", &scripts)?;
    let mut lines = vec![
        format!("#SBATCH --job-name={}{suffix}", name(&sweep.folder)),
        "#SBATCH --open-mode=append".to_owned(),
        format!("#SBATCH --chdir={}", quoted(scripts)),
        format!("#SBATCH --output={}", quoted(&format!("{}/{output}", scripts.replace('%', "%%")))),
    ];
    let chosen = [
        ("--time", &options.time),
        ("--partition", &options.partition),
        ("--account", &options.account),
        ("--mem", &options.mem),
    ];
    for (option, value) in chosen {
        if let Some(value) = value {
            lines.push(format!("#SBATCH {option}={}", quoted(quoting::line("an option", value)?)));
        }
    }
    // Last, as the last option of a name wins.
    lines.extend(options.more.iter().map(|option| format!("#SBATCH {option}")));
    Ok(lines)
}

/// Quotes a value for a line of `#SBATCH`.
fn quoted(value: &str) -> String {
    format!("\"{}\"", value.replace('\\', "\\\\").replace('"', "\\\""))
}

/// The job's name: that of the folder, with `-` for all but letters, digits, `-`, `_` and `.`.
fn name(folder: &Path) -> String {
    let name = folder.file_name().unwrap_or_default().to_string_lossy();
    name.chars().map(|c| if c.is_ascii_alphanumeric() || "-_.".contains(c) { c } else { '-' }).collect()
}

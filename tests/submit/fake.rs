//! A fake Slurm: shell scripts with the names of its programs. Each appends its arguments to
//! `calls`, one per line, with an empty line after the last. Files in the folder control how they
//! behave.

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Folder of the fake programs.
pub struct Slurm {
    folder: PathBuf,
}

/// Records the call. `$here` is the folder.
const RECORD: &str = r#"#!/bin/sh
here=$(dirname "$0")/..
{ basename "$0"; printf '%s\n' "$@"; echo; } >>"$here/calls"
"#;

const SCONTROL: &str = r#"
if [ -e "$here/down" ]; then
    echo "slurm_load_ctl_conf error: Unable to contact slurm controller (connect failure)" >&2
    exit 1
fi
printf 'Configuration data as of now\nMaxArraySize            = 1001\nMaxJobCount             = 10000\n'
"#;

/// Prints the next job number. With the file `run` it also runs the script: array tasks one after
/// the other, in the script's folder, with Slurm's variables.
const SBATCH: &str = r##"
for script; do :; done
case " $* " in
*" --test-only "*)
    [ ! -e "$here/rejects" ] || { echo "sbatch: error: Batch job submission failed: $(cat "$here/rejects")" >&2; exit 1; }
    echo "sbatch: Job 1 to start at 2026-01-01T00:00:00 using 1 processors on nodes n in partition all" >&2
    exit 0 ;;
*" --dependency="*)
    [ ! -e "$here/rejects-merge" ] || { echo "sbatch: error: Batch job submission failed: Job dependency problem" >&2; exit 1; } ;;
esac
id=$(($(cat "$here/last" 2>/dev/null || echo 40) + 1))
echo "$id" >"$here/last"
echo "$id;one"
[ -e "$here/run" ] || exit 0
export SLURM_JOB_ID="$id" SLURM_CPUS_PER_TASK=1
# The value of an #SBATCH option: quotes and backslashes as observed with the real Slurm.
option() { sed -n "s/^#SBATCH --$1=//p" "$script" | tail -n 1; }
plain() { sed -e 's/^"//' -e 's/"$//' -e 's/\\\(.\)/\1/g'; }
cd "$(option chdir | plain)" || exit 99
tasks=$(option array)
if [ -z "$tasks" ]; then
    sh "$script" >>"$(option output | plain | sed 's/%%/%/g')" 2>&1
    exit $?
fi
first=${tasks%-*} last=${tasks#*-}
export SLURM_ARRAY_TASK_MIN="$first" SLURM_ARRAY_TASK_STEP=1 SLURM_ARRAY_TASK_COUNT=$((last - first + 1))
for task in $(seq "$first" "$last"); do
    [ "$(cat "$here/loses" 2>/dev/null)" != "$task" ] || continue
    # `%a` is the number of the task and `%%` is `%`.
    output=$(option output | plain | sed -e "s/%%/\n/g" -e "s/%a/$task/g" | paste -sd %)
    SLURM_ARRAY_TASK_ID=$task sh "$script" >>"$output" 2>&1
done
exit 0
"##;

const SQUEUE: &str = r#"
[ ! -e "$here/alive" ] || { cat "$here/alive"; exit 0; }
echo "slurm_load_jobs error: Invalid job id specified" >&2
exit 1
"#;

const SCANCEL: &str = r#"
[ ! -e "$here/keeps" ] || { echo "scancel: error: Kill job error" >&2; exit 1; }
"#;

impl Slurm {
    pub fn new(folder: &Path) -> Self {
        let slurm = Slurm { folder: folder.to_owned() };
        fs::create_dir_all(slurm.programs()).unwrap();
        for (name, body) in [("scontrol", SCONTROL), ("sbatch", SBATCH), ("squeue", SQUEUE), ("scancel", SCANCEL)] {
            let path = slurm.programs().join(name);
            fs::write(&path, format!("{RECORD}{body}")).unwrap();
            fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).unwrap();
        }
        slurm
    }

    fn programs(&self) -> PathBuf {
        self.folder.join("bin")
    }

    /// Puts the programs first on PATH.
    pub fn put_on_path(&self, command: &mut Command) {
        let path = std::env::var("PATH").unwrap();
        command.env("PATH", format!("{}:{path}", self.programs().display()));
    }

    /// Removes a program. No other program of this name may be on PATH.
    pub fn without(&self, name: &str) -> &Self {
        fs::remove_file(self.programs().join(name)).unwrap();
        self
    }

    /// Writes a file that controls the programs.
    pub fn set(&self, name: &str, text: &str) -> &Self {
        fs::write(self.folder.join(name), text).unwrap();
        self
    }

    pub fn unset(&self, name: &str) -> &Self {
        fs::remove_file(self.folder.join(name)).unwrap();
        self
    }

    /// Recorded calls, each with the program's name first.
    pub fn calls(&self) -> Vec<Vec<String>> {
        let text = fs::read_to_string(self.folder.join("calls")).unwrap_or_default();
        let calls = text.split("\n\n").filter(|call| !call.is_empty());
        calls.map(|call| call.lines().map(str::to_owned).collect()).collect()
    }

    /// Names of the called programs, in order.
    pub fn called(&self) -> Vec<String> {
        self.calls().into_iter().map(|call| call[0].clone()).collect()
    }

    /// Deletes the recorded calls.
    pub fn clear_calls(&self) {
        let _ = fs::remove_file(self.folder.join("calls"));
    }
}

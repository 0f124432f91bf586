#!/bin/sh
# Compares `runner submit` on a local Slurm with direct batches (docs/scale.md). The results must have
# the same bits, except for times.
#
#     tests/scale/slurm-sweep.sh RUNNER DIR       DIR must be new
#
# 1. The 200 runs of thrown.toml in 8 parts. 9 runs fail on purpose, so the exit code must be 1.
# 2. Folders whose names contain special characters of shells and Slurm.
# 3. 80 runs of HOAP-2 in 2 parts. One part is cancelled while it runs; a second submission completes
#    it.
# 4. Refused submissions: another number of parts, another plan, jobs that have not ended, options
#    unknown to Slurm.
set -eu
[ $# = 2 ] || { echo "usage: $0 RUNNER DIR" >&2; exit 2; }
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
runner=$(realpath "$1")
mkdir "$2"
cd "$2"

eval "$("$here/slurm-one-node.sh" start slurm)"
trap '"$here/slurm-one-node.sh" stop slurm' EXIT

# Runs a command that must exit with the given code.
ends() {
    expected=$1
    shift
    code=0
    "$@" || code=$?
    [ "$code" = "$expected" ] || { echo "$0: exit code $code, expected $expected: $*" >&2; exit 1; }
}

same() {
    python3 "$here/same_bits.py" "$1" "$2"
    "$runner" compare "$1" "$2" --absolute 0 --relative 0 | tail -n 1
}

slurm() {
    "$runner" submit --engine slurm "$@"
}

echo "== 200 runs in 8 parts"
ends 1 "$runner" run "$here/thrown.toml" --output local >local.txt 2>&1
begin=$(date +%s)
ends 1 slurm --parts 8 --time 10 --wait --output sweep "$here/thrown.toml"
echo "$(($(date +%s) - begin)) s"
array=$(sed -n 's/.*"array": "\(.*\)".*/\1/p' sweep/submit/jobs.json)
scontrol --oneliner show job "$array" | tr ' ' '\n' | grep -E '^(ArrayTaskId|ExitCode)=' | paste -d' ' - - | sort
grep ' runs: ' sweep/submit/merge.txt
same local sweep/results

echo "== folders with names"
names="it's a \"sweep\" of \$HOME, 100% %a größe #1"
mkdir "$names"
sed "s|\"../../robots|\"$root/robots|" "$here/thrown.toml" >"$names/thrown.toml"
ends 1 slurm --parts 2 --wait --output "$names/sweep" --filter 'name ~ "thr*" and contact.method == "exact"' "$names/thrown.toml"
ends 1 "$runner" run "$names/thrown.toml" --filter 'contact.method == "exact"' --output exact >exact.txt 2>&1
same exact "$names/sweep/results"

echo "== a task is cancelled in the middle"
cat >push.toml <<TOML
duration = 4.0
[robot]
model = "$root/robots/hoap2/hoap2.toml"
[[force]]
type = "push"
link = "torso"
force = [20, 5, 0]
start = 0.05
duration = 0.1
[sweep.random]
samples = 80
"force.0.force.0" = { uniform = [10, 30] }
"force.0.force.1" = { uniform = [-10, 10] }
TOML
direct=0
"$runner" run push.toml --output pushed >pushed.txt 2>&1 || direct=$?
echo "directly: exit code $direct"
slurm --parts 2 --output pushes push.toml
array=$(sed -n 's/.*"array": "\(.*\)".*/\1/p' pushes/submit/jobs.json)
merge=$(sed -n 's/.*"merge": "\(.*\)".*/\1/p' pushes/submit/jobs.json)
done_runs() {
    cat pushes/part-1/runs.jsonl 2>/dev/null | wc -l
}
while [ "$(done_runs)" -lt 3 ]; do sleep 0.2; done
scancel "${array}_1"
echo "cancelled after $(done_runs) runs"
ends 2 slurm --parts 2 --output pushes push.toml
while [ -n "$(squeue --noheader --jobs="$array,$merge")" ]; do sleep 0.5; done
cat pushes/submit/merge.txt
ends "$direct" slurm --parts 2 --wait --output pushes push.toml
grep -h 'resumed: ' pushes/submit/task-*.txt
same pushed pushes/results

echo "== what is refused"
ends 2 slurm --parts 4 --output sweep "$here/thrown.toml"
ends 2 slurm --parts 8 --output sweep "$here/thrown.toml" --set duration=0.25
ends 2 slurm --parts 5000 --output more "$here/thrown.toml"
ends 2 slurm --parts 8 --partition none --output more "$here/thrown.toml"
"$here/slurm-one-node.sh" stop slurm
ends 2 slurm --parts 8 --output more "$here/thrown.toml"
echo "== all as it must be"

#!/bin/sh
# The sweep of thrown.toml as a job array on a Slurm of this machine alone, merged by a job that depends on it, against the
# same sweep in one batch: the same bits but for times.
#
#     tests/scale/slurm-sweep.sh RUNNER DIR       DIR must be new
set -eu
[ $# = 2 ] || { echo "usage: $0 RUNNER DIR" >&2; exit 2; }
here=$(cd "$(dirname "$0")" && pwd)
RUNNER=$(realpath "$1")
SCENARIO=$here/thrown.toml
export RUNNER SCENARIO
mkdir "$2"
cd "$2"

eval "$("$here/slurm-one-node.sh" start slurm)"
trap '"$here/slurm-one-node.sh" stop slurm' EXIT

# The file says that some runs fail: 1 is the exit code to have.
code=0
"$RUNNER" run "$SCENARIO" --output local >local.txt 2>&1 || code=$?
echo "local: exit code $code"

array=$(sbatch --parsable "$here/array.sbatch")
echo "job array $array"
merged=0
sbatch --wait --dependency="afterany:$array" "$here/merge.sbatch" || merged=$?
echo "merge: exit code $merged"
scontrol --oneliner show job "$array" | tr ' ' '\n' | grep -E '^(ArrayTaskId|ExitCode)=' | paste -d' ' - - | sort
cat merge.txt

[ "$merged" = "$code" ]
python3 "$here/same_bits.py" local all
"$RUNNER" compare local all --absolute 0 --relative 0

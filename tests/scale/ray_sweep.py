"""Runs the parts of a sweep as Ray tasks, then merges them (docs/scale.md). Needs `pip install ray`.

    python3 ray_sweep.py PARTS OUTPUT SCENARIO... [-- options of `runner run`]

OUTPUT and the scenarios must be on a file system that all nodes share. `runner` must be on their
PATH, or RUNNER must contain its path. RAY_ADDRESS selects a cluster; without it Ray starts on this
machine. The exit code is that of the merge.
"""

import os
import subprocess
import sys

import ray

RUNNER = os.environ.get("RUNNER", "runner")
# A part killed by a signal or by the loss of its node is re-run. --resume continues it.
RETRIES = 3


@ray.remote(num_cpus=1, max_retries=RETRIES, retry_exceptions=[ChildProcessError])
def part(number, of, output, arguments):
    folder = os.path.join(output, f"part-{number}")
    command = [RUNNER, "run", f"--shard={number}/{of}", "--resume", "--jobs=1", f"--output={folder}", *arguments]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode < 0:
        raise ChildProcessError(f"part {number} was ended by signal {-done.returncode}")
    return folder, done.returncode, done.stderr


def main(parts, output, arguments):
    output = os.path.abspath(output)
    end = arguments.index("--") if "--" in arguments else len(arguments)
    # Tasks run in other folders on their nodes, so paths must be absolute.
    arguments = [os.path.abspath(scenario) for scenario in arguments[:end]] + arguments[end + 1 :]
    ray.init()
    results = ray.get([part.remote(number, parts, output, arguments) for number in range(1, parts + 1)])
    for folder, code, stderr in results:
        print(f"{folder}: exit code {code}")
        # 1 and 3 are outcomes of runs, which the merge reports again; 2 is an invalid scenario.
        if code not in (0, 1, 3):
            sys.exit(stderr)
    merge = [RUNNER, "merge", *(folder for folder, _, _ in results), "--output", os.path.join(output, "all")]
    return subprocess.run(merge).returncode


if __name__ == "__main__":
    if len(sys.argv) < 4:
        sys.exit(__doc__)
    sys.exit(main(int(sys.argv[1]), sys.argv[2], sys.argv[3:]))

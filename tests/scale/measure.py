"""Measures memory and time of large batches, for the table of docs/scale.md.

    python3 tests/scale/measure.py RUNNER DIR [MOST]

MOST is the greatest number of runs that are simulated, by default 1 000 000, which needs 20 GB of
disk for some minutes. All results are written below DIR and removed.
"""

import os
import random
import shutil
import sys
import time

BLOCK = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "robots", "block", "block.toml")


def scenario(path, sweep):
    with open(path, "w") as file:
        file.write(f'duration = 0.002\n[robot]\nmodel = "{os.path.realpath(BLOCK)}"\n{sweep}\n')


def measured(name, command, expected=(0,)):
    """Runs a command and prints its wall-clock and processor time and its greatest memory."""
    begin = time.monotonic()
    child = os.fork()
    if child == 0:
        with open(os.devnull, "w") as nowhere:
            os.dup2(nowhere.fileno(), 1)
            os.dup2(nowhere.fileno(), 2)
        os.execv(command[0], command)
    _, status, usage = os.wait4(child, 0)
    wall = time.monotonic() - begin
    code = os.waitstatus_to_exitcode(status)
    if code not in expected:
        sys.exit(f"{' '.join(command)}: exit code {code}")
    processor = usage.ru_utime + usage.ru_stime
    print(f"| {name} | {usage.ru_maxrss / 1024:.0f} MB | {wall:.1f} s | {processor:.1f} s |", flush=True)


def shuffled(source, target, header):
    with open(source) as file:
        lines = file.readlines()
    rest = lines[header:]
    random.Random(1).shuffle(rest)
    with open(target, "w") as file:
        file.writelines(lines[:header] + rest)


def main():
    runner, folder = os.path.abspath(sys.argv[1]), os.path.abspath(sys.argv[2])
    most = int(sys.argv[3]) if len(sys.argv) > 3 else 1_000_000
    os.makedirs(folder, exist_ok=True)
    path = lambda name: os.path.join(folder, name)
    limit = ["--max-runs", "100000000"]
    print("| | greatest memory | time | processor time |\n|---|---|---|---|")
    for runs in [10_000, 100_000, 1_000_000]:
        if runs > most:
            continue
        scenario(path("rest.toml"), f"[sweep]\nrepeat = {runs}")
        command = [runner, path("rest.toml"), "--no-log", "-o", path("results"), *limit]
        measured(f"`run`, {runs} runs", command)
        if runs == 100_000:
            kept = {}
            for name in ["summary.csv", "summary.parquet", "runs.jsonl"]:
                kept[name] = path(name)
                shutil.copy(os.path.join(folder, "results", name), kept[name])
            measured(f"`report`, {runs} runs", [runner, "report", path("results")])
            shuffled(kept["summary.csv"], path("other.csv"), 1)
            shuffled(kept["runs.jsonl"], path("other.jsonl"), 0)
            for name, other in [*((kept[n], kept[n]) for n in kept), (kept["summary.csv"], path("other.csv")),
                                (kept["runs.jsonl"], path("other.jsonl")),
                                (path("other.jsonl"), kept["summary.parquet"])]:
                title = f"`compare {os.path.basename(name)} {os.path.basename(other)}`, {runs} runs"
                measured(title, [runner, "compare", name, other])
            for name in [*kept.values(), path("other.csv"), path("other.jsonl")]:
                os.remove(name)
        shutil.rmtree(path("results"))
    for name, sweep in [
        ("repeat", "[sweep]\nrepeat = {runs}"),
        ("grid", "[sweep.grid]\n\"floor.friction\" = {{ linspace = [0.1, 0.9, {first}] }}\n"
                 "\"integrator.relative_tolerance\" = {{ linspace = [1e-6, 1e-5, {second}] }}"),
    ]:
        scenario(path("million.toml"), sweep.format(runs=1_000_000, first=1000, second=1000))
        measured(f"`check`, 1 000 000 runs, `{name}`", [runner, "check", path("million.toml"), *limit])
        scenario(path("ten.toml"), sweep.format(runs=10_000_000, first=5000, second=2000))
        command = [runner, "check", path("ten.toml"), "--shard", "1/100", *limit]
        measured(f"`check --shard 1/100`, 10 000 000 runs, `{name}`", command)
    for name in ["rest.toml", "million.toml", "ten.toml"]:
        os.remove(path(name))
    os.rmdir(folder)


main()

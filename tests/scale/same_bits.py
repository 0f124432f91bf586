"""Two folders of results, compared bit for bit but for what the clock wrote.

    python3 same_bits.py A B

Files other than those below are compared byte by byte, logs among them. Records, lines of runs.jsonl (in any order) and
rows of summary.csv are compared without their times. Of summary.parquet and report.html, which show times too, it is only
asked that both have them. Exit code 0: the same. Needs Python 3.9 and nothing else.
"""

import csv
import json
import sys
from pathlib import Path


def is_time(name):
    return name in ("wall_s", "real_time_factor") or name.endswith("cpu_s") or name.startswith("timing_")


def record(path):
    whole = json.loads(path.read_text())
    del whole["timing"]
    return json.dumps(whole)


def lines(path):
    parsed = [json.loads(line) for line in path.read_text().splitlines()]
    return sorted(json.dumps({k: v for k, v in line.items() if not is_time(k)}) for line in parsed)


def rows(path):
    with path.open(newline="") as file:
        return [{k: v for k, v in row.items() if not is_time(k)} for row in csv.DictReader(file)]


READ = {"run.json": record, "runs.jsonl": lines, "summary.csv": rows}
WITH_TIMES = ("summary.parquet", "report.html")


def files(folder):
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file())


def main(a, b):
    both = files(a)
    problems = [f"only in one: {name}" for name in sorted(set(both) ^ set(files(b)))]
    counts = {}
    for name in set(both) & set(files(b)):
        kind = Path(name).name
        if kind in WITH_TIMES:
            continue
        read = READ.get(kind, Path.read_bytes)
        counts[kind] = counts.get(kind, 0) + 1
        if read(a / name) != read(b / name):
            problems.append(f"differs: {name}")
    if "summary.csv" not in counts or len(rows(a / "summary.csv")) == 0:
        problems.append("no rows: nothing was compared")
    if len(problems) > 20:
        problems[20:] = [f"and {len(problems) - 20} more"]
    print("\n".join(problems) or f"the same but for times: {counts}, {len(rows(a / 'summary.csv'))} rows")
    return bool(problems)


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    sys.exit(main(Path(sys.argv[1]), Path(sys.argv[2])))

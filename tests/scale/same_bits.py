"""Compares two folders of results bit for bit, except for measured times.

    python3 same_bits.py A B

Records, lines of runs.jsonl (in any order) and rows of summary.csv are compared without times. Both
folders must have summary.parquet and report.html, but their contents, which include times, are not
compared. All other files, such as logs, are compared byte by byte. Exit code 0: the results are
equal. Needs Python 3.9 and no packages.
"""

import csv
import json
import sys
from pathlib import Path


def is_time(name):
    return name in ("wall_s", "real_time_factor") or name.endswith("cpu_s") or name.startswith("timing_")


def record(path):
    content = json.loads(path.read_text())
    # The checksum is also that of the times.
    for name in ("timing", "checksum"):
        content.pop(name, None)
    return json.dumps(content)


def lines(path):
    parsed = [json.loads(line) for line in path.read_text().splitlines()]
    return sorted(json.dumps({k: v for k, v in line.items() if not is_time(k) and k != "checksum"}) for line in parsed)


def rows(path):
    with path.open(newline="") as file:
        return [{k: v for k, v in row.items() if not is_time(k)} for row in csv.DictReader(file)]


READ = {"run.json": record, "runs.jsonl": lines, "summary.csv": rows}
WITH_TIMES = ("summary.parquet", "report.html")


def files(folder):
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file())


def main(a, b):
    names = files(a)
    problems = [f"only in one: {name}" for name in sorted(set(names) ^ set(files(b)))]
    counts = {}
    for name in set(names) & set(files(b)):
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

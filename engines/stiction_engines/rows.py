"""Writes the tables of a comparison: summary.csv, details.csv and truths.csv.

summary.csv has one row per cell with those columns of the runner's summary that apply (docs/results.md), so that
`runner report` and `runner compare` read it, and the size of the error of each measure as `error_NAME`, empty
where a case has no measure of this name. details.csv has for each `key` the `engine_version`, `cpu_per_step_us`,
`noise` and `noise_max`, and `value_NAME` and the signed `error_NAME` of each measure.

- `method` is the engine, `integrator` its settings.
- `wall_s` and `real_time_factor` are those of the run that was measured for accuracy, with set-up and record.
- `cpu_s` is the processor time without set-up and record, the least of the rounds; empty if not measured.
- `steps` of adaptive runs are those that the engine reports with its cost.
- `noise`, `noise_max`: median and greatest time of the probe over the least, each minus 1, for the case.
- `message` says why a cell did not pass, or why it has no cost.
"""

import csv
import hashlib
import json
import os
from pathlib import Path

SUMMARY, DETAILS = "summary.csv", "details.csv"
FIRST = ["scenario", "key", "outcome", "message", "method", "integrator", "seed"]
STEP, TOLERANCE = "integrator.step", "integrator.relative_tolerance"
COSTS = ["duration_s", "wall_s", "cpu_s", "real_time_factor", "steps"]
OWN = ["engine_version", "cpu_per_step_us", "noise", "noise_max"]
TRUTHS = ["case", "measure", "truth", "truth_error", "unit", "derivation"]


def key(cell, case):
    """16 hexadecimal digits of the files of the case, engine, version, settings and step."""
    digest = hashlib.sha256()
    for file in [case.file, *sorted({body.urdf for body in case.bodies})]:
        digest.update(hashlib.sha256(Path(file).read_bytes()).digest())
    digest.update(json.dumps([cell.engine, cell.version, cell.settings, cell.step]).encode())
    return digest.hexdigest()[:16]


def _message(result):
    if result.outcome != "passed":
        return result.message
    return f"cost not measured: {result.cost_message}" if result.cost_message and result.cpu is None else ""


def row(cell, result, case):
    """The row of a cell: values by column, None where there is none."""
    duration, wall = result.duration, result.wall
    found = {
        "scenario": cell.case,
        "key": key(cell, case),
        "outcome": result.outcome,
        "message": _message(result),
        "method": cell.engine,
        "integrator": cell.settings,
        "seed": 1,
        TOLERANCE if cell.adaptive else STEP: cell.step,
        "duration_s": duration,
        "wall_s": wall,
        "cpu_s": result.cpu,
        "real_time_factor": duration / wall if duration and wall else None,
        "steps": result.steps,
        "engine_version": cell.version,
        "cpu_per_step_us": 1e6 * result.cpu / result.steps
        if result.cpu is not None and result.steps
        else None,
        "noise": result.noise and result.noise[0],
        "noise_max": result.noise and result.noise[1],
    }
    found |= {f"value_{name}": value for name, value in result.values.items()}
    return found | {f"error_{name}": error for name, error in result.errors.items()}


def _text(value):
    if value is None:
        return ""
    return repr(value) if isinstance(value, float) else str(value)


def write(file, columns, rows):
    """Writes a table. The file appears when it is complete."""
    file = Path(file)
    unfinished = file.with_name(f".{file.name}.{os.getpid()}")
    try:
        with open(unfinished, "w", newline="") as stream:
            writer = csv.writer(stream, lineterminator="\n")
            writer.writerow(columns)
            writer.writerows([_text(row.get(column)) for column in columns] for row in rows)
        os.replace(unfinished, file)
    finally:
        unfinished.unlink(missing_ok=True)


def write_summary(folder, cases, cells, results):
    """Writes summary.csv and details.csv, rows by case in the order of `cases`. Returns the path of the first."""
    known = {case.name: case for case in cases}
    place = {name: k for k, name in enumerate(known)}
    pairs = sorted(zip(cells, results), key=lambda pair: place[pair[0].case])
    rows = [row(cell, result, known[cell.case]) for cell, result in pairs]
    measures = list(dict.fromkeys(m.name for case in cases for m in case.measures))
    errors = [f"error_{name}" for name in measures]
    values = [f"value_{name}" for name in measures]
    write(Path(folder) / DETAILS, ["key", *OWN, *values, *errors], rows)
    size = lambda value: None if value is None else abs(value)
    sizes = [row | {name: size(row.get(name)) for name in errors} for row in rows]
    file = Path(folder) / SUMMARY
    write(file, [*FIRST, STEP, TOLERANCE, *COSTS, *errors], sizes)
    return file


def write_truths(folder, cases):
    """Writes truths.csv. Returns its path."""
    file = Path(folder) / "truths.csv"
    measures = [(case.name, m) for case in cases for m in case.measures]
    write(
        file,
        TRUTHS,
        [
            dict(zip(TRUTHS, (case, m.name, float(m.truth), float(m.truth_error), m.unit, m.derivation)))
            for case, m in measures
        ],
    )
    return file


def read(file):
    """Rows of a table, as text by column."""
    with open(file, newline="") as stream:
        return list(csv.DictReader(stream))


def read_cells(folder):
    """Rows of summary.csv with those of details.csv, whose errors have signs."""
    summary = read(Path(folder) / SUMMARY)
    details = {row["key"]: row for row in read(Path(folder) / DETAILS)}
    return [row | details[row["key"]] for row in summary]

"""Formats a summary as Markdown: errors by family, costs, and what engines do not support."""

import math
from pathlib import Path

from . import case, rows

#: Cases of the table of costs: a box, a stack, robots.
COST_CASES = ["slide-45", "stack-stands", "hoap2-stands", "humanoid-pushed"]


def digits(number):
    """Two significant digits."""
    if number == 0 or not math.isfinite(number):
        return f"{number:g}"
    exponent = math.floor(math.log10(abs(float(f"{number:.1e}"))))
    if -3 <= exponent <= 3:
        return f"{number:.{max(0, 1 - exponent)}f}"
    return f"{number:.1e}"


def table(head, lines):
    """A Markdown table."""
    text = lambda cell: str(cell).replace("|", "\\|")
    yield "| " + " | ".join(map(text, head)) + " |"
    yield "|" + "---|" * len(head)
    for line in lines:
        yield "| " + " | ".join(map(text, line)) + " |"
    yield ""


def _choice(row):
    return row["method"], row["integrator"]


class Summary:
    """Rows of a summary at one step: fixed steps at `step`, adaptive engines at their middle tolerance."""

    def __init__(self, folders, step):
        every = [row for folder in folders for row in rows.read_cells(folder)]
        self.truths = rows.read(Path(folders[0]) / "truths.csv")
        self.choices = list(dict.fromkeys(_choice(row) for row in every))
        tolerances = {}
        for row in every:
            if row[rows.TOLERANCE]:
                tolerances.setdefault(_choice(row), set()).add(float(row[rows.TOLERANCE]))
        self.middle = {choice: sorted(found)[len(found) // 2] for choice, found in tolerances.items()}
        self.every = every
        self.rows = {(row["scenario"], *_choice(row)): row for row in every if self._is_shown(row, step)}

    def _is_shown(self, row, step):
        if row[rows.TOLERANCE]:
            return float(row[rows.TOLERANCE]) == self.middle[_choice(row)]
        return math.isclose(float(row[rows.STEP]), step)

    def label(self, choice):
        """Heading of a choice."""
        tolerance = f" {self.middle[choice]:g}" if choice in self.middle else ""
        return f"{choice[0]} {choice[1]}{tolerance}"

    def error(self, case, measure, choice):
        """Text of a cell of the tables of errors."""
        row = self.rows.get((case, *choice))
        if row is None:
            return ""
        if row["outcome"] == "unsupported":
            return "-"
        if row["outcome"] != "passed":
            return row["outcome"]
        text = row.get(f"error_{measure}", "")
        return digits(float(text)) if text else ""


def errors(summary):
    """Tables of errors, one per family."""
    families = {known.name: known.family for known in case.read_all()}
    present = {row["scenario"] for row in summary.every}
    by_family = {}
    for truth in summary.truths:
        if truth["case"] in present:
            by_family.setdefault(families.get(truth["case"], "other"), []).append(truth)
    head = ["case, measure (unit)", *map(summary.label, summary.choices)]
    for family, truths in sorted(by_family.items()):
        yield f"## {family}: errors"
        yield ""
        yield from table(
            head,
            [
                [f"{t['case']} {t['measure']} ({t['unit']})"]
                + [summary.error(t["case"], t["measure"], choice) for choice in summary.choices]
                for t in truths
            ],
        )


def costs(summary):
    """The table of processor time per simulated second."""
    cost = lambda row: 1e3 * float(row["cpu_s"]) / float(row["duration_s"])
    present = [name for name in COST_CASES if any(key[0] == name for key in summary.rows)]
    lines = []
    for choice in summary.choices:
        found = [summary.rows.get((name, *choice)) for name in present]
        shown = [digits(cost(row)) if row and row["cpu_s"] else "-" for row in found]
        if any(text != "-" for text in shown):
            lines.append([summary.label(choice), *shown])
    if not lines:
        return
    yield "## Processor time per simulated second, ms"
    yield ""
    noises = [
        [
            float(row["noise_max"])
            for row in summary.rows.values()
            if row["scenario"] == name and row["noise_max"]
        ]
        for name in present
    ]
    lines.append(["noise: slowest probe over the fastest"] + [f"{1 + max(n, default=0):.2f}" for n in noises])
    yield from table(["engine", *present], lines)


def reasons(summary):
    """Lines of the table of unsupported cases: engine and settings, reason, cases."""
    found, every = {}, {}
    for row in summary.every:
        engine, choice = _choice(row)
        every.setdefault(engine, set()).add(choice)
        if row["outcome"] == "unsupported":
            entry = found.setdefault((engine, row["message"]), ({}, {}))
            entry[0][choice] = entry[1][row["scenario"]] = None
    for (engine, message), (choices, cases) in found.items():
        whole = set(choices) == every[engine]
        yield [engine if whole else f"{engine} {', '.join(choices)}", message, ", ".join(cases)]


def versions(summary):
    """The table of engines with their versions and numbers of runs by outcome."""
    found, outcomes = {}, {}
    for row in summary.every:
        found.setdefault(row["method"], row["engine_version"])
        counts = outcomes.setdefault(row["method"], {})
        counts[row["outcome"]] = counts.get(row["outcome"], 0) + 1
    counted = lambda counts: ", ".join(f"{count} {outcome}" for outcome, count in counts.items())
    yield "## Engines"
    yield ""
    yield from table(["engine", "version", "runs"], [[e, found[e], counted(outcomes[e])] for e in found])


def text(folders, step):
    """All tables of the results in some folders, of the same cases."""
    summary = Summary(folders, step)
    lines = [*versions(summary), *errors(summary), *costs(summary)]
    unsupported = list(reasons(summary))
    if unsupported:
        lines += ["## Unsupported", "", *table(["engine", "reason", "cases"], unsupported)]
    return "\n".join(lines)

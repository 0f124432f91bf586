"""Writes the outcome of a batch as Markdown: scenarios, failed runs, changes against a baseline.

Reads the messages of `runner run --message-format json` and the object of `runner compare --format json`. Called by
`run.sh`. On GitHub it also annotates failures, and counts them in GITHUB_OUTPUT. Needs Python 3.8 and no package.
"""

import argparse
import json
import math
import os
import re
from collections import Counter
from pathlib import Path

# Rows of a table: what a reader takes in, far below GitHub's limit of 1 MiB for a summary.
ROWS = 40
# Failed runs of a scenario that are shown where not all fit.
RUNS = 3
# GitHub shows ten errors of a step.
ANNOTATIONS = 10
# Characters of a cell and of a block of diagnostics.
CELL = 300
BLOCK = 4000

MEANING = {
    0: "all runs finished, every expectation and claim held.",
    1: "an expectation did not hold, or a claim fails.",
    2: "the input is invalid; nothing was run.",
    3: "a run or a reference run did not finish, or results could not be written.",
    4: "nothing was selected.",
    5: "a claim is undecided, or a search has no result.",
    130: "interrupted; finished runs are kept.",
    143: "interrupted; finished runs are kept.",
}


def visible(text):
    """The text on one line, with line breaks and control characters as escapes."""
    text = text if len(text) <= CELL else text[: CELL - 1] + "…"
    return "".join(c if c.isprintable() else repr(c)[1:-1] for c in text)


def code(text):
    """A code span: nothing in it is Markdown, HTML or a mention. A bar is escaped, as tables need it."""
    text = visible(str(text)).replace("|", "\\|")
    if not text.strip():
        return ""
    fence = "`" * (1 + max(map(len, re.findall("`+", text)), default=0))
    pad = " " if text[0] in "` " or text[-1] in "` " else ""
    return f"{fence}{pad}{text}{pad}{fence}"


def block(text):
    """A block of code."""
    text = text if len(text) <= BLOCK else text[:BLOCK] + "\n…"
    fence = "`" * max(3, 1 + max(map(len, re.findall("`+", text)), default=0))
    return [fence + "text", *text.splitlines(), fence]


def short(value, digits, sign=""):
    """Digits of a number, without the zeros that Python writes in exponents."""
    return re.sub(r"e([+-])0*", lambda match: "e" + match[1].strip("+"), f"{value:{sign}.{digits}g}")


def number(value, digits=6):
    """A number of a message, which may be null or a text such as "inf"."""
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        return short(value, digits)
    return "-" if value is None or value == "" else code(value)


def count(number_of, noun):
    plural = "es" if noun.endswith("s") else "s"
    return f"{number_of} {noun}{'' if number_of == 1 else plural}"


def table(header, right, rows, what, limit=ROWS, total=None):
    """A table of at most `limit` rows, and how many of all are shown. `right` numbers the columns aligned right."""
    total = len(rows) if total is None else total
    lines = ["| " + " | ".join(header) + " |"]
    lines.append("|" + "|".join("--:" if column in right else "---" for column in range(len(header))) + "|")
    lines += ["| " + " | ".join(row) + " |" for row in rows[:limit]]
    if total > min(len(rows), limit):
        lines += ["", f"{min(len(rows), limit)} of {count(total, what)} shown."]
    return [*lines, ""]


def read_messages(path):
    """All messages that are whole: the last line of a killed program may not be."""
    messages = []
    try:
        lines = Path(path).read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError:
        return messages
    for line in lines:
        try:
            message = json.loads(line)
        except ValueError:
            continue
        if isinstance(message, dict):
            messages.append(message)
    return messages


def run_name(run):
    """Scenario and label, as the program shows them."""
    name = f"{run['scenario']} {run['label']}".strip()
    return f"{name} (reference {run['key']})" if run["reference"] else name


def natural(label):
    """For sorting: seed=9 comes before seed=10."""
    return [int(part) if part.isdigit() else part for part in re.split("([0-9]+)", label)]


def expected(verdict):
    """What an expectation allows."""
    low, high = verdict["min"], verdict["max"]
    if verdict["truth"] is not None:
        return f"{number(verdict['truth'])} ± {number(verdict['allowed'], 3)}"
    if low is not None and high is not None:
        return f"{number(low)} to {number(high)}"
    if low is not None:
        return f"at least {number(low)}"
    if high is not None:
        return f"at most {number(high)}"
    return code(verdict["message"])


def scenario_table(runs):
    """A row per scenario, those with failed runs first."""
    groups = {}
    for run in runs:
        if not run["reference"]:
            groups.setdefault(run["scenario"], []).append(run)
    rows = []
    for name, group in sorted(groups.items(), key=lambda item: all(run["accepted"] for run in item[1])):
        outcomes = Counter(run["outcome"] for run in group)
        verdicts = [verdict for run in group for verdict in run["expectations"]]
        held = sum(verdict["held"] for verdict in verdicts)
        seconds = [run["metrics"].get("wall_s") for run in group]
        seconds = sum(s for s in seconds if isinstance(s, (int, float)))
        shown = ", ".join(f"{n} {outcome}" for outcome, n in outcomes.most_common())
        rows.append(
            [
                code(name),
                str(len(group)),
                shown if all(run["accepted"] for run in group) else f"**{shown}**",
                f"{held} of {len(verdicts)}" if verdicts else "-",
                short(seconds, 3),
            ]
        )
    return table(["scenario", "runs", "outcomes", "expectations held", "time, s"], {1, 3, 4}, rows, "scenario")


def missed(run):
    return [verdict for verdict in run["expectations"] if not verdict["held"]]


def failure_tables(runs):
    """Failed expectations, and runs that ended otherwise."""
    failed = [run for run in runs if not run["accepted"]]
    judged = [run for run in failed if missed(run)]
    rows, all_rows, shown = [], 0, Counter()
    crowded = sum(len(missed(run)) for run in judged) > ROWS
    for run in judged:
        all_rows += len(missed(run))
        shown[run["scenario"]] += 1
        if crowded and shown[run["scenario"]] > RUNS:
            continue
        for index, verdict in enumerate(missed(run)):
            rows.append(
                [
                    code(run_name(run)) if index == 0 else "",
                    code(verdict["metric"]),
                    number(verdict["measured"]),
                    expected(verdict),
                    number(verdict["error"], 3),
                ]
            )
    lines = []
    if rows:
        header = ["run", "metric", "measured", "expected", "error"]
        lines += ["#### Failed expectations", ""]
        lines += table(header, {2, 4}, rows, "failed expectation", total=all_rows)
    unfinished = [run for run in failed if not missed(run)]
    if unfinished:
        rows = [[code(run_name(run)), code(run["outcome"]), code(run["message"])] for run in unfinished]
        lines += ["#### Runs that did not finish", ""]
        lines += table(["run", "outcome", "reason"], set(), rows, "run")
    return lines


def parsed(text):
    try:
        value = float(text)
    except (TypeError, ValueError):
        return None
    return value if math.isfinite(value) else None


def change_row(change):
    """Old and new value, their difference and the relative change; sorted by the latter."""
    old, new = parsed(change["a"]), parsed(change["b"])
    name = [code(change["run"]), code(change["column"])]
    if old is None or new is None:
        return math.inf, [*name, number(change["a"]), number(change["b"]), "-", "-"]
    digits = next((d for d in (6, 9, 12) if short(old, d) != short(new, d)), 17)
    relative = (new - old) / abs(old) if old else math.inf
    shown = short(100 * relative, 3, "+") + " %" if math.isfinite(relative) else "-"
    return abs(relative), [*name, short(old, digits), short(new, digits), short(new - old, 3, "+"), shown]


def differences(compared):
    """Runs and values that differ: their number, and their part of the summary."""
    beyond, outcomes = compared["beyond"], compared["outcomes"]
    gone, added = compared["only_in_a"], compared["only_in_b"]
    claims, searches = compared.get("claims", []), compared.get("searches", [])
    changed = len(beyond) + len(outcomes) + len(claims) + len(searches) + len(gone) + len(added)
    if not changed:
        return 0, [f"{count(compared['matched'], 'run')} compared: no change beyond tolerance.", ""]
    parts = [
        f"{count(len(list_), noun)} {state}"
        for list_, noun, state in (
            (outcomes, "outcome", "changed"),
            (claims, "claim", "changed"),
            (searches, "found value", "changed"),
            (beyond, "value", "beyond tolerance"),
            (gone, "run", "missing"),
            (added, "run", "added"),
        )
        if list_
    ]
    lines = [f"{count(compared['matched'], 'run')} compared: {', '.join(parts)}.", ""]
    if outcomes:
        rows = [[code(o["run"]), code(o["a"]), code(o["b"])] for o in outcomes]
        lines += table(["run", "outcome before", "now"], set(), rows, "outcome", 10)
    for key, found in (("claim", claims), ("search", searches)):
        if found:
            rows = [[code(one[key]), code(one["a"]), code(one["b"])] for one in found]
            lines += table([key, "before", "now"], set(), rows, key, 10)
    # Sorted by relative change.
    rows = [row for _, row in sorted(map(change_row, beyond), key=lambda pair: -pair[0])]
    header = ["run", "metric", "before", "now", "difference", "relative"]
    if len(rows) > ROWS:
        # One row per metric: its greatest change.
        times = Counter(row[1] for row in rows)
        greatest = {}
        for row in rows:
            greatest.setdefault(row[1], row)
        rows = [[*row, str(times[row[1]])] for row in sorted(greatest.values(), key=lambda row: -times[row[1]])]
        header += ["runs changed"]
        lines += ["The greatest change of each metric:", ""]
    if rows:
        lines += table(header, {2, 3, 4, 5, 6}, rows, "changed value" if len(header) == 6 else "metric")
    for title, runs in (("Only in the baseline", gone), ("Not in the baseline", added)):
        if runs:
            lines += table([title], set(), [[code(run)] for run in runs], "run", 10)
    return changed, lines


def trends(history):
    """Trends of metrics over the results of a history."""
    found = [series for series in history["series"] if series["trend"] and series["trend"]["is_shown"]]
    if not found:
        return 0, []
    rows = [
        [
            code(series["run"]),
            code(series["column"]),
            *(number(series[key]) for key in ("value", "last", "median")),
            "rises" if series["trend"]["s"] > 0 else "falls",
            short(series["trend"]["p"], 2),
        ]
        for series in found
    ]
    header = ["run", "metric", "now", "before", "median", "trend", "p"]
    return len(found), table(header, {2, 3, 4, 6}, rows, "trend")


def comparison(result):
    """A result against the baseline or history: the number of changes, and their part of the summary."""
    if not result["is_compared"]:
        return 0, ["The history has no other results yet.", ""]
    changed, lines = differences(result["changes"])
    drifting, part = trends(result["history"]) if "history" in result else (0, [])
    lines += part
    lines += claim_table(result["claims"], "Claims about changes")
    return changed + drifting + sum(claim["verdict"] == "fails" for claim in result["claims"]), lines


def annotations(runs, diagnostics):
    """Workflow commands of GitHub. Their values are escaped: no text of a file makes another command."""

    def data(text):
        return text.replace("%", "%25").replace("\r", "%0D").replace("\n", "%0A")

    def value(text):
        return data(str(text)).replace(":", "%3A").replace(",", "%2C")

    lines = []
    for diagnostic in diagnostics:
        if diagnostic["severity"] != "error":
            continue
        place = {"file": diagnostic["file"], "line": diagnostic["line"], "col": diagnostic["column"]}
        if str(diagnostic["file"]).startswith("--"):
            place = {}
        place = ",".join(f"{key}={value(given)}" for key, given in place.items() if given is not None)
        lines.append(f"::error {place}".rstrip() + f"::{data(diagnostic['message'])}")
    for run in runs:
        if not run["accepted"]:
            reason = data(visible(run["message"])) or run["outcome"]
            title = f"{run_name(run)}: {run['outcome']}"
            lines.append(f"::error file={value(run['file'])},title={value(title)}::{reason}")
    return lines[:ANNOTATIONS]


def claim_table(claims, title="Claims"):
    """The claims with verdict, measured value and bounds; nothing without claims."""
    if not claims:
        return []
    rows = ["| claim | verdict | statement | measured | from | to | counted |", "|---|---|---|---|---|---|---|"]
    for claim in claims[:ROWS]:
        name = f"{claim['scenario']}: {claim['claim']}" + (f" [{claim['group']}]" if claim["group"] else "")
        values = [number(claim[key], 3) for key in ("estimate", "lower", "upper")]
        cells = [code(name), claim["verdict"], code(claim["statement"]), *values, f"{claim['used']} of {claim['planned']}"]
        rows.append("| " + " | ".join(cells) + " |")
    if len(claims) > ROWS:
        rows += ["", f"and {count(len(claims) - ROWS, 'more claim')}"]
    return [f"#### {title}", "", *rows, ""]


def found(search):
    """What a search found; empty without a result."""
    points = sum(len(line) for line in search.get("lines", []))
    if search["interval"]:
        side = "above" if search["interval"]["holds_above"] else "below"
        return f"{search['interval']['lower']:.9g} to {search['interval']['upper']:.9g}, holds {side}"
    if search["best"]:
        at = ", ".join(f"{key} = {x:.9g}" for key, x in zip(search["keys"], search["best"]["at"]))
        return f"{search['best']['value']:.6g} at {at}"
    return f"{count(len(search['lines']), 'line')} of {count(points, 'point')}" if points else ""


def search_table(searches):
    """The searches with verdict and what they found; nothing without searches."""
    if not searches:
        return []
    rows = ["| search | verdict | over | found | runs |", "|---|---|---|---|---|"]
    for search in searches[:ROWS]:
        kind = {"minimum": "least ", "maximum": "greatest "}.get(search["search"], "")
        name = f"{search['scenario']}: {kind}{search['subject']}" + (f" [{search['label']}]" if search["label"] else "")
        given = found(search) or search["message"]
        shown = code(given) if given else ""
        cells = [code(name), search["verdict"], code(", ".join(search["keys"])), shown, str(search["runs"])]
        rows.append("| " + " | ".join(cells) + " |")
    if len(searches) > ROWS:
        rows += ["", f"and {len(searches) - ROWS} more"]
    return ["#### Searches", "", *rows, ""]


def summary(messages, compared, given):
    """The Markdown, the number of failed runs and the number of changes."""
    exit_code = given.exit_code
    events = {}
    for message in messages:
        events.setdefault(message.get("event"), []).append(message)
    started = events.get("batch-started", [{}])[-1]
    # Messages come as runs end; the summary has the order of the command line.
    files = {file: index for index, file in enumerate(started.get("files", []))}
    runs = sorted(
        events.get("run-finished", []),
        key=lambda run: (files.get(run["file"], len(files)), natural(run["label"])),
    )
    finished = events.get("batch-finished", [{}])[-1]
    diagnostics = events.get("diagnostic", [])
    failed = sum(not run["accepted"] for run in runs)
    total = len(runs)

    if exit_code == 0:
        title = f"{count(total, 'run')}, all as expected"
    elif failed:
        title = f"{failed} of {count(total, 'run')} failed"
    else:
        title = "nothing was run" if not total else f"exit code {exit_code}"
    lines = [f"### Scenarios: {title}", ""]
    lines += [f"Exit code {exit_code}: {MEANING.get(exit_code, 'the program did not end by itself.')}"]
    if started.get("program"):
        lines += [f"Results of {code(started['program'])} are in {code(given.output)}."]
    lines += [""]
    if finished.get("error"):
        lines += [f"Error: {code(finished['error'])}", ""]
    if finished.get("not_started"):
        lines += [f"{count(finished['not_started'], 'run')} not started.", ""]
    if finished.get("not_needed"):
        lines += [f"{count(finished['not_needed'], 'run')} not started, since their claims are decided.", ""]
    if not messages:
        lines += ["The program wrote no messages: the log of this step has its error.", ""]
    if diagnostics:
        kinds = Counter(diagnostic["severity"] for diagnostic in diagnostics)
        lines += ["#### " + ", ".join(count(n, kind) for kind, n in kinds.items()), ""]
        diagnostics.sort(key=lambda diagnostic: ["error", "warning", "note"].index(diagnostic["severity"]))
        lines += [*block("\n\n".join(diagnostic["rendered"] for diagnostic in diagnostics)), ""]
    if total:
        lines += scenario_table(runs)
        lines += failure_tables(runs)
    lines += search_table(events.get("search-ended", []))
    lines += claim_table(events.get("claim-judged", []))
    changed = None
    if given.baseline:
        lines += ["#### Compared with the baseline", ""]
        if given.compare_code is None:
            lines += [f"There is no baseline {code(given.baseline)} yet.", ""]
        elif compared is None:
            failure = f"failed with exit code {given.compare_code}: the log of this step has its error."
            lines += [f"The comparison with {code(given.baseline)} {failure}", ""]
        else:
            changed, part = comparison(compared["results"][0])
            lines += part
    return "\n".join(lines), failed, changed


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--messages", required=True)
    parser.add_argument("--compare", required=True, help="may be missing")
    parser.add_argument("--output", required=True, help="folder of the results, where summary.md is written")
    parser.add_argument("--exit-code", type=int, required=True)
    parser.add_argument("--baseline", help="given if a comparison was attempted")
    parser.add_argument("--compare-code", type=int, help="its exit code; none without a baseline")
    given = parser.parse_args()

    messages = read_messages(given.messages)
    try:
        compared = json.loads(Path(given.compare).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        compared = None
    # The program prints nothing if it cannot compare.
    compared = compared if isinstance(compared, dict) and compared.get("results") else None
    text, failed, changed = summary(messages, compared, given)
    Path(given.output, "summary.md").write_text(text, encoding="utf-8")

    if os.environ.get("GITHUB_ACTIONS"):
        runs = [message for message in messages if message.get("event") == "run-finished"]
        diagnostics = [message for message in messages if message.get("event") == "diagnostic"]
        print("\n".join(annotations(runs, diagnostics)))
    if os.environ.get("GITHUB_OUTPUT"):
        with open(os.environ["GITHUB_OUTPUT"], "a", encoding="utf-8") as outputs:
            outputs.write(f"failed-runs={failed}\nchanged={'' if changed is None else changed}\n")


if __name__ == "__main__":
    main()

"""The command: runs cases in engines, lists both, and formats results as tables."""

import argparse
import os
import signal
import sys
import time
from collections import Counter
from pathlib import Path

from . import adapters, case, cost, picture, rows, sweep, tables
from .worker_process import described

EXIT_CODES = """exit codes:
  0    done: the outcomes are in the summary
  2    wrong arguments, or a case or a folder that cannot be used
  130  interrupted (SIGINT); finished cells are written
  143  interrupted (SIGTERM); finished cells are written"""


class UsageError(Exception):
    """Wrong arguments; the text has what is wrong, found and expected."""


def _positive(kind):
    def parse(text):
        value = kind(text)
        if not value > 0:
            raise argparse.ArgumentTypeError(f"{text!r} is not above 0")
        return value

    parse.__name__ = kind.__name__
    return parse


def parser():
    """The parser of the command line."""
    top = argparse.ArgumentParser(
        prog="stiction-engines",
        description="Run contact cases with known truths in physics engines",
        epilog=EXIT_CODES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    commands = top.add_subparsers(dest="command", required=True, metavar="COMMAND")
    run = commands.add_parser(
        "run",
        help="run cases in engines, write summary.csv, details.csv and truths.csv",
        epilog=EXIT_CODES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    run.add_argument(
        "--engines",
        nargs="+",
        metavar="NAME",
        default=[],
        help="names, or paths of adapters of your own (default: all that are installed)",
    )
    run.add_argument(
        "--cases", nargs="+", metavar="SUBSTRING", default=[], help="parts of names (default: all cases)"
    )
    run.add_argument(
        "--settings", nargs="+", metavar="NAME", default=[], help="names of settings (default: all)"
    )
    run.add_argument(
        "--steps",
        nargs="+",
        type=_positive(float),
        metavar="S",
        default=[],
        help="lengths of fixed steps, s (default: those of the settings)",
    )
    run.add_argument(
        "--tolerances",
        nargs="+",
        type=_positive(float),
        metavar="X",
        default=[],
        help="relative tolerances of adaptive settings (default: those of the settings)",
    )
    run.add_argument(
        "-j",
        "--jobs",
        type=_positive(int),
        default=os.cpu_count() or 1,
        metavar="N",
        help="parallel runs [default: one per processor]",
    )
    run.add_argument(
        "--time-limit",
        type=_positive(float),
        default=60.0,
        metavar="S",
        help="wall-clock limit of a run, s [default: 60]",
    )
    run.add_argument(
        "--rounds",
        type=_positive(int),
        default=3,
        metavar="N",
        help="runs of each cell for its cost [default: 3]",
    )
    run.add_argument("--no-cost", action="store_true", help="do not measure processor time")
    run.add_argument(
        "-o",
        "--output",
        default="results/engines",
        metavar="FOLDER",
        help="folder of the results [default: results/engines]",
    )
    commands.add_parser("list", help="list cases and engines")
    shown = commands.add_parser("tables", help="print results as Markdown")
    shown.add_argument("folder", metavar="FOLDER", help="folder of the results")
    shown.add_argument(
        "--step",
        type=_positive(float),
        default=1e-3,
        metavar="S",
        help="fixed step that is shown, s [default: 1e-3]; adaptive settings show their middle tolerance",
    )
    drawn = commands.add_parser("picture", help="draw error over cost as SVG")
    drawn.add_argument("folder", metavar="FOLDER", help="folder of the results")
    drawn.add_argument("-o", "--output", required=True, metavar="FILE", help="file of the picture")
    return top


def _known(kind, unknown, names):
    return UsageError(f"unknown {kind} {unknown!r}; known: {', '.join(names)}")


def chosen_engines(names, jobs):
    """Descriptions of engines by adapter. Prints what is not installed. Raises `UsageError`."""
    for name in names:
        if name.endswith(".py") and not Path(name).is_file():
            raise UsageError(f"{name}: no such file, expected an adapter")
        if not name.endswith(".py") and name not in adapters.names():
            raise _known("engine", name, adapters.names())
    wanted = [str(Path(name).resolve()) if name.endswith(".py") else name for name in dict.fromkeys(names)]
    found = described(wanted or adapters.names(), jobs)
    for name, engine in found.items():
        if "missing" in engine and names:
            raise UsageError(f"{name}: {engine['missing']}")
        if "missing" in engine:
            print(f"{name}: {engine['missing']}")
    return {name: engine for name, engine in found.items() if "missing" not in engine}


def chosen_cases(parts):
    """Cases whose names contain one of the parts. Raises `UsageError`."""
    cases = case.read_all()
    for part in parts:
        if not any(part in known.name for known in cases):
            raise _known("case", part, [known.name for known in cases])
    return [known for known in cases if not parts or any(part in known.name for part in parts)]


def prepared_folder(folder):
    """Makes the folder of results. Raises `UsageError`."""
    try:
        Path(folder).mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise UsageError(f"{folder}: {error.strerror}, expected a folder that can be written") from error
    return Path(folder)


def progress(name, engine, results):
    """The line of a case and engine."""
    outcomes = Counter(result.outcome for result in results)
    if outcomes["unsupported"] == len(results):
        line = "unsupported"
    else:
        line = f"{outcomes.pop('passed', 0)} of {len(results)} passed"
        line += "".join(f", {count} {outcome}" for outcome, count in outcomes.items())
    seconds = sum(result.wall or 0.0 for result in results)
    print(f"{name:24}{engine:12}{line}  {seconds:.1f} s", flush=True)


def report(cells, results):
    """Outcomes by engine, and the reasons of what did not pass."""
    order = ["passed", "unsupported", "diverged", "timed-out", "error", "cancelled"]
    print()
    for engine in dict.fromkeys(cell.engine for cell in cells):
        outcomes = Counter(r.outcome for c, r in zip(cells, results) if c.engine == engine)
        print(f"{engine:12}" + ", ".join(f"{outcomes[name]} {name}" for name in order if outcomes[name]))
    for outcome in order[1:5]:
        found = {}
        for cell, result in zip(cells, results):
            if result.outcome == outcome:
                reason = result.message if outcome == "unsupported" else result.message[:100]
                found.setdefault((cell.engine, reason), {})[cell.case] = None
        if found:
            print(f"\n{outcome}:")
        for (engine, message), names in found.items():
            names = list(names)
            shown = ", ".join(names[:3]) + (f" and {len(names) - 3} more" if len(names) > 3 else "")
            print(f"  {engine}: {message} ({shown})")


def run(options):
    """Runs the sweep. Returns the exit code."""
    cases = chosen_cases(options.cases)
    folder = prepared_folder(options.output)
    engines = chosen_engines(options.engines, options.jobs)
    if not engines:
        raise UsageError("no engine is installed")
    known = list(dict.fromkeys(s["name"] for engine in engines.values() for s in engine["settings"]))
    for name in options.settings:
        if name not in known:
            raise _known("settings", name, known)
    cells = sweep.cells(cases, engines, options.settings, options.steps, options.tolerances)
    print(f"{len(cells)} runs: {len(cases)} cases, engines {', '.join(e['name'] for e in engines.values())}")
    interrupted = []

    def interrupt(number, _):
        interrupted.append(number)
        raise KeyboardInterrupt

    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, interrupt)
    begin = time.monotonic()
    results, complete = sweep.run(cells, options.jobs, options.time_limit, progress)
    if complete and not options.no_cost:
        print("\ncosts:")
        complete = cost.run(cells, results, options.rounds, _cost_progress)
    report(cells, results)
    print(f"\n{time.monotonic() - begin:.0f} s")
    summary, truths = rows.write_summary(folder, cases, cells, results), rows.write_truths(folder, cases)
    for file in (summary, summary.with_name(rows.DETAILS), truths):
        print(file)
    return 0 if complete else 128 + interrupted[0]


def _cost_progress(name, pairs):
    measured = [result for _, result in pairs if result.cpu is not None]
    noise = f"  noise {measured[0].noise[0]:.0%} (at most {measured[0].noise[1]:.0%})" if measured else ""
    print(f"{name:24}{len(measured)} of {len(pairs)} measured{noise}", flush=True)


def list_all():
    """Prints cases and engines. Returns the exit code."""
    print("cases:")
    for known in case.read_all():
        print(f"  {known.name:24}{known.family:12}{known.title}")
    print("\nengines:")
    missing = []
    for name, engine in described(adapters.names()).items():
        if "missing" in engine:
            missing.append(f"{name}: {engine['missing']}")
            continue
        print(f"  {engine['name']} {engine['version']}")
        for choice in engine["settings"]:
            kind = "tolerances" if choice["adaptive"] else "steps"
            steps = ", ".join(f"{step:g}" for step in choice["steps"])
            print(f"    {choice['name']:14}{kind} {steps}: {choice['description']}")
    if missing:
        print("\n" + "\n".join(missing))
    return 0


def show(options):
    """Prints tables or draws the picture. Returns the exit code."""
    try:
        if options.command == "picture":
            picture.write(options.folder, options.output)
        else:
            print(tables.text([options.folder], options.step))
    except FileNotFoundError as error:
        raise UsageError(f"{error.filename}: no such file, expected the folder of a `run`") from error
    except KeyError as error:
        raise UsageError(
            f"{options.folder}: summary.csv has no column {error}, expected that of a `run`"
        ) from error
    return 0


def main(arguments=None):
    """The command. Returns the exit code."""
    options = parser().parse_args(arguments)
    try:
        if options.command == "run":
            return run(options)
        return list_all() if options.command == "list" else show(options)
    except BrokenPipeError:
        # The reader has ended, such as `head`. Python would complain once more when it flushes at its end.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except (UsageError, case.CaseError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 2


if __name__ == "__main__":
    sys.exit(main())

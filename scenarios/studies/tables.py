"""Prints the tables of docs/studies.md from the summary of the studies' runs.

    runner scenarios/studies/*.toml --output results
    python3 scenarios/studies/tables.py results/summary.csv

Needs Python 3.9, nothing else.
"""

import csv
import itertools
import re
import sys


def number(row, column):
    return float(row[column]) if row.get(column) else 0.0


def short(value):
    """Two digits, three if it is in the hundreds; with an exponent where it is small or large."""
    if value == 0 or 0.01 <= value < 99.5:
        return f"{value:.2g}"
    if 99.5 <= value < 1000:
        return f"{value:.0f}"
    mantissa, exponent = f"{value:.1e}".split("e")
    return f"{mantissa.removesuffix('.0')}e{int(exponent)}"


def power(value):
    """With an exponent always, so that a column can be read downwards."""
    mantissa, exponent = f"{value:.1e}".split("e")
    return f"{mantissa}e{int(exponent)}"


def table(head, rows):
    print("| " + " | ".join(head) + " |")
    print("|" + "---|" * len(head))
    for row in rows:
        line = "| " + " | ".join(row) + " |"
        # An empty cell is one blank wide.
        print(re.sub(r"\|  (?=\|)", "| ", line))
    print()


def precision(rows, settings, name, error, columns):
    """Errors at their costs: a line for each method, a column for each step or tolerance."""

    def key(row):
        return tuple(row[column] for column in settings)

    lines = []
    for one, runs in itertools.groupby(rows, key):
        lines.append([name(dict(zip(settings, one)))])
        lines[-1] += [f"{power(error(run))} at {power(number(run, 'timing_cpu_min_s') / number(run, 'duration_s'))}" for run in runs]
    table(["method", *columns], lines)


def block(rows):
    def name(setting):
        facets = f", {setting['contact.lcp.facets']} facets" if setting["contact.method"] == "lcp" else ""
        return f"{setting['contact.method']}, {setting['integrator.method']}{facets}"

    def off(row):
        return (number(row, "error_final_base_x") ** 2 + number(row, "error_final_base_y") ** 2) ** 0.5

    settings = ["contact.method", "integrator.method", "contact.lcp.facets"]
    spins = [number(row, "robot.base.angular_velocity.2") != 0 for row in rows]
    for title, wanted in [("slides to rest", False), ("slides and spins", True)]:
        print(f"A block {title}\n")
        some = [row for row, spin in zip(rows, spins) if spin == wanted]
        precision(some, settings, name, off, ["1e-2", "1e-3", "1e-4", "1e-5"])


def humanoid(rows):
    settings = ["contact.method", "integrator.method"]
    for metric in ["error_position_rms_m", "error_force_rms_N", "error_joint_rms_rad"]:
        for title, some in motions(rows):
            print(f"{metric}, *{title}*\n")

            def error(row):
                return number(row, metric)

            precision(some, settings, lambda setting: ", ".join(setting.values()), error, ["1e-3", "3e-4", "1e-4", "3e-5"])


def servo(rows):
    settings = ["contact.method", "integrator.method"]
    for metric in ["error_joint_rms_rad", "error_force_rms_N"]:
        print(f"{metric}\n")
        precision(rows, settings, lambda setting: ", ".join(setting.values()), lambda row: number(row, metric), ["1e-3", "1e-4", "3e-5", "1e-5"])


def motions(rows):
    pushed = [row["force.0.force"] not in ("[0, 0, 0]", "[0,0,0]", "[0.0, 0.0, 0.0]", "[0.0,0.0,0.0]") for row in rows]
    for title, wanted in [("landing", False), ("push", True)]:
        yield title, [row for row, push in zip(rows, pushed) if push == wanted]


def tolerances(rows):
    def tolerance(row, column):
        return short(number(row, column))

    def errors(row):
        columns = ["error_position_rms_m", "error_joint_rms_rad", "error_final_rotation_rad", "error_force_rms_N"]
        return [short(number(row, column)) for column in columns] + [f"{number(row, 'contact_state_agreement'):.2f}"]

    def tested(row):
        return f"{number(row, 'states_tested_mean'):.1f}, {number(row, 'states_tested_max'):.0f}"

    def is_default(row):
        columns = ["velocity_tolerance", "acceleration_tolerance", "distance_tolerance"]
        contact = [number(row, f"contact.{column}") for column in columns]
        return contact == [0.1, 0.1, 1e-3] and number(row, "integrator.relative_tolerance") == 1e-6

    def located(row):
        names = ["contact.velocity_tolerance", "contact.acceleration_tolerance", "integrator.relative_tolerance"]
        name = ", ".join(tolerance(row, column) for column in names)
        if number(row, "contact.distance_tolerance") != 1e-3:
            name += f", d {tolerance(row, 'contact.distance_tolerance')}"
        elif is_default(row):
            name = f"**{name}**"
        return [name, *errors(row), row["impacts"], tested(row), tolerance(row, "cpu_s")]

    def stepped(row):
        adaptive = row["integrator.method"] == "dopri5"
        step = tolerance(row, "integrator.max_step" if adaptive else "integrator.step")
        names = ["contact.distance_tolerance", "contact.velocity_tolerance"]
        name = [row["contact.method"], row["integrator.method"], step, *(tolerance(row, column) for column in names)]
        return [", ".join(name), *errors(row), tolerance(row, "max_tension_N"), tolerance(row, "cpu_s")]

    def at_ends(row):
        return row["contact.events"] == "step" or row["contact.method"] == "one-step" or row["integrator.method"] == "semi-implicit"

    # What runs of the same bits share.
    def bits(row):
        return [row[column] for column in row if column.startswith(("final_", "max_", "error_")) or column == "steps"]

    lines, ends, notes = [], [], []
    for title, some in motions(rows):
        units = [f"*{title}*", "m", "rad", "rad", "N", ""]
        lines.append([*units, "", "", ""])
        ends.append([*units, "N", ""])
        seen = []
        for row in some:
            if row["inconsistent"] != "0":
                name = stepped(row)[0] if at_ends(row) else located(row)[0]
                notes.append(f"{title}: {name} has {row['inconsistent']} inconsistent selections")
            if at_ends(row):
                ends.append(stepped(row))
            elif not is_default(row) and bits(row) in [bits(other) for other in seen]:
                notes.append(f"{title}: {located(row)[0]} gives the same bits as one above")
            else:
                lines.append(located(row))
                seen.append(row)
    common = ["position", "joints", "end", "force", "agreement"]
    table(["v_t, a_t, relative tolerance", *common, "impacts", "tested", "cost"], lines)
    print("\n".join(notes) + "\n")
    table(["method, integrator, h, d, v_t", *common, "pull", "cost"], ends)


def pushes(rows):
    """The greatest push up to which all are survived and the next one, without balance and with it."""

    def limits(some):
        ordered = sorted(some, key=lambda row: number(row, "force.0.force.0"))
        stands = list(itertools.takewhile(lambda row: row["outcome"] == "passed", ordered))
        falls = ordered[len(stands) :]
        if not stands or not all(row["outcome"] == "fallen" for row in falls):
            return ["?", "?"]
        return [peak(stands[-1]), peak(falls[0])]

    def peak(row):
        return f"{number(row, 'force.0.force.0'):.0f}"

    lines = []
    for time in sorted({number(row, "force.0.duration") for row in rows}):
        blows = [row for row in rows if number(row, "force.0.duration") == time]
        balanced = [[row for row in blows if (row["task"] != "[]") == wanted] for wanted in (False, True)]
        lines.append([f"{time:g} s", *limits(balanced[0]), *limits(balanced[1])])
    table(["T", "stands without", "falls", "stands with balance", "falls"], lines)
    for row in rows:
        if row["inconsistent"] != "0":
            balance = "without" if row["task"] == "[]" else "with"
            print(f"{peak(row)} N in {row['force.0.duration']} s {balance} balance: {row['inconsistent']} instants without a state")
    print()


STUDIES = {
    "work-precision-block": block,
    "work-precision-hoap2": humanoid,
    "work-precision-servo": servo,
    "contact-tolerances": tolerances,
    "hoap2-push-limits": pushes,
}

with open(sys.argv[1], newline="") as file:
    everything = list(csv.DictReader(file))
for scenario, show in STUDIES.items():
    found = [row for row in everything if row["scenario"] == scenario]
    if found:
        print(f"# {scenario}\n")
        show(found)

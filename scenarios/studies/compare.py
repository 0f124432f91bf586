#!/usr/bin/env python3
"""Errors and costs of the runs of a study against its reference.

    pip install -r ../../tests/oracles/requirements.txt
    python compare.py results contact-tolerances-landing [...]

`results` is the folder that `runner` wrote, the names are scenarios in it. The first run of a scenario, in the order of
its sweep, is the reference. Printed is a row per run, with the keys that differ between runs and

    x                  root mean square of the distance of the root frame's origin from the reference's, m
    turn               of the angle between the root frames, rad
    joints             of the angles of all joints (mean over joints as well), rad
    force              of the difference of the floor's whole force, N
    end                distance of the origins, m, and angle, rad, at the end
    tested             candidate states per selection, mean and most
    cpu, evaluations   what the run cost, as fractions of the reference's

over all instants that both logs have. Instants within 1e-6 s are the same: fixed steps log the first state at or after
the instant asked for.
"""

import csv
import math
import sys
from pathlib import Path

from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory

SAME = 1000  # ns


def read(path):
    """Log time in ns -> (origin, orientation, joint positions, force of the floor)."""
    states, forces = {}, {}
    with open(path, "rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        for _, channel, message, decoded in reader.iter_decoded_messages(topics=["/state", "/contact"]):
            if channel.topic == "/state":
                p, q = decoded.base_position, decoded.base_orientation
                states[message.log_time] = ((p.x, p.y, p.z), (q.w, q.x, q.y, q.z), tuple(decoded.q))
            else:
                total = [0.0, 0.0, 0.0]
                for sole in decoded.soles:
                    total = [a + b for a, b in zip(total, (sole.force.x, sole.force.y, sole.force.z))]
                forces[message.log_time] = total
    return {round(t / SAME): (*states[t], forces[t]) for t in sorted(states.keys() & forces.keys())}


def angle(p, q):
    """Angle between two unit quaternions; their difference is 2 sin(angle / 4) long."""
    near, far = math.dist(p, q), math.dist(p, [-x for x in q])
    return 4 * math.asin(min(1.0, 0.5 * min(near, far)))


def mean_square_root(values):
    return math.sqrt(math.fsum(v * v for v in values) / len(values))


def errors(run, reference):
    """The columns x, turn, joints, force and the two of end; None when the logs share no instant."""
    pairs = [(run[t], reference[t]) for t in reference if t in run]
    if not pairs:
        return None
    x = [math.dist(a[0], b[0]) for a, b in pairs]
    turn = [angle(a[1], b[1]) for a, b in pairs]
    joints = [math.dist(a[2], b[2]) / math.sqrt(len(b[2])) for a, b in pairs]
    force = [math.dist(a[3], b[3]) for a, b in pairs]
    return [mean_square_root(c) for c in (x, turn, joints, force)] + [x[-1], turn[-1]]


def ratio(row, reference, column):
    return float(row[column]) / float(reference[column])


def compare(results, rows):
    first = rows[0]
    swept = [k for k in first if "." in k and not k.startswith("expect.") and len({r[k] for r in rows}) > 1]
    print(f"\n{first['scenario']}")
    columns = ["outcome", "x", "turn", "joints", "force", "end x", "end turn", "tested", "impacts", "changes"]
    print(" | ".join(swept + columns + ["inconsistent", "penetration", "cpu", "evaluations"]))
    log = lambda row: read(results / row["scenario"] / row["key"] / "log.mcap")
    reference = log(first)
    for row in rows:
        found = errors(log(row), reference)
        cells = [row[k] for k in swept] + [row["outcome"]]
        cells += [f"{e:.1e}" for e in found] if found else ["-"] * 6
        cells += [f"{float(row['states_tested_mean']):.3g}, {row['states_tested_max']}", row["impacts"], row["state_changes"]]
        cells += [row["inconsistent"], f"{float(row['max_penetration_m']):.0e}"]
        cells += [f"{ratio(row, first, column):.2g}" for column in ("cpu_s", "evaluations")]
        print(" | ".join(cells))


def main(arguments):
    if len(arguments) < 2:
        print(__doc__, file=sys.stderr)
        return 2
    results, names = Path(arguments[0]), arguments[1:]
    with open(results / "summary.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    for name in names:
        runs = [r for r in rows if r["scenario"] == name]
        if not runs:
            print(f"no runs of {name} in {results}", file=sys.stderr)
            return 2
        compare(results, runs)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

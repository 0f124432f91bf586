#!/usr/bin/env python3
"""Makes the data of the fits in this folder: runs with known values of the parameters, and noise.

    scenarios/fits/make_data.py [RUNNER]

Runs the program (default: `runner`) and writes data/*.csv. The noise is normal with the standard
deviations below, of fixed seeds; values are rounded to 1e-6.
"""

import csv
import io
import pathlib
import random
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
RUNNER = sys.argv[1] if len(sys.argv) > 1 else "runner"

# True values.
CART = {
    "floor.friction.static": 0.6,
    "floor.friction.kinetic": 0.4,
    "robot.joint.swing.friction.coulomb": 0.01,
    "robot.joint.swing.friction.viscous": 0.001,
}
LOAD = {
    "robot.payload.0.mass": 0.45,
    "robot.payload.0.position.0": -0.06,
    "robot.joint.left_knee.friction.viscous": 0.35,
    "robot.joint.right_knee.friction.viscous": 0.35,
}

# File, scenario, values, columns with their noise.
CART_NOISE = {"base_x_m": 0.001, "joint.swing.position_rad": 0.002}
LEGS = [f"joint.{side}_{name}.effort_Nm" for name in ("knee", "hip_pitch", "ankle_pitch") for side in ("left", "right")]
LOAD_NOISE = dict.fromkeys(LEGS, 0.02)
DATA = [
    ("cart", "cart", CART, CART_NOISE),
    ("cart-gentle", "cart", CART | {"force.0.force": "[9, 0, 0]"}, CART_NOISE),
    ("hoap2-squat", "hoap2-squat", LOAD, LOAD_NOISE),
    ("hoap2-slow", "hoap2-squat", LOAD | {"task.0.depth": 0.02, "task.0.period": 2.7}, LOAD_NOISE),
]


def simulated(scenario, values, columns):
    with tempfile.TemporaryDirectory() as folder:
        overrides = [f"--set={key}={value}" for key, value in values.items()]
        command = [RUNNER, HERE / "base" / f"{scenario}.toml", "-o", folder, *overrides]
        subprocess.run(command, check=True, capture_output=True)
        (log,) = pathlib.Path(folder).glob("*/*/log.mcap")
        command = [RUNNER, "export", log, "--columns", ",".join(columns)]
        table = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    return list(csv.DictReader(io.StringIO(table)))


for name, scenario, values, noise in DATA:
    source = random.Random(name)
    rows = simulated(scenario, values, noise)
    with open(HERE / "data" / f"{name}.csv", "w", encoding="utf-8", newline="\n") as out:
        out.write(f"# By make_data.py; noise {noise[next(iter(noise))]} and the like, seed {name}.\n")
        out.write(",".join(["time_s", *noise]) + "\n")
        for row in rows:
            cells = [f"{float(row[column]) + source.gauss(0.0, sigma):.6f}" for column, sigma in noise.items()]
            out.write(",".join([row["time_s"], *cells]) + "\n")

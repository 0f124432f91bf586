#!/usr/bin/env python3
"""Writes example_robots.json: joints, mass and inertia of every URDF of example-robot-data, as Pinocchio reads them.

Run by hand, in an environment with `pin` and `example-robot-data` (6.0 or newer, wheels that contain the URDF files):

    python tests/oracles/make_example_robots.py

`inertia` is the sum, over all moving links, of the traces of their tensors about their centres of mass, kg m^2.

Each robot has a floating joint, so that its root's mass counts; mimic joints are independent; null where
Pinocchio reads no robot.
"""

import importlib.metadata
import json
from pathlib import Path

import pinocchio as pin

HERE = Path(__file__).resolve().parent
EXAMPLES = Path(pin.__file__).resolve().parents[4] / "share/example-robot-data/robots"


def read(path):
    try:
        model = pin.buildModelFromUrdf(str(path), pin.JointModelFreeFlyer())
    except ValueError:
        return None
    mass = sum(inertia.mass for inertia in model.inertias)
    # Inertias of the universe or of massless links may contain NaN.
    traces = [float(inertia.inertia.trace()) for inertia in model.inertias]
    return {"joints": model.nv - 6, "mass": mass, "inertia": sum(traces)}


def main():
    robots = {str(p.relative_to(EXAMPLES)): read(p) for p in sorted(EXAMPLES.rglob("*.urdf"))}
    versions = {name: importlib.metadata.version(name) for name in ("pin", "example-robot-data")}
    text = json.dumps({"versions": versions, "robots": robots}, indent=1)
    (HERE / "example_robots.json").write_text(text + "\n")


if __name__ == "__main__":
    main()

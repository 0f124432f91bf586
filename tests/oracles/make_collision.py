#!/usr/bin/env python3
"""Distances between all pairs of CB-i's convex bodies in random postures, by Coal; poses by Pinocchio.

    pip install coal==3.0.3 pin==4.1.0 numpy
    python3 make_collision.py                               # writes collision_cbi.json, 40 postures
    python3 make_collision.py --postures 10000 --out FILE   # for the test `many_postures` (COLLISION_ORACLE=FILE)

The script uses only cbi.urdf of this repository. It tessellates the shapes independently, by the
rule of docs/self-collision.md, and Coal (with qhull) builds the hulls. A negative distance is the
depth of an overlap.
"""

import argparse
import json
import sys
import xml.etree.ElementTree as ET
from math import ceil, cos, hypot, pi, sin
from pathlib import Path

import coal
import numpy as np
import pinocchio as pin

HERE = Path(__file__).resolve().parent
URDF = HERE.parents[1] / "robots/cbi/cbi.urdf"
RESOLUTION = 21  # of robots/cbi/cbi.toml
INNER = {"r_eye_pan", "r_eye", "l_eye_pan", "l_eye"}  # inside the head


def ring(radius, z, n):
    return [(radius * cos(2 * pi * k / n), radius * sin(2 * pi * k / n), z) for k in range(n)]


def sphere(radius, n):
    """n meridians, 2 ceil(n / 4) bands, every face at least `radius` from the centre."""
    bands = ceil(n / 4)
    angle = [pi / 2 * k / bands for k in range(bands + 1)]
    sides = [(cos(a) * cos(pi / n), sin(a)) for a in angle]
    clear = [abs(x0 * z1 - x1 * z0) / hypot(x1 - x0, z1 - z0) for (x0, z0), (x1, z1) in zip(sides, sides[1:])]
    outer = radius / min(clear + [cos(pi / n)])
    points = [(0, 0, outer), (0, 0, -outer)]
    for a in angle[:-1]:
        for sign in (1, -1):
            points += ring(outer * cos(a), sign * outer * sin(a), n)
    return points


def points(collision):
    origin, geometry = collision.find("origin"), collision.find("geometry")[0]
    numbers = lambda text: [float(x) for x in text.split()]
    place = pin.SE3(pin.rpy.rpyToMatrix(np.array(numbers(origin.get("rpy", "0 0 0")))), np.array(numbers(origin.get("xyz", "0 0 0"))))
    if geometry.tag == "box":
        x, y, z = (s / 2 for s in numbers(geometry.get("size")))
        own = [(i * x, j * y, k * z) for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)]
    elif geometry.tag == "cylinder":
        radius, half = float(geometry.get("radius")) / cos(pi / RESOLUTION), float(geometry.get("length")) / 2
        own = ring(radius, half, RESOLUTION) + ring(radius, -half, RESOLUTION)
    else:
        own = sphere(float(geometry.get("radius")), RESOLUTION)
    return [place.act(np.array(p)) for p in own]


def hull(cloud):
    vertices = coal.StdVec_Vec3s()
    vertices.extend([np.array(p) for p in cloud])
    return coal.Convex.convexHull(vertices, True, "Qt")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--postures", type=int, default=40)
    parser.add_argument("--out", type=Path, default=HERE / "collision_cbi.json")
    options = parser.parse_args()

    model = pin.buildModelFromUrdf(str(URDF))
    data = model.createData()
    bodies, frames = {}, {}
    for link in ET.parse(URDF).getroot().iter("link"):
        cloud = [p for c in link.iter("collision") for p in points(c)]
        if cloud and link.get("name") not in INNER:
            bodies[link.get("name")] = hull(cloud)
            frames[link.get("name")] = model.getFrameId(link.get("name"), pin.FrameType.BODY)
    names = list(bodies)
    pairs = [(a, b) for i, a in enumerate(names) for b in names[i + 1:]]

    request, result = coal.DistanceRequest(), coal.DistanceResult()
    request.enable_signed_distance = True
    request.gjk_tolerance = request.epa_tolerance = 1e-10
    request.gjk_max_iterations = request.epa_max_iterations = 1000
    random = np.random.default_rng(2026)
    postures = []
    for _ in range(options.postures):
        q = random.uniform(model.lowerPositionLimit, model.upperPositionLimit)
        pin.framesForwardKinematics(model, data, q)
        at = {n: coal.Transform3s(data.oMf[f].rotation, data.oMf[f].translation) for n, f in frames.items()}
        distances = []
        for a, b in pairs:
            result.clear()
            distances.append(coal.distance(bodies[a], at[a], bodies[b], at[b], request, result))
        postures.append({"q": [float(x) for x in q], "distances": [float(f"{d:.12g}") for d in distances]})

    oracle = {
        "versions": {"coal": coal.__version__, "pin": pin.__version__, "numpy": np.__version__},
        "joints": list(model.names)[1:],
        "bodies": {n: [b.num_points, b.num_polygons] for n, b in bodies.items()},
        "pairs": pairs,
    }
    lines = [f"{json.dumps(k)}:{json.dumps(x, separators=(',', ':'))}" for k, x in oracle.items()]
    lines.append('"postures":[\n' + ",\n".join(json.dumps(p, separators=(",", ":")) for p in postures) + "\n]")
    options.out.write_text("{\n" + ",\n".join(lines) + "\n}\n")
    all_distances = np.array([p["distances"] for p in postures])
    print(f"{options.out}: {options.out.stat().st_size} bytes, {all_distances.size} distances, {(all_distances < 0).sum()} overlaps")


if __name__ == "__main__":
    sys.exit(main())

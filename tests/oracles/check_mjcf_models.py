#!/usr/bin/env python3
"""Compares the reader of MJCF with MuJoCo on every MJCF model of installed or unpacked Python packages.

Run by hand, in an environment with `mujoco` (4.0.0) and `numpy`:

    python tests/oracles/check_mjcf_models.py --runner target/release/runner FOLDER...

FOLDER holds packages, for example site-packages, or wheels unpacked side by side: each folder in it is one row of
the table. Without FOLDER the packages of the environment are searched.

For each file with a root element <mujoco> that MuJoCo compiles, `runner inspect --format json` is run. Compared are
total mass, mass, centre and inertia of each link (the bodies welded to it, by MuJoCo's numbers), the mass matrix at
home, and the gains of servos. Differences are relative to the greatest entry of the true values. A file that only
one of both reads is listed with the reason.
"""

import argparse
import collections
import json
import re
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import mujoco
import numpy as np

BOUND = 1e-9


def main():
    arguments = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    arguments.add_argument("--runner", default="target/release/runner")
    arguments.add_argument("--verbose", action="store_true", help="list each file")
    arguments.add_argument("folders", nargs="*", type=Path)
    given = arguments.parse_args()
    folders = given.folders or [Path(mujoco.__file__).resolve().parents[1]]
    packages = collections.defaultdict(list)
    for folder in folders:
        for path in sorted(folder.rglob("*")):
            if path.suffix in (".xml", ".mjcf") and path.is_file() and is_mjcf(path):
                packages[path.relative_to(folder).parts[0]].append(path)
    print("| package | files | for MuJoCo | read | refused | greatest difference of mass | inertia | M |")
    print("|---|---|---|---|---|---|---|---|")
    details = []
    for package, paths in packages.items():
        with ThreadPoolExecutor(2) as pool:
            ours = list(pool.map(lambda path: inspect(given.runner, path), paths))
        results = [judge(path, robot) for path, robot in zip(paths, ours)]
        valid = [r for r in results if r["mujoco"]]
        read = [r for r in valid if "mass" in r]
        worst = [max((r[key] for r in read), default=0.0) for key in ("mass", "inertia", "matrix")]
        print(f"| {package} | {len(paths)} | {len(valid)} | {len(read)} | {len(valid) - len(read)} |", end="")
        print("".join(f" {x:.1e} |" for x in worst), flush=True)
        for path, result in zip(paths, results):
            if not result["mujoco"] and "mass" in result:
                details.append(f"{path}: read, although MuJoCo does not: {result['why']}")
            elif result["mujoco"] and "mass" not in result:
                details.append(f"{path}: refused: {result['why']}")
            elif "mass" in result and max(result["mass"], result["inertia"], result["matrix"], result["gains"]) > BOUND:
                numbers = ", ".join(f"{key} {result[key]:.1e}" for key in ("mass", "inertia", "matrix", "gains"))
                details.append(f"{path}: {numbers}; {result['why']}")
            elif given.verbose:
                details.append(f"{path}: {result}")
    print("\n".join(["", *details]))


def is_mjcf(path):
    text = path.read_text(errors="ignore")
    return re.search(r"<mujoco[\s>]", re.sub(r"<!--.*?-->", "", text, flags=re.S)) is not None


def inspect(runner, path):
    """Our model, or the first line of the error."""
    try:
        command = [runner, "inspect", str(path), "--format", "json"]
        done = subprocess.run(command, capture_output=True, text=True, timeout=300)
    except subprocess.TimeoutExpired:
        return "no answer within 300 s"
    if done.returncode:
        return " / ".join(line.strip() for line in done.stderr.splitlines()[:2])
    return json.loads(done.stdout)


def judge(path, ours):
    try:
        model = mujoco.MjModel.from_xml_path(str(path))
    except ValueError as error:
        why = str(error).strip().splitlines()[0]
        return {"mujoco": False, "why": why} | ({"mass": 0.0} if isinstance(ours, dict) else {})
    if not isinstance(ours, dict):
        return {"mujoco": True, "why": ours}
    return {"mujoco": True, "why": ""} | compare(model, ours)


def name_of(model, kind, i):
    return mujoco.mj_id2name(model, kind, i)


def compare(model, ours):
    """Greatest relative differences."""
    why = []
    bodies = {name_of(model, mujoco.mjtObj.mjOBJ_BODY, i) or f"body{i}": i for i in range(model.nbody)}
    joints = {name_of(model, mujoco.mjtObj.mjOBJ_JOINT, i) or f"joint{i}": i for i in range(model.njnt)}
    data = mujoco.MjData(model)
    data.qpos[:] = model.qpos0
    mujoco.mj_forward(model, data)
    worst = {"mass": 0.0, "inertia": 0.0, "matrix": 0.0, "gains": 0.0}

    def note(kind, got, true, label):
        got, true = np.atleast_1d(got).astype(float), np.atleast_1d(true).astype(float)
        scale = max(np.abs(true).max(), 1e-12)
        difference = np.abs(got - true).max() / scale
        if not difference <= BOUND:
            why.append(f"{kind} of {label}")
        worst[kind] = max(worst[kind], difference)

    fixed = ours["base"] == "fixed"
    total = 0.0
    for number, link in enumerate(ours["links"]):
        if number == 0 and fixed:
            continue
        members = [bodies[n] for n in [link["name"], *(w["name"] for w in link["welded"])] if n in bodies]
        if not members:
            note("mass", link["mass"], 0.0, link["name"])
            continue
        mass, com, tensor = union(model, data, members)
        total += mass
        note("mass", link["mass"], mass, link["name"])
        if mass > 0:
            size = np.sqrt(np.abs(tensor).max() / mass)
            note("inertia", np.append(link["com"], 1.0 + size), np.append(com, 1.0 + size), link["name"])
            note("inertia", link["inertia"], tensor, link["name"])
    note("mass", ours["mass"], total, "the robot")
    matrix(model, ours, joints, note)
    gains(model, ours, joints, note)
    return worst | {"why": ", ".join(why[:6])}


def union(model, data, members):
    """Mass, centre and inertia of bodies in the frame of the first one."""
    origin, axes = data.xpos[members[0]], data.xmat[members[0]].reshape(3, 3)
    mass = sum(model.body_mass[i] for i in members)
    parts = []
    for i in members:
        rotation = axes.T @ data.ximat[i].reshape(3, 3)
        inertia = rotation @ np.diag(model.body_inertia[i]) @ rotation.T
        parts.append((model.body_mass[i], axes.T @ (data.xipos[i] - origin), inertia))
    com = sum(m * c for m, c, _ in parts) / mass if mass > 0 else np.zeros(3)
    tensor = np.zeros((3, 3))
    for m, c, inertia in parts:
        d = c - com
        tensor += inertia + m * (d @ d * np.eye(3) - np.outer(d, d))
    return mass, com, tensor


def rotation(axis, angle):
    """Quaternion of a turn about a unit axis."""
    return np.append(np.cos(angle / 2), np.sin(angle / 2) * np.asarray(axis, float))


def product(a, b):
    out = np.zeros(4)
    mujoco.mju_mulQuat(out, a, b)
    return out


def matrix(model, ours, joints, note):
    """The mass matrix at our home, base at the origin."""
    data = mujoco.MjData(model)
    data.qpos[:] = model.qpos0
    home = {joint["name"]: joint["home"] for joint in ours["joints"]}
    columns = []
    free = [j for j in range(model.njnt) if model.jnt_type[j] == mujoco.mjtJoint.mjJNT_FREE]
    root = ours["links"][0]["name"]
    for j in free:
        body = model.jnt_bodyid[j]
        if ours["base"] == "floating" and (name_of(model, mujoco.mjtObj.mjOBJ_BODY, body) or f"body{body}") == root:
            data.qpos[model.jnt_qposadr[j] : model.jnt_qposadr[j] + 7] = [0, 0, 0, 1, 0, 0, 0]
            columns += [np.eye(model.nv)[model.jnt_dofadr[j] + k] for k in range(6)]
            # It is ignored, with a warning.
            model.dof_armature[model.jnt_dofadr[j] : model.jnt_dofadr[j] + 6] = 0
    if ours["base"] == "floating" and not columns:
        return
    for joint in ours["joints"]:
        name = joint["name"]
        if name in joints:
            j = joints[name]
            data.qpos[model.jnt_qposadr[j]] = home[name]
            columns.append(np.eye(model.nv)[model.jnt_dofadr[j]])
            continue
        # Yaw, pitch and roll of a ball: angular velocity in the axes of the body.
        ball, part = name.rsplit("/", 1)
        j = joints[ball]
        yaw, pitch, roll = (home[f"{ball}/{k}"] for k in ("yaw", "pitch", "roll"))
        turns = [rotation([0, 0, 1], yaw), rotation([0, 1, 0], pitch), rotation([1, 0, 0], roll)]
        whole = product(product(turns[0], turns[1]), turns[2])
        data.qpos[model.jnt_qposadr[j] : model.jnt_qposadr[j] + 4] = whole
        before = {"yaw": whole, "pitch": product(turns[1], turns[2]), "roll": turns[2]}[part]
        axis = {"yaw": [0, 0, 1], "pitch": [0, 1, 0], "roll": [1, 0, 0]}[part]
        back, local = np.array([before[0], *-before[1:]]), np.zeros(3)
        mujoco.mju_rotVecQuat(local, np.asarray(axis, float), back)
        column = np.zeros(model.nv)
        column[model.jnt_dofadr[j] : model.jnt_dofadr[j] + 3] = local
        columns.append(column)
    mujoco.mj_forward(model, data)
    full = full_matrix(model, data)
    if columns:
        t = np.array(columns)
        note("matrix", np.array(ours["mass_matrix"]), t @ full @ t.T, "the robot")


def full_matrix(model, data):
    full = np.zeros((model.nv, model.nv))
    try:
        mujoco.mj_fullM(model, full, data.qM)
    except (TypeError, AttributeError):
        mujoco.mj_fullM(model, data, full)
    return full


def gains(model, ours, joints, note):
    """Gains of position servos at their joints."""
    for joint in ours["joints"]:
        j = joints.get(joint["name"])
        if j is None or joint["drive"]["mode"] != "position" or not joint["drive"]["configured"]:
            continue
        on_joint = (model.actuator_trntype == mujoco.mjtTrn.mjTRN_JOINT) & (model.actuator_trnid[:, 0] == j)
        kp = sum(-model.actuator_biasprm[on_joint, 1] * model.actuator_gear[on_joint, 0] ** 2)
        kd = sum(-model.actuator_biasprm[on_joint, 2] * model.actuator_gear[on_joint, 0] ** 2)
        note("gains", [joint["drive"]["kp"], joint["drive"]["kd"]], [kp, kd], joint["name"])


if __name__ == "__main__":
    sys.exit(main())

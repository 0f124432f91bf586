#!/usr/bin/env python3
"""Checks the files of `runner convert` by MuJoCo, Pinocchio and Drake.

    python tests/oracles/check_convert.py target/release/runner

Each robot is converted to MJCF and URDF. At random postures the mass matrix of the MJCF file by
MuJoCo is that of the original file: by Pinocchio for URDFs, by Drake for SDFs. So is that of the
converted URDF by Pinocchio. Masses agree too.
"""

import subprocess
import sys
import tempfile
from pathlib import Path

import mujoco
import numpy as np
import pinocchio as pin

HERE = Path(__file__).resolve().parent
REPOSITORY = HERE.parent.parent
URDFS = ["hoap2/hoap2", "cbi/cbi", "quadruped/quadruped", "door/door", "pendulum/pendulum"]
SDFS = ["frames", "old_axis", "oldest_axis", "fixed_base"]
POSTURES = 5
# MuJoCo diagonalizes inertias iteratively.
BOUND = 1e-9


def main():
    runner = Path(sys.argv[1]).resolve()
    random = np.random.default_rng(11)
    with tempfile.TemporaryDirectory() as folder:
        for name in URDFS:
            original = REPOSITORY / "robots" / f"{name}.urdf"
            mjcf, urdf = converted(runner, original, Path(folder))
            check(name, pinocchio_model(original), mujoco_model(mjcf), random)
            check(f"{name} (URDF)", pinocchio_model(original), pinocchio_model(urdf), random)
        for name in SDFS:
            original = REPOSITORY / "tests/robot/sdf" / f"{name}.sdf"
            mjcf, urdf = converted(runner, original, Path(folder))
            check(name, drake_model(original), mujoco_model(mjcf), random)
            check(f"{name} (URDF)", mujoco_model(mjcf), pinocchio_model(urdf), random)


def converted(runner, robot, folder):
    files = [folder / f"{robot.stem}.xml", folder / f"{robot.stem}.urdf"]
    for file in files:
        subprocess.run([runner, "convert", robot, "-o", file], check=True, capture_output=True)
    return files


def check(name, truth, ours, random):
    """Both are (joint names, total mass, whether the base is free, mass matrix by posture)."""
    names, mass, is_free, matrix = truth
    ours_names, ours_mass, ours_free, ours_matrix = ours
    assert set(names) == set(ours_names), (name, names, ours_names)
    assert is_free == ours_free, name
    assert abs(mass - ours_mass) <= BOUND * mass, (name, mass, ours_mass)
    order = list(range(6 * is_free)) + [6 * is_free + ours_names.index(n) for n in names]
    worst = 0.0
    for _ in range(POSTURES):
        q = dict(zip(names, random.uniform(-1, 1, len(names))))
        quaternion = random.normal(size=4)
        quaternion /= np.linalg.norm(quaternion)
        a = matrix(q, quaternion)
        b = ours_matrix(q, quaternion)[np.ix_(order, order)]
        worst = max(worst, np.abs(a - b).max() / np.abs(a).max())
    print(f"{name}: {len(names)} joints, {mass:.6g} kg, mass matrices differ by {worst:.1e}")
    assert worst <= BOUND, name


def mujoco_model(path):
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    kinds = model.jnt_type
    is_free = bool(len(kinds) and kinds[0] == mujoco.mjtJoint.mjJNT_FREE)
    names = [model.joint(i).name for i in range(int(is_free), model.njnt)]

    def matrix(q, quaternion):
        data.qpos[:] = 0
        if is_free:
            data.qpos[3:7] = quaternion
        for name, value in q.items():
            data.qpos[model.joint(name).qposadr[0]] = value
        mujoco.mj_forward(model, data)
        full = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, data, full)
        return full

    # The fixed root counts in no engine's total.
    mass = model.body_mass[2 - is_free :].sum()
    return names, mass, is_free, matrix


def rotation(quaternion):
    w, x, y, z = quaternion
    return pin.Quaternion(w, x, y, z).toRotationMatrix()


def pinocchio_model(path):
    tree = path.read_text()
    is_free = '<link name="world"' not in tree
    model = pin.buildModelFromUrdf(str(path), pin.JointModelFreeFlyer()) if is_free else pin.buildModelFromUrdf(str(path))
    data = model.createData()
    names = list(model.names)[1 + is_free :]
    rows = [model.joints[model.getJointId(n)].idx_v for n in names]

    def matrix(q, quaternion):
        full = pin.neutral(model)
        if is_free:
            full[3:7] = np.roll(quaternion, -1)
        for name, value in q.items():
            joint = model.joints[model.getJointId(name)]
            at = joint.idx_q
            full[at : at + joint.nq] = [value] if joint.nq == 1 else [np.cos(value), np.sin(value)]
        pin.crba(model, data, full)
        m = np.triu(data.M) + np.triu(data.M, 1).T
        m = m[np.ix_([*range(6 * is_free), *rows], [*range(6 * is_free), *rows])]
        if not is_free:
            return m
        # MuJoCo's linear velocity of a free body is in world axes, its angular one in the body's.
        t = np.eye(len(m))
        t[:3, :3] = rotation(quaternion).T
        return t.T @ m @ t

    mass = sum(i.mass for i in model.inertias) - (0 if is_free else model.inertias[0].mass)
    return names, mass, is_free, matrix


def drake_model(path):
    from make_sdf import PARTS, nested_models, scoped
    from pydrake.common.eigen_geometry import Quaternion
    from pydrake.math import RigidTransform, RotationMatrix
    from pydrake.multibody.parsing import Parser
    from pydrake.multibody.plant import MultibodyPlant

    plant = MultibodyPlant(time_step=1e-3)
    model, *_ = Parser(plant).AddModels(str(path))
    plant.Finalize()
    context = plant.CreateDefaultContext()
    floating = [plant.get_body(i) for i in plant.GetFloatingBaseBodies()]
    moving = [j for j in map(plant.get_joint, plant.GetJointIndices()) if j.num_velocities() in (1, 2)]
    parts = [PARTS.get(j.name(), [scoped(plant, model, j)]) for j in moving]
    names = [name for part in parts for name in part]
    columns = [j.velocity_start() + k for j in moving for k in range(j.num_velocities())]

    def matrix(q, quaternion):
        positions = plant.GetPositions(context)
        for joint, part in zip(moving, parts):
            positions[joint.position_start() : joint.position_start() + len(part)] = [q[n] for n in part]
        plant.SetPositions(context, positions)
        order = columns
        if floating:
            (base,) = floating
            plant.SetFreeBodyPose(context, base, RigidTransform(RotationMatrix(Quaternion(quaternion)), np.zeros(3)))
            start = base.floating_velocities_start_in_v()
            order = [start + k for k in (3, 4, 5, 0, 1, 2)] + columns
        m = plant.CalcMassMatrix(context)[np.ix_(order, order)]
        if not floating:
            return m
        t = np.eye(len(m))
        t[3:6, 3:6] = rotation(quaternion)
        return t.T @ m @ t

    bodies = [b for m in [model, *nested_models(plant, model)] for b in plant.GetBodyIndices(m)]
    anchored = [b for b in bodies if not floating and plant.IsAnchored(plant.get_body(b))]
    mass = sum(plant.get_body(b).default_mass() for b in bodies if b not in anchored)
    return names, mass, bool(floating), matrix


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""Writes mjcf_<model>.json: MuJoCo's values of the models in tests/robot/mjcf, in this project's conventions.

Run by hand, in an environment with `mujoco` (4.0.0) and `numpy`:

    python tests/oracles/make_mjcf.py

Velocities are (p', omega, joint rates), both base vectors in world axes. MuJoCo's free joint has the angular velocity
in body axes; a ball joint too, here it is the chain of yaw, pitch and roll. With v_mujoco = T^T v:
M = T M_mujoco T^T, and without ball joints, where the derivative of T vanishes in both, h = T h_mujoco.
Links are the bodies with joints and those welded to them.
"""

import json
from pathlib import Path

import mujoco
import numpy as np
from check_mjcf_models import full_matrix, product, rotation, union

HERE = Path(__file__).resolve().parent
MODELS = HERE.parent / "robot/mjcf"
CONFIGURATIONS = 3
GRAVITY = np.array([0.4, -0.3, -9.7])
# Model: names of bodies directly under the world that are not part of the robot.
LEFT_OUT = {"arm": [], "biped": ["ball", "table"], "shapes": [], "replicate": [], "attach": []}


def main():
    for name, left_out in LEFT_OUT.items():
        oracle = make(name, left_out)
        path = HERE / f"mjcf_{name}.json"
        fields = ",\n".join(f"{json.dumps(k)}:{json.dumps(x, separators=(',', ':'))}" for k, x in oracle.items())
        path.write_text("{\n" + fields + "\n}\n")
        print(f"{path.name}: {path.stat().st_size} bytes")


def name_of(model, kind, i, plain):
    return mujoco.mj_id2name(model, kind, i) or f"{plain}{i}"


def top(model, body):
    while model.body_parentid[body]:
        body = model.body_parentid[body]
    return body


def make(name, left_out):
    model = mujoco.MjModel.from_xml_path(str(MODELS / f"{name}.xml"))
    model.opt.gravity[:] = GRAVITY
    random = np.random.default_rng(sum(name.encode()))
    body_name = lambda i: name_of(model, mujoco.mjtObj.mjOBJ_BODY, i, "body")
    robot = [i for i in range(1, model.nbody) if body_name(top(model, i)) not in left_out]
    joints = [j for j in range(model.njnt) if model.jnt_bodyid[j] in robot]
    free = [j for j in joints if model.jnt_type[j] == mujoco.mjtJoint.mjJNT_FREE]
    joints = [j for j in joints if j not in free]

    data = mujoco.MjData(model)
    data.qpos[:] = model.qpos0
    mujoco.mj_forward(model, data)
    # Bodies without joints belong to the nearest one with joints, or to the root.
    carrier = {}
    for i in robot:
        parent = model.body_parentid[i]
        carrier[i] = i if model.body_jntnum[i] or parent not in carrier else carrier[parent]
    links = []
    for i in robot:
        if carrier[i] == i and (free or model.body_jntnum[i]):
            mass, com, tensor = union(model, data, [j for j in robot if carrier[j] == i])
            links.append({"name": body_name(i), "mass": mass, "com": list(com), "inertia": tensor.tolist()})
    couplings = [k for k in range(model.neq) if int(model.eq_type[k]) == int(mujoco.mjtEq.mjEQ_JOINT)]
    return {
        "model": name,
        "versions": {"mujoco": mujoco.__version__, "numpy": np.__version__},
        "floating": bool(free),
        "gravity": list(GRAVITY),
        "links": links,
        "joints": [joint(model, j) for j in joints],
        "loops": [loop(model, k) for k in range(model.neq) if is_loop(model, k)],
        "couplings": [coupling(model, k) for k in couplings],
        "configurations": [values(model, free, joints, random) for _ in range(CONFIGURATIONS)],
    }


def joint(model, j):
    kind = int(model.jnt_type[j])
    limited = bool(model.jnt_limited[j])
    on_joint = (model.actuator_trntype == mujoco.mjtTrn.mjTRN_JOINT) & (model.actuator_trnid[:, 0] == j)
    on_joint &= model.actuator_biastype == mujoco.mjtBias.mjBIAS_AFFINE
    gear = model.actuator_gear[on_joint, 0]
    return {
        "name": name_of(model, mujoco.mjtObj.mjOBJ_JOINT, j, "joint"),
        "kind": ["free", "ball", "slide", "hinge"][kind],
        "axis": list(model.jnt_axis[j]),
        "anchor": list(model.jnt_pos[j]),
        "range": list(model.jnt_range[j]) if limited and kind != 1 else None,
        "armature": model.dof_armature[model.jnt_dofadr[j]],
        "damping": model.dof_damping[model.jnt_dofadr[j]],
        "friction": model.dof_frictionloss[model.jnt_dofadr[j]],
        "kp": float(sum(-model.actuator_biasprm[on_joint, 1] * gear**2)),
        "kd": float(sum(-model.actuator_biasprm[on_joint, 2] * gear**2)),
    }


def is_loop(model, k):
    kinds = [int(mujoco.mjtEq.mjEQ_CONNECT), int(mujoco.mjtEq.mjEQ_WELD)]
    return bool(model.eq_active0[k]) and int(model.eq_type[k]) in kinds


def loop(model, k):
    """Points of both bodies that coincide, in their frames; for a weld, the second's orientation in the first."""
    weld = int(model.eq_type[k]) == int(mujoco.mjtEq.mjEQ_WELD)
    data = model.eq_data[k]
    ends = []
    points = (data[3:6], data[:3]) if weld else (data[:3], data[3:6])
    for which, of_body in zip((model.eq_obj1id[k], model.eq_obj2id[k]), points):
        if int(model.eq_objtype[k]) == int(mujoco.mjtObj.mjOBJ_SITE):
            ends.append((model.site_bodyid[which], model.site_pos[which]))
        else:
            ends.append((which, of_body))
    names = [name_of(model, mujoco.mjtObj.mjOBJ_BODY, i, "body") for i, _ in ends]
    by_site = int(model.eq_objtype[k]) == int(mujoco.mjtObj.mjOBJ_SITE)
    return {
        "name": mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_EQUALITY, k),
        "weld": bool(weld),
        "bodies": names,
        "points": [list(point) for _, point in ends],
        "quaternion": list(data[6:10]) if weld and not by_site else None,
    }


def coupling(model, k):
    """Values of the follower at three positions of the leader, by MuJoCo's polynomial about the references."""
    j1, j2 = model.eq_obj1id[k], model.eq_obj2id[k]
    y0, x0 = (model.qpos0[model.jnt_qposadr[j]] for j in (j1, j2))
    at = [-0.7, 0.2, 1.1]
    values = [y0 + sum(a * (x - x0) ** i for i, a in enumerate(model.eq_data[k][:5])) for x in at]
    names = [name_of(model, mujoco.mjtObj.mjOBJ_JOINT, j, "joint") for j in (j1, j2)]
    return {"joint": names[0], "leader": names[1], "at": at, "values": values}


def values(model, free, joints, random):
    """Mass matrix and bias at one state. A ball joint has three positions and rates."""
    data = mujoco.MjData(model)
    data.qpos[:] = model.qpos0
    rows, names, positions = [], [], []
    unit = np.eye(model.nv)
    base = random.uniform(-1, 1, 3)
    turn = random.uniform(-1, 1, 4)
    turn /= np.linalg.norm(turn)
    has_ball = False
    if not free:
        # The root is the body under the world, or the world itself if that body has joints.
        body = top(model, model.jnt_bodyid[joints[0]])
        body = 0 if model.body_jntnum[body] else body
        base, turn = model.body_pos[body], model.body_quat[body]
    for j in free:
        at, dof = model.jnt_qposadr[j], model.jnt_dofadr[j]
        data.qpos[at : at + 3], data.qpos[at + 3 : at + 7] = base, turn
        matrix = np.zeros(9)
        mujoco.mju_quat2Mat(matrix, turn)
        rows += [unit[dof + k] for k in range(3)]
        # Angular velocity in body axes is R^T omega.
        rows += [sum(matrix.reshape(3, 3)[k, c] * unit[dof + 3 + c] for c in range(3)) for k in range(3)]
    for j in joints:
        at, dof = model.jnt_qposadr[j], model.jnt_dofadr[j]
        name = name_of(model, mujoco.mjtObj.mjOBJ_JOINT, j, "joint")
        if model.jnt_type[j] != mujoco.mjtJoint.mjJNT_BALL:
            q = random.uniform(-1, 1)
            data.qpos[at] = q
            names.append(name)
            positions.append(q)
            rows.append(unit[dof])
            continue
        has_ball = True
        axes = {"yaw": [0, 0, 1], "pitch": [0, 1, 0], "roll": [1, 0, 0]}
        angles = random.uniform(-1, 1, 3)
        turns = [rotation(axis, angle) for axis, angle in zip(axes.values(), angles)]
        data.qpos[at : at + 4] = product(product(turns[0], turns[1]), turns[2])
        # Each rate turns the body about its axis, seen through the turns after it.
        after = [product(turns[1], turns[2]), turns[2], np.array([1.0, 0, 0, 0])]
        for (part, axis), angle, quaternion in zip(axes.items(), angles, after):
            local = np.zeros(3)
            mujoco.mju_rotVecQuat(local, np.asarray(axis, float), quaternion * [1, -1, -1, -1])
            names.append(f"{name}/{part}")
            positions.append(angle)
            rows.append(sum(local[c] * unit[dof + c] for c in range(3)))
    t = np.array(rows)
    v = random.uniform(-2, 2, len(rows))
    data.qvel[:] = t.T @ v
    mujoco.mj_forward(model, data)
    return {
        "position": list(base),
        "quaternion": list(turn),
        "joints": names,
        "q": [float(q) for q in positions],
        "v": list(v),
        "mass": (t @ full_matrix(model, data) @ t.T).tolist(),
        "bias": None if has_ball else list(t @ data.qfrc_bias),
    }


if __name__ == "__main__":
    main()

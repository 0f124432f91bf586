#!/usr/bin/env python3
"""Writes loops_hoap2.json: accelerations and loop forces of HOAP-2 with closed loops, by Pinocchio's constraint dynamics.

Run by hand, in an environment with `pin` 4.1:

    python tests/oracles/make_loops.py

Loops hold at the configuration: the second frame is placed where the first one is, and the velocities are projected onto
`J v = 0`, so that all definitions of a constraint's error agree in their second derivatives. Conventions of velocities and
forces: make_dynamics.py. Forces are those on the first link at its frame, in world axes.
"""

import json

import numpy as np
import pinocchio as pin
from make_dynamics import GRAVITY, HERE, ROBOTS, configuration, exact

# type, first joint, second joint (None: the world)
CASES = [
    [("ball", "left_knee", "right_knee")],
    [("weld", "left_hand", "right_elbow")],
    [("ball", "left_hand", "right_hand"), ("ball", "head_tilt", None)],
    [("weld", "right_hand", None), ("ball", "left_knee", "left_hand")],
]


def make_case(model, loops, random):
    nv = model.nv
    position, rotation = random.uniform(-1, 1, 3), pin.exp3(random.uniform(-2, 2, 3))
    angles = random.uniform(-1, 1, nv - 6)
    q = configuration(model, True, angles, position, rotation)
    e = np.eye(nv)
    e[:3, :3] = e[3:6, 3:6] = rotation
    data = model.createData()
    pin.forwardKinematics(model, data, q)
    constraints, placed = pin.StdVec_RigidConstraintModel(), []
    for kind, first, second in loops:
        one = model.getJointId(first)
        two = 0 if second is None else model.getJointId(second)
        on_first = pin.SE3(pin.exp3(random.uniform(-1, 1, 3)), random.uniform(-0.1, 0.1, 3))
        on_second = data.oMi[two].inverse() * data.oMi[one] * on_first
        shape = pin.ContactType.CONTACT_6D if kind == "weld" else pin.ContactType.CONTACT_3D
        constraints.append(pin.RigidConstraintModel(shape, model, one, on_first, two, on_second, pin.LOCAL))
        placed.append((on_first, on_second))
    datas = pin.StdVec_RigidConstraintData()
    datas.extend(c.createData() for c in constraints)
    sizes = [6 if kind == "weld" else 3 for kind, _, _ in loops]
    jacobian = np.vstack([relative_jacobian(model, q, c)[:size] for c, size in zip(constraints, sizes)])
    v = random.uniform(-2, 2, nv)
    v -= np.linalg.pinv(jacobian) @ (jacobian @ v)
    tau = random.uniform(-20, 20, nv)
    pin.initConstraintDynamics(model, data, constraints, datas)
    settings = pin.ProximalSettings(1e-14, 0.0, 20)
    a = pin.constraintDynamics(model, data, q, v, tau, constraints, datas, settings)
    # The forces are those on the first link, in its frame's axes: J is its motion relative to the second link.
    forces = data.lambda_c
    mass = pin.crba(model, model.createData(), q)
    mass = np.triu(mass) + np.triu(mass, 1).T
    residual = mass @ a + pin.nonLinearEffects(model, model.createData(), q, v) - tau - jacobian.T @ forces
    print(f"equation of motion: {np.abs(residual).max():.1e}, condition of J: {np.linalg.cond(jacobian):.1f}")
    assert np.abs(residual).max() < 1e-10
    transport = np.zeros(nv)
    transport[:3] = np.cross(v[3:6], v[:3])
    out, row = [], 0
    for (kind, first, second), c, (on_first, on_second), size in zip(loops, constraints, placed, sizes):
        world = (data.oMi[c.joint1_id] * on_first).rotation
        force, moment = forces[row : row + 3], forces[row + 3 : row + size] if size == 6 else np.zeros(3)
        out.append(
            {
                "type": kind,
                "link": first,
                "to": second,
                "rotation": exact(on_first.rotation),
                "position": exact(on_first.translation),
                "to_rotation": exact(on_second.rotation),
                "to_position": exact(on_second.translation),
                "force": exact(world @ force),
                "moment": exact(world @ moment),
            }
        )
        row += size
    return {
        "position": exact(position),
        "rotation": exact(rotation),
        "joints": exact(angles),
        "v": exact(e @ v),
        "tau": exact(e @ tau),
        "acceleration": exact(e @ (a + transport)),
        "loops": out,
    }


def data_at(model, q):
    data = model.createData()
    pin.computeJointJacobians(model, data, q)
    pin.forwardKinematics(model, data, q)
    return data


def relative_jacobian(model, q, c):
    """Motion of the first link's frame relative to the second link, in the first frame's axes."""
    data = data_at(model, q)

    def at(joint, placement):
        if joint == 0:
            return np.zeros((6, model.nv))
        return pin.getFrameJacobian(model, data, joint, placement, pin.LOCAL)

    frame = data.oMi[c.joint1_id] * c.joint1_placement
    second = data.oMi[c.joint2_id].inverse() * frame
    return at(c.joint1_id, c.joint1_placement) - at(c.joint2_id, second)


def main():
    urdf, floating, _ = ROBOTS["hoap2"]
    model = pin.buildModelFromUrdf(str(urdf), pin.JointModelFreeFlyer())
    model.gravity.linear = GRAVITY
    random = np.random.default_rng(27)
    armature = random.uniform(0, 0.1, model.nv - 6)
    model.armature = np.concatenate([np.zeros(6), armature])
    oracle = {
        "robot": "hoap2",
        "versions": {"pin": pin.__version__, "numpy": np.__version__},
        "gravity": exact(GRAVITY),
        "names": list(model.names)[2:],
        "armature": exact(armature),
        "cases": [make_case(model, loops, random) for loops in CASES],
    }
    path = HERE / "loops_hoap2.json"
    fields = ",\n".join(f"{json.dumps(k)}:{json.dumps(x, separators=(',', ':'))}" for k, x in oracle.items())
    path.write_text("{\n" + fields + "\n}\n")
    print(f"{path.name}: {path.stat().st_size} bytes")


if __name__ == "__main__":
    main()

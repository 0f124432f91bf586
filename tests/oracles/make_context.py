#!/usr/bin/env python3
"""Writes context_hoap2.json: the context of tasks, computed by Pinocchio on HOAP-2.

Run by hand in an environment with `pin`:

    python tests/oracles/make_context.py

Conventions of velocities and forces as in make_dynamics.py. Jacobians by rows, world axes unless named `base`.

The zero-moment point follows from its definition. Random forces act on the vertices of both feet.
About the zero-moment point of the plane, the sum of their moments, each with its own arm, has no
component along the plane.
"""

import json
import sys

import numpy as np
import pinocchio as pin

from make_dynamics import HERE, REPOSITORY, configuration, exact

GRAVITY = np.array([0.4, -0.3, -9.7])
CONFIGURATIONS = 4
# Name, link, position and roll, pitch, yaw in the link's frame: feet, hands and a tool.
FRAMES = [
    ("left_sole", "l_foot", [0.0112, 0.0, -0.0405], [0.0, 0.0, 0.0]),
    ("right_sole", "r_foot", [0.0112, 0.0, -0.0405], [0.0, 0.0, 0.0]),
    ("left_hand", "l_hand", [0.01, -0.02, 0.03], [0.3, -0.4, 1.2]),
    ("right_hand", "r_hand", [0.02, 0.01, -0.05], [-1.0, 0.2, 0.5]),
    ("eyes", "head", [0.05, 0.0, 0.02], [0.0, 1.1, -0.7]),
]
SOLE = [[0.0582, 0.031, -0.0405], [-0.0358, 0.031, -0.0405], [-0.0358, -0.031, -0.0405], [0.0582, -0.031, -0.0405]]


def zmp(points, forces, floor, origin):
    """The point of the plane about which the forces have no moment along the plane."""
    def moment_along(at):
        moment = sum(np.cross(p - at, f) for p, f in zip(points, forces))
        return (floor.T @ moment)[:2]

    # The moment is affine in the point: three evaluations give it exactly.
    zero = moment_along(origin)
    slope = np.column_stack([moment_along(origin + floor[:, k]) - zero for k in range(2)])
    x = np.linalg.solve(slope, -zero)
    at = origin + floor[:, :2] @ x
    assert np.abs(moment_along(at)).max() < 1e-12 * sum(np.linalg.norm(f) for f in forces)
    return at


def values(model, random):
    nv = model.nv
    position = random.uniform(-2, 2, 3)
    rotation = pin.exp3(random.uniform(-2, 2, 3))
    angles, v = random.uniform(-1.5, 1.5, nv - 6), random.uniform(-2, 2, nv)
    floor = pin.exp3(random.uniform(-0.5, 0.5, 3))
    origin = random.uniform(-0.3, 0.3, 3)
    e = np.eye(nv)
    e[:3, :3] = e[3:6, 3:6] = rotation
    q = configuration(model, True, angles, position, rotation)
    data = model.createData()

    com_jacobian = pin.jacobianCenterOfMass(model, data, q).copy() @ e.T
    com = data.com[0].copy()
    com_velocity = com_jacobian @ v
    # In the base's axes: Pinocchio's own Jacobian with the base at the origin, upright; its joint columns.
    upright = pin.neutral(model)
    upright[7:] = q[7:]
    com_jacobian_base = pin.jacobianCenterOfMass(model, data, upright)[:, 6:].copy()
    gravity = e @ pin.computeGeneralizedGravity(model, data, q)
    v_pin = e.T @ v
    transport = np.zeros(nv)
    transport[:3] = np.cross(v_pin[3:6], v_pin[:3])
    bias = e @ pin.rnea(model, data, q, v_pin, -transport)

    pin.computeJointJacobians(model, data, q)
    pin.updateFramePlacements(model, data)
    frames = []
    for name, *_ in FRAMES:
        i = model.getFrameId(name, pin.FrameType.OP_FRAME)
        jacobian = pin.getFrameJacobian(model, data, i, pin.LOCAL_WORLD_ALIGNED) @ e.T
        frames.append({
            "position": exact(data.oMf[i].translation),
            "rotation": exact(data.oMf[i].rotation),
            "jacobian": exact(jacobian),
            "twist": exact(jacobian @ v),
        })

    points, forces, vertices = [], [], []
    for link in ("l_foot", "r_foot"):
        i = model.getFrameId(link, pin.FrameType.BODY)
        twisted = pin.getFrameJacobian(model, data, i, pin.LOCAL_WORLD_ALIGNED) @ e.T
        for corner in SOLE:
            arm = data.oMf[i].rotation @ np.array(corner)
            points.append(data.oMf[i].translation + arm)
            vertices.append(exact(twisted[:3] - pin.skew(arm) @ twisted[3:]))
            forces.append(floor @ np.append(random.uniform(-2, 2, 2), random.uniform(0, 20)))
    return {
        "position": exact(position),
        "rotation": exact(rotation),
        "joints": exact(angles),
        "v": exact(v),
        "floor": exact(floor),
        "origin": exact(origin),
        "com": exact(com),
        "com_velocity": exact(com_velocity),
        "com_jacobian": exact(com_jacobian),
        "com_jacobian_base": exact(com_jacobian_base),
        "gravity_effort": exact(gravity),
        "bias": exact(bias),
        "frames": frames,
        "vertices": exact(points),
        "vertex_jacobians": vertices,
        "vertex_forces": exact(forces),
        "zmp": exact(zmp(points, forces, floor, origin)),
    }


def main():
    model = pin.buildModelFromUrdf(str(REPOSITORY / "robots/hoap2/hoap2.urdf"), pin.JointModelFreeFlyer())
    model.gravity.linear = GRAVITY
    for name, link, position, rpy in FRAMES:
        body = model.frames[model.getFrameId(link, pin.FrameType.BODY)]
        placement = body.placement * pin.SE3(pin.rpy.rpyToMatrix(np.array(rpy)), np.array(position))
        model.addFrame(pin.Frame(name, body.parentJoint, model.getFrameId(link, pin.FrameType.BODY), placement, pin.FrameType.OP_FRAME))
    random = np.random.default_rng(2026)
    oracle = {
        "versions": {"pin": pin.__version__, "numpy": np.__version__},
        "gravity": exact(GRAVITY),
        "names": list(model.names)[2:],
        "end_effectors": [
            {"name": n, "link": link, "position": exact(p), "rpy": exact(rpy)} for n, link, p, rpy in FRAMES
        ],
        "configurations": [values(model, random) for _ in range(CONFIGURATIONS)],
    }
    path = HERE / "context_hoap2.json"
    path.write_text("{\n" + ",\n".join(f"{json.dumps(k)}:{json.dumps(x, separators=(',', ':'))}" for k, x in oracle.items()) + "\n}\n")
    print(f"{path.name}: {path.stat().st_size} bytes")


if __name__ == "__main__":
    sys.exit(main())

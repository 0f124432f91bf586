#!/usr/bin/env python3
"""Writes dynamics_<robot>.json: rigid-body quantities computed by Pinocchio, in this project's conventions.

Run by hand, in an environment with `pin` and `example-robot-data` (6.0 or newer, wheels that contain the URDF files):

    python tests/oracles/make_dynamics.py

The repository does not contain the example robots' URDF files; the JSON records their trees as
Pinocchio reads them. For robots of this repository the JSON has only the values, and the test loads
the URDF itself.

Conventions of the output. Velocities v = (p', omega, joint rates) with p the base origin, both base vectors in world
axes; vdot = (p'', omega', joint accelerations); generalised forces dual to v. Pinocchio's floating-base velocity is the
twist in base axes, and its acceleration the component-wise rate of that, so with R the base orientation and
E = diag(R, R, 1):  v = E v_pin,  vdot = E (a_pin + (omega x v_lin, 0, 0)),  tau = E tau_pin,  M = E M_pin E^T.
"""

import importlib.metadata
import json
import sys
from pathlib import Path

import numpy as np
import pinocchio as pin

HERE = Path(__file__).resolve().parent
REPOSITORY = HERE.parent.parent
EXAMPLES = Path(pin.__file__).resolve().parents[4] / "share/example-robot-data/robots"
CONFIGURATIONS = 3
GRAVITY = np.array([0.4, -0.3, -9.7])

# name: (URDF, floating base, recorded tree)
ROBOTS = {
    "talos": (EXAMPLES / "talos_data/robots/talos_reduced.urdf", True, True),
    "solo12": (EXAMPLES / "solo_description/robots/solo12.urdf", True, True),
    "tiago": (EXAMPLES / "tiago_description/robots/tiago_no_hand.urdf", False, True),
    "panda": (EXAMPLES / "panda_description/urdf/panda.urdf", False, True),
    "hoap2": (REPOSITORY / "robots/hoap2/hoap2.urdf", True, False),
}


def exact(x):
    """Nested lists of floats; whole numbers as integers, which are shorter and read back the same."""
    if isinstance(x, (list, tuple, np.ndarray)):
        return [exact(y) for y in x]
    x = float(x)
    return int(x) if x == int(x) and abs(x) < 1e9 else x


def motion_axis(model, joint):
    """Kind and axis (in the joint's frame) of a one-velocity joint."""
    data = model.createData()
    pin.computeAllTerms(model, data, pin.neutral(model), np.zeros(model.nv))
    s = np.asarray(data.joints[joint].S).ravel()
    assert s.shape == (6,), "only joints with one velocity"
    if np.linalg.norm(s[:3]) > 0.5:
        return "prismatic", s[:3]
    return ("continuous" if model.joints[joint].nq == 2 else "revolute"), s[3:]


def frozen_tree(model, first):
    """Root inertia (a floating base's first joint) and the joints after it, as Pinocchio merged them."""

    def body(i):
        inertia = model.inertias[i]
        return {"mass": exact(inertia.mass), "com": exact(inertia.lever), "inertia": exact(inertia.inertia)}

    tree = [{"name": model.names[first - 1], **body(first - 1)}]
    for i in range(first, model.njoints):
        kind, axis = motion_axis(model, i)
        placement = model.jointPlacements[i]
        tree.append(
            {
                "name": model.names[i],
                "parent": model.parents[i] - (first - 1),
                "rotation": exact(placement.rotation),
                "offset": exact(placement.translation),
                "kind": kind,
                "axis": exact(axis),
                **body(i),
            }
        )
    return tree


def configuration(model, floating, angles, position, rotation):
    """Pinocchio's q from one number per joint."""
    q = pin.neutral(model)
    if floating:
        q[:3] = position
        q[3:7] = pin.Quaternion(rotation).coeffs()
    first = 2 if floating else 1
    for angle, joint in zip(angles, list(model.joints)[first:]):
        if joint.nq == 2:
            q[joint.idx_q : joint.idx_q + 2] = np.cos(angle), np.sin(angle)
        else:
            q[joint.idx_q] = angle
    return q


def values(model, floating, soles, random):
    """Inputs and true values of one configuration."""
    nv = model.nv
    nb = 6 if floating else 0
    first = 2 if floating else 1
    position = random.uniform(-2, 2, 3) if floating else np.zeros(3)
    rotation = pin.exp3(random.uniform(-2, 2, 3)) if floating else np.eye(3)
    angles = random.uniform(-1.5, 1.5, nv - nb)
    v, vdot, tau = random.uniform(-2, 2, nv), random.uniform(-5, 5, nv), random.uniform(-20, 20, nv)
    floor = pin.exp3(random.uniform(-1, 1, 3))

    e = np.eye(nv)
    if floating:
        e[:3, :3] = e[3:6, 3:6] = rotation
    q = configuration(model, floating, angles, position, rotation)
    v_pin = e.T @ v
    # p'' = R (a_lin + omega x v_lin) in base axes.
    transport = np.zeros(nv)
    if floating:
        transport[:3] = np.cross(v_pin[3:6], v_pin[:3])

    def to_pin(a):
        return e.T @ a - transport

    def from_pin(a):
        return e @ (a + transport)

    data = model.createData()
    mass_pin = pin.crba(model, data, q)
    mass_pin = np.triu(mass_pin) + np.triu(mass_pin, 1).T
    mass = e @ mass_pin @ e.T
    bias = e @ pin.rnea(model, data, q, v_pin, to_pin(np.zeros(nv)))
    inverse = e @ pin.rnea(model, data, q, v_pin, to_pin(vdot))
    forward = from_pin(pin.aba(model, data, q, v_pin, e.T @ tau))

    pin.forwardKinematics(model, data, q, v_pin, to_pin(vdot))
    poses = [data.oMi[i] for i in range(first - 1, model.njoints)]
    com = pin.centerOfMass(model, data, q, v_pin)
    momentum = pin.computeCentroidalMomentum(model, data, q, v_pin)

    twists = [data.v[i].vector for i in range(1, model.njoints)]
    links = sum(0.5 * t @ i.matrix() @ t for t, i in zip(twists, list(model.inertias)[1:]))
    kinetic_energy = links + 0.5 * np.sum(model.armature * v_pin**2)

    # Frames at points of chosen links, all in world axes.
    pin.computeJointJacobians(model, data, q)
    frames = []
    rows, drift, velocity = [], [], []
    for link, point in soles:
        joint = link + first - 1
        local = pin.Frame("sole", joint, pin.SE3(np.eye(3), point), pin.FrameType.OP_FRAME)
        pin.forwardKinematics(model, data, q, v_pin, to_pin(vdot))
        jacobian = pin.getJointJacobian(model, data, joint, pin.LOCAL_WORLD_ALIGNED) if joint else np.zeros((6, nv))
        arm = data.oMi[joint].rotation @ point
        jacobian = np.vstack([jacobian[:3] - pin.skew(arm) @ jacobian[3:], jacobian[3:]]) @ e.T
        placement = local.placement

        def acceleration():
            return pin.getFrameClassicalAcceleration(
                model, data, joint, placement, pin.LOCAL_WORLD_ALIGNED
            ).vector

        a = acceleration()
        twist = pin.getFrameVelocity(model, data, joint, placement, pin.LOCAL_WORLD_ALIGNED).vector
        pin.forwardKinematics(model, data, q, v_pin, to_pin(np.zeros(nv)))
        product = acceleration()
        frames.append(
            {
                "point": exact(data.oMi[joint].act(point)),
                "jacobian": exact(jacobian),
                "velocity": exact(twist),
                "acceleration": exact(a),
            }
        )
        turn = np.kron(np.eye(2), floor.T)
        rows.append(turn @ jacobian)
        velocity.append(turn @ twist)
        drift.append(turn @ product)
    j = np.vstack(rows)
    w = j @ np.linalg.solve(mass, j.T)
    a0 = j @ forward + np.concatenate(drift)

    return {
        "position": exact(position),
        "rotation": exact(rotation),
        "joints": exact(angles),
        "v": exact(v),
        "vdot": exact(vdot),
        "tau": exact(tau),
        "floor": exact(floor),
        "mass_lower": exact(mass[np.tril_indices(nv)]),
        "bias": exact(bias),
        "inverse_dynamics": exact(inverse),
        "forward_dynamics": exact(forward),
        "positions": exact([p.translation for p in poses]),
        "rotations": exact([p.rotation for p in poses]),
        "com": exact(com),
        "com_velocity": exact(data.vcom[0]),
        "momentum": exact(momentum.vector),
        # Not computeKineticEnergy: in 4.1 it leaves out the armature of revolute joints with an axis off x, y and z.
        "kinetic_energy": exact(kinetic_energy),
        "potential_energy": exact(pin.computePotentialEnergy(model, data, q)),
        "frames": frames,
        "contact_w_lower": exact(w[np.tril_indices(len(w))]),
        "contact_a0": exact(a0),
        "contact_velocity": exact(np.concatenate(velocity)),
    }


def make(name, urdf, floating, frozen):
    """The whole oracle of one robot."""
    model = pin.buildModelFromUrdf(str(urdf), pin.JointModelFreeFlyer()) if floating else pin.buildModelFromUrdf(str(urdf))
    random = np.random.default_rng(sum(name.encode()))
    first = 2 if floating else 1
    nb = 6 if floating else 0
    model.gravity.linear = GRAVITY
    armature = random.uniform(0, 0.1, model.nv - nb)
    model.armature = np.concatenate([np.zeros(nb), armature])

    # Soles with a single vertex: at the last link, one in the middle of the list and on the root's first child.
    links = model.njoints - first
    soles = [(k, random.uniform(-0.2, 0.2, 3)) for k in (links, links // 2, 1)]
    versions = {"pin": pin.__version__, "numpy": np.__version__}
    if frozen:
        versions["example-robot-data"] = importlib.metadata.version("example-robot-data")
    return {
        "robot": name,
        "urdf": urdf.name,
        "versions": versions,
        "floating": floating,
        "gravity": exact(GRAVITY),
        "names": list(model.names)[first:],
        "armature": exact(armature),
        "total_mass": exact(sum(model.inertias[i].mass for i in range(1, model.njoints))),
        "tree": frozen_tree(model, first) if frozen else None,
        "soles": [{"link": link, "point": exact(point)} for link, point in soles],
        "configurations": [values(model, floating, soles, random) for _ in range(CONFIGURATIONS)],
    }


def main():
    names = sys.argv[1:] or ROBOTS
    for name in names:
        urdf, floating, frozen = ROBOTS[name]
        oracle = make(name, urdf, floating, frozen)
        path = HERE / f"dynamics_{name}.json"
        fields = ",\n".join(f"{json.dumps(k)}:{json.dumps(x, separators=(',', ':'))}" for k, x in oracle.items())
        path.write_text("{\n" + fields + "\n}\n")
        print(f"{path.name}: {path.stat().st_size} bytes, {len(oracle['names'])} joints")


if __name__ == "__main__":
    main()

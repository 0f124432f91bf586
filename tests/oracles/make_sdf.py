#!/usr/bin/env python3
"""Writes sdf.json: mass matrices and link poses of tests/robot/sdf/*.sdf as Drake reads these files.

Run by hand, in an environment with Drake 1.51 or newer:

    python tests/oracles/make_sdf.py

Velocities are those of this project: of a floating base the origin's velocity and the angular
velocity, both in world axes, then one rate per joint in the order of `joints`. Drake has the angular
velocity first.
"""

import json
from pathlib import Path

import numpy as np
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant

HERE = Path(__file__).resolve().parent
FILES = ["frames", "old_axis", "oldest_axis", "fixed_base"]
STATES = 3
# Names of this project for the parts of a joint with two motions.
PARTS = {"gimbal": ["gimbal/axis", "gimbal/axis2"]}


def oracle(name, random):
    plant = MultibodyPlant(time_step=1e-3)
    model, *_ = Parser(plant).AddModels(str(HERE.parent / "robot/sdf" / f"{name}.sdf"))
    plant.Finalize()
    context = plant.CreateDefaultContext()
    floating = [plant.get_body(i) for i in plant.GetFloatingBaseBodies()]
    moving = [plant.get_joint(i) for i in plant.GetJointIndices()]
    moving = [j for j in moving if j.num_velocities() in (1, 2)]
    names = [part for j in moving for part in PARTS.get(j.name(), [scoped(plant, model, j)])]
    columns = [j.velocity_start() + k for j in moving for k in range(j.num_velocities())]
    bodies = [plant.get_body(i) for i in plant.GetBodyIndices(model)]
    nested = [plant.get_body(i) for m in nested_models(plant, model) for i in plant.GetBodyIndices(m)]
    bodies += nested
    states = []
    for _ in range(STATES):
        q = {}
        for joint in moving:
            low, high = joint.position_lower_limits(), joint.position_upper_limits()
            values = random.uniform(np.maximum(low, -1.2), np.minimum(high, 1.2))
            joint_positions = plant.GetPositions(context)
            joint_positions[joint.position_start() : joint.position_start() + len(values)] = values
            plant.SetPositions(context, joint_positions)
            q.update(zip(PARTS.get(joint.name(), [scoped(plant, model, joint)]), values))
        state = {"joints": [q[n] for n in names]}
        order = columns
        if floating:
            (base,) = floating
            pose = RigidTransform(RollPitchYaw(random.uniform(-1, 1, 3)), random.uniform(-1, 1, 3))
            plant.SetFreeBodyPose(context, base, pose)
            start = base.floating_velocities_start_in_v()
            order = [start + k for k in (3, 4, 5, 0, 1, 2)] + columns
            quaternion = pose.rotation().ToQuaternion().wxyz()
            state |= {"position": list(pose.translation()), "quaternion": list(quaternion)}
        mass = plant.CalcMassMatrix(context)[np.ix_(order, order)]
        state["mass"] = mass.tolist()
        state["links"] = {scoped(plant, model, b): list(pose_of(plant, context, b)) for b in bodies}
        states.append(state)
    total = sum(b.default_mass() for b in bodies)
    return {"total_mass": total, "joints": names, "states": states}


def nested_models(plant, model):
    own = plant.GetModelInstanceName(model)
    names = [plant.GetModelInstanceName(m) for m in map(type(model), range(plant.num_model_instances()))]
    return [plant.GetModelInstanceByName(n) for n in names if n.startswith(own + "::")]


def scoped(plant, model, element):
    """The name in the outer model, such as tool::disc."""
    own = plant.GetModelInstanceName(model)
    prefix = plant.GetModelInstanceName(element.model_instance())
    inner = prefix.removeprefix(own).removeprefix("::")
    return f"{inner}::{element.name()}" if inner else element.name()


def pose_of(plant, context, body):
    """Origin, then the rotation matrix by rows."""
    pose = plant.EvalBodyPoseInWorld(context, body)
    return [*pose.translation(), *pose.rotation().matrix().ravel()]


def main():
    random = np.random.default_rng(7)
    robots = {name: oracle(name, random) for name in FILES}
    (HERE / "sdf.json").write_text(json.dumps(robots, indent=1) + "\n")


if __name__ == "__main__":
    main()

"""Times steps of 1 ms of MuJoCo with the robots of standing.toml."""

import math
import time
import xml.etree.ElementTree as xml

import mujoco
import numpy
from mujoco import rollout

STEP = 1e-3  # s
HOLD = 2  # steps between commands
WARM_UP = 1000  # steps
SLICE = 100  # steps of a sample


def urdf_without_shapes(path):
    """The URDF on a floating joint; contact points replace its shapes."""
    robot = xml.parse(path).getroot()
    for link in robot.iter("link"):
        for shape in link.findall("visual") + link.findall("collision"):
            link.remove(shape)
    children = {joint.find("child").get("link") for joint in robot.findall("joint")}
    roots = [link.get("name") for link in robot.findall("link") if link.get("name") not in children]
    floating = [joint for joint in robot.findall("joint") if joint.get("type") == "floating"]
    if not floating:
        xml.SubElement(robot, "link", name="peers_world")
        joint = xml.SubElement(robot, "joint", name="peers_floating", type="floating")
        xml.SubElement(joint, "parent", link="peers_world")
        xml.SubElement(joint, "child", link=roots[0])
    extension = xml.SubElement(robot, "mujoco")
    xml.SubElement(extension, "compiler", fusestatic="true", balanceinertia="true", inertiafromgeom="false")
    return xml.tostring(robot, encoding="unicode")


class Standing:
    """A robot on position servos whose arms swing by 0.05 rad at 1 Hz; its soles touch the floor with their vertices."""

    def __init__(self, robot, path, elliptic):
        spec = mujoco.MjSpec.from_string(urdf_without_shapes(path))
        spec.option.timestep = STEP
        spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
        spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC if elliptic else mujoco.mjtCone.mjCONE_PYRAMIDAL
        spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[0, 0, 1], friction=[0.6, 0, 0])
        for sole in robot["sole"]:
            for vertex in sole["polygon"]:
                # Their centres are at the vertices, so the robot stands higher by their radius.
                spec.body(sole["link"]).add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[1e-3, 0, 0], pos=vertex,
                                                 mass=0, friction=[0.6, 0, 0], contype=0, conaffinity=1)
        joints = [joint for joint in spec.joints if joint.type != mujoco.mjtJoint.mjJNT_FREE]
        self.posture, self.amplitude = [], []
        for joint in joints:
            within = lambda parts: any(part in joint.name for part in parts)
            kp = robot["gain"] * (1.0 if within(robot["legs"]) else 0.3)
            joint.armature, joint.limited = 5e-5 * kp, mujoco.mjtLimited.mjLIMITED_FALSE
            joint.damping, joint.frictionloss = numpy.zeros(3), 0.0
            servo = spec.add_actuator(name=joint.name, target=joint.name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
            servo.gainprm[0], servo.biastype = kp, mujoco.mjtBias.mjBIAS_AFFINE
            servo.biasprm[1], servo.biasprm[2] = -kp, -0.03 * kp
            ends = [value for end, value in robot["posture"].items() if joint.name.endswith(end)]
            self.posture.append(ends[0] if ends else 0.0)
            self.amplitude.append(0.05 if within(robot["arms"]) else 0.0)
        self.model = spec.compile()
        self.data = mujoco.MjData(self.model)
        self.data.qpos[7:] = self.posture
        mujoco.mj_forward(self.model, self.data)
        spheres = self.model.geom_type == mujoco.mjtGeom.mjGEOM_SPHERE
        self.data.qpos[2] += 1e-3 - self.data.geom_xpos[spheres, 2].min()
        self.state = numpy.zeros(mujoco.mj_stateSize(self.model, mujoco.mjtState.mjSTATE_FULLPHYSICS))
        mujoco.mj_getState(self.model, self.data, self.state, mujoco.mjtState.mjSTATE_FULLPHYSICS)
        self.steps = 0
        self.height = self.data.qpos[2]
        self.advance(WARM_UP)

    def advance(self, steps):
        """us per step."""
        ticks = [STEP * HOLD * ((self.steps + i) // HOLD) for i in range(steps)]
        swing = numpy.array([math.sin(2.0 * math.pi * tick) for tick in ticks])
        control = numpy.array(self.posture) + numpy.outer(swing, self.amplitude)
        states = numpy.zeros((1, steps, len(self.state)))
        # One call for all steps: the loop over them is in C++. Outputs are given, so nothing is allocated.
        begin = time.perf_counter()
        rollout.rollout(self.model, self.data, self.state[None], control[None], state=states)
        seconds = time.perf_counter() - begin
        self.state, self.steps = states[0, -1].copy(), self.steps + steps
        if self.data.ncon == 0 or abs(self.data.qpos[2] - self.height) > 0.2 * self.height:
            raise RuntimeError("the robot no longer stands")
        return 1e6 * seconds / steps

    def sample(self, samples):
        return [self.advance(SLICE) for _ in range(samples)]

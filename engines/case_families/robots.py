"""The robots: HOAP-2 and the quadruped of this repository, and a humanoid of about the size of a Unitree G1."""

import math
import tomllib
import xml.etree.ElementTree as xml
from fnmatch import fnmatchcase
from pathlib import Path

from .parts import box_inertia

ROOT = Path(__file__).resolve().parents[2] / "robots"


def stripped(path):
    """The URDF without shapes, limits, damping and friction; joints are continuous where limits would be needed."""
    robot = xml.parse(path).getroot()
    for child in list(robot):
        if child.tag not in ("link", "joint"):
            robot.remove(child)
    for link in robot.iter("link"):
        for shape in link.findall("visual") + link.findall("collision"):
            link.remove(shape)
    for joint in robot.iter("joint"):
        for tag in ("limit", "dynamics", "safety_controller", "calibration"):
            for element in joint.findall(tag):
                joint.remove(element)
        if joint.get("type") == "revolute":
            joint.set("type", "continuous")
    xml.indent(robot)
    return '<?xml version="1.0"?>\n' + xml.tostring(robot, encoding="unicode") + "\n"


def angle(value):
    return math.radians(float(value.split()[0])) if isinstance(value, str) else float(value)


def of_robot_file(name, gains=1.0):
    """A robot of this repository with its own servos, home posture and soles: body and URDF."""
    folder = ROOT / name
    robot = tomllib.loads((folder / f"{name}.toml").read_text())
    text = stripped(folder / robot["urdf"])
    joints = [j.get("name") for j in xml.fromstring(text).iter("joint") if j.get("type") != "fixed"]
    drives = {}
    for joint in joints:
        drive = dict(robot["joint_default"])
        for pattern, changes in robot.get("joint", {}).items():
            if fnmatchcase(joint, pattern):
                drive |= changes
        drives[joint] = drive
    home = {joint: angle(robot.get("home", {}).get(joint, 0.0)) for joint in joints}
    touching = {}
    for sole in robot["sole"]:
        touching.setdefault(sole["link"], []).append({"kind": "points", "points": sole["polygon"]})
    return {
        "name": name,
        "urdf": f"{name}.urdf",
        "joints": home,
        "armature": {j: drives[j].get("armature", 0.0) for j in joints},
        "servos": {j: {"kp": drives[j]["kp"], "kd": drives[j]["kd"], "target": home[j]} for j in joints},
        "touching": touching,
    }, {f"{name}.urdf": text}


# Links of the humanoid: name, parent, joint axis, origin in the parent, mass, box, centre of the box. A leg has six
# joints, an arm four, the waist one: 21. Total mass 33 kg, height 1.3 m; the figures are a design of this file.
LEG = [
    ("hip_pitch", "pelvis", "y", (0, 0.1, -0.1), 1.3, (0.09, 0.08, 0.09), (0, 0.02, 0)),
    ("hip_roll", "hip_pitch", "x", (0, 0.03, -0.03), 1.5, (0.1, 0.1, 0.1), (0, 0, -0.04)),
    ("thigh", "hip_roll", "z", (0, 0, -0.1), 1.7, (0.1, 0.1, 0.18), (0, 0, -0.08)),
    ("shank", "thigh", "y", (0, 0, -0.18), 1.9, (0.08, 0.08, 0.26), (0, 0, -0.14)),
    ("ankle", "shank", "y", (0, 0, -0.3), 0.3, (0.05, 0.05, 0.05), (0, 0, 0)),
    ("foot", "ankle", "x", (0, 0, -0.02), 0.6, (0.2, 0.07, 0.03), (0.03, 0, -0.02)),
]
ARM = [
    ("shoulder", "torso", "y", (0, 0.13, 0.25), 0.8, (0.08, 0.06, 0.08), (0, 0.02, 0)),
    ("upper_arm", "shoulder", "x", (0, 0.05, 0), 0.9, (0.07, 0.07, 0.16), (0, 0, -0.06)),
    ("elbow", "upper_arm", "z", (0, 0, -0.12), 0.5, (0.06, 0.06, 0.1), (0, 0, -0.04)),
    ("forearm", "elbow", "y", (0.01, 0, -0.08), 0.7, (0.05, 0.05, 0.22), (0.02, 0, -0.1)),
]
AXES = {"x": "1 0 0", "y": "0 1 0", "z": "0 0 1"}
# Postures of the left side, rad, and gains N m/rad; kd = 0.05 kp, rotor 1.2e-4 kp (as in geared motors).
POSTURE = {"hip_pitch": -0.3, "shank": 0.6, "ankle": -0.3, "forearm": -0.8}
GAIN = {
    "waist": 200.0,
    "ankle": 150.0,
    "foot": 100.0,
    "shoulder": 80.0,
    "upper_arm": 80.0,
    "elbow": 40.0,
    "forearm": 40.0,
}
SOLE = [[0.13, 0.035, -0.035], [-0.07, 0.035, -0.035], [-0.07, -0.035, -0.035], [0.13, -0.035, -0.035]]


def humanoid():
    """A humanoid with 21 joints: body and URDF."""
    robot = xml.Element("robot", name="humanoid")

    def link(name, mass, size, centre):
        element = xml.SubElement(robot, "link", name=name)
        inertial = xml.SubElement(element, "inertial")
        xml.SubElement(inertial, "origin", xyz=" ".join(f"{x:g}" for x in centre))
        xml.SubElement(inertial, "mass", value=f"{mass:g}")
        ixx, iyy, izz = (f"{x:.10g}" for x in box_inertia(mass, size))
        xml.SubElement(inertial, "inertia", ixx=ixx, ixy="0", ixz="0", iyy=iyy, iyz="0", izz=izz)

    def joint(name, parent, child, origin, axis):
        element = xml.SubElement(robot, "joint", name=name, type="continuous")
        xml.SubElement(element, "origin", xyz=" ".join(f"{x:g}" for x in origin))
        xml.SubElement(element, "parent", link=parent)
        xml.SubElement(element, "child", link=child)
        xml.SubElement(element, "axis", xyz=AXES[axis])

    joints = {"waist_yaw": ("waist", 0.0)}
    link("pelvis", 3.8, (0.16, 0.22, 0.12), (0, 0, -0.02))
    link("torso", 9.0, (0.16, 0.24, 0.36), (0, 0, 0.18))
    joint("waist_yaw", "pelvis", "torso", (0, 0, 0.05), "z")
    for side, sign in [("left", 1), ("right", -1)]:
        for name, parent, axis, origin, mass, size, centre in LEG + ARM:
            mirror = lambda v: (v[0], sign * v[1], v[2])
            link(f"{side}_{name}", mass, size, mirror(centre))
            root = parent if parent in ("pelvis", "torso") else f"{side}_{parent}"
            joint(f"{side}_{name}_joint", root, f"{side}_{name}", mirror(origin), axis)
            joints[f"{side}_{name}_joint"] = (name, POSTURE.get(name, 0.0))
    xml.indent(robot)
    home = {joint: posture for joint, (_, posture) in joints.items()}
    gain = {joint: GAIN.get(name, 300.0) for joint, (name, _) in joints.items()}
    return {
        "name": "humanoid",
        "urdf": "humanoid.urdf",
        "joints": home,
        "armature": {j: 1.2e-4 * gain[j] for j in joints},
        "servos": {j: {"kp": gain[j], "kd": 0.05 * gain[j], "target": home[j]} for j in joints},
        "touching": {f"{side}_foot": [{"kind": "points", "points": SOLE}] for side in ("left", "right")},
    }, {"humanoid.urdf": '<?xml version="1.0"?>\n' + xml.tostring(robot, encoding="unicode") + "\n"}


def sole_height(body, text):
    """Height of the root link's frame at which the lowest point of contact is on the floor, at the start's posture."""
    robot = xml.fromstring(text)
    parents = {j.find("child").get("link"): j for j in robot.iter("joint")}

    def numbers(element, key):
        return [float(x) for x in (element.get(key, "0 0 0") if element is not None else "0 0 0").split()]

    def apply(joint, point):
        axis = numbers(joint.find("axis"), "xyz") if joint.get("type") != "fixed" else [0, 0, 1]
        turned = rotate(axis, body["joints"].get(joint.get("name"), 0.0), point)
        origin = joint.find("origin")
        r, p, y = numbers(origin, "rpy")
        for about, value in (([1, 0, 0], r), ([0, 1, 0], p), ([0, 0, 1], y)):
            turned = rotate(about, value, turned)
        return [a + b for a, b in zip(numbers(origin, "xyz"), turned)]

    lowest = math.inf
    for link, shapes in body["touching"].items():
        for point in [point for shape in shapes for point in shape["points"]]:
            at = link
            while at in parents:
                point = apply(parents[at], point)
                at = parents[at].find("parent").get("link")
            lowest = min(lowest, point[2])
    return -lowest


def rotate(axis, angle, v):
    norm = math.sqrt(sum(x * x for x in axis))
    k = [x / norm for x in axis]
    c, s = math.cos(angle), math.sin(angle)
    dot = sum(a * b for a, b in zip(k, v))
    cross = [k[1] * v[2] - k[2] * v[1], k[2] * v[0] - k[0] * v[2], k[0] * v[1] - k[1] * v[0]]
    return [v[i] * c + cross[i] * s + k[i] * dot * (1 - c) for i in range(3)]

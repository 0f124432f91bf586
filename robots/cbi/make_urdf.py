#!/usr/bin/env python3
"""Prints cbi.urdf. The table below holds the figures of the left side and the centre; the right side is its mirror image.

    python3 make_urdf.py > cbi.urdf

Sources and marks: README.md. Axes of every link at zero: x forward, y left, z up; each link's frame sits on its joint.
Lengths in m, masses in kg, tensors in kg m^2 about the centre of mass, angles in rad.
"""

from math import asin, atan2, cos, hypot, pi, radians, sin

TILT = radians(15.5)  # of the thigh-rotation axis, backwards at the top
HALF = cos(radians(45))  # the shoulder-pitch axes point 45 degrees up

# joint, link, parent link, offset, axis, lower, upper, effort, mass, centre of mass, tensor xx yy zz xy xz yz
# Centre links first, then the left side; the two eyes are given each, since they differ.
LINKS = [
    ("", "pelvis", "", (0, 0, 0), (0, 0, 0), 0, 0, 0,
     7.1448, (-0.1043, 0.0102, 0.0210), (0.0662, 0.032, 0.0592, 0.00147, -0.00256, -0.00698)),
    ("B_TR", "torso_twist", "pelvis", (-0.0042, 0, 0.1761), (0, 0, -1), -0.31, 0.31, 500,
     1.9636, (0.0005, 0.0383, -0.0405), (0.0088, 0.00467, 0.00552, -1.15e-05, -0.000141, -0.00124)),
    ("B_TAA", "torso_lean", "torso_twist", (0, 0, 0), (1, 0, 0), -0.48, 0.48, 500,
     1.6606, (-0.0279, 0.0179, 0.0391), (0.00622, 0.00744, 0.00516, -0.000251, 0.0019, -0.000567)),
    ("B_TFE", "torso", "torso_lean", (0, 0, 0), (0, 1, 0), -0.17, 0.61, 500,
     5.8388, (0.0229, -0.0191, 0.1294), (0.0713, 0.0563, 0.0357, 0.00157, 0.00967, -0.000729)),
    ("B_HN", "neck_nod", "torso", (0, 0, 0.3068), (0, 1, 0), -0.44, 0.44, 100,
     0.5310, (0.0212, 0.0005, -0.0538), (0.00342, 0.00347, 0.000597, 2.2e-06, 0.000774, -8.71e-06)),
    ("B_HT", "neck_tilt", "neck_nod", (0, 0, 0), (1, 0, 0), -0.22, 0.22, 100,
     0.5310, (0.0212, 0.0005, -0.0538), (0.00342, 0.00347, 0.000597, 2.22e-06, 0.000774, -9.01e-06)),
    ("B_HR", "head", "neck_tilt", (0, 0, 0), (0, 0, -1), -0.79, 0.79, 100,
     2.7360, (-0.0106, -0.0033, 0.0461), (0.0323, 0.0315, 0.00669, -0.000316, -0.00496, -0.00108)),
    ("R_EP", "r_eye_pan", "head", (0.0674, -0.0366, 0.1356), (0, 0, -1), -0.65, 0.65, 5,
     0.1513, (0.0010, -0.0004, -0.0163), (0.000134, 0.00013, 4.7e-05, -7.31e-07, -1.58e-06, -6.12e-06)),
    ("R_ET", "r_eye", "r_eye_pan", (0, 0, 0), (0, 1, 0), -0.65, 0.65, 5,
     0.1099, (-0.0038, -0.0003, 0.0039), (3.99e-05, 6.14e-05, 5.6e-05, 0, 1.12e-05, -8.4e-07)),
    ("L_EP", "l_eye_pan", "head", (0.0674, 0.0366, 0.1356), (0, 0, -1), -0.65, 0.65, 5,
     0.1559, (-0.0010, -0.0001, -0.0160), (0.00014, 0.000135, 4.83e-05, 9.22e-07, 8.82e-07, -5.53e-06)),
    ("L_ET", "l_eye", "l_eye_pan", (0, 0, 0), (0, 1, 0), -0.65, 0.65, 5,
     0.1115, (-0.0040, 0.0004, 0.0037), (4.06e-05, 6.33e-05, 5.8e-05, 0, 1.12e-05, 1.06e-06)),
]
SIDE = [
    ("SFE", "shoulder", "torso", (0, 0, 0.1110), (0, -HALF, -HALF), -0.35, 1.75, 100,
     1.7170, (0.0005, 0.1013, 0.1321), (0.00766, 0.00438, 0.00382, 2.72e-05, 2.55e-05, -0.00211)),
    ("SAA", "shoulder_roll", "shoulder", (0, 0.1957, 0.1957), (-1, 0, 0), -1.75, 0, 100,
     0.2869, (-0.0013, 0.0117, -0.0089), (0.000148, 0.000166, 0.000145, -4.62e-06, 5.2e-06, 3.25e-05)),
    ("HR", "upper_arm", "shoulder_roll", (0, 0.0240, 0), (0, 0, 1), -0.79, 0.79, 100,
     3.0791, (-0.0058, 0.0020, -0.1403), (0.0121, 0.0123, 0.00306, -5.12e-06, 0.000343, 0.000371)),
    ("EB", "elbow", "upper_arm", (0, 0, -0.2577), (0, -1, 0), 0, 2.09, 100,
     0.3462, (-0.0095, 0.0010, -0.0180), (0.000319, 0.00029, 0.000191, -3.01e-06, 7.12e-06, -5.59e-06)),
    ("WR", "forearm", "elbow", (0, 0, 0), (0, 0, 1), -0.79, 0.79, 100,
     1.0582, (-0.0185, -0.0006, -0.1397), (0.00276, 0.00303, 0.000904, 2.3e-05, -0.000591, 5.49e-05)),
    ("WFE", "wrist", "forearm", (0, 0.0038, -0.2408), (1, 0, 0), -0.39, 0.39, 100,
     0.0566, (0.0088, 0.0078, 0.0006), (2.01e-05, 2e-05, 3.98e-05, 0, -1.72e-06, 0)),
    ("WAA", "hand", "wrist", (0, 0, 0), (0, -1, 0), -0.78, 0.78, 100,
     0.2734, (-0.0086, 0.0041, -0.0857), (0.000824, 0.000891, 0.000185, -4.25e-05, -2.64e-05, -9.67e-05)),
    ("HAA", "hip", "pelvis", (0, 0.0889, 0), (-1, 0, 0), -0.52, 0.26, 300,
     1.5840, (-0.0655, 0.0019, 0.0098), (0.003, 0.00574, 0.00617, 0.000219, -3.36e-05, -3.29e-05)),
    ("HFE", "upper_thigh", "hip", (0, 0, 0), (0, -1, 0), -0.52, 1.57, 300,
     3.1890, (0.0247, 0.0171, -0.1255), (0.0353, 0.0376, 0.00648, -0.000859, 0.00647, 0.00345)),
    ("HFR", "thigh", "upper_thigh", (-0.0385, 0, -0.0107), (-sin(TILT), 0, cos(TILT)), -0.44, 0.44, 100,
     2.4870, (0.0379, 0.0085, -0.2618), (0.0264, 0.0273, 0.0047, 0.000712, 0.0038, -0.00174)),
    ("KFE", "knee", "thigh", (0.0396, 0, -0.3851), (0, 1, 0), 0, 2.09, 100,
     1.3910, (0.0148, 0.0022, -0.0489), (0.0105, 0.0109, 0.00153, -5.74e-05, -0.000594, 0.000121)),
    ("AR", "shank", "knee", (0, 0, 0), (0, 0, 1), -0.26, 0.26, 100,
     3.4690, (0.0161, 0.0275, -0.2131), (0.0188, 0.0215, 0.00697, 0.000475, 0.000649, -0.000404)),
    ("AFE", "ankle", "shank", (0, 0, -0.3810), (0, -1, 0), -0.52, 0.52, 100,
     0.3412, (0.0224, 0, 0), (0.000108, 0.000482, 0.00053, 1.79e-06, 5.31e-07, 0)),
    ("AAA", "foot", "ankle", (0, 0, 0), (-1, 0, 0), -0.26, 0.26, 100,
     1.6940, (0.0390, 0.0089, -0.0361), (0.00128, 0.00673, 0.00735, -3.4e-06, -0.000357, 2.96e-05)),
]

# Greatest speed of every joint, rad/s: an estimate, none is published.
SPEED = 10

# Shapes, all estimates from the lengths: ("box", size, centre), ("sphere", radius, centre), ("rod", radius, from, to).
# A shape of a side link is mirrored. Those marked True are collision shapes as well.
SHAPES = {
    "pelvis": [("box", (0.16, 0.15, 0.15), (-0.075, 0, 0.045), "dark", True),
               ("rod", 0.045, (0, -0.06, 0), (0, 0.06, 0), "silver", True)],
    "torso_twist": [("rod", 0.075, (-0.01, 0, -0.08), (-0.01, 0, -0.02), "silver", False)],
    "torso_lean": [("box", (0.13, 0.16, 0.07), (-0.01, 0, 0.02), "dark", False)],
    "torso": [("box", (0.21, 0.29, 0.21), (0, 0, 0.155), "silver", True),
              ("box", (0.01, 0.16, 0.10), (0.11, 0, 0.175), "blue", True)],
    "neck_nod": [("rod", 0.036, (0, 0, -0.06), (0, 0, -0.01), "dark", False)],
    "neck_tilt": [("sphere", 0.038, (0, 0, 0), "dark", False)],
    "head": [("rod", 0.03, (0, 0, 0.01), (0, 0, 0.07), "dark", False),
             ("box", (0.15, 0.145, 0.22), (-0.014, 0, 0.17), "silver", True)],
    "eye_pan": [("rod", 0.012, (0, 0, -0.03), (0, 0, -0.012), "dark", True)],
    "eye": [("sphere", 0.021, (0, 0, 0), "white", True), ("sphere", 0.009, (0.0145, 0, 0), "black", True)],
    "shoulder": [("rod", 0.045, (0, 0.11, 0.11), (0, 0.1957, 0.1957), "silver", True)],
    "shoulder_roll": [("sphere", 0.052, (0, 0, 0), "dark", False)],
    "upper_arm": [("rod", 0.048, (0, 0, -0.04), (0, 0, -0.22), "silver", True)],
    "elbow": [("rod", 0.04, (0, -0.045, 0), (0, 0.045, 0), "dark", False)],
    "forearm": [("rod", 0.038, (0, 0, -0.04), (0, 0, -0.21), "silver", True)],
    "wrist": [("sphere", 0.028, (0, 0, 0), "dark", False)],
    "hand": [("box", (0.075, 0.03, 0.12), (0, 0, -0.085), "dark", True)],
    "hip": [("box", (0.10, 0.06, 0.08), (-0.06, 0, 0.01), "silver", False)],
    "upper_thigh": [("rod", 0.058, (0, 0, -0.02), (-0.008, 0, -0.17), "silver", True)],
    "thigh": [("rod", 0.055, (0.017, 0, -0.17), (0.037, 0, -0.36), "silver", True)],
    "knee": [("rod", 0.05, (0, -0.055, 0), (0, 0.055, 0), "dark", False)],
    "shank": [("rod", 0.046, (0, 0, -0.05), (0, 0, -0.34), "silver", True)],
    "ankle": [("sphere", 0.035, (0, 0, 0), "dark", False)],
    "foot": [("box", (0.30, 0.10, 0.025), (0.05, 0, -0.0387), "black", True),
             ("box", (0.09, 0.07, 0.03), (0, 0, -0.0112), "silver", True)],
}
# Collision shapes only: joint housings drawn on the next link stand here on the one before, where they are just as well
# (a ball in its centre, a rod along the joint's axis), so that the hull of a limb reaches over its joints; the hips on the
# pelvis and the lower torso on the upper, where they are at zero; and around the eyes, the front of the head.
COVERS = {
    "pelvis": [("box", (0.10, 0.2378, 0.08), (-0.06, 0, 0.01))],
    "torso": [("box", (0.13, 0.16, 0.07), (-0.01, 0, 0.02)), ("sphere", 0.038, (0, 0, 0.3068))],
    "head": [("box", (0.032, 0.125, 0.06), (0.076, 0, 0.135))],
    "shoulder": [("sphere", 0.052, (0, 0.1957, 0.1957))],
    "upper_arm": [("rod", 0.04, (0, -0.045, -0.2577), (0, 0.045, -0.2577))],
    "forearm": [("sphere", 0.028, (0, 0.0038, -0.2408))],
    "thigh": [("rod", 0.05, (0.0396, -0.055, -0.3851), (0.0396, 0.055, -0.3851))],
    "shank": [("sphere", 0.035, (0, 0, -0.381))],
}
COLOURS = {"silver": "0.74 0.75 0.78 1", "dark": "0.27 0.28 0.31 1", "blue": "0.16 0.30 0.55 1", "black": "0.08 0.08 0.09 1",
           "white": "0.95 0.95 0.95 1"}


def text(x):
    """Shortest decimal of at most nine digits; no minus before zero."""
    return f"{x:.9g}" if x != 0 else "0"


def row(values):
    return " ".join(text(v) for v in values)


def mirrored(entry):
    """The right link of a left one: y turned over; rotations about x and z turn round so that ranges stay."""
    joint, link, parent, (x, y, z), axis, lower, upper, effort, mass, com, (xx, yy, zz, xy, xz, yz) = entry
    return (joint, link, parent, (x, -y, z), (-axis[0], axis[1], -axis[2]), lower, upper, effort, mass,
            (com[0], -com[1], com[2]), (xx, yy, zz, -xy, xz, -yz))


def flip(point, side):
    return (point[0], -point[1], point[2]) if side == "r" else point


def geometry(shape, side):
    """Origin and geometry elements of a shape."""
    if shape[0] == "box":
        return f'<origin xyz="{row(flip(shape[2], side))}"/>', f'<box size="{row(shape[1])}"/>'
    if shape[0] == "sphere":
        return f'<origin xyz="{row(flip(shape[2], side))}"/>', f'<sphere radius="{text(shape[1])}"/>'
    start, end = flip(shape[2], side), flip(shape[3], side)
    centre = [(a + b) / 2 for a, b in zip(start, end)]
    dx, dy, dz = (b - a for a, b in zip(start, end))
    length = hypot(dx, dy, dz)
    # z turned by roll about x, then by pitch about y, points along the rod.
    roll, pitch = -asin(dy / length), atan2(dx, dz)
    if abs(pitch) > pi / 2:  # a rod has no direction: the smaller turn
        roll, pitch = -roll, pitch - pi if pitch > 0 else pitch + pi
    origin = f'<origin xyz="{row(centre)}" rpy="{row((roll, pitch, 0))}"/>'
    return origin, f'<cylinder radius="{text(shape[1])}" length="{text(length)}"/>'


def link(name, mass, com, tensor):
    side, _, kind = name.partition("_") if name[:2] in ("l_", "r_") else ("", "", name)
    xx, yy, zz, xy, xz, yz = (text(t) for t in tensor)
    print(f'  <link name="{name}">')
    print("    <inertial>")
    print(f'      <origin xyz="{row(com)}"/>')
    print(f'      <mass value="{text(mass)}"/>')
    print(f'      <inertia ixx="{xx}" ixy="{xy}" ixz="{xz}" iyy="{yy}" iyz="{yz}" izz="{zz}"/>')
    print("    </inertial>")
    for shape in SHAPES[kind]:
        origin, solid = geometry(shape, side)
        print(f'    <visual>{origin}<geometry>{solid}</geometry><material name="{shape[-2]}"/></visual>')
    for shape in [s for s in SHAPES[kind] if s[-1]] + COVERS.get(kind, []):
        origin, solid = geometry(shape, side)
        print(f"    <collision>{origin}<geometry>{solid}</geometry></collision>")
    print("  </link>")


def joint(name, parent, child, offset, axis, lower, upper, effort):
    print(f'  <joint name="{name}" type="revolute">')
    print(f'    <origin xyz="{row(offset)}"/>')
    print(f'    <parent link="{parent}"/>')
    print(f'    <child link="{child}"/>')
    print(f'    <axis xyz="{row(axis)}"/>')
    limits = f'lower="{text(lower)}" upper="{text(upper)}" effort="{text(effort)}" velocity="{text(SPEED)}"'
    print(f"    <limit {limits}/>")
    print("  </joint>")


def main():
    print('<?xml version="1.0"?>')
    print("<!-- ATR / SARCOS CB-i: 38 joints, 39 links. Printed by make_urdf.py, where the figures are; sources: README.md. -->")
    print('<robot name="cbi">')
    for name, rgba in COLOURS.items():
        print(f'  <material name="{name}"><color rgba="{rgba}"/></material>')
    everything = list(LINKS)
    for side in "lr":
        for entry in SIDE:
            name, kind, parent, *rest = entry if side == "l" else mirrored(entry)
            parent = parent if parent in ("torso", "pelvis") else f"{side}_{parent}"
            everything.append((f"{side.upper()}_{name}", f"{side}_{kind}", parent, *rest))
    for name, child, parent, offset, axis, lower, upper, effort, mass, com, tensor in everything:
        if name:
            joint(name, parent, child, offset, axis, lower, upper, effort)
        link(child, mass, com, tensor)
    print("</robot>")


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""Prints quadruped.urdf: a design of this project, its inertias computed from homogeneous solids.

    python3 make_urdf.py > quadruped.urdf

Axes of every link at zero: x forward, y left, z up; each link's frame sits on its joint; the legs hang straight down.
"""

# Lengths, m. Hip-roll axes: HIP_X ahead and behind, HIP_Y left and right of the middle of the body. Each leg stands SPREAD further
# out; thigh and shank are LEG long.
HIP_X, HIP_Y, SPREAD, LEG = 0.20, 0.07, 0.075, 0.22

# Solids: kind, mass in kg, centre, and ("box", edges) or ("rod", radius, length, axis) or ("ball", radius). The left legs'
# are given; the right ones mirror them in y.
BODY = [
    ("shell with computer and battery", 4.10, (0, 0, 0.005), ("box", 0.34, 0.13, 0.09), "silver"),
    ("fl hip-roll motor", 0.60, (HIP_X - 0.045, HIP_Y, 0), ("rod", 0.042, 0.05, "x"), "dark"),
    ("fr hip-roll motor", 0.60, (HIP_X - 0.045, -HIP_Y, 0), ("rod", 0.042, 0.05, "x"), "dark"),
    ("hl hip-roll motor", 0.60, (0.045 - HIP_X, HIP_Y, 0), ("rod", 0.042, 0.05, "x"), "dark"),
    ("hr hip-roll motor", 0.60, (0.045 - HIP_X, -HIP_Y, 0), ("rod", 0.042, 0.05, "x"), "dark"),
]
LEG_SOLIDS = {
    "hip": [("bracket", 0.12, (0, 0.018, 0), ("box", 0.05, 0.04, 0.06), "silver"),
            ("hip-pitch motor", 0.60, (0, 0.045, 0), ("rod", 0.042, 0.05, "y"), "dark")],
    "thigh": [("knee motor", 0.60, (0, 0.025, 0), ("rod", 0.042, 0.04, "y"), "dark"),
              ("tube", 0.24, (0, 0, -0.11), ("box", 0.036, 0.024, 0.22), "blue")],
    "shank": [("tube", 0.11, (0, 0, -0.105), ("rod", 0.011, 0.21, "z"), "silver")],
    "foot": [("ball", 0.05, (0, 0, 0.014), ("ball", 0.014), "black")],
}
COLOURS = {"silver": "0.74 0.75 0.78 1", "dark": "0.27 0.28 0.31 1", "blue": "0.16 0.30 0.55 1", "black": "0.08 0.08 0.09 1"}

# Motors: N m and rad/s at the joint.
EFFORT, SPEED = 20, 25


def text(x):
    return f"{x:.9g}" if abs(x) > 1e-15 else "0"


def row(values):
    return " ".join(text(v) for v in values)


def own_tensor(mass, shape):
    """Diagonal of a solid's tensor about its own centre."""
    kind, *size = shape
    if kind == "box":
        a, b, c = (s * s for s in size)
        return [mass / 12 * (b + c), mass / 12 * (a + c), mass / 12 * (a + b)]
    if kind == "ball":
        return [0.4 * mass * size[0] ** 2] * 3
    radius, length, axis = size
    across = mass * (3 * radius**2 + length**2) / 12
    return [mass * radius**2 / 2 if name == axis else across for name in "xyz"]


def together(solids):
    """Mass, centre and tensor (xx yy zz xy xz yz) about it."""
    mass = sum(m for _, m, *_ in solids)
    com = [sum(m * c[i] for _, m, c, *_ in solids) / mass for i in range(3)]
    tensor = [0.0] * 6
    for _, m, centre, shape, _ in solids:
        x, y, z = (c - o for c, o in zip(centre, com))
        own = own_tensor(m, shape)
        for i, term in enumerate((own[0] + m * (y * y + z * z), own[1] + m * (x * x + z * z), own[2] + m * (x * x + y * y),
                                  -m * x * y, -m * x * z, -m * y * z)):
            tensor[i] += term
    return mass, com, tensor


def link(name, solids):
    mass, com, (xx, yy, zz, xy, xz, yz) = together(solids)
    print(f'  <link name="{name}">')
    print("    <inertial>")
    print(f'      <origin xyz="{row(com)}"/>')
    print(f'      <mass value="{text(mass)}"/>')
    print(f'      <inertia ixx="{text(xx)}" ixy="{text(xy)}" ixz="{text(xz)}" iyy="{text(yy)}" iyz="{text(yz)}" izz="{text(zz)}"/>')
    print("    </inertial>")
    for _, _, centre, (kind, *size), colour in solids:
        turn = {"x": ' rpy="0 1.57079633 0"', "y": ' rpy="1.57079633 0 0"'}.get(size[-1], "")
        body = {"box": f'<box size="{row(size)}"/>' if kind == "box" else "", "ball": f'<sphere radius="{text(size[0])}"/>',
                "rod": f'<cylinder radius="{text(size[0])}" length="{text(size[1])}"/>' if kind == "rod" else ""}[kind]
        shape = f'<origin xyz="{row(centre)}"{turn}/><geometry>{body}</geometry>'
        print(f'    <visual>{shape}<material name="{colour}"/></visual>')
        print(f"    <collision>{shape}</collision>")
    print("  </link>")


def joint(name, parent, child, offset, axis=None, lower=0, upper=0):
    print(f'  <joint name="{name}" type="{"revolute" if axis else "fixed"}">')
    print(f'    <origin xyz="{row(offset)}"/>')
    print(f'    <parent link="{parent}"/>')
    print(f'    <child link="{child}"/>')
    if axis:
        limits = f'lower="{text(lower)}" upper="{text(upper)}" effort="{text(EFFORT)}" velocity="{text(SPEED)}"'
        print(f'    <axis xyz="{axis}"/>')
        print(f"    <limit {limits}/>")
    print("  </joint>")


def main():
    print('<?xml version="1.0"?>')
    print("<!-- A quadruped with point feet: 12 joints. Printed by make_urdf.py, where the design figures are. -->")
    print('<robot name="quadruped">')
    for name, rgba in COLOURS.items():
        print(f'  <material name="{name}"><color rgba="{rgba}"/></material>')
    link("body", BODY)
    for leg in ("fl", "fr", "hl", "hr"):
        front, left = 1 if leg[0] == "f" else -1, 1 if leg[1] == "l" else -1
        solids = {part: [(n, m, (x, left * y, z), shape, colour) for n, m, (x, y, z), shape, colour in s]
                  for part, s in LEG_SOLIDS.items()}
        inner, outer = (-0.5, 0.9) if left > 0 else (-0.9, 0.5)
        joint(f"{leg}_hip_roll", "body", f"{leg}_hip", (front * HIP_X, left * HIP_Y, 0), "1 0 0", inner, outer)
        link(f"{leg}_hip", solids["hip"])
        joint(f"{leg}_hip_pitch", f"{leg}_hip", f"{leg}_thigh", (0, left * SPREAD, 0), "0 1 0", -1.2, 2.4)
        link(f"{leg}_thigh", solids["thigh"])
        joint(f"{leg}_knee", f"{leg}_thigh", f"{leg}_shank", (0, 0, -LEG), "0 1 0", -2.6, -0.1)
        link(f"{leg}_shank", solids["shank"])
        joint(f"{leg}_ankle", f"{leg}_shank", f"{leg}_foot", (0, 0, -LEG))
        link(f"{leg}_foot", solids["foot"])
    print("</robot>")


if __name__ == "__main__":
    main()

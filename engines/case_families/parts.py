"""Parts of cases: bodies, floors, measures."""

import math

FORMAT = "stiction-case-1"
G = 9.81
BOX = (0.2, 0.2, 0.1)


def urdf(name, mass, inertia, com=(0, 0, 0)):
    """A URDF of one link without shapes; `inertia` about its centre of mass, along the link's axes."""
    ixx, iyy, izz = inertia
    return f"""<?xml version="1.0"?>
<robot name="{name}">
  <link name="{name}">
    <inertial>
      <origin xyz="{com[0]:.17g} {com[1]:.17g} {com[2]:.17g}"/>
      <mass value="{mass:.17g}"/>
      <inertia ixx="{ixx:.17g}" ixy="0" ixz="0" iyy="{iyy:.17g}" iyz="0" izz="{izz:.17g}"/>
    </inertial>
  </link>
</robot>
"""


def box_inertia(mass, size):
    x, y, z = size
    return mass * (y * y + z * z) / 12, mass * (x * x + z * z) / 12, mass * (x * x + y * y) / 12


def box(name="box", mass=1.0, size=BOX):
    """A homogeneous box with its frame at its centre: the body's entries, and its URDF."""
    body = {
        "name": name,
        "urdf": f"{name}.urdf",
        "primitive": {"kind": "box", "mass": mass, "size": list(size)},
        "touching": {name: [{"kind": "box", "size": list(size)}]},
    }
    return body, {f"{name}.urdf": urdf(name, mass, box_inertia(mass, size))}


def sphere(name="ball", mass=1.0, radius=0.1):
    """A homogeneous ball."""
    inertia = 0.4 * mass * radius**2
    body = {
        "name": name,
        "urdf": f"{name}.urdf",
        "primitive": {"kind": "sphere", "mass": mass, "radius": radius},
        "touching": {name: [{"kind": "sphere", "radius": radius}]},
    }
    return body, {f"{name}.urdf": urdf(name, mass, (inertia, inertia, inertia))}


def placed(body, position, orientation=(1, 0, 0, 0), velocity=(0, 0, 0), angular=(0, 0, 0), **more):
    """The body at its start."""
    return {
        **body,
        "position": list(position),
        "orientation": list(orientation),
        "linear_velocity": list(velocity),
        "angular_velocity": list(angular),
        **more,
    }


def floor(mu, bodies=("box",), kinetic=None):
    """Friction of bodies with the floor."""
    kinetic = mu if kinetic is None else kinetic
    return [{"bodies": ["floor", body], "static": mu, "kinetic": kinetic} for body in bodies]


def measure(name, kind, truth, derivation, unit, error=0.0, body="box", **parameters):
    return {
        "name": name,
        "kind": kind,
        "body": body,
        "unit": unit,
        "truth": truth,
        "truth_error": error,
        "derivation": derivation,
        **parameters,
    }


def case(
    name, title, family, bodies, friction, duration, measures, gravity=(0, 0, -G), restitution=0.0, forces=()
):
    return {
        "format": FORMAT,
        "name": name,
        "title": title,
        "family": family,
        "gravity": list(gravity),
        "restitution": restitution,
        "bodies": bodies,
        "friction": friction,
        "forces": list(forces),
        "duration": duration,
        "measures": measures,
    }


def about(axis, angle):
    """A quaternion."""
    s = math.sin(angle / 2)
    return [math.cos(angle / 2), axis[0] * s, axis[1] * s, axis[2] * s]


def tilted(angle, heading=0.0):
    """Gravity on a slope that falls by `angle` towards `heading` about z."""
    s = G * math.sin(angle)
    return [s * math.cos(heading), s * math.sin(heading), -G * math.cos(angle)]


def rising(body, height, force=(0, 0, 0), moment=(0, 0, 0)):
    """A load on a body of one link that rises from 0 to these values in 1 s, at a height in the link's frame."""
    knots = [[0.0] + [0.0] * 6, [1.0, *force, *moment]]
    return {"body": body, "link": body, "point": [0, 0, height], "knots": knots}

"""URDF files of bodies: their joints in order, and the same file with the shapes that touch."""

import xml.etree.ElementTree as xml

from .engine import Unsupported
from .series import matrix, rpy


def joint_names(body):
    """Names of the joints of a body in the order of its URDF, fixed ones left out."""
    joints = xml.parse(body.urdf).getroot().iter("joint")
    return [joint.get("name") for joint in joints if joint.get("type") != "fixed"]


def _text(values):
    return " ".join(f"{value:.17g}" for value in values)


def _add_collision(link, kind, position, orientation, **attributes):
    collision = xml.SubElement(link, "collision")
    xml.SubElement(collision, "origin", xyz=_text(position), rpy=_text(rpy(orientation)))
    xml.SubElement(xml.SubElement(collision, "geometry"), kind, attributes)


def with_shapes(body, point_radius=None):
    """Text of the body's URDF with its shapes as collision elements.

    Points become spheres whose lowest point is the point where the link is level, or are left out without a
    radius. Raises `Unsupported` for an unknown shape.
    """
    robot = xml.parse(body.urdf).getroot()
    links = {link.get("name"): link for link in robot.iter("link")}
    for name, shape in ((name, shape) for name, shapes in body.touching.items() for shape in shapes):
        placed = links[name], shape.kind, shape.position, shape.orientation
        if shape.kind == "box":
            _add_collision(*placed, size=_text(shape.size))
        elif shape.kind == "sphere":
            _add_collision(*placed, radius=_text([shape.radius]))
        elif shape.kind == "cylinder":
            _add_collision(*placed, radius=_text([shape.radius]), length=_text([shape.length]))
        elif shape.kind == "points":
            for point in shape.points if point_radius else []:
                centre = shape.position + matrix(shape.orientation) @ point + [0.0, 0.0, point_radius]
                radius = _text([point_radius])
                _add_collision(links[name], "sphere", centre, [1, 0, 0, 0], radius=radius)
        else:
            raise Unsupported(f"no shape {shape.kind!r} (body {body.name})")
    return xml.tostring(robot, encoding="unicode")

"""Energy and momentum of a body's motion, from its URDF alone, so that they mean the same for every engine."""

import xml.etree.ElementTree as xml

import numpy

from .series import matrix


def _numbers(element, key, otherwise):
    text = element.get(key) if element is not None else None
    return numpy.array([float(x) for x in text.split()]) if text else numpy.array(otherwise, dtype=float)


def _rpy(angles):
    (sr, sp, sy), (cr, cp, cy) = numpy.sin(angles), numpy.cos(angles)
    return numpy.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )


def _about(axis, angle):
    cross = numpy.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    return numpy.eye(3) + numpy.sin(angle) * cross + (1 - numpy.cos(angle)) * cross @ cross


class Mechanism:
    """Links and joints of a URDF on a floating joint."""

    def __init__(self, body):
        robot = xml.parse(body.urdf).getroot()
        self.joints = []
        for joint in robot.iter("joint"):
            origin, axis = joint.find("origin"), _numbers(joint.find("axis"), "xyz", [1, 0, 0])
            self.joints.append(
                {
                    "name": joint.get("name"),
                    "kind": joint.get("type"),
                    "parent": joint.find("parent").get("link"),
                    "child": joint.find("child").get("link"),
                    "rotation": _rpy(_numbers(origin, "rpy", [0, 0, 0])),
                    "translation": _numbers(origin, "xyz", [0, 0, 0]),
                    "axis": axis / numpy.linalg.norm(axis),
                }
            )
        self.moving = [j["name"] for j in self.joints if j["kind"] != "fixed"]
        self.armature = numpy.array([body.armature.get(name, 0.0) for name in self.moving])
        children = {j["child"] for j in self.joints}
        self.links = {}
        for link in robot.iter("link"):
            inertial = link.find("inertial")
            if inertial is None:
                continue
            origin, tensor = inertial.find("origin"), inertial.find("inertia")
            value = lambda key: float(tensor.get(key, 0))
            local = numpy.array(
                [
                    [value("ixx"), value("ixy"), value("ixz")],
                    [value("ixy"), value("iyy"), value("iyz")],
                    [value("ixz"), value("iyz"), value("izz")],
                ]
            )
            turn = _rpy(_numbers(origin, "rpy", [0, 0, 0]))
            mass = float(inertial.find("mass").get("value"))
            self.links[link.get("name")] = (mass, _numbers(origin, "xyz", [0, 0, 0]), turn @ local @ turn.T)
        self.root = next(link.get("name") for link in robot.iter("link") if link.get("name") not in children)
        self.ordered = self._ordered()

    def _ordered(self):
        """Joints, each after the one that carries its parent."""
        known, rest, ordered = {self.root}, list(self.joints), []
        while rest:
            ready = [joint for joint in rest if joint["parent"] in known]
            if not ready:
                raise ValueError("the joints do not form a tree")
            ordered += ready
            known |= {joint["child"] for joint in ready}
            rest = [joint for joint in rest if joint["child"] not in known]
        return ordered

    @property
    def mass(self):
        """Mass of all links, kg."""
        return sum(mass for mass, _, _ in self.links.values())

    def moved(self, series, k):
        """Rotation, origin, velocity of the origin, angular velocity of each link at instant `k`."""
        pose = {
            self.root: (
                matrix(series.orientation[k] / numpy.linalg.norm(series.orientation[k])),
                series.position[k],
                series.linear_velocity[k],
                series.angular_velocity[k],
            )
        }
        place = {name: i for i, name in enumerate(self.moving)}
        for joint in self.ordered:
            rotation, origin, v, w = pose[joint["parent"]]
            arm = rotation @ joint["translation"]
            turned = rotation @ joint["rotation"]
            axis = turned @ joint["axis"]
            v, origin = v + numpy.cross(w, arm), origin + arm
            if joint["kind"] in ("revolute", "continuous"):
                i = place[joint["name"]]
                turned, w = turned @ _about(joint["axis"], series.q[k, i]), w + axis * series.qd[k, i]
            elif joint["kind"] == "prismatic":
                i = place[joint["name"]]
                arm = axis * series.q[k, i]
                origin, v = origin + arm, v + numpy.cross(w, arm) + axis * series.qd[k, i]
            pose[joint["child"]] = (turned, origin, v, w)
        return pose

    def totals(self, series, k, gravity):
        """Kinetic and potential energy, J, momentum, angular momentum about the world's origin, centre of mass.

        The kinetic energy includes that of rotors, as half the armature times the square of the joint's speed.
        """
        kinetic = 0.5 * float(self.armature @ series.qd[k] ** 2) if len(self.armature) else 0.0
        potential, momentum, angular, first = 0.0, numpy.zeros(3), numpy.zeros(3), numpy.zeros(3)
        for name, (rotation, origin, v, w) in self.moved(series, k).items():
            if name not in self.links:
                continue
            mass, centre, tensor = self.links[name]
            arm = rotation @ centre
            at, speed, spin = origin + arm, v + numpy.cross(w, arm), rotation @ tensor @ rotation.T @ w
            kinetic += 0.5 * (mass * speed @ speed + w @ spin)
            potential -= mass * gravity @ at
            momentum += mass * speed
            angular += mass * numpy.cross(at, speed) + spin
            first += mass * at
        return kinetic, potential, momentum, angular, first / self.mass

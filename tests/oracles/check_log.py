#!/usr/bin/env python3
"""Reads a log.mcap with independent libraries and checks its consistency.

    pip install -r requirements.txt
    python check_log.py results/*/*/log.mcap

The script decodes every message of every topic by the schema in the file. It checks log times,
counts, finite numbers, unit quaternions, a frame for every link of the attached URDF, and that
topics with the same data agree. Exit code 1 for an inconsistent log, 2 for an unreadable file.
"""

import json
import math
import sys
import xml.etree.ElementTree as ElementTree
from collections import defaultdict

from mcap.exceptions import McapError
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory as Protobuf
from mcap_ros2.decoder import DecoderFactory as Ros2

TICKED = ["/state", "/contact", "/residual", "/objects"]
# Topics at some of these instants.
VIEWED = ["/tf", "/scene/contact", "/joint_states"]
ONCE = ["/scene", "/robot_description"]
# The quaternions are products and logarithms of unit quaternions in double precision.
UNIT = 1e-9
# Arrows have single precision, 6e-8 of each component.
DRAWN_UNIT = 3e-7
# Poses are composed over at most a few dozen links, each with an error of a few 1e-16 of the distance to the origin.
POSE = 1e-9


class Checks:
    """Collects errors; prints each kind only a few times."""

    def __init__(self):
        self.wrong = defaultdict(int)

    def __call__(self, holds, text):
        if not holds:
            self.wrong[text] += 1

    def report(self):
        for text, times in self.wrong.items():
            print(f"  WRONG {text}" + (f" ({times} times)" if times > 1 else ""))
        return not self.wrong


def xyz(v):
    return (v.x, v.y, v.z)


def finite(values):
    return all(math.isfinite(x) for x in values)


def distance(a, b):
    return math.dist(a, b) / max(1.0, math.hypot(*b))


def rotate(q, v):
    """v rotated by the unit quaternion q = (w, x, y, z)."""
    w, x, y, z = q
    vx, vy, vz = v
    tx, ty, tz = 2 * (y * vz - z * vy), 2 * (z * vx - x * vz), 2 * (x * vy - y * vx)
    return (
        vx + w * tx + y * tz - z * ty,
        vy + w * ty + z * tx - x * tz,
        vz + w * tz + x * ty - y * tx,
    )


def product(p, q):
    pw, px, py, pz = p
    qw, qx, qy, qz = q
    return (
        pw * qw - px * qx - py * qy - pz * qz,
        pw * qx + px * qw + py * qz - pz * qy,
        pw * qy - px * qz + py * qw + pz * qx,
        pw * qz + px * qy - py * qx + pz * qw,
    )


def wxyz(q):
    return (q.w, q.x, q.y, q.z)


def poses(tf, world, check):
    """Pose of every frame in the world: name -> (position, quaternion)."""
    transforms = {t.child_frame_id: t for t in tf.transforms}
    check(len(transforms) == len(tf.transforms), "/tf: a frame has two parents")
    found = {world: ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0))}

    def pose(name):
        if name not in found:
            t = transforms[name]
            position, rotation = pose(t.parent_frame_id)
            offset = rotate(rotation, xyz(t.translation))
            found[name] = (tuple(a + b for a, b in zip(position, offset)), product(rotation, wxyz(t.rotation)))
        return found[name]

    for name in transforms:
        pose(name)
    return found


def check_scene(scene, check):
    for entity in scene.entities:
        check(entity.frame_id != "", f"scene: entity {entity.id} has no frame")
        for kind in ("arrows", "cubes", "spheres", "cylinders", "lines", "triangles"):
            for primitive in getattr(entity, kind):
                pose = primitive.pose
                unit = DRAWN_UNIT if kind == "arrows" else UNIT
                check(abs(math.hypot(*wxyz(pose.orientation)) - 1) < unit, f"scene: {entity.id} {kind}: no unit quaternion")
                check(finite(xyz(pose.position)), f"scene: {entity.id} {kind}: position not finite")
        for mesh in entity.triangles:
            check(len(mesh.indices) % 3 == 0, f"scene: {entity.id}: indices are no triangles")
            check(all(i < len(mesh.points) for i in mesh.indices), f"scene: {entity.id}: index past the points")


def check_contact(contact, check):
    for sole in contact.soles:
        vertices = len(sole.positions)
        check(len(sole.forces) == vertices == len(sole.velocities) == len(sole.clamped), f"/contact: {sole.name}: lengths differ")
        total = [math.fsum(axis) for axis in zip(*map(xyz, sole.forces))] or [0.0] * 3
        check(finite(total), f"/contact: {sole.name}: force not finite")
        check(distance(total, xyz(sole.force)) < 1e-12, f"/contact: {sole.name}: force is not the sum")
        check(sole.state != "", f"/contact: {sole.name}: no state")


def check_residual(residual, contact, check):
    r = residual
    names = [f.name for f in r.DESCRIPTOR.fields]
    check(finite(getattr(r, name) for name in names), "/residual: not finite")
    for name in ("penetration", "tension", "signorini", "cone_excess", "dissipation_gap", "creep_speed", "resultant_gap"):
        check(getattr(r, name) >= 0, f"/residual: {name} is negative")
    gains, losses = (r.actuator_work, r.external_work), (r.joint_loss, r.friction_loss, r.impact_loss)
    error = math.fsum([r.energy_change, *(-x for x in gains), *losses])
    size = sum(map(abs, (r.energy_change, *gains, *losses)))
    check(abs(error - r.energy_error) <= 1e-14 * size, "/residual: energies do not add up")
    # The speeds of static vertices from /contact, whole; /residual has their tangential part.
    touching = [*contact.soles, *contact.links]
    sticking = [s for s in touching if s.state.endswith("static")]
    speeds = [math.hypot(*xyz(v)) for s in sticking for v, on in zip(s.velocities, s.clamped) if on]
    # Two ways to sum a velocity of nearly zero differ by its rounding; squares of less than 1e-154 lose digits.
    greatest = max(speeds, default=0) * (1 + 1e-12) + 1e-30
    pivots = any(s.state.endswith("dynamic") for s in touching)
    check(pivots or r.creep_speed <= greatest, "/residual: creep faster than in /contact")


def has_mass(urdf):
    """False for a URDF of nothing but fixed ground, which has no centre of mass."""
    return any(float(mass.get("value", 0)) > 0 for mass in ElementTree.fromstring(urdf).iter("mass"))


def check_state(state, joints, is_heavy, check):
    for name in ("q", "qd", "q_desired", "qd_desired", "effort", "effort_desired"):
        values = getattr(state, name)
        # A run without drives has no desired values.
        check(len(values) in (len(joints), 0), f"/state: {len(values)} {name} for {len(joints)} joints")
        check(finite(values), f"/state: {name} not finite")
    check(len(state.q) == len(joints), "/state: not a position for every joint")
    check(abs(math.hypot(*wxyz(state.base_orientation)) - 1) < UNIT, "/state: no unit quaternion")
    for name in ("base_position", "base_linear_velocity", "base_angular_velocity", "com", "com_velocity"):
        check(state.HasField(name), f"/state: no {name}")
        check(not is_heavy and name.startswith("com") or finite(xyz(getattr(state, name))), f"/state: {name} not finite")
    names = [point.name for point in state.points]
    check(all(names) and len(set(names)) == len(names), f"/state: points without a name of their own: {names}")
    for point in state.points:
        check(not point.HasField("position") or finite(xyz(point.position)), f"/state: point {point.name} not finite")
    check_stability(state, check)


def inside(point, corners, normal):
    """Distance from the sides of a convex polygon, negative outside; ignores the distance from the plane."""
    least = math.inf
    for a, b in zip(corners, corners[1:] + corners[:1]):
        along = [y - x for x, y in zip(a, b)]
        inward = cross(normal, along)
        to = [y - x for x, y in zip(a, point)]
        least = min(least, math.fsum(x * y for x, y in zip(inward, to)) / math.hypot(*inward))
    return least


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def check_stability(state, check):
    """The point of optimal stability is in the support polygon and no mean of corners is farther from its sides."""
    corners = [xyz(p) for p in state.support_polygon]
    check(state.HasField("stable_point") == bool(corners), "/state: a point of optimal stability without a polygon")
    if len(corners) < 3:
        return
    edges = [[b - a for a, b in zip(corners[0], c)] for c in corners[1:]]
    spans = [cross(a, b) for a, b in zip(edges, edges[1:])]
    normal = [math.fsum(axis) for axis in zip(*spans)]
    normal = [x / math.hypot(*normal) for x in normal]
    radius = inside(xyz(state.stable_point), corners, normal)
    above = max(abs(math.fsum((a - b) * n for a, b, n in zip(c, xyz(state.stable_point), normal))) for c in corners)
    check(above <= 1e-9, f"/state: the support polygon is not flat, or {above} m from the point of optimal stability")
    check(radius > 0, "/state: the point of optimal stability is outside the support polygon")
    groups = [corners] + [corners[:k] + corners[k + 1 :] for k in range(len(corners))]
    groups += [[a, b] for a in corners for b in corners]
    for group in groups:
        mean = [math.fsum(axis) / len(group) for axis in zip(*group)]
        check(inside(mean, corners, normal) <= radius + 1e-6 * (1 + radius), "/state: a larger disc fits the polygon")


def read(path):
    """Topic -> [(log time, message)], channel metadata by topic, attachments and metadata by name."""
    topics, channels = defaultdict(list), {}
    with open(path, "rb") as file:
        reader = make_reader(file, validate_crcs=True, decoder_factories=[Protobuf(), Ros2()])
        for _, channel, message, decoded in reader.iter_decoded_messages(log_time_order=False):
            topics[channel.topic].append((message.log_time, decoded))
            channels[channel.topic] = channel.metadata
        attachments = {a.name: a for a in reader.iter_attachments()}
        metadata = {m.name: m.metadata for m in reader.iter_metadata()}
        statistics = reader.get_summary().statistics
    return topics, channels, attachments, metadata, statistics


def check_frames(topics, urdf, world, check):
    links = {link.get("name") for link in ElementTree.fromstring(urdf).iter("link")} - {"world"}
    states, contacts = dict(topics["/state"]), dict(topics["/contact"])
    soles = {s.name for _, c in topics["/contact"][:1] for s in c.soles}
    drawn = {e.frame_id for _, s in topics["/scene"] for e in s.entities}
    for time, tf in topics["/tf"]:
        for t in tf.transforms:
            check(abs(math.hypot(*wxyz(t.rotation)) - 1) < UNIT, f"/tf: {t.child_frame_id}: no unit quaternion")
            check(finite(xyz(t.translation)), f"/tf: {t.child_frame_id}: not finite")
            check(t.timestamp.seconds * 10**9 + t.timestamp.nanos == time, "/tf: stamp differs from log time")
        found = poses(tf, world, check)
        for name in sorted(links - found.keys()):
            check(False, f"/tf: no frame for link {name}")
        for name in sorted(soles):
            check(f"sole/{name}" in found, f"/tf: no frame for sole {name}")
        for name in sorted(drawn):
            check(name in found, f"/scene: frame {name} is not in /tf")
        for sole in contacts[time].soles if time in contacts else []:
            mean = [math.fsum(axis) / len(sole.positions) for axis in zip(*map(xyz, sole.positions))]
            frame = found.get(f"sole/{sole.name}")
            check(frame is None or distance(frame[0], mean) < POSE, f"/tf: sole {sole.name} is not where its vertices are")
        if time in states:
            standing = [t.child_frame_id for t in tf.transforms if t.parent_frame_id == world]
            roots = [name for name in standing if not name.startswith("object/")]
            check(len(roots) == 1, f"/tf: {len(roots)} frames stand in the world")
            position, rotation = found[roots[0]]
            state = states[time]
            check(distance(position, xyz(state.base_position)) < POSE, "/tf: root is not at /state's base")
            turn = abs(sum(a * b for a, b in zip(rotation, wxyz(state.base_orientation))))
            check(abs(turn - 1) < POSE, "/tf: root is not turned as /state's base")


def check_log(path):
    topics, channels, attachments, metadata, statistics = read(path)
    check = Checks()
    run = metadata.get("run", {})
    print(f"{path}: {run.get('scenario')} {run.get('key')} {run.get('method')}, {statistics.message_count} messages")

    for topic, messages in sorted(topics.items()):
        times = [t for t, _ in messages]
        check(all(a <= b for a, b in zip(times, times[1:])), f"{topic}: log time goes back")
        span = f"{times[0] / 1e9:g} .. {times[-1] / 1e9:g} s"
        print(f"  {topic:20} {len(messages):7} messages {span}")
    ticked = {t: len(topics[t]) for t in TICKED if t in topics}
    check(len(set(ticked.values())) <= 1, f"counts differ: {ticked}")
    instants = {t for topic in TICKED if topic in topics for t, _ in topics[topic]}
    for topic in VIEWED if instants else []:
        check({t for t, _ in topics.get(topic, [])} <= instants, f"{topic}: has instants of its own")
    for topic in ONCE:
        check(len(topics.get(topic, [1])) == 1, f"{topic}: not written once")
    check(len(topics["/events"]) == len(topics["/log"]), "/events and /log differ in number")
    check(sum(map(len, topics.values())) == statistics.message_count, "not every message was decoded")
    check(metadata.get("end", {}).get("complete") == "true", "the run did not finish its log")

    joints = json.loads(channels.get("/state", {}).get("joints", "[]"))
    urdfs = [a.data for a in attachments.values() if a.media_type == "application/xml"]
    is_heavy = any(map(has_mass, urdfs))
    for _, state in topics["/state"]:
        check_state(state, joints, is_heavy, check)
    for _, contact in topics["/contact"]:
        check_contact(contact, check)
    contacts = dict(topics["/contact"])
    for time, residual in topics["/residual"]:
        check_residual(residual, contacts[time], check)
    for _, scene in topics["/scene"] + topics["/scene/contact"]:
        check_scene(scene, check)

    states = dict(topics["/state"])
    for time, ros in topics["/joint_states"]:
        check(ros.header.stamp.sec * 10**9 + ros.header.stamp.nanosec == time, "/joint_states: stamp differs from log time")
        check(list(ros.name) == joints, "/joint_states: joint names differ from /state's")
        if time in states:
            same = list(ros.position) == list(states[time].q) and list(ros.velocity) == list(states[time].qd)
            check(same and list(ros.effort) == list(states[time].effort), "/joint_states differ from /state")
    for topic in ("/state", "/contact", "/residual", "/events"):
        for time, message in topics[topic]:
            check(abs(message.time * 1e9 - time) <= 0.5 + 1e-6 * time, f"{topic}: time differs from log time")

    check(len(urdfs) == 1, f"{len(urdfs)} URDF files attached")
    check(any(a.media_type == "application/toml" for a in attachments.values()), "no scenario attached")
    for _, description in topics["/robot_description"]:
        check(description.data.encode() == urdfs[0], "/robot_description differs from the attached URDF")
    if topics["/tf"]:
        check_frames(topics, urdfs[0], run.get("world_frame", "world"), check)

    first = topics["/contact"][:1]
    names = [s.name for _, c in first for s in c.soles]
    print(f"  {len(joints)} joints, soles {names}, attached {sorted(attachments)}")
    return check.report()


def main(paths):
    if not paths:
        print(__doc__, file=sys.stderr)
        return 2
    try:
        results = [check_log(path) for path in paths]
    except (OSError, McapError) as error:
        print(error, file=sys.stderr)
        return 2
    return 0 if all(results) else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

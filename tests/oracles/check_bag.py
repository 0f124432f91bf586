#!/usr/bin/env python3
"""Exports logs as ROS 2 bags and checks them with independent libraries.

    pip install -r requirements.txt
    python check_bag.py RUNNER results/*/*/log.mcap

RUNNER is the program. Each bag is read by `rosbags`, with its own definitions of the messages of
Humble and Jazzy and with those in the bag, and by `mcap` with `mcap-ros2-support`. The script
compares metadata.yaml with the file, both readers with each other, stamps with log times, and joint
states, wrenches and the base with the tables of `RUNNER export`. Exit code 1 for an inconsistent
bag, 2 for a bag or log that cannot be read.
"""

import csv
import io
import math
import subprocess
import sys
import tempfile
from collections import Counter, defaultdict
from pathlib import Path

from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.interfaces import QosDurability, QosHistory, QosReliability
from rosbags.rosbag2 import Reader
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

LATCHED = ["/tf_static", "/robot_description", "/scene_markers"]
# The moments of tens of N at tenths of m, each with a few roundings.
MOMENT = 1e-9


class Checks:
    """Collects errors; prints each kind once, with its number."""

    def __init__(self):
        self.wrong = Counter()

    def __call__(self, holds, text):
        if not holds:
            self.wrong[text] += 1

    def report(self):
        for text, times in self.wrong.items():
            print(f"  WRONG {text}" + (f" ({times} times)" if times > 1 else ""))
        return not self.wrong


def nanoseconds(stamp):
    return stamp.sec * 10**9 + stamp.nanosec


def xyz(v):
    return (v.x, v.y, v.z)


def table(runner, log):
    """Columns of the log as text, by name."""
    text = subprocess.run([runner, "export", log], check=True, capture_output=True, text=True).stdout
    rows = list(csv.reader(io.StringIO(text)))
    return dict(zip(rows[0], zip(*rows[1:])))


def columns(found, name):
    """Cells x, y, z of a column whose name contains `{}`, as tuples of numbers."""
    return list(zip(*([float(cell) for cell in found[name.format(axis)]] for axis in "xyz")))


def stamps(message):
    """Stamps of a message and of its parts."""
    if hasattr(message, "clock"):
        return [message.clock]
    parts = getattr(message, "transforms", None) or getattr(message, "markers", None) or [message]
    return [part.header.stamp for part in parts if hasattr(part, "header")]


def read_with_rosbags(folder, check):
    """Topic -> [(log time, message)], decoded by the definitions of Humble."""
    humble, jazzy = get_typestore(Stores.ROS2_HUMBLE), get_typestore(Stores.ROS2_JAZZY)
    own = get_typestore(Stores.EMPTY)
    topics = defaultdict(list)
    with Reader(folder) as reader:
        for connection in reader.connections:
            own.register(get_types_from_msg(connection.msgdef.data, connection.msgtype))
        counts, times = Counter(), []
        for connection, time, data in reader.messages():
            message = humble.deserialize_cdr(data, connection.msgtype)
            # The same bytes again: nothing is left out, and no padding differs.
            again = bytes(humble.serialize_cdr(message, connection.msgtype))
            check(again == bytes(data), f"{connection.topic}: other bytes when serialized again")
            for store in (jazzy, own):
                other = store.deserialize_cdr(data, connection.msgtype)
                same = bytes(store.serialize_cdr(other, connection.msgtype)) == again
                check(same, f"{connection.topic}: other definitions give another message")
            topics[connection.topic].append((time, message))
            counts[connection.topic] += 1
            times.append(time)
        check(times == sorted(times), "log time goes back")
        check(reader.message_count == len(times), "metadata.yaml: other number of messages")
        check(reader.start_time == times[0], "metadata.yaml: other starting time")
        # The library's end is exclusive.
        check(reader.end_time == times[-1] + 1, "metadata.yaml: other duration")
        for connection in reader.connections:
            name = connection.topic
            check(connection.msgcount == counts[name], f"metadata.yaml: other number of messages on {name}")
            check(connection.ext.serialization_format == "cdr", f"{name}: not in CDR")
            [qos] = connection.ext.offered_qos_profiles
            latched = QosDurability.TRANSIENT_LOCAL if name in LATCHED else QosDurability.VOLATILE
            check(qos.durability is latched, f"{name}: durability {qos.durability}")
            check(qos.reliability is QosReliability.RELIABLE, f"{name}: reliability {qos.reliability}")
            check(qos.history is QosHistory.KEEP_LAST and qos.depth > 0, f"{name}: history {qos.history}")
    return topics


def check_with_mcap(path, topics, check):
    """Compares the file, decoded by the definitions in it, with the other reader."""
    found = Counter()
    with open(path, "rb") as file:
        reader = make_reader(file, validate_crcs=True, decoder_factories=[DecoderFactory()])
        check(reader.get_header().profile == "ros2", "the profile is not ros2")
        for schema, channel, message, decoded in reader.iter_decoded_messages():
            check(schema.encoding == "ros2msg" and channel.message_encoding == "cdr", f"{channel.topic}: encodings")
            time, other = topics[channel.topic][found[channel.topic]]
            found[channel.topic] += 1
            check(message.log_time == time == message.publish_time, f"{channel.topic}: log times differ")
            same = [nanoseconds(s) for s in stamps(decoded)] == [nanoseconds(s) for s in stamps(other)]
            check(same, f"{channel.topic}: the readers differ in stamps")
            if channel.topic == "/joint_states":
                for name in ("name", "position", "velocity", "effort"):
                    check(list(getattr(decoded, name)) == list(getattr(other, name)), f"/joint_states: {name} differs")
        statistics = reader.get_summary().statistics
        check(statistics.message_count == sum(found.values()), "statistics: other number of messages")
    counts = Counter({topic: len(messages) for topic, messages in topics.items()})
    check(found == counts, "the readers differ in counts")


def check_joints(messages, found, check):
    for i, (_, message) in enumerate(messages):
        for j, name in enumerate(message.name):
            unit = "m" if f"joint.{name}.position_m" in found else "rad"
            for values, column in (
                (message.position, f"joint.{name}.position_{unit}"),
                (message.velocity, f"joint.{name}.velocity_{unit}_s"),
                (message.effort, f"joint.{name}.effort_{'N' if unit == 'm' else 'Nm'}"),
            ):
                # The digits in the table read back to the same number.
                check(values[j] == float(found[column][i]), f"/joint_states: {column} differs")


def check_wrenches(topics, found, check):
    soles = sorted({name.split(".")[1] for name in found if name.startswith("sole.") and name.endswith(".state")})
    wrenches = {m[0][1].header.frame_id: m for topic, m in topics.items() if topic.startswith("/soles/")}
    check(len(wrenches) == len(soles), f"wrenches of {sorted(wrenches)} for soles {soles}")
    for sole in soles:
        forces = columns(found, f"sole.{sole}.force_{{}}_N")
        messages = wrenches[f"sole/{sole}/world_axes"]
        check(len(messages) == len(forces), f"{sole}: not a wrench at every instant")
        vertices, v = [], 0
        while f"sole.{sole}.vertex{v}.x_m" in found:
            positions = columns(found, f"sole.{sole}.vertex{v}.{{}}_m")
            vertices.append((positions, columns(found, f"sole.{sole}.vertex{v}.force_{{}}_N")))
            v += 1
        for i, (_, message) in enumerate(messages):
            check(xyz(message.wrench.force) == forces[i], f"{sole}: force differs")
            mean = [math.fsum(positions[i][k] for positions, _ in vertices) / len(vertices) for k in range(3)]
            moment = [0.0, 0.0, 0.0]
            for positions, loads in vertices:
                r, f = [a - b for a, b in zip(positions[i], mean)], loads[i]
                for k in range(3):
                    a, b = (k + 1) % 3, (k + 2) % 3
                    moment[k] += r[a] * f[b] - r[b] * f[a]
            error = math.dist(moment, xyz(message.wrench.torque))
            check(error <= MOMENT * (1 + math.hypot(*forces[i])), f"{sole}: moment differs")


def check_frames(topics, found, check):
    fixed = {t.child_frame_id: t.header.frame_id for _, m in topics.get("/tf_static", []) for t in m.transforms}
    base = columns(found, "base_{}_m") if "base_x_m" in found else []
    seen = {}
    for i, (_, message) in enumerate(topics.get("/tf", [])):
        names = [t.child_frame_id for t in message.transforms]
        check(len(set(names)) == len(names), "/tf: a frame twice in a message")
        check(not fixed.keys() & set(names), "/tf: a frame is also on /tf_static")
        for t in message.transforms:
            q = t.transform.rotation
            check(abs(math.hypot(q.x, q.y, q.z, q.w) - 1) < 1e-9, f"/tf: {t.child_frame_id}: no unit quaternion")
            parent = seen.setdefault(t.child_frame_id, t.header.frame_id)
            check(parent == t.header.frame_id, f"/tf: {t.child_frame_id} has two parents")
        roots = [t for t in message.transforms if t.header.frame_id == "world" and "/" not in t.child_frame_id]
        if base and roots and len(base) == len(topics["/tf"]):
            check(xyz(roots[0].transform.translation) == base[i], "/tf: the base is not that of the table")
    parents = {**seen, **fixed}
    for name in parents:
        steps = 0
        while name in parents and steps <= len(parents):
            name, steps = parents[name], steps + 1
        check(name in ("world", "map"), f"/tf: {name} has no parent")
    frames = {m.header.frame_id for topic, ms in topics.items() if "markers" in topic for _, a in ms for m in a.markers}
    for name in sorted(frames - parents.keys() - {"world", "map"}):
        check(False, f"markers: no frame {name}")


def check_bag(runner, log, folder):
    check = Checks()
    subprocess.run([runner, "export", log, "--bag", "-o", folder], check=True, capture_output=True)
    found = table(runner, log)
    topics = read_with_rosbags(folder, check)
    storage = folder / f"{folder.name}_0.mcap"
    print(f"{log}: {sum(map(len, topics.values()))} messages, {storage.stat().st_size} bytes")
    check_with_mcap(storage, topics, check)
    for topic, messages in sorted(topics.items()):
        print(f"  {topic:32} {len(messages):7} messages")
        for time, message in messages:
            check(all(nanoseconds(stamp) == time for stamp in stamps(message)), f"{topic}: stamp differs from log time")
        times = [time for time, _ in messages]
        check(all(a < b for a, b in zip(times, times[1:])), f"{topic}: times do not rise")
    ticks = [round(float(time) * 1e9) for time in found["time_s"]]
    for topic in ("/clock", "/joint_states"):
        if topic in topics:
            check([time for time, _ in topics[topic]] == ticks, f"{topic}: other instants than the table")
    check_joints(topics.get("/joint_states", []), found, check)
    check_wrenches(topics, found, check)
    check_frames(topics, found, check)
    return check.report()


def main(arguments):
    if len(arguments) < 2:
        print(__doc__, file=sys.stderr)
        return 2
    runner, *logs = arguments
    results = []
    try:
        for log in logs:
            with tempfile.TemporaryDirectory() as folder:
                results.append(check_bag(Path(runner).resolve(), Path(log), Path(folder) / "bag"))
    except (OSError, subprocess.CalledProcessError) as error:
        print(error, getattr(error, "stderr", None) or "", file=sys.stderr)
        return 2
    return 0 if all(results) else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

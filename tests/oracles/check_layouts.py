#!/usr/bin/env python3
"""Checks the viewer layouts in docs/layouts, and that a log and a bag have all that they show.

    pip install -r requirements.txt
    python check_layouts.py [LOG [BAG]]

LOG is a log.mcap of HOAP-2 with a push; BAG is its ROS 2 bag, a folder or its .mcap file. The checks
of the files alone need no packages. Exit code 1 for a wrong layout, 2 for an unreadable file.
"""

import json
import re
import sys
import xml.etree.ElementTree as ElementTree
from collections import Counter, defaultdict
from pathlib import Path

try:
    from mcap.exceptions import McapError
    from mcap.reader import make_reader
    from mcap_protobuf.decoder import DecoderFactory as Protobuf
    from mcap_ros2.decoder import DecoderFactory as Ros2
except ImportError:
    McapError, make_reader = OSError, None

LAYOUTS = Path(__file__).resolve().parents[2] / "docs" / "layouts"
# Foxglove's and Lichtblick's names of panel types in layout files; RosOut is the log panel.
PANELS = {"3D", "Plot", "StateTransitions", "RosOut"}
TIMES = {"receiveTime", "publishTime", "headerStamp"}
# The layout version that PlotJuggler 3 expects.
PLOTJUGGLER = "2.3.8"
WORD = r"[A-Za-z_]\w*"
PATH = re.compile(rf"(?P<topic>(/{WORD})+)(?P<fields>(\.{WORD}(\[[^\]]*\])?(\{{[^}}]*\}})?)*)")
FIELD = re.compile(rf"\.(?P<name>{WORD})(\[(?P<slice>[^\]]*)\])?(\{{(?P<filter>[^}}]*)\}})?")
FILTER = re.compile(rf'(?P<name>{WORD})=="(?P<text>[^"]*)"')


class Checks:
    """Collects errors."""

    def __init__(self):
        self.wrong = []

    def __call__(self, holds, text):
        if not holds:
            self.wrong.append(text)


def index(text, variables):
    """Array index: a number or `$variable`."""
    value = variables[text[1:]] if text.startswith("$") else int(text)
    if not isinstance(value, int) or value < 0:
        raise ValueError(f"{text} is not an index")
    return value


def parse_path(path, variables):
    """Topic of a message path and its steps: (field, (first, last) or None, (field, text) or None)."""
    match = PATH.fullmatch(path)
    if not match:
        raise ValueError("not a message path")
    steps = []
    for field in FIELD.finditer(match["fields"]):
        bounds, condition = None, None
        if field["slice"] is not None:
            first, colon, last = field["slice"].partition(":")
            low = index(first, variables) if first or not colon else 0
            high = (index(last, variables) if last else sys.maxsize) if colon else low
            bounds = (low, high)
        if field["filter"] is not None:
            filtered = FILTER.fullmatch(field["filter"])
            if not filtered:
                raise ValueError("a filter other than {name==\"text\"}")
            condition = (filtered["name"], filtered["text"])
        steps.append((field["name"], bounds, condition))
    return match["topic"], steps


def values(message, steps):
    """Values at the end of a path in a protobuf message; an unknown field raises KeyError."""
    if not steps:
        return [message]
    (name, bounds, condition), rest = steps[0], steps[1:]
    field = message.DESCRIPTOR.fields_by_name[name]
    value = getattr(message, name)
    is_array = not isinstance(value, (str, bytes)) and hasattr(value, "__getitem__")
    if is_array != (bounds is not None):
        raise ValueError(f"{name} is {'an array' if is_array else 'no array'}")
    if not is_array and field.message_type is not None and not message.HasField(name):
        return []
    items = value[bounds[0] : bounds[1] + 1] if is_array else [value]
    if condition:
        items = [item for item in items if getattr(item, condition[0]) == condition[1]]
    return [found for item in items for found in values(item, rest)]


def leaves(node, check):
    """Panels of a layout tree."""
    if isinstance(node, str):
        return [node]
    check(set(node) == {"direction", "first", "second", "splitPercentage"}, f"a split has {sorted(node)}")
    check(node.get("direction") in ("row", "column"), f"direction {node.get('direction')}")
    check(0 < node.get("splitPercentage", 0) < 100, f"splitPercentage {node.get('splitPercentage')}")
    return [panel for child in ("first", "second") for panel in leaves(node[child], check)]


def check_foxglove(layout, check):
    """Structure of the layout, without a log."""
    configs = layout["configById"]
    panels = leaves(layout["layout"], check)
    check(len(set(panels)) == len(panels), "a panel is in the tree twice")
    for panel in set(panels) ^ set(configs):
        check(False, f"{panel} is not both in the tree and in configById")
    keys = {"configById", "globalVariables", "userNodes", "playbackConfig", "layout"}
    check(set(layout) == keys, f"keys {sorted(layout)}")
    used = set()
    for panel, config in configs.items():
        kind, _, name = panel.partition("!")
        check(kind in PANELS and name, f"{panel}: unknown type of panel")
        titles = {config.get(f"{viewer}PanelTitle") for viewer in ("foxglove", "lichtblick")}
        check(len(titles) == 1 and all(titles), f"{panel}: titles {titles}")
        check(bool(config.get("paths")) == (kind in ("Plot", "StateTransitions")), f"{panel}: paths")
        series = config.get("paths", [])
        for path in series:
            check(path.get("enabled") is True and path.get("label"), f"{panel}: a series without label, or off")
            check(path.get("timestampMethod") in TIMES, f"{panel}: timestampMethod {path.get('timestampMethod')}")
            used |= set(re.findall(r"\$(\w+)", path["value"]))
            try:
                parse_path(path["value"], layout["globalVariables"])
            except (ValueError, KeyError) as error:
                check(False, f"{panel}: {path['value']}: {error}")
        check(len({path["value"] for path in series}) == len(series), f"{panel}: a series twice")
    defined = set(layout["globalVariables"])
    check(used == defined, f"variables {sorted(used)} are used, {sorted(defined)} defined")


def check_foxglove_log(layout, path, check):
    """Every topic and field of the layout is in the log, with a value in some message."""
    series = defaultdict(list)
    topics = {}
    for panel, config in layout["configById"].items():
        for entry in config.get("paths", []):
            topic, steps = parse_path(entry["value"], layout["globalVariables"])
            series[topic].append((panel, entry["value"], steps, set()))
        for topic in [*config.get("topics", {}), *filter(None, [config.get("topicToRender")])]:
            topics[topic] = panel
    frames = set()
    with open(path, "rb") as file:
        reader = make_reader(file, decoder_factories=[Protobuf()])
        summary = reader.get_summary()
        schemas = {c.topic: summary.schemas[c.schema_id].name for c in summary.channels.values()}
        run = next((m.metadata for m in reader.iter_metadata() if m.name == "run"), {})
        wanted = [t for t in [*series, "/tf"] if t in schemas]
        for _, channel, _, message in reader.iter_decoded_messages(topics=wanted):
            for panel, text, steps, types in series[channel.topic]:
                try:
                    found = values(message, steps)
                except (KeyError, ValueError, AttributeError) as error:
                    raise ValueError(f"{panel}: {text}: {error!r}") from error
                check(len(found) <= 1, f"{panel}: {text}: several values in a message")
                types.update(map(type, found))
            if channel.topic == "/tf":
                frames |= {f for t in message.transforms for f in (t.parent_frame_id, t.child_frame_id)}
    count = sum(map(len, series.values()))
    print(f"{path}: {run.get('scenario')}, {count} series, {len(topics)} other topics, {len(frames)} frames")
    for topic in [*topics, *series]:
        check(topic in schemas, f"the log has no topic {topic}")
    for panel, text, _, types in (entry for entries in series.values() for entry in entries):
        check(types, f"{panel}: {text} has no value in the log")
        drawn = {int, float} if panel.startswith("Plot!") else {int, float, bool, str}
        check(types <= drawn, f"{panel}: {text} cannot be drawn: {types}")
    for panel, config in layout["configById"].items():
        if panel.startswith("3D!"):
            check(config["followTf"] == run.get("world_frame"), f"{panel}: followTf is not the log's world frame")
            check(config["followTf"] in frames, f"{panel}: frame {config['followTf']} is not in /tf")
            for topic in (t for t, s in config["topics"].items() if s["visible"]):
                check(schemas.get(topic) == "foxglove.SceneUpdate", f"{panel}: {topic} is {schemas.get(topic)}")
        elif panel.startswith("RosOut!"):
            check(schemas.get(config["topicToRender"]) == "foxglove.Log", f"{panel}: no log")


def check_plotjuggler(root, check):
    """Structure of the layout; its curves."""
    check(root.tag == "root" and root.get("version") == PLOTJUGGLER, f"root {root.tag} {root.get('version')}")
    widgets = root.findall("tabbed_widget")
    check([w.get("parent") for w in widgets] == ["main_window"], "not one main window")
    tabs = root.findall("tabbed_widget/Tab")
    names = [tab.get("tab_name") for tab in tabs]
    check(tabs and all(names) and len(set(names)) == len(names), f"tabs {names}")
    current = root.find("tabbed_widget/currentTabIndex")
    check(current is not None and 0 <= int(current.get("index")) < len(tabs), "currentTabIndex")
    for tab in tabs:
        roots = [[child.tag for child in container] for container in tab.findall("Container")]
        check(roots == [["DockSplitter"]], f"{tab.get('tab_name')}: not one container with one splitter")
    for splitter in root.iter("DockSplitter"):
        sizes = [float(size) for size in splitter.get("sizes").split(";")]
        check(int(splitter.get("count")) == len(splitter) == len(sizes), "DockSplitter: count, sizes and children differ")
        check(abs(sum(sizes) - 1) < 1e-3, f"DockSplitter: sizes {sizes}")
        check(splitter.get("orientation") in ("|", "-"), "DockSplitter: orientation")
        check({child.tag for child in splitter} <= {"DockSplitter", "DockArea"}, "DockSplitter: unknown child")
    for area in root.iter("DockArea"):
        plot = area.find("plot")
        check(area.get("name") and plot is not None and plot.find("curve") is not None, f"DockArea {area.get('name')}")
        check(plot is not None and plot.get("mode") == "TimeSeries", f"DockArea {area.get('name')}: mode")
    curves = Counter(curve.get("name") for curve in root.iter("curve"))
    for name, times in curves.items():
        check(times == 1, f"curve {name} {times} times")
    colours = [curve.get("color") for curve in root.iter("curve")]
    check(all(re.fullmatch("#[0-9a-f]{6}", colour or "") for colour in colours), "a curve without a colour")
    return list(curves)


def curve_names(topic, schema, message):
    """Numeric curves that PlotJuggler 3 makes of a ROS 2 message. Names of headers are left out."""
    if schema == "sensor_msgs/msg/JointState":
        for quantity in ("position", "velocity", "effort"):
            yield from (f"{topic}/{name}/{quantity}" for name, _ in zip(message.name, getattr(message, quantity)))
    elif schema == "tf2_msgs/msg/TFMessage":
        for transform in message.transforms:
            prefix = f"{topic}/{transform.header.frame_id}/{transform.child_frame_id}"
            yield from (f"{prefix}/translation/{axis}" for axis in "xyz")
            yield from (f"{prefix}/rotation/{part}" for part in ("x", "y", "z", "w", "roll", "pitch", "yaw"))
    else:
        yield from fields(topic, message)


def fields(prefix, message):
    for name in message.__slots__:
        value = getattr(message, name)
        if hasattr(value, "__slots__"):
            yield from fields(f"{prefix}/{name}", value)
        elif isinstance(value, (int, float)):
            yield f"{prefix}/{name}"


def check_plotjuggler_bag(curves, bag, check):
    """PlotJuggler makes every curve of the layout from the bag's messages."""
    found, topics = set(), set()
    files = sorted(bag.glob("*.mcap")) if bag.is_dir() else [bag]
    check(files, f"{bag}: no .mcap file")
    for path in files:
        with open(path, "rb") as file:
            reader = make_reader(file, decoder_factories=[Ros2()])
            present = {c.topic for c in reader.get_summary().channels.values()}
            used = [t for t in present if any(curve.startswith(t + "/") for curve in curves)]
            topics |= set(used)
            for schema, channel, _, message in reader.iter_decoded_messages(topics=used):
                found |= set(curve_names(channel.topic, schema.name, message))
    print(f"{bag}: {len(curves)} curves of topics {sorted(topics)}")
    for curve in curves:
        check(curve in found, f"the bag has no curve {curve}")


def main(arguments):
    if len(arguments) > 2 or any(a.startswith("-") for a in arguments):
        print(__doc__, file=sys.stderr)
        return 2
    check = Checks()
    try:
        layout = json.loads((LAYOUTS / "foxglove.json").read_text(encoding="utf-8"))
        root = ElementTree.parse(LAYOUTS / "plotjuggler.xml").getroot()
        check_foxglove(layout, check)
        curves = check_plotjuggler(root, check)
        print(f"{LAYOUTS}: {len(layout['configById'])} panels, {len(curves)} curves")
        if arguments and make_reader is None:
            print("log skipped: the packages of tests/oracles/requirements.txt are not installed")
        elif arguments and not check.wrong:
            check_foxglove_log(layout, arguments[0], check)
            if arguments[1:]:
                check_plotjuggler_bag(curves, Path(arguments[1]), check)
    except (OSError, ValueError, KeyError, ElementTree.ParseError, McapError) as error:
        print(f"{type(error).__name__}: {error}", file=sys.stderr)
        return 2
    for text in dict.fromkeys(check.wrong):
        print(f"  WRONG {text}")
    return 1 if check.wrong else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

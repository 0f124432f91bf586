#!/usr/bin/env python3
"""Reads logs with Rerun: each must pass its check and be converted completely, without warnings.

    pip install rerun-sdk==0.41.0
    check_rerun.py results/*/*/log.mcap

The program is $RERUN, or `rerun` where that is installed; without it nothing is checked, and it says so. The Python standard
library is enough. Rerun draws the frames and the URDF, makes curves of the joint states, and keeps what it does not know as
fields; so every topic must be there again under its name, and every link of the URDF that is to be seen as geometry.
"""

import os
import re
import shutil
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as ElementTree
from pathlib import Path

CURVES = ["/joint_states/position", "/joint_states/velocity", "/joint_states/effort"]


def rerun(program, *arguments):
    """Runs Rerun; returns exit code, output, standard error and lines with warnings."""
    done = subprocess.run([program, *arguments], capture_output=True, text=True, timeout=600)
    said = re.sub(r"\x1b\[[0-9;]*m", "", done.stderr)
    return done.returncode, re.sub(r"\x1b\[[0-9;]*m", "", done.stdout), said, [line for line in said.splitlines() if re.search(r"\b(WARN|ERROR)\b", line)]


def rows(table):
    """Topic -> whether it is good and how many chunks it has, of the table that `mcap check` prints."""
    found = {}
    for line in table.splitlines():
        cells = re.match(r"(\S+)\s+\d+\s+(\d+)\s+(/\S+)\s+(.*)", line)
        if cells:
            found[cells[3]] = (cells[1], cells[4].strip())
    return found


def visible_links(log):
    """Links with something to be seen, of the URDF in the log: attachments of ours are not compressed."""
    text = Path(log).read_bytes()
    end = text.rfind(b"</robot>")
    begin = text.rfind(b"<robot", 0, end)
    robot = ElementTree.fromstring(text[begin : end + len(b"</robot>")])
    # Only these kinds are geometry without separate files.
    kinds = ("box", "cylinder", "sphere")
    seen = lambda link: any(link.find(f"visual/geometry/{kind}") is not None for kind in kinds)
    return {link.get("name") for link in robot.iter("link") if seen(link)}


def check(program, log, place):
    """Errors of a log, as text, and its numbers of topics and entities."""
    wrong = []
    code, table, said, _ = rerun(program, "mcap", "check", log)
    topics = rows(table)
    if code != 0 or not topics:
        return [f"check: {said.strip() or table.strip()}"], 0, 0
    wrong += [f"check, {topic}: {state} {issues}" for topic, (state, issues) in topics.items() if state != "ok" or issues != "—"]
    converted = place / "log.rrd"
    code, _, said, complaints = rerun(program, "mcap", "convert", log, "-o", converted, "--application-id", "stiction", "--timeline-type", "duration")
    wrong += [f"convert: {line}" for line in complaints]
    if code != 0 or not converted.exists():
        return [*wrong, f"convert: exit code {code}: {said.strip()}"], len(topics), 0
    entities = set(re.findall(r"^\s+(/\S+),$", said, re.MULTILINE))
    if not entities:
        wrong.append("convert: it does not say what it found")
    expected = set(topics) | (set(CURVES) if "/joint_states" in topics else set())
    wrong += [f"not converted: {name}" for name in sorted(expected - entities)]
    if "/robot_description" in topics:
        drawn = {name.split("/")[-2] for name in entities if "/visual_geometries/" in name}
        wrong += [f"not drawn: link {name}" for name in sorted(visible_links(log) - drawn)]
    code, output, errors, _ = rerun(program, "rrd", "verify", converted)
    if code != 0 or "verified without error" not in output + errors:
        wrong.append(f"verify: {(output + errors).strip()}")
    return wrong, len(topics), len(entities)


def main(logs):
    if not logs:
        print(__doc__, file=sys.stderr)
        return 2
    program = shutil.which(os.environ.get("RERUN", "rerun"))
    if program is None:
        print("skipped: no rerun")
        return 0
    # Without this it sends usage data.
    home = tempfile.mkdtemp()
    os.environ.update(HOME=home, XDG_CONFIG_HOME=home, XDG_DATA_HOME=home, XDG_CACHE_HOME=home)
    rerun(program, "analytics", "disable")
    failed = False
    for log in logs:
        with tempfile.TemporaryDirectory() as place:
            wrong, topics, entities = check(program, log, Path(place))
        failed |= bool(wrong)
        print(f"{log}: {'; '.join(wrong) if wrong else f'good, {topics} topics, {entities} entities'}")
    shutil.rmtree(home, ignore_errors=True)
    return int(failed)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

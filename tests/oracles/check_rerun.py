#!/usr/bin/env python3
"""Reads logs with Rerun: each must pass its check and be converted completely, without warnings.

    pip install rerun-sdk==0.41.0
    check_rerun.py results/*/*/log.mcap

The program is $RERUN, or `rerun` if it is installed; without it the script prints that it checks
nothing. The Python standard library is enough. Rerun draws the frames and the URDF, converts the
joint states to curves, and stores unknown messages as fields. Every topic must therefore be present
under its name, and every visible link of the URDF must be present as geometry.
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
    stderr_text = re.sub(r"\x1b\[[0-9;]*m", "", done.stderr)
    return done.returncode, re.sub(r"\x1b\[[0-9;]*m", "", done.stdout), stderr_text, [line for line in stderr_text.splitlines() if re.search(r"\b(WARN|ERROR)\b", line)]


def rows(table):
    """Topic -> whether it is good and its number of chunks, from the table printed by `mcap check`."""
    found = {}
    for line in table.splitlines():
        cells = re.match(r"(\S+)\s+\d+\s+(\d+)\s+(/\S+)\s+(.*)", line)
        if cells:
            found[cells[3]] = (cells[1], cells[4].strip())
    return found


def visible_links(log):
    """Links with visible geometry, of the URDF in the log: our attachments are not compressed."""
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
    code, table, stderr_text, _ = rerun(program, "mcap", "check", log)
    topics = rows(table)
    if code != 0 or not topics:
        return [f"check: {stderr_text.strip() or table.strip()}"], 0, 0
    wrong += [f"check, {topic}: {state} {issues}" for topic, (state, issues) in topics.items() if state != "ok" or issues != "—"]
    converted = place / "log.rrd"
    code, _, stderr_text, complaints = rerun(program, "mcap", "convert", log, "-o", converted, "--application-id", "stiction", "--timeline-type", "duration")
    wrong += [f"convert: {line}" for line in complaints]
    if code != 0 or not converted.exists():
        return [*wrong, f"convert: exit code {code}: {stderr_text.strip()}"], len(topics), 0
    entities = set(re.findall(r"^\s+(/\S+),$", stderr_text, re.MULTILINE))
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
    # Without this option Rerun sends usage data.
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

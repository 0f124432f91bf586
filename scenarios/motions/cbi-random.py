#!/usr/bin/env python3
"""Writes cbi-random.csv: random postures for all joints of CB-i, 1 to 1.4 s apart for 60 s.

Each joint is drawn uniformly from the middle 65 % of its range, so that the minimum-jerk curve through the postures stays
within the range. The motion begins and ends at home. The script checks only the ranges, so much of the
motion passes through the robot's own body.
"""

import math
import pathlib
import random
import re
import tomllib

HERE = pathlib.Path(__file__).parent
ROBOT = HERE.parent.parent / "robots/cbi"


def main():
    urdf = (ROBOT / "cbi.urdf").read_text()
    joints = re.findall(r'<joint name="([^"]+)" type="revolute">.*?lower="([^"]+)" upper="([^"]+)".*?</joint>', urdf, re.S)
    home = tomllib.loads((ROBOT / "cbi-hung.toml").read_text())["home"]
    at_home = [math.radians(float(home[name].split()[0])) if name in home else 0.0 for name, _, _ in joints]
    draw = random.Random(2008)
    rows, time = [(0.0, at_home)], 0.0
    while True:
        time = round(time + draw.uniform(1.0, 1.4), 2)
        if time > 58.5:
            break
        posture = []
        for _, lower, upper in joints:
            middle, half = (float(lower) + float(upper)) / 2, (float(upper) - float(lower)) / 2
            posture.append(middle + 0.65 * half * draw.uniform(-1, 1))
        rows.append((time, posture))
    rows.append((60.0, at_home))
    lines = ["time," + ",".join(name for name, _, _ in joints)]
    lines += [f"{time:g}," + ",".join(f"{q:.4f}" for q in posture) for time, posture in rows]
    (HERE / "cbi-random.csv").write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()

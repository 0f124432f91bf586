#!/usr/bin/env python3
"""Prints the preview gains recorded in tests/task/gait.rs, by SciPy's Riccati solver ([Kajita 2003], equations
11 to 15). Run by hand, in an environment with SciPy (1.17.1 for the recorded values):

    python tests/oracles/make_preview.py
"""

import numpy as np
from scipy.linalg import solve_discrete_are


def gains(height, gravity, period, count, weight=1e-6):
    """(G_i, G_x), the first `count` of G_p, and P."""
    a = np.array([[1, period, period**2 / 2], [0, 1, period], [0, 0, 1]])
    b = np.array([[period**3 / 6], [period**2 / 2], [period]])
    c = np.array([[1, 0, -height / gravity]])
    wide = np.zeros((4, 4))
    wide[0, 0] = 1
    wide[0, 1:] = c @ a
    wide[1:, 1:] = a
    column = np.vstack([c @ b, b])
    p = solve_discrete_are(wide, column, np.diag([1.0, 0, 0, 0]), np.array([[weight]]))
    scale = weight + (column.T @ p @ column)[0, 0]
    gain = (column.T @ p @ wide) / scale
    closed = wide - column @ gain
    seen = -p @ np.array([[1.0], [0], [0], [0]])
    ahead = []
    for _ in range(count):
        ahead.append((column.T @ seen)[0, 0] / scale)
        seen = closed.T @ seen
    return gain[0], ahead, p


for height, period in ((0.26, 0.005), (0.814, 0.005), (0.9, 0.02)):
    gain, ahead, p = gains(height, 9.81, period, 320)
    print(height, period, [float(x) for x in gain], [float(ahead[i]) for i in (0, 1, 9, 99)], float(p[1, 1]))

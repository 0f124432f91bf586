#!/usr/bin/env python3
"""Tails and quantiles of Student's, the chi-square and the F distribution, for distributions.rs.

    python3 tests/oracles/make_distributions.py > tests/oracles/distributions.json

Written with SciPy 1.17.1.
"""

import json

from scipy import stats

CONFIDENCES = [0.5, 0.9, 0.95, 0.99, 0.999]
FREEDOMS = [1, 2, 3, 7, 20, 97, 1000, 20_000, 1_000_000]

student = [(c, n, stats.t.isf((1 - c) / 2, n)) for c in CONFIDENCES for n in FREEDOMS]
normal = [(c, stats.norm.isf((1 - c) / 2)) for c in CONFIDENCES]
chi_square = [(x * n, n, stats.chi2.sf(x * n, n)) for n in FREEDOMS for x in (0.5, 0.97, 1.0, 1.01, 1.2, 3.0)]
f = [
    (x, a, b, stats.f.sf(x, a, b))
    for a, b in [(1, 1), (2, 9), (9, 2), (40, 97), (300, 1000), (20_000, 997), (50_000, 100_000)]
    for x in (0.5, 0.98, 1.0, 1.02, 1.3, 4.0)
]
# Where a tail is below 1e-250, its logarithm is large and the printed digits are few.
chi_square = [row for row in chi_square if row[-1] > 1e-250]
f = [row for row in f if row[-1] > 1e-250]
print(json.dumps({"student": student, "normal": normal, "chi_square": chi_square, "f": f}, indent=1))

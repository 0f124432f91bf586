#!/usr/bin/env python3
"""Two-sided probabilities of the rank test of a trend, for trend.rs.

    python3 tests/oracles/make_trend.py > tests/oracles/trend.json

Written with SciPy 1.17.1. Without equal values they are those of `scipy.stats.kendalltau` of the values over
their positions, by its exact method. SciPy has none for equal values: there all distinct orders are counted.
"""

import json
import random
from fractions import Fraction
from itertools import permutations

from scipy.stats import kendalltau

DIFFERENT = [2, 3, 4, 5, 6, 8, 11, 20, 40, 60]
EQUAL = [[1, 1, 2], [1, 2, 2, 3], [1, 1, 1, 2, 2], [1, 1, 2, 2, 3, 3], [0, 0, 0, 0, 0, 0, 1], [1, 2, 3, 3, 4, 5, 6, 6]]


def size(values):
    return abs(sum((b > a) - (b < a) for i, a in enumerate(values) for b in values[i + 1 :]))


def by_counting(values):
    orders = set(permutations(values))
    return float(Fraction(sum(size(order) >= size(values) for order in orders), len(orders)))


def orders_of(values, generator):
    yield sorted(values)
    for swaps in (1, 3):
        order = sorted(values)
        for _ in range(swaps):
            at = generator.randrange(len(order) - 1)
            order[at], order[at + 1] = order[at + 1], order[at]
        yield order
    yield generator.sample(values, len(values))


generator = random.Random(28)
cases = []
for n in DIFFERENT:
    for order in orders_of(range(n), generator):
        p = kendalltau(range(n), order, method="exact").pvalue
        cases.append([order, float(p)])
for values in EQUAL:
    for order in orders_of(values, generator):
        cases.append([order, by_counting(order)])
print(json.dumps(cases).replace("]], ", "]],\n").replace("], [[", "],\n[["))

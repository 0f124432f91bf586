#!/usr/bin/env python3
"""Binomial tails, Clopper-Pearson bounds and means of likelihood ratios, for binomial.rs.

    python3 tests/oracles/make_binomial.py > tests/oracles/binomial.json

Written with SciPy 1.17.1 and mpmath 1.4.1. Tails are sums in rational arithmetic where the numbers are
small and sums of 60 digits elsewhere; bounds are those of
`scipy.stats.binomtest`; means are integrals by mpmath's quadrature, not sums of binomial tails.
"""

import json
from fractions import Fraction
from math import comb

import mpmath
from scipy.stats import binomtest

mpmath.mp.dps = 60

SMALL = [(1, 1, 0.5), (10, 3, 0.1), (29, 29, 0.9), (43, 40, 0.9), (200, 180, 0.95), (200, 199, 0.99), (300, 2, 0.01)]
LARGE = [(10_000, 9_950, 0.99), (100_000, 50_500, 0.5), (1_000_000, 990_300, 0.99), (1_000_000, 9_700, 0.01)]
COUNTS = [(1, 0), (1, 1), (7, 3), (29, 28), (43, 43), (200, 188), (200, 1), (2_000, 1_985), (20_000, 9_000)]
MEANS = [(1, 1, 0.5), (10, 9, 0.7), (43, 43, 0.9), (42, 42, 0.9), (98, 81, 0.7), (200, 150, 0.9), (500, 499, 0.99)]


def upper_tail(n, k, p):
    if n <= 300:
        p = Fraction(p)
        return float(sum(comb(n, j) * p**j * (1 - p) ** (n - j) for j in range(k, n + 1)))
    p = mpmath.mpf(p)
    if k <= n * p:
        return float(1 - mpmath.mpf(lower_sum(n, k - 1, p)))
    term = total = probability(n, k, p)
    for j in range(k, n):
        term *= (n - j) * p / ((j + 1) * (1 - p))
        total += term
        if term < total * mpmath.mpf(10) ** -50:
            break
    return float(total)


def lower_sum(n, k, p):
    term = total = probability(n, k, p)
    for j in range(k, 0, -1):
        term *= j * (1 - p) / ((n - j + 1) * p)
        total += term
        if term < total * mpmath.mpf(10) ** -50:
            break
    return total


def lower_tail(n, k, p):
    if n <= 300:
        p = Fraction(p)
        return float(sum(comb(n, j) * p**j * (1 - p) ** (n - j) for j in range(0, k + 1)))
    p = mpmath.mpf(p)
    return float(lower_sum(n, k, p)) if k < n * p else float(1 - mpmath.mpf(upper_tail(n, k + 1, p)))


def probability(n, k, p):
    ways = mpmath.loggamma(n + 1) - mpmath.loggamma(k + 1) - mpmath.loggamma(n - k + 1)
    return mpmath.exp(ways + k * mpmath.log(p) + (n - k) * mpmath.log(1 - p))


def bounds(n, k, confidence):
    def of(side):
        return binomtest(k, n, alternative=side).proportion_ci(confidence, "exact")

    return [float(of("greater").low), float(of("less").high)]


def mean(n, k, q, low, high):
    q = mpmath.mpf(q)

    def ratio(p):
        return (p / q) ** k * ((1 - p) / (1 - q)) ** (n - k)

    peak = mpmath.mpf(k) / n
    points = sorted({low, high} | ({peak} if low < peak < high else set()))
    return mpmath.quad(ratio, mpmath.linspace(points[0], points[-1], 40) if len(points) == 2 else
                       mpmath.linspace(points[0], points[1], 40) + mpmath.linspace(points[1], points[2], 40)[1:]) / (high - low)


print(json.dumps({
    "tails": [[n, k, p, upper_tail(n, k, p), lower_tail(n, k, p)] for n, k, p in SMALL + LARGE],
    "bounds": [[n, k, c, *bounds(n, k, c)] for n, k in COUNTS for c in (0.9, 0.95, 0.999)],
    "means": [
        [n, k, q, float(mpmath.log(mean(n, k, q, mpmath.mpf(q), mpmath.mpf(1)))),
         float(mpmath.log(mean(n, k, q, mpmath.mpf(0), mpmath.mpf(q))))]
        for n, k, q in MEANS
    ],
}, indent=1))

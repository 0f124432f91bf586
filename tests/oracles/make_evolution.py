"""Two generations of covariance matrix adaptation, for the test in format/src/search/evolution.rs.

The equations and constants of Hansen, The CMA Evolution Strategy: A Tutorial (2016), with positive weights
alone, and SciPy's matrix square root in place of axes. Made with NumPy 2.4.6 and SciPy 1.17.1.
"""

import math

import numpy as np
from scipy.linalg import sqrtm

n, population = 2, 4
mu = population // 2
weights = np.array([math.log((population + 1) / 2) - math.log(i) for i in range(1, mu + 1)])
weights /= weights.sum()
mu_eff = 1 / (weights**2).sum()
c_sigma = (mu_eff + 2) / (n + mu_eff + 5)
d_sigma = 1 + 2 * max(0, math.sqrt((mu_eff - 1) / (n + 1)) - 1) + c_sigma
c_c = (4 + mu_eff / n) / (n + 4 + 2 * mu_eff / n)
c_1 = 2 / ((n + 1.3) ** 2 + mu_eff)
c_mu = min(1 - c_1, 2 * (0.25 + mu_eff + 1 / mu_eff - 2) / ((n + 2) ** 2 + mu_eff))
expected = math.sqrt(n) * (1 - 1 / (4 * n) + 1 / (21 * n**2))

mean, sigma, covariance = np.array([0.5, 0.25]), 0.3, np.eye(n)
path_sigma, path_c = np.zeros(n), np.zeros(n)
generations = [[(1.0, 0.5), (-0.25, 1.0)], [(3.0, 2.5), (2.0, 3.5)]]
for number, generation in enumerate(generations, 1):
    y = np.array(generation)
    y_w = weights @ y
    mean = mean + sigma * y_w
    path_sigma = (1 - c_sigma) * path_sigma + math.sqrt(c_sigma * (2 - c_sigma) * mu_eff) * np.linalg.solve(
        sqrtm(covariance), y_w
    )
    length = np.linalg.norm(path_sigma)
    settled = math.sqrt(1 - (1 - c_sigma) ** (2 * number))
    h = 1.0 if length / settled < (1.4 + 2 / (n + 1)) * expected else 0.0
    path_c = (1 - c_c) * path_c + h * math.sqrt(c_c * (2 - c_c) * mu_eff) * y_w
    covariance = (
        (1 - c_1 - c_mu + (1 - h) * c_1 * c_c * (2 - c_c)) * covariance
        + c_1 * np.outer(path_c, path_c)
        + c_mu * sum(w * np.outer(step, step) for w, step in zip(weights, y))
    )
    sigma *= math.exp(min(1, c_sigma / d_sigma * (length / expected - 1)))
    values = [*mean, sigma, covariance[0, 0], covariance[0, 1], covariance[1, 1]]
    print("h", h, [float(f"{value:.15g}") for value in values])

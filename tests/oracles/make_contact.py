#!/usr/bin/env python3
"""Writes contact_<robot>.json: contact problems of real runs and their solutions by Pinocchio's ADMM solver.

Run by hand, in an environment with `pin` (4.1 or newer) and a built `runner`:

    python tests/oracles/make_contact.py target/release/runner [HARD.json]

The runs below use `--dump-problems=all`. Each problem (docs/contact.md, section 17) becomes the vertex problem: with J the map from sole motions to vertex motions, G = J W J^T and g = J b + c,

    a = G l + g      N >= 0, a_n >= 0, N a_n = 0;   |t| <= mu N, and t = -mu N a_t / |a_t| where a_t is not zero,

l = (t, N) stacked over the vertices that may touch, c the centripetal term less the target motion.
`ADMMConstraintSolver` solves this (De Saxce's form of Coulomb's law). Sole wrenches are J^T l.

Which problems are comparable. Coulomb's law in these variables is the law of an impact and of a time step (a: velocities
after), and of a sole that rests (a: accelerations; friction opposes the acceleration that sets in), with one coefficient.
Excluded, with counts of the reasons: vertices that slide at the acceleration level (their friction is given by the velocity,
not by a), two coefficients, forced states, vertices within the tolerance but not on the floor (the method may let them
approach), and solutions in which a sole that is not parallel to the floor presses on it with more than one vertex. Only a
time step that closes different gaps has those; the method then leaves the second-order sideways motion of the vertices
(tilting rate times difference in height) out of sticking and of slip directions.

Where the solution is unique. Only resultant wrenches are compared, and only if
 1. every vertex is clearly open, sticking or sliding: quantities that should be positive are, by 1e-6 of their scale;
 2. the conditions linearised about the solution leave no direction that changes a wrench: the null space of
        open: dl = 0;  sticking: (G dl) = 0;  sliding: (G dl)_n = 0, dt + mu dN u + mu N (1 - u u^T) (G dl)_t / |a_t| = 0
    (u = a_t / |a_t|) is found by SVD, and J^T must map it to zero. A sole that slides and turns on four vertices fails
    here: how they share the load changes its friction;
 3. four random starting points lead to the same wrenches.

The solver's own status is not trusted: with bad inputs it reports success with zero impulses. A solution is accepted only if
the conditions above, evaluated here with numpy alone, hold to 1e-12 of their scales.

The test does not compare problems for which the runner found no valid state. A second argument names a file for them,
comparable or not, with the reason for leaving them out.
"""

import collections
import json
import platform
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import pinocchio as pin

HERE = Path(__file__).resolve().parent
ROBOTS = HERE.parent.parent / "robots"
TOUCHING = 1e-10  # m, the height at which the method counts a vertex as touching
SOLVED = 1e-12  # of the scales of force and motion
CLEAR = 1e-6
SAME = 1e-9
STARTS = 4
# Greatest number of problems of a run, and of those with the same states.
PER_RUN, PER_KIND = 12, 2

TIGHT = "contact = { distance_tolerance = 1e-9, velocity_tolerance = 1e-8, acceleration_tolerance = 1e-8 }\n"
TRIPOD = '[{ name = "bottom", link = "block", polygon = [[0.1, 0.02, -0.05], [-0.08, 0.1, -0.05], [-0.05, -0.09, -0.05]] }]'
TUMBLE = "position = [0, 0, 0.12], rpy = [0.3, 0.2, 0.1], linear_velocity = [1, 0.4, 0], angular_velocity = [0, 0, 3]"


def semi(step):
    return f'integrator = {{ method = "semi-implicit", step = {step} }}\n'


def push(link, point, force, duration, profile):
    return (
        f'[[force]]\ntype = "push"\nlink = "{link}"\npoint = {point}\nforce = {force}\n'
        f'start = 0.0\nduration = {duration}\nprofile = "{profile}"\n'
    )


# (run, robot, base, soles, duration, friction, settings, tables)
RUNS = [
    ("tumble", "block", TUMBLE, None, 0.6, 0.4, "", ""),
    ("tumble-steps", "block", TUMBLE, None, 0.4, 0.4, semi(5e-3), ""),
    ("slide-steps", "block", "linear_velocity = [0.6, 0.2, 0]", None, 0.4, 0.3, semi(2e-2), ""),
    ("spin-steps", "block", "linear_velocity = [0.6, 0.2, 0], angular_velocity = [0, 0, 4]", None, 0.3, 0.3, semi(1e-2), ""),
    ("pull-off", "block", "", None, 0.6, 0.5, "", push("block", [0, 0, -0.03], [6, 3, 0], 0.5, "ramp")),
    ("tripod-spin-steps", "block", "linear_velocity = [0.4, 0.2, 0], angular_velocity = [0, 0, 5]", TRIPOD, 0.4, 0.3, semi(1e-2), ""),
    ("tripod-tumble", "block", TUMBLE, TRIPOD, 0.6, 0.4, "", ""),
    ("tripod-twist", "block", "", TRIPOD, 0.6, 0.3, "", push("block", [0.03, 0.08, -0.04], [5, -3, 0], 0.5, "ramp")),
    ("tripod-twist-steps", "block", "", TRIPOD, 0.6, 0.3, semi(1e-2), push("block", [0.03, 0.08, -0.04], [8, -3, 0], 0.3, "ramp")),
    ("land", "hoap2", "position = [0, 0, 0.33], rpy = [0.1, 0.15, 0.2], linear_velocity = [0.2, 0.1, 0]", None, 0.4, 0.5, "", ""),
    ("land-flat", "hoap2", "position = [0, 0, 0.304]", None, 0.3, 0.6, "", ""),
    ("land-steps", "hoap2", "position = [0, 0, 0.31], rpy = [0.05, 0.08, 0.2], linear_velocity = [0.3, 0.1, 0]", None, 0.25, 0.3, semi(2e-3), ""),
    ("slide-steps", "hoap2", "linear_velocity = [0.5, 0.1, 0]", None, 0.2, 0.2, semi(4e-3), ""),
    ("pushed", "hoap2", "", None, 0.5, 0.3, "", push("torso", [0, 0, 0.05], [15, 8, 0], 0.3, "half-sine")),
    ("pushed-steps", "hoap2", "", None, 0.35, 0.3, semi(4e-3), push("torso", [0, 0, 0.05], [40, 20, 0], 0.3, "half-sine")),
]


def scenario(robot, base, soles, duration, friction, settings, tables):
    robot = f'{{ model = "{ROBOTS / robot / robot}.toml"' + (f", base = {{ {base} }}" if base else "")
    robot += (f", soles = {soles}" if soles else "") + " }"
    head = f"duration = {duration}\nrobot = {robot}\nfloor = {{ friction = {friction} }}\nlog = {{ rate = 0.0 }}\n"
    return head + settings + TIGHT + tables


def run(runner, folder):
    """Problems of all runs: (robot, run, number, selection), in order."""
    for name, robot, *rest in RUNS:
        path = folder / f"{robot}-{name}.toml"
        path.write_text(scenario(robot, *rest))
        command = [runner, path, "-o", folder / "results", "--dump-problems=all"]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        for file in sorted((folder / "results" / path.stem).glob("*/problems/*.json")):
            problem = json.loads(file.read_text())
            yield robot, name, problem["number"], problem["selection"]


def cross(r):
    x, y, z = r
    return np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])


class Left(Exception):
    """Why a problem is not comparable."""


class Vertices:
    """The vertex problem of a selection."""

    def __init__(self, selection):
        soles, tolerances = selection["soles"], selection["tolerances"]
        n = 6 * len(soles)
        self.W, self.b = np.reshape(selection["W"], (n, n)), np.array(selection["b"])
        rows, c, self.mu, self.positions = [], [], [], []
        for s, sole in enumerate(soles):
            if sole["forced"] is not None:
                raise Left("a forced state")
            touching = [v for v in sole["vertices"] if self.touches(v, selection["level"], tolerances)]
            for v in touching:
                x, y, _ = v["r_m"]
                j = np.zeros((3, n))
                j[:, 6 * s : 6 * s + 3], j[:, 6 * s + 3 : 6 * s + 6] = np.eye(3), -cross(v["r_m"])
                rows.append(j)
                lift, tilt_x, tilt_y = sole["target"]
                c.append(np.array(v["bias"]) - [0, 0, lift + tilt_x * y - tilt_y * x])
                self.mu.append(v["mu_s"])
                self.positions.append((s, v["r_m"][2]))
        if not rows:
            raise Left("nothing touches")
        self.J = np.vstack(rows)
        G = self.J @ self.W @ self.J.T
        self.G, self.g = (G + G.T) / 2, self.J @ self.b + np.concatenate(c)

    @staticmethod
    def touches(v, level, tolerances):
        if v["mu_s"] != v["mu_k"]:
            raise Left("two friction coefficients")
        if level == "velocity":
            if v["near"] and v["height_m"] > TOUCHING:
                raise Left("a vertex just above the floor")
            return v["near"]
        if v["height_m"] > tolerances["distance_m"]:
            return False
        if v["moving"]:
            raise Left("sliding at the acceleration level")
        if abs(v["velocity_m_per_s"][2]) > tolerances["rest_m_per_s"]:
            raise Left("a vertex that moves up or down at the acceleration level")
        return True

    def split(self, l):
        """Per vertex: mu, t, N, a_t, a_n."""
        a = self.G @ l + self.g
        return [(m, l[3 * i : 3 * i + 2], l[3 * i + 2], a[3 * i : 3 * i + 2], a[3 * i + 2]) for i, m in enumerate(self.mu)]

    def scales(self, l):
        """Of forces and of motions."""
        return max(np.abs(l).max(), 1e-300), max(np.abs(self.g).max(), 1e-300)

    def residual(self, l):
        """Worst violation of the conditions in the module's text, in units of the scales."""
        f, m = self.scales(l)
        worst = 0.0
        for mu, t, n, at, an in self.split(l):
            tn, size = np.linalg.norm(t), np.linalg.norm(at)
            worst = max(worst, -n / f, -an / m, abs(n * an) / (f * m), (tn - mu * n) / f)
            # The force itself, not only the power, where vertices clearly slide.
            worst = max(worst, abs(mu * n * size + t @ at) / (f * m))
            if size > 1e-9 * m:
                worst = max(worst, np.linalg.norm(t + mu * n * at / size) / f * min(1.0, size / m))
        return worst

    def tilted(self, l):
        """Whether a sole presses with vertices of different heights."""
        pressed = collections.defaultdict(list)
        for (sole, height), n in zip(self.positions, l[2::3]):
            if n > CLEAR * np.abs(l).max():
                pressed[sole].append(height)
        return any(max(heights) - min(heights) > TOUCHING for heights in pressed.values())

    def unique(self, l):
        """The reason why the wrenches may not be unique near `l`, or None. Points 1 and 2."""
        f, m = self.scales(l)
        size = len(self.g)
        conditions = np.zeros((size, size))
        for i, (mu, t, n, at, an) in enumerate(self.split(l)):
            rows, speed = slice(3 * i, 3 * i + 3), np.linalg.norm(at)
            if an > CLEAR * m:
                conditions[rows, rows] = np.eye(3) * m / f
            elif n > CLEAR * f and speed > CLEAR * m:
                u = at / speed
                friction = np.zeros((2, size))
                friction[:, 3 * i : 3 * i + 2] = np.eye(2)
                friction[:, 3 * i + 2] = mu * u
                friction += mu * n * (np.eye(2) - np.outer(u, u)) @ self.G[3 * i : 3 * i + 2] / speed
                conditions[3 * i : 3 * i + 2] = friction * m / f
                conditions[3 * i + 2] = self.G[3 * i + 2]
            elif n > CLEAR * f and mu * n - np.linalg.norm(t) > CLEAR * f:
                conditions[rows] = self.G[rows]
            else:
                return "a vertex at the border of two states"
        _, values, vectors = np.linalg.svd(conditions)
        for value, direction in zip(values, vectors):
            wrench = self.J.T @ direction
            if value < 1e-9 * values[0] and np.linalg.norm(wrench) > 1e-6:
                return "wrenches not unique (linearised)"
        return None

    def admm(self, start):
        """Pinocchio's solution from a starting point, in scaled variables of size about one."""
        weight, size = np.trace(self.G) / len(self.g), np.abs(self.g).max()
        models, datas = pin.StdVec_ConstraintModel(), pin.StdVec_ConstraintData()
        empty, here = pin.Model(), pin.SE3.Identity()
        for mu in self.mu:
            point = pin.PointContactConstraintModel(empty, 0, here, 0, here)
            point.setFriction(mu)
            point.setCompliance(np.zeros(3))
            model = pin.ConstraintModel(point)
            models.append(model)
            datas.append(model.createData())
        settings = pin.ADMMSolverSettings()
        settings.solve_ncp = True
        settings.max_iterations = 20000
        settings.absolute_feasibility_tol = settings.absolute_complementarity_tol = 1e-13
        settings.relative_feasibility_tol = settings.relative_complementarity_tol = 0
        result = pin.ADMMSolverResult()
        if start is not None:
            result.resize(len(self.g))
            result.setConstraintImpulseGuess(start)
        delassus = pin.DelassusOperatorDense(self.G / weight)
        pin.ADMMConstraintSolver().solve(delassus, self.g / size, models, datas, settings, result)
        return np.array(result.retrieveConstraintImpulses()) * size / weight, result.iterations


def solve(problem, random):
    """Wrenches, the worst residual and the number of iterations."""
    l, iterations = problem.admm(None)
    residual = problem.residual(l)
    if not residual <= SOLVED:
        raise Left("not solved to 1e-12 by ADMM")
    if problem.tilted(l):
        raise Left("a tilted sole that presses with several vertices")
    if why := problem.unique(l):
        raise Left(why)
    wrench = problem.J.T @ l
    for _ in range(STARTS):
        other, _ = problem.admm(random.normal(size=len(l)) * 3)
        if problem.residual(other) <= SOLVED and np.abs(problem.J.T @ other - wrench).max() > SAME * np.abs(wrench).max():
            raise Left("wrenches not unique (another start)")
    return wrench, residual, iterations


def unsolved(robot, name, number, selection, random):
    """ADMM's result for a problem without a valid state in the runner."""
    entry = {"robot": robot, "run": name, "number": number, "why": None, "wrench": None, "residual": None}
    try:
        problem = Vertices(selection)
        l, _ = problem.admm(None)
        entry.update(wrench=problem.J.T @ l, residual=problem.residual(l))
        solve(problem, random)
    except Left as why:
        entry["why"] = str(why)
    return {**entry, "selection": selection}


def numbers(x):
    """Whole numbers as integers, which are shorter and read back the same."""
    if isinstance(x, dict):
        return {k: numbers(y) for k, y in x.items()}
    if isinstance(x, (list, np.ndarray)):
        return [numbers(y) for y in x]
    if isinstance(x, (bool, str, int)) or x is None:
        return x
    x = float(x)
    return int(x) if x == int(x) and abs(x) < 1e9 else x


def main():
    if len(sys.argv) not in (2, 3):
        sys.exit(__doc__)
    random = np.random.default_rng(1)
    selected, hard, left = collections.defaultdict(list), [], collections.Counter()
    taken, kinds, met = collections.Counter(), collections.Counter(), 0
    with tempfile.TemporaryDirectory() as folder:
        for robot, name, number, selection in run(Path(sys.argv[1]).resolve(), Path(folder)):
            met += 1
            states = tuple(selection["answer"]["states"])
            kind = (robot, name, selection["level"], states)
            if not selection["answer"]["consistent"]:
                left["no valid state found by this program"] += 1
                hard.append(unsolved(robot, name, number, selection, random))
                continue
            if taken[robot, name] >= PER_RUN or kinds[kind] >= PER_KIND:
                left["enough of that kind"] += 1
                continue
            try:
                problem = Vertices(selection)
                wrench, residual, iterations = solve(problem, random)
            except Left as why:
                left[str(why)] += 1
                continue
            entry = {
                "run": name,
                "number": number,
                "iterations": iterations,
                "residual": residual,
                "wrench": wrench,
                "selection": selection,
            }
            taken[robot, name] += 1
            kinds[kind] += 1
            selected[robot].append(entry)
            ours = np.array(selection["answer"]["wrench"])
            miss = np.abs(wrench - ours).max() / np.abs(wrench).max() if wrench.any() else np.abs(ours).max()
            print(f"{robot} {name} {number:3} {selection['level'][:3]} {miss:.1e} {iterations:5} {' '.join(states)}")
    versions = {"pin": pin.__version__, "numpy": np.__version__, "python": platform.python_version()}
    for robot, entries in selected.items():
        path = HERE / f"contact_{robot}.json"
        head = f'"robot":"{robot}",\n"versions":{json.dumps(versions)},\n"problems":[\n'
        body = ",\n".join(json.dumps(numbers(e), separators=(",", ":")) for e in entries)
        path.write_text("{" + head + body + "\n]}\n")
        print(f"{path.name}: {len(entries)} problems, {path.stat().st_size} bytes")
    print(f"{met} problems met, left out:", dict(left))
    if len(sys.argv) == 3:
        Path(sys.argv[2]).write_text(json.dumps(numbers(hard)))


if __name__ == "__main__":
    main()

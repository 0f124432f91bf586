"""Exports contact problems of `runner run --dump-problems` as files of FCLIB, and checks these files.

    python -m stiction_engines.fclib PROBLEMS... -o FOLDER [--check]

PROBLEMS are files `problems/0001.json` (docs/contact.md, section 17) or folders with such files. A problem
becomes `FOLDER/<scenario>-<key>-<number>.hdf5`, in the form of `friction_problem`, which is that of FCLIB's
`src/fclib.h` (github.com/FrictionalContactLibrary/fclib). The components of a contact are along z, x, y of
the axes of its polygon. A positive u_n separates, a positive r_n presses. With J from motions of soles to
motions of vertices, W = J W_s J^T and q = J b + bias - target. W_s, b, bias and target are those of the
problem file.

The layout is that of `write_matrix`, `write_local_vectors`, `write_problem_info` and `write_solution` in
`fclib.h`. Integers have 32 bits, reals 64, vectors one dimension, strings a fixed length and a final zero:

    fclib_local/spacedim             3
    fclib_local/W/m, n, nzmax, nz    rows, columns, entries, and -1: compressed columns
    fclib_local/W/p, i, x            column pointers, row indices, values
    fclib_local/vectors/q, mu        q by contact, one coefficient for each contact
    fclib_local/info/title, description, math_info
    solution/u, r                    the answer of the runner, where it satisfies the conditions
    guesses/number_of_guesses        1, if there is no solution:
    guesses/1/u, r                   the answer that does not satisfy them

Velocity-level problems (impacts, fixed steps) have velocities u and impulses r. Acceleration-level problems
have accelerations u and forces r. They have FCLIB's form where all touching vertices rest, as friction then
opposes the acceleration that begins. `REASONS` lists what has no such form and is refused.

An answer is no solution if the runner found no valid state, or if its forces on single vertices miss the
conditions. The latter happens where only the wrench of an edge or face is within the friction cone: the
runner needs no more.
"""

import argparse
import collections
import json
import os
import sys
from pathlib import Path

import h5py
import numpy
import scipy.sparse

from .friction_problem import SOLVERS, Problem, residuals

#: Height at which the runner counts a vertex as touching, m.
TOUCHING = 1e-10
#: Residual, as in `friction_problem.residuals`, up to which an answer is a solution.
SOLVED = 1e-8
#: Difference of u, relative to its scale, above which two solutions are not the same.
SAME = 1e-6

FORCED = "an imposed state (contact.forced)"
NOTHING = "no vertex touches"
SLIDING = "a sliding vertex at the acceleration level: its velocity, not u, gives the direction of friction"
NORMAL = "a touching vertex that moves along the normal at the acceleration level"
ABOVE = "a vertex above the floor that a step may clamp: the gap is part of the conditions"
COEFFICIENTS = "different static and kinetic coefficients (to avoid: one number for every `friction`)"
OUTSIDE = "an answer that loads a vertex which does not touch"
TILTED = "a tilted sole on several vertices: the answer neglects their second-order sideways motion"
NULL = "a number that is not finite"
#: Why problems are refused. Of several reasons the first is reported.
REASONS = [NULL, FORCED, SLIDING, NORMAL, ABOVE, COEFFICIENTS, NOTHING, OUTSIDE, TILTED]


class Refused(Exception):
    """The problem does not have FCLIB's form; the text is the reason."""


class BadFile(Exception):
    """A file cannot be read; the text names the file and the error."""


# Conversion of a problem of the runner


def cross(r):
    x, y, z = r
    return numpy.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])


def reasons(selection, vertex):
    """Whether the contact law applies to a vertex, and the reasons to refuse its law."""
    tolerances, height = selection["tolerances"], vertex["height_m"]
    if vertex.get("leaves"):
        return False, []
    if selection["level"] == "velocity":
        applies = vertex["near"]
        found = [ABOVE] if height > TOUCHING else []
    else:
        speed = vertex["velocity_m_per_s"][2]
        # A vertex that rises faster than the tolerance of velocity is never clamped.
        applies = height <= tolerances["distance_m"] and speed <= tolerances["velocity_m_per_s"]
        found = [SLIDING] if vertex["moving"] and vertex["mu_k"] > 0 else []
        found += [NORMAL] if abs(speed) > tolerances["rest_m_per_s"] else []
    found += [COEFFICIENTS] if vertex["mu_s"] != vertex["mu_k"] else []
    return applies, found if applies else []


def selected(selection):
    """Indices (sole, vertex) of the contacts. Raises `Refused`."""
    contacts, found = [], []
    for s, sole in enumerate(selection["soles"]):
        found += [FORCED] if sole["forced"] is not None else []
        for v, vertex in enumerate(sole["vertices"]):
            applies, why = reasons(selection, vertex)
            contacts += [(s, v)] if applies else []
            found += why
    found += [] if contacts else [NOTHING]
    if found:
        raise Refused(min(found, key=REASONS.index))
    return contacts


def check_answer(selection, contacts):
    """Raises `Refused` if the answer follows another law than that of the contacts."""
    for s, (sole, normal) in enumerate(zip(selection["soles"], selection["answer"]["normal"])):
        pressed = [v for v, n in enumerate(normal) if n > 0]
        if any((s, v) not in contacts for v in pressed):
            raise Refused(OUTSIDE)
        heights = [sole["vertices"][v]["r_m"][2] for v in pressed]
        if selection["level"] == "velocity" and heights and max(heights) - min(heights) > TOUCHING:
            raise Refused(TILTED)


def rows_of(selection, s, v):
    """Rows z, x, y of J for a vertex, and its bias less its target."""
    sole = selection["soles"][s]
    vertex = sole["vertices"][v]
    rows = numpy.zeros((3, 6 * len(selection["soles"])))
    rows[:, 6 * s : 6 * s + 6] = numpy.hstack([numpy.eye(3), -cross(vertex["r_m"])])
    lift, tilt_x, tilt_y = sole["target"]
    x, y, _ = vertex["r_m"]
    offset = numpy.array(vertex["bias"]) - [0, 0, lift + tilt_x * y - tilt_y * x]
    return rows[[2, 0, 1]], offset[[2, 0, 1]]


def convert(record):
    """The `Problem` of a parsed problem file. Raises `Refused`."""
    selection = record["selection"]
    if has_null(selection):
        raise Refused(NULL)
    contacts = selected(selection)
    check_answer(selection, contacts)
    J, offset = map(numpy.concatenate, zip(*(rows_of(selection, s, v) for s, v in contacts)))
    b, answer = numpy.array(selection["b"], dtype=float), selection["answer"]
    W = J @ numpy.reshape(selection["W"], (len(b), len(b))) @ J.T
    mu = numpy.array([selection["soles"][s]["vertices"][v]["mu_s"] for s, v in contacts], dtype=float)
    r = numpy.concatenate([[answer["normal"][s][v], *answer["tangent"][s][v]] for s, v in contacts])
    u = J @ answer["motion"] + offset
    problem = Problem(scipy.sparse.csc_array((W + W.T) / 2), J @ b + offset, mu, (u, r), None, {})
    if not answer["consistent"] or max(residuals(problem, u, r)) > SOLVED:
        problem.solution, problem.guess = None, (u, r)
    problem.info = information(record, problem)
    return problem


def has_null(value):
    """Whether a number of the file was not finite. Keys that may be null have no numbers."""
    if isinstance(value, dict):
        return any(has_null(v) for k, v in value.items() if k != "forced" and v is not None)
    return value is None or (isinstance(value, list) and any(map(has_null, value)))


def information(record, problem):
    """Title, description and mathematical properties of a problem."""
    selection, units, run = record["selection"], record["selection"]["units"], record["key"]
    motion = {"velocity": "velocities after the impact or step", "acceleration": "accelerations"}
    rank = numpy.linalg.matrix_rank(problem.W.toarray(), hermitian=True)
    answer = "the solution" if problem.solution else "guess 1: it does not satisfy the conditions"
    polygons = ", ".join(sole["name"] for sole in selection["soles"])
    return {
        "title": f"{record['scenario']} {run} {record['number']}",
        "description": f"Contact problem {record['number']} of run {run} of {record['scenario']}, by "
        f"{record['program']}: {selection['level']} level, {selection['time_s']!r} s, contacts at vertices "
        f"of {polygons}. The answer of the method `{selection['method']}` is {answer}.",
        "math_info": f"u = W r + q. u: {motion[selection['level']]}, {units['vertex']}, normal ones less "
        f"their target (restitution). r: contact forces or impulses, {units['force']}. Components of a "
        "contact: normal, tangent, tangent. The term mu |u_t| of De Saxce is left to the solver. W is "
        f"symmetric and positive semidefinite, of rank {rank} of {len(problem.q)}. Where several contacts "
        "share a load, r need not be unique, nor u if they slide and turn.",
    }


# Files


def load(path):
    """A parsed problem file. Raises `BadFile`."""
    try:
        record = json.loads(path.read_text())
    except (OSError, ValueError) as error:
        raise BadFile(f"{path}: {error}") from error
    if not isinstance(record, dict) or "selection" not in record:
        raise BadFile(f"{path}: not a problem file of `runner run --dump-problems`: no key `selection`")
    if record.get("schema") != 1:
        raise BadFile(f"{path}: schema {record.get('schema')!r}, expected 1")
    return record


def put(group, name, value):
    """Writes a dataset as FCLIB does: integers, reals, or text of fixed length with a final zero."""
    if isinstance(value, str):
        text = h5py.h5t.C_S1.copy()
        text.set_size(len(value.encode()) + 1)
        dataset = h5py.h5d.create(group.id, name.encode(), text, h5py.h5s.create(h5py.h5s.SCALAR))
        dataset.write(h5py.h5s.ALL, h5py.h5s.ALL, numpy.array(value.encode() + b"\0"), mtype=text)
        return
    value = numpy.atleast_1d(value)
    group.create_dataset(name, data=value.astype("i4" if value.dtype.kind == "i" else "f8"))


def write(path, problem):
    """Writes a file, or replaces it as a whole."""
    W = problem.W
    partial = path.with_name(path.name + ".part")
    matrix = {"m": W.shape[0], "n": W.shape[1], "nzmax": W.nnz, "nz": -1}
    matrix |= {"p": W.indptr, "i": W.indices, "x": W.data}
    groups = {"fclib_local": {"spacedim": 3}, "fclib_local/W": matrix, "fclib_local/info": problem.info}
    groups["fclib_local/vectors"] = {"q": problem.q, "mu": problem.mu}
    if problem.solution:
        groups["solution"] = dict(zip("ur", problem.solution))
    if problem.guess:
        groups["guesses"] = {"number_of_guesses": 1}
        groups["guesses/1"] = dict(zip("ur", problem.guess))
    with h5py.File(partial, "w") as file:
        for name, datasets in groups.items():
            group = file.require_group(name)
            for key, value in datasets.items():
                put(group, key, value)
    os.replace(partial, path)


def read_matrix(group):
    """A matrix of FCLIB: triplets (nz >= 0), compressed columns (-1) or compressed rows (-2)."""
    m, n, nz = (int(group[name][0]) for name in ("m", "n", "nz"))
    p, i, x = (group[name][:] for name in "pix")
    if nz >= 0:
        return scipy.sparse.csc_array(scipy.sparse.coo_array((x[:nz], (p[:nz], i[:nz])), shape=(m, n)))
    kind = {-1: scipy.sparse.csc_array, -2: scipy.sparse.csr_array}[nz]
    return scipy.sparse.csc_array(kind((x, i, p), shape=(m, n)))


def read(path):
    """The `Problem` of an FCLIB file with a local problem in three dimensions. Raises `BadFile`."""
    try:
        with h5py.File(path, "r") as file:
            local = file["fclib_local"]
            if local["spacedim"][0] != 3 or "V" in local:
                raise BadFile(f"{path}: expected spacedim 3 and no equality constraints (V, R)")
            info = {name: text[()].decode() for name, text in local.get("info", {}).items()}
            solution, guess = (
                tuple(file[group][name][:] for name in "ur") if group in file else None
                for group in ("solution", "guesses/1")
            )
            q, mu = local["vectors/q"][:], local["vectors/mu"][:]
            return Problem(read_matrix(local["W"]), q, mu, solution, guess, info)
    except (OSError, KeyError) as error:
        raise BadFile(f"{path}: not an FCLIB file with a local problem: {error}") from error


# Check


def same(a, b):
    """Whether two problems are equal to the bit."""
    pairs = zip((a.q, a.mu, *(a.solution or a.guess)), (b.q, b.mu, *(b.solution or b.guess)))
    return (a.W != b.W).nnz == 0 and all(numpy.array_equal(x, y) for x, y in pairs) and a.info == b.info


def relative_difference(problem, u):
    """Difference from u of the stored solution, in units of the greatest |q|."""
    return numpy.abs(u - problem.solution[0]).max() / max(numpy.abs(problem.q).max(), 1e-300)


def worst(found):
    """Text of the greatest residuals."""
    equation, coulomb, natural = numpy.max([*found, (0, 0, 0)], axis=0)
    return f"u = W r + q {equation:.1e}, Coulomb {coulomb:.1e}, natural map {natural:.1e}"


def compare(name, solve, problems):
    """Prints residuals of a solver, and how its u differs from that of the stored solutions."""
    errors, gaps = {}, {}
    for path, problem in problems.items():
        r = solve(problem)
        u = problem.W @ r + problem.q
        found = residuals(problem, u, r)
        if max(found) <= SOLVED:
            errors[path] = found
            gaps |= {path: relative_difference(problem, u)} if problem.solution else {}
    print(f"{name}: {len(errors)} of {len(problems)} solved to {SOLVED:g}; {worst(errors.values())}")
    near = [gap for gap in gaps.values() if gap <= SAME]
    print(f"  same u as stored in {len(near)} of {len(gaps)}, greatest difference {max(near, default=0):.1e}")
    for path, gap in gaps.items():
        if gap > SAME:
            print(f"  another u in {path.name}, by {gap:.1e}: both satisfy the conditions")


def check(written):
    """Reads files back, solves them and prints the figures. Returns whether they read back the same."""
    problems = {path: read(path) for path in written}
    wrong = [path for path, problem in problems.items() if not same(problem, written[path])]
    for path in wrong:
        print(f"error: {path} does not read back as it was written")
    stored = [residuals(p, *p.solution) for p in problems.values() if p.solution]
    print(f"{len(problems)} read back; residuals and differences of u are relative to max |r| and max |q|")
    print(f"stored solutions: {len(stored)}; {worst(stored)}")
    for name, solve in SOLVERS.items():
        try:
            compare(name, solve, problems)
        except (ImportError, AttributeError) as error:
            print(f"{name}: not available ({error})")
    return not wrong


# Command line


def problem_files(paths):
    """Problem files among the arguments and in folders. Raises `BadFile`."""
    files = []
    for path in paths:
        inside = [path]
        if path.is_dir():
            inside = sorted(path.rglob("problems/*.json")) or sorted(path.glob("*.json"))
        if not inside:
            raise BadFile(f"{path}: no problem files; `runner run --dump-problems=all` writes them")
        files += inside
    return list(dict.fromkeys(files))


def export(files, folder):
    """Writes problems. Returns those written, by path, and counts of the reasons for refusing the others."""
    written, counts = {}, collections.Counter()
    folder.mkdir(parents=True, exist_ok=True)
    for file in files:
        record = load(file)
        try:
            problem = convert(record)
            path = folder / f"{record['scenario']}-{record['key']}-{record['number']:04}.hdf5"
        except Refused as reason:
            counts[str(reason)] += 1
            continue
        except (KeyError, IndexError, TypeError, ValueError) as error:
            raise BadFile(f"{file}: not a valid problem: {type(error).__name__}: {error}") from error
        if path in written:
            raise BadFile(f"{file}: a second problem that would be written to {path}")
        write(path, problem)
        written[path] = problem
    return written, counts


def options(arguments):
    parser = argparse.ArgumentParser(
        prog="python -m stiction_engines.fclib",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("problems", nargs="+", type=Path, metavar="PROBLEMS", help="problem files or folders")
    parser.add_argument("-o", "--output", required=True, type=Path, metavar="FOLDER", help="where to write")
    parser.add_argument("--check", action="store_true", help="read the files back, solve them and compare")
    return parser.parse_args(arguments)


def main(arguments=None):
    chosen = options(arguments)
    try:
        written, refused = export(problem_files(chosen.problems), chosen.output)
        guesses = sum(problem.guess is not None for problem in written.values())
        print(f"{len(written)} written to {chosen.output}, {guesses} of them with a guess and no solution")
        print(f"{refused.total()} refused")
        for reason, count in refused.most_common():
            print(f"  {count:5}  {reason}")
        return 1 if chosen.check and written and not check(written) else 0
    except (BadFile, OSError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 2


if __name__ == "__main__":
    sys.exit(main())

"""Coulomb friction at n contacts as a cone problem: residuals, and solvers of other programs.

Find u and r in R^3n with u = W r + q and, for each contact with the coefficient mu,

    K* contains u + (mu |u_t|, 0, 0), perpendicular to r in K = {|r_t| <= mu r_n}.

The components of a contact are normal, tangent, tangent. mu |u_t| is De Saxce's term.
"""

from dataclasses import dataclass

import numpy
import scipy.sparse


@dataclass
class Problem:
    """The problem FC(W, q, mu) of FCLIB.

    `solution` and `guess` are pairs (u, r), or None. `info` maps names to texts.
    """

    W: scipy.sparse.csc_array
    q: numpy.ndarray
    mu: numpy.ndarray
    solution: tuple | None
    guess: tuple | None
    info: dict


def project(mu, x):
    """Projections onto the friction cones, row by row."""
    size = numpy.hypot(x[:, 1], x[:, 2])
    normal = numpy.where(size <= mu * x[:, 0], x[:, 0], numpy.maximum(x[:, 0] + mu * size, 0) / (1 + mu**2))
    shrink = numpy.where(size <= mu * x[:, 0], 1, mu * normal / numpy.maximum(size, 1e-300))
    return numpy.column_stack([normal, shrink[:, None] * x[:, 1:]])


def residuals(problem, u, r):
    """Errors of u = W r + q, of Coulomb's conditions and of the natural map, relative to the scales.

    The scales are the greatest |r| and |q|. In units of these the natural map is
    r - P(r - u - (mu |u_t|, 0, 0)), with the projection P onto the cones.
    """
    W, q, mu = problem.W, problem.q, problem.mu
    motion = max(numpy.abs(q).max(), 1e-300)
    load = numpy.abs(r).max() or motion * len(q) / W.trace()
    equation = numpy.abs(W @ r + q - u).max() / motion
    u, r = numpy.reshape(u, (-1, 3)) / motion, numpy.reshape(r, (-1, 3)) / load
    slip, friction = (numpy.hypot(x[:, 1], x[:, 2]) for x in (u, r))
    power = mu * r[:, 0] * slip + numpy.sum(r[:, 1:] * u[:, 1:], axis=1)
    coulomb = [-r[:, 0], -u[:, 0], abs(r[:, 0] * u[:, 0]), friction - mu * r[:, 0], abs(power)]
    dual = u + numpy.outer(mu * slip, [1, 0, 0])
    natural = numpy.abs(r - project(mu, r - dual)).max()
    return equation, max(0.0, *(x.max() for x in coulomb)), natural


def scaled(problem):
    """W and q divided by scales, and the factor of the solution r."""
    weight, size = problem.W.trace() / len(problem.q), max(numpy.abs(problem.q).max(), 1e-300)
    return problem.W.toarray() / weight, problem.q / size, size / weight


def solve_pinocchio(problem):
    """r by Pinocchio's ADMM solver, whose components are tangent, tangent, normal."""
    import pinocchio as pin

    W, q, factor = scaled(problem)
    order = numpy.arange(len(q)).reshape(-1, 3)[:, [1, 2, 0]].ravel()
    models, datas = pin.StdVec_ConstraintModel(), pin.StdVec_ConstraintData()
    for mu in problem.mu:
        point = pin.PointContactConstraintModel(pin.Model(), 0, pin.SE3.Identity(), 0, pin.SE3.Identity())
        point.setFriction(mu)
        point.setCompliance(numpy.zeros(3))
        models.append(pin.ConstraintModel(point))
        datas.append(models[len(models) - 1].createData())
    settings, result = pin.ADMMSolverSettings(), pin.ADMMSolverResult()
    settings.solve_ncp, settings.max_iterations = True, 20000
    settings.absolute_feasibility_tol = settings.absolute_complementarity_tol = 1e-13
    settings.relative_feasibility_tol = settings.relative_complementarity_tol = 0
    delassus = pin.DelassusOperatorDense(numpy.ascontiguousarray(W[numpy.ix_(order, order)]))
    pin.ADMMConstraintSolver().solve(delassus, q[order], models, datas, settings, result)
    r = numpy.empty(len(q))
    r[order] = result.retrieveConstraintImpulses()
    return r * factor


def solve_siconos(problem):
    """r by the nonsmooth Gauss-Seidel method of Siconos."""
    from siconos import numerics

    W, q, factor = scaled(problem)
    options = numerics.SolverOptions(numerics.SICONOS_FRICTION_3D_NSGS)
    options.iparam[numerics.SICONOS_IPARAM_MAX_ITER] = 20000
    options.dparam[numerics.SICONOS_DPARAM_TOL] = 1e-12
    r, u = numpy.zeros(len(q)), numpy.zeros(len(q))
    numerics.fc3d_nsgs(numerics.FrictionContactProblem(3, W, q, problem.mu), r, u, options)
    return r * factor


SOLVERS = {"Pinocchio ADMM": solve_pinocchio, "Siconos NSGS": solve_siconos}

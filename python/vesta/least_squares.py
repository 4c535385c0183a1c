# SPDX-License-Identifier: Apache-2.0
"""least_squares: the function of scipy.optimize with this name, solved by vesta."""
from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import time

import numpy as np

from vesta import _vesta
from vesta._differences import Differences
from vesta._layout import Blocks
from vesta._rows import merge_rows, rows_of
from vesta._solve import RowProblem
from vesta._trace import Graph, TraceError

_LOSSES = {
    "linear": lambda scale: None,
    "huber": _vesta.HuberLoss,
    "soft_l1": _vesta.SoftLOneLoss,
    "cauchy": _vesta.CauchyLoss,
    "arctan": lambda scale: _vesta.ArctanLoss(scale * scale),
}

# scipy's numbers for the reason of the end.
_STATUS = {"max_iterations": 0, "gradient_tolerance": 1, "function_tolerance": 2, "parameter_tolerance": 3,
           "no_decrease": 2, "callback": -2}


class OptimizeResult(dict):
    """A dictionary whose entries are attributes too, as in scipy."""

    def __getattr__(self, name):
        try:
            return self[name]
        except KeyError as error:
            raise AttributeError(name) from error

    __setattr__ = dict.__setitem__

    def __repr__(self):
        return "\n".join(f"{name:>12}: {value!r}" for name, value in self.items() if name != "report")


def least_squares(fun: Callable[..., Any], x0: Any, jac: str | Callable[..., Any] | None = None,
                  bounds: Any = (-np.inf, np.inf), method: str = "trf", ftol: float | None = 1e-8,
                  xtol: float | None = 1e-8, gtol: float | None = 1e-8, x_scale: Any = None, loss: str = "linear",
                  f_scale: float = 1.0, diff_step: float | None = None, tr_solver: Any = None, tr_options: Any = None,
                  jac_sparsity: Any = None, max_nfev: int | None = None, verbose: int = 0, args: Sequence[Any] = (),
                  kwargs: Mapping[str, Any] | None = None, *, callback: Callable[[np.void], Any] | None = None,
                  linear_solver: str = "auto", column_scaling: str = "inverse_root") -> OptimizeResult:
    """Minimises 1/2 sum rho(fun(x)_i^2) over x, with the arguments and the result of scipy.optimize.least_squares.

    fun(x, *args, **kwargs): residuals, shape (m,), from x, shape (n,).

    jac: None records fun once with a symbolic x, and differentiates the recorded operations exactly. fun must then use
    numpy (or vesta.where, vesta.norm, ...) on x, without branches on values. Entries of x that always occur together,
    such as the parameters of one camera, become parameter blocks, so that the solver can use their sparsity. If fun
    cannot be recorded, or jac is "2-point" or "3-point", derivatives are finite differences; jac_sparsity (m, n) lets
    several columns share one evaluation. jac may also be a function of x that returns an array, or a scipy.sparse
    matrix whose zeros stay where they are at x0, or a scipy.sparse.linalg.LinearOperator, of the shape (m, n). An
    operator is used without forming a matrix, by LSMR or PCG. If it has an attribute diag_jtj, this is the diagonal of
    J^T J, which preconditions; bounds and losses are not supported with operators.

    bounds: lower and upper bounds, numbers or arrays (n,). loss: "linear", "huber", "soft_l1", "cauchy" or "arctan",
    applied to each residual divided by f_scale. ftol, xtol, gtol: tolerances of the Levenberg-Marquardt solver (None:
    0). max_nfev: the largest number of iterations. verbose: 1 prints a report, 2 an iteration per line. callback:
    called with a row of the history (iteration, cost, ...) after each iteration; returning False stops. linear_solver:
    "auto", "pcg", "schur_pcg", "lsmr" or "dense_qr". column_scaling: "inverse_root" divides the Jacobian's columns by
    their norms at the start, "one_plus_inverse" by 1 + norm as Ceres does, "none" does not. method, x_scale, tr_solver
    and tr_options have no effect, because the method is Levenberg-Marquardt.

    Returns x, cost, fun, jac, grad, optimality, active_mask, nfev, njev, status, message, success as scipy does, and
    derivatives ("recorded", "differences", "jac"), note (why fun could not be recorded), history (a structured array
    with a row per iteration), setup_seconds (before the first iteration) and report.

    Raises ValueError for arguments that do not fit, and if the residuals at x0 are not finite.
    """
    start = time.perf_counter()
    kwargs = kwargs or {}
    x0 = np.atleast_1d(np.asarray(x0, float))
    if x0.ndim != 1:
        raise ValueError("x0 needs one dimension")
    if loss not in _LOSSES:
        raise ValueError(f'loss is "{loss}"; the losses are {", ".join(_LOSSES)}')
    if jac not in (None, "2-point", "3-point", "cs") and not callable(jac):
        raise ValueError('jac needs to be None, "2-point", "3-point" or a function')
    lower, upper = (np.broadcast_to(np.asarray(b, float), x0.shape) for b in _bound_pair(bounds))
    if (x0 < lower).any() or (x0 > upper).any():
        raise ValueError("x0 is outside of the bounds")
    the_loss = None if loss == "linear" else _LOSSES[loss](float(f_scale))

    note = None
    problem = None
    options = {"function_tolerance": ftol or 0.0, "parameter_tolerance": xtol or 0.0,
               "gradient_tolerance": gtol or 0.0, "linear_solver": linear_solver, "column_scaling": column_scaling,
               "max_iterations": int(max_nfev) if max_nfev is not None else 100 * max(1, min(len(x0), 100))}
    on_iteration = _reporter(verbose, callback)
    if callable(jac):
        at_start = jac(x0, *args, **kwargs)
        if hasattr(at_start, "matvec") and not hasattr(at_start, "tocsr"):
            if the_loss is not None or np.isfinite(lower).any() or np.isfinite(upper).any():
                raise ValueError("bounds and losses are not supported with a LinearOperator as jac")
            return _by_operators(lambda x: np.asarray(fun(x, *args, **kwargs), float),
                                 lambda x: jac(x, *args, **kwargs), x0, options, on_iteration, verbose)
    if jac is None:
        try:
            problem = _recorded(lambda x: fun(x, *args, **kwargs), x0, the_loss)
            kind = "recorded"
        except TraceError as error:
            note = str(error)
    if problem is None:
        kind = "jac" if callable(jac) else "differences"
        problem = Differences(lambda x: fun(x, *args, **kwargs), x0,
                              (lambda x: jac(x, *args, **kwargs)) if callable(jac) else None,
                              jac_sparsity, central=jac in ("3-point", "cs"), step=diff_step,
                              bounds=(lower, upper)).problem(the_loss)
    problem.set_bounds(lower, upper)

    setup_seconds = time.perf_counter() - start
    summary = problem.problem.solve(options, on_iteration)
    if summary["failed"]:
        raise ValueError(summary["message"])
    _print_report(verbose, summary)
    result = _result(problem, x0, lower, upper, summary, the_loss)
    result.update(derivatives=kind, note=note, history=summary["iterations"], setup_seconds=setup_seconds,
                  report=summary["full_report"])
    return result


def _reporter(verbose, callback):
    """The function to call after each iteration; None if there is nothing to do."""
    if verbose < 2:
        return callback

    def report(row):
        print(f"{row['iteration']:5d}  cost {row['cost']:.6e}  damping {row['damping']:.1e}")
        return callback(row) if callback else None

    return report


def _print_report(verbose, summary):
    if verbose:
        print(summary["full_report" if verbose >= 2 else "brief_report"])


def _by_operators(fun, jac, x0, options, on_iteration, verbose):
    x, summary = _vesta.solve_operators(fun, jac, x0, fun(x0).size, options, on_iteration)
    if summary["failed"]:
        raise ValueError(summary["message"])
    _print_report(verbose, summary)
    residuals, operator = fun(x), jac(x)
    grad = np.asarray(operator.rmatvec(residuals))
    return OptimizeResult(
        x=x, cost=summary["final_cost"], fun=residuals, jac=operator, grad=grad,
        optimality=float(np.abs(grad).max(initial=0.0)), active_mask=np.zeros(len(x), int), **_counts(summary),
        derivatives="jac", note=None, history=summary["iterations"], setup_seconds=0.0, report=summary["full_report"])


def _counts(summary):
    linearizations = summary["num_linearizations"]
    return dict(nfev=summary["num_cost_evaluations"] + linearizations, njev=linearizations,
                status=_STATUS[summary["status"]], message=summary["message"], success=summary["converged"])


def _bound_pair(bounds):
    if hasattr(bounds, "lb"):  # scipy.optimize.Bounds
        return bounds.lb, bounds.ub
    if len(bounds) != 2:
        raise ValueError("bounds needs a lower and an upper bound")
    return bounds


def _recorded(fun, x0, loss):
    graph = Graph()
    with np.errstate(all="ignore"):
        residuals = graph.array_of(fun(graph.variables(len(x0))))
    # A loss applies to each residual on its own; without one, residuals may share rows.
    groups = rows_of(graph, residuals.reshape(-1, 1) if residuals.ndim else graph.from_ids(residuals.ids.reshape(1, 1)))
    if any(not rows.variables for rows in groups):
        raise TraceError("some residuals do not depend on x")
    if loss is None:
        groups = merge_rows(groups)
    problem = RowProblem(x0, Blocks.from_rows(len(x0), [rows.variables for rows in groups]))
    for rows in groups:
        problem.add_rows(rows, loss)
    return problem


def _result(problem, x0, lower, upper, summary, loss):
    x = problem.values(x0)
    plain = problem.problem.evaluate(apply_loss=False, derivatives=True)
    at = problem.positions
    fun = np.empty(len(at))
    fun[at] = plain["residuals"]
    corrected = problem.problem.evaluate(apply_loss=True, derivatives=True) if loss else plain
    grad = np.zeros(len(x0))
    grad[problem.order] = corrected["gradient"]
    active = np.where(x <= lower, -1, np.where(x >= upper, 1, 0))
    pushed = np.where((active == -1) & (grad > 0) | (active == 1) & (grad < 0), 0.0, grad)
    return OptimizeResult(
        x=x, cost=summary["final_cost"], fun=fun, jac=_matrix(plain, at, problem.order, len(x0)), grad=grad,
        optimality=float(np.abs(pushed).max(initial=0.0)), active_mask=active,
        **_counts(summary))


def _matrix(evaluation, row_of, column_of, num_columns):
    """The Jacobian in the order of fun and x: scipy.sparse where there is scipy and zeros pay, else an array."""
    rows = np.repeat(row_of, np.diff(evaluation["row_starts"]))
    columns, values = column_of[evaluation["columns"]], evaluation["values"]
    shape = (len(row_of), num_columns)
    if len(values) < 0.5 * shape[0] * shape[1]:
        try:
            from scipy.sparse import csr_matrix
            return csr_matrix((values, (rows, columns)), shape)
        except ImportError:
            pass
    dense = np.zeros(shape)
    dense[rows, columns] = values
    return dense

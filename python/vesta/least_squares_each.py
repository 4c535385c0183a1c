# SPDX-License-Identifier: Apache-2.0
"""least_squares_each: many small problems of one kind at once."""
from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from vesta import _vesta
from vesta._rows import rows_of
from vesta._trace import Graph, TraceError
from vesta.least_squares import OptimizeResult


def least_squares_each(fun: Callable[..., Any], x0: Any, args: Sequence[Any] = (), ftol: float | None = 1e-8,
                       xtol: float | None = 1e-8, gtol: float | None = 1e-8, max_nfev: int = 100) -> OptimizeResult:
    """Minimises 1/2 sum_j fun(x_i, ...)_ij^2 for each problem i on its own.

    x0: start values, shape (problems, parameters), at most 12 parameters. fun(x, *args) -> residuals (problems,
    residuals). x[k] is parameter k of all problems, shape (problems, 1), so that x[0] * np.exp(-x[1] * t) - y works for
    times t of the shape (residuals,) and samples y (problems, residuals). An argument with one dimension holds for all
    problems; one with more dimensions has a row per problem.

    fun is recorded once, as by vesta.least_squares; all residuals need the same operations. Each SIMD lane of each core
    solves a problem, and no problem depends on another. ftol, xtol, gtol, max_nfev: as in vesta.least_squares, for each
    problem.

    Returns x (problems, parameters), cost, status, nit (iterations) and success, one entry per problem. Raises
    TraceError if fun cannot be recorded.
    """
    x0 = np.asarray(x0, float)
    if x0.ndim != 2 or not x0.size:
        raise ValueError(f"x0 needs the shape (problems, parameters), not {x0.shape}")
    num_problems, num_parameters = x0.shape
    args = [np.asarray(a, float) for a in args]
    own = [a.ndim >= 2 and len(a) == num_problems for a in args]
    # Recorded for one problem.
    graph = Graph()
    x = graph.variables(num_parameters)[:, None, None]
    with np.errstate(all="ignore"):
        residuals = graph.array_of(fun(x, *(graph.argument(k, (1, *a.shape[1:])) if mine else a
                                            for k, (a, mine) in enumerate(zip(args, own)))))
    if residuals.ndim != 2 or residuals.shape[0] != 1:
        raise ValueError(f"fun returned the shape {(num_problems, *residuals.shape[1:])}; it needs two dimensions")
    groups = rows_of(graph, residuals.reshape(-1, 1))
    if len(groups) != 1 or any((v != v[0]).any() for v in groups[0].variables):
        raise TraceError("the residuals of a problem have different operations; use vesta.least_squares")
    rows, num_residuals = groups[0], residuals.shape[1]
    places = [int(v[0]) for v in rows.variables]
    data = [args[d[0]].reshape(num_problems, -1)[:, d[1]] if isinstance(d, tuple) else
            np.broadcast_to(d, (num_problems, num_residuals)) for d in rows.data]
    inputs = places + [num_parameters + d for d in range(len(rows.data))]
    instructions = [(op, inputs[a] if op == "input" else a, b, c, v) for op, a, b, c, v in rows.instructions]
    program = _vesta.Program(num_parameters + len(rows.data), instructions, rows.outputs)
    options = {"function_tolerance": ftol or 0.0, "parameter_tolerance": xtol or 0.0,
               "gradient_tolerance": gtol or 0.0, "max_iterations": int(max_nfev)}
    x, cost, status, nit, success = _vesta.solve_each(program, x0, data, num_residuals, options)
    return OptimizeResult(x=x, cost=cost, status=status, nit=nit, success=success)

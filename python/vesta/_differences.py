# SPDX-License-Identifier: Apache-2.0
"""Residuals of a function that cannot be recorded: finite differences, or the user's Jacobian."""
import numpy as np

from vesta._layout import Blocks, layouts
from vesta._solve import RowProblem


class Differences:
    """fun(x) -> residuals (m,); jac(x) -> array or sparse matrix (m, n), or None for differences.

    sparsity: None, or an array or sparse matrix (m, n) that is zero where the Jacobian is always zero. step: relative
    step; None for the square root (central differences: the cube root) of the rounding error.
    """

    def __init__(self, fun, x0, jac, sparsity, central, step, bounds):
        self._fun, self._jac, self._x0, self._central = fun, jac, x0, central
        self._step = (np.finfo(float).eps ** (1 / 3 if central else 1 / 2)) if step is None else step
        self._bounds = bounds
        self._residuals = self._evaluate(x0)
        self._cached = None
        m, n = len(self._residuals), len(x0)
        if jac is not None:
            sparsity = jac(x0)
            sparsity = sparsity if hasattr(sparsity, "tocsr") else None
        self._starts, self._columns = _pattern(sparsity, m, n)
        self._groups = None if jac is not None else _groups(self._starts, self._columns, n)

    def _evaluate(self, x):
        residuals = np.atleast_1d(np.asarray(self._fun(x), float))
        if residuals.ndim != 1:
            raise ValueError("fun needs to return residuals of one dimension")
        return residuals

    def problem(self, loss):
        counts = np.diff(self._starts)
        if (counts == 0).any():
            raise ValueError("some residuals do not depend on x")
        groups = []
        for count in np.unique(counts):
            rows = np.flatnonzero(counts == count)
            entries = self._starts[rows][:, None] + np.arange(count)
            groups.append((rows, entries, list(self._columns[entries].T)))
        blocks = Blocks.from_rows(len(self._x0), [variables for _, _, variables in groups])
        result = RowProblem(self._x0, blocks)
        order = result.order
        for rows, entries, variables in groups:
            for layout in layouts(blocks, variables):
                result.add_callback(self._callback(rows[layout.rows], entries[layout.rows], layout, order), 1, layout,
                                    rows[layout.rows], loss)
        return result

    def _callback(self, rows, entries, layout, order):
        ends = np.cumsum(layout.sizes)

        def evaluate(values, derivatives):
            x = self._x0.copy()
            x[order] = values
            residuals, jacobian = self._at(x, derivatives)
            if not derivatives:
                return residuals[rows], None
            matrix = np.zeros((len(rows), ends[-1]))
            matrix[:, layout.places] = jacobian[entries]
            return residuals[rows], [matrix[:, end - size:end] for size, end in zip(layout.sizes, ends)]

        return evaluate

    def _at(self, x, derivatives):
        """The residuals at x, and the stored entries of the Jacobian; several groups of rows share an evaluation."""
        key = (x.tobytes(), derivatives)
        if self._cached is None or self._cached[0] != key:
            self._cached = key, self._evaluate(x), self._jacobian(x) if derivatives else None
        return self._cached[1:]

    def _jacobian(self, x):
        if self._jac is None:
            return self._differences(x)
        matrix = self._jac(x)
        if not hasattr(matrix, "tocsr"):
            matrix = np.asarray(matrix, float)
            if matrix.size != len(self._columns):
                raise ValueError(f"jac returned the shape {matrix.shape}, not {len(self._starts) - 1, len(x)}")
            return matrix.ravel()
        matrix = matrix.tocsr()
        matrix.sort_indices()
        if not (np.array_equal(matrix.indptr, self._starts) and np.array_equal(matrix.indices, self._columns)):
            raise ValueError("jac has stored entries in other places than at x0")
        return matrix.data

    def _differences(self, x):
        f = self._evaluate(x)
        steps = self._step * np.maximum(1.0, np.abs(x))
        lower, upper = self._bounds
        steps = np.where(x + steps > upper, -steps, steps)  # stays within the bounds where it can
        steps = (x + steps) - x
        slopes = np.empty(len(self._columns))
        row_of = np.repeat(np.arange(len(f)), np.diff(self._starts))
        for group in self._groups:
            moved = x.copy()
            moved[group] += steps[group]
            if self._central:
                back = x.copy()
                back[group] -= steps[group]
                change, width = self._evaluate(moved) - self._evaluate(back), 2 * steps
            else:
                change, width = self._evaluate(moved) - f, steps
            at = np.flatnonzero(np.isin(self._columns, group))
            slopes[at] = change[row_of[at]] / width[self._columns[at]]
        return slopes


def _pattern(sparsity, m, n):
    if sparsity is None:
        return np.arange(m + 1) * n, np.tile(np.arange(n), m)
    if hasattr(sparsity, "tocsr"):
        matrix = sparsity.tocsr()
        matrix.sort_indices()
        starts, columns, shape = np.asarray(matrix.indptr, int), np.asarray(matrix.indices, int), matrix.shape
    else:
        nonzero = np.asarray(sparsity) != 0
        starts = np.concatenate([[0], np.cumsum(nonzero.sum(axis=1))])
        columns, shape = np.nonzero(nonzero)[1], nonzero.shape
    if shape != (m, n):
        raise ValueError(f"the Jacobian or jac_sparsity has the shape {shape}, not {m, n}")
    return starts, columns


def _groups(starts, columns, n):
    """Columns that share no row, greedily in groups (Curtis, Powell and Reid, 1974)."""
    rows = np.repeat(np.arange(len(starts) - 1), np.diff(starts))
    order = np.argsort(columns, kind="stable")
    rows_of = np.split(rows[order], np.cumsum(np.bincount(columns, minlength=n))[:-1])
    groups, taken = [], []
    for column in sorted(range(n), key=lambda c: -len(rows_of[c])):
        for group, used in zip(groups, taken):
            if not used[rows_of[column]].any():
                break
        else:
            group, used = [], np.zeros(len(starts) - 1, bool)
            groups.append(group)
            taken.append(used)
        group.append(column)
        used[rows_of[column]] = True
    return [np.array(g) for g in groups]

# SPDX-License-Identifier: Apache-2.0
"""Least-squares problems of parameter blocks and batches of residuals."""
from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from vesta import _vesta
from vesta._layout import Blocks, Layout
from vesta._rows import rows_of
from vesta._solve import RowProblem
from vesta._trace import Graph, TraceError


class BlockArray:
    """Parameter blocks of one kind. array[i], with numbers or an array of numbers, selects blocks for residuals."""

    def __init__(self, problem, first, offset, count, size):
        self._problem, self._first, self._offset, self.count, self.size = problem, first, offset, count, size

    @property
    def values(self) -> np.ndarray:
        """The values, shape (count, size); a copy."""
        x = self._problem._rows.problem.get_values()
        return x[self._offset:self._offset + self.count * self.size].reshape(self.count, self.size)

    @values.setter
    def values(self, values):
        x = self._problem._rows.problem.get_values()
        x[self._offset:self._offset + self.count * self.size] = np.broadcast_to(values, (self.count, self.size)).ravel()
        self._problem._rows.problem.set_values(x)

    def __len__(self):
        return self.count

    def __getitem__(self, index: Any) -> Selection:
        return Selection(self, np.atleast_1d(np.arange(self.count)[index]))

    def set_constant(self, constant=True):
        """Holds all blocks (or array[i].set_constant(): some) at their values, or frees them."""
        self[:].set_constant(constant)

    def set_bounds(self, lower, upper):
        """Bounds of all blocks; numbers, or arrays that broadcast to (count, size)."""
        self[:].set_bounds(lower, upper)


class Selection:
    """Some blocks of a BlockArray, possibly repeated, one per row of residuals."""

    def __init__(self, array, indices):
        self.array, self.indices = array, indices

    def set_constant(self, constant=True):
        for i in np.unique(self.indices):
            self.array._problem._rows.problem.set_constant(self.array._first + int(i), constant)

    def set_bounds(self, lower, upper):
        shape = len(self.indices), self.array.size
        lower, upper = np.broadcast_to(lower, shape), np.broadcast_to(upper, shape)
        for row, i in enumerate(self.indices):
            for entry in range(self.array.size):
                self.array._problem._rows.problem.set_bounds(self.array._first + int(i), entry,
                                                             float(lower[row, entry]), float(upper[row, entry]))

    @property
    def entries(self):
        """Positions of the blocks' numbers in the vector of all parameters, shape (rows, size)."""
        array = self.array
        return array._offset + self.indices[:, None] * array.size + np.arange(array.size)

    @property
    def blocks(self):
        return self.array._first + self.indices


class Summary:
    """The result of a solve: status, message, initial_cost, final_cost, converged, seconds, linear_solver, counts, and
    iterations, a structured array with one row per iteration."""

    def __init__(self, values):
        self.__dict__.update(values)

    def brief_report(self) -> str:
        return self.__dict__["brief_report_text"]

    def full_report(self) -> str:
        return self.__dict__["full_report_text"]

    def __repr__(self):
        return self.brief_report()


class Problem:
    """Minimises 1/2 sum rho(|f_i|^2) over residual rows f_i of parameter blocks.

        problem = vesta.Problem()
        cameras = problem.add_blocks(camera_values)                # (M, 9)
        points = problem.add_blocks(point_values)                  # (N, 3)
        problem.add_residuals(reprojection, [cameras[camera_of], points[point_of]], data=[pixels])
        summary = problem.solve()
        cameras.values
    """

    def __init__(self):
        empty = np.zeros(0, int)
        self._rows = RowProblem(np.zeros(0), Blocks(empty, empty, empty))

    def add_blocks(self, values: Any, manifold: _vesta.Manifold | None = None) -> BlockArray:
        """Adds one block per row of `values`, shape (count, size) or (size,). Returns a BlockArray.

        manifold: such as vesta.SO3(); its ambient size is `size`.
        """
        values = np.atleast_2d(np.asarray(values, float))
        if values.ndim != 2 or not values.size:
            raise ValueError(f"parameter blocks need values of the shape (count, size), not {values.shape}")
        blocks, (count, size) = self._rows.blocks, values.shape
        offset, first = len(blocks.block), self._rows.problem.add_blocks(values, manifold)
        self._rows.blocks = Blocks(np.concatenate([blocks.block, np.repeat(first + np.arange(count), size)]),
                                   np.concatenate([blocks.entry, np.tile(np.arange(size), count)]),
                                   np.concatenate([blocks.sizes, np.full(count, size)]))
        return BlockArray(self, first, offset, count, size)

    def add_residuals(self, function: Callable[..., Any], blocks: Sequence[BlockArray | Selection],
                      data: Sequence[Any] = (), loss: _vesta.Loss | None = None,
                      jac: str | Callable[..., Any] | None = None) -> None:
        """Adds one row of residuals per selected block.

        function(*blocks, *data) -> residuals (n, k) or (n,), from blocks of the shape (n, size) and data whose first
        axis has length n. blocks: BlockArrays or selections such as cameras[camera_of], each of n blocks or of one
        block for all rows. loss: such as vesta.Huber(1.0), of the squared norm of a row.

        jac: None records the function (see vesta.least_squares). "2-point": forward differences, for functions that
        cannot be recorded. A function with the same arguments: a list with the derivatives by each block, (n, k, size).
        """
        selections = [b if isinstance(b, Selection) else b[:] for b in blocks]
        if not selections:
            raise ValueError("residuals need at least one parameter block")
        data = [np.asarray(d, float) for d in data]
        n = max([len(s.indices) for s in selections] + [len(d) for d in data if d.ndim])
        for k, s in enumerate(selections):
            if s.array._problem is not self:
                raise ValueError(f"block {k} belongs to another problem")
            if len(s.indices) not in (1, n):
                raise ValueError(f"block {k} has {len(s.indices)} rows, not {n}")
        selections = [s if len(s.indices) == n else Selection(s.array, np.repeat(s.indices, n)) for s in selections]
        for k, d in enumerate(data):
            if d.ndim and len(d) != n:
                raise ValueError(f"data {k} has {len(d)} rows, not {n}")
        if jac is None:
            self._record(function, selections, data, loss, n)
        elif callable(jac) or jac == "2-point":
            self._call(function, selections, data, loss, n, jac)
        else:
            raise ValueError('jac needs to be None, "2-point" or a function')

    def _record(self, function, selections, data, loss, n):
        try:
            with np.errstate(all="ignore"):
                if self._record_row(function, selections, data, loss, n):
                    return
                graph = Graph()
                x = graph.variables(len(self._rows.blocks.block))
                result = graph.array_of(function(*(x[s.entries] for s in selections), *data))
        except TraceError as error:
            raise TraceError(f'{error}; give jac="2-point" for finite differences, or a function as jac') from None
        if result.shape[:1] != (n,) or result.ndim > 2:
            raise ValueError(f"the function returned the shape {result.shape}, not ({n}, residuals)")
        for rows in rows_of(graph, result.reshape(n, -1)):
            if not rows.variables:
                raise ValueError("some residuals do not depend on a parameter block")
            self._rows.add_rows(rows, loss)

    def _record_row(self, function, selections, data, loss, n):
        """Records the function for two rows. If their operations are the same, they hold for all rows.

        Returns False if not, if a row of residuals depends on the blocks of another row, if a row reads a block twice,
        or if the function uses arrays with n rows that are not among its arguments.
        """
        blocks = np.stack([s.blocks for s in selections], axis=1)
        if (np.diff(np.sort(blocks, axis=1), axis=1) == 0).any():
            return False
        sizes = [s.array.size for s in selections]
        graph, total = Graph(), sum(sizes)
        x = graph.variables(2 * total).reshape(2, total)
        values = [x[:, end - size:end] for size, end in zip(sizes, np.cumsum(sizes))]
        values += [graph.argument(k, (2, *d.shape[1:])) if d.ndim else d for k, d in enumerate(data)]
        try:
            result = graph.array_of(function(*values))
        except TraceError:
            raise
        except (ValueError, IndexError):
            return False
        if result.shape[:1] != (2,) or result.ndim > 2:
            return False
        groups = rows_of(graph, result.reshape(2, -1))
        if len(groups) != 1:
            return False
        rows = groups[0]
        columns = []
        for d in rows.data:
            if not isinstance(d, tuple):
                return False
            values = data[d[0]].reshape(n, -1)
            if d[1][0] >= values.shape[1] or d[1][1] != d[1][0] + values.shape[1]:
                return False
            columns.append(values[:, d[1][0]])
        if any(v[0] >= total or v[1] != v[0] + total for v in rows.variables):
            return False
        rows.data = columns
        layout = Layout(np.arange(n), blocks, sizes, [int(v[0]) for v in rows.variables])
        rows.positions = np.arange(n * len(rows.outputs)).reshape(n, -1)
        self._rows.add_layout(rows, layout, loss)
        return True

    def _call(self, function, selections, data, loss, n, jac):
        def blocks_of(x):
            return [x[s.entries] for s in selections]

        def residuals_of(blocks):
            residuals = np.asarray(function(*blocks, *data), float)
            if residuals.shape[:1] != (n,) or residuals.ndim > 2:
                raise ValueError(f"the function returned the shape {residuals.shape}, not ({n}, residuals)")
            return residuals.reshape(n, -1)

        def evaluate(x, derivatives):
            blocks = blocks_of(x)
            residuals = residuals_of(blocks)
            if not derivatives:
                return residuals, None
            if callable(jac):
                return residuals, [np.asarray(j, float) for j in jac(*blocks, *data)]
            jacobians = [np.empty((*residuals.shape, s.array.size)) for s in selections]
            for k, jacobian in enumerate(jacobians):
                for entry in range(jacobian.shape[2]):
                    moved = [b.copy() for b in blocks]
                    step = np.sqrt(np.finfo(float).eps) * np.maximum(1.0, np.abs(blocks[k][:, entry]))
                    moved[k][:, entry] += step
                    step = moved[k][:, entry] - blocks[k][:, entry]
                    jacobian[:, :, entry] = (residuals_of(moved) - residuals) / step[:, None]
            return residuals, jacobians

        num_residuals = residuals_of(blocks_of(self._rows.problem.get_values())).shape[1]
        layout = Layout(np.arange(n), np.stack([s.blocks for s in selections], axis=1),
                        [s.array.size for s in selections], None)
        self._rows.add_callback(evaluate, num_residuals, layout, np.arange(n * num_residuals), loss)

    def solve(self, max_iterations: int = 50, function_tolerance: float = 1e-6, gradient_tolerance: float = 1e-10,
              parameter_tolerance: float = 1e-8, max_seconds: float = np.inf, linear_solver: str = "auto",
              column_scaling: str = "inverse_root", callback: Callable[[np.void], Any] | None = None) -> Summary:
        """Solves from the present values, and replaces them by the best ones found. Returns a Summary.

        The tolerances have the meaning of Ceres. linear_solver, column_scaling: as in vesta.least_squares. callback:
        called with a row of `iterations` after each iteration; returning False stops. Ctrl-C stops with
        KeyboardInterrupt, and then the values are as before. Raises ValueError if the start is not valid.
        """
        values = self._rows.problem.solve(
            dict(max_iterations=max_iterations, function_tolerance=function_tolerance,
                 gradient_tolerance=gradient_tolerance, parameter_tolerance=parameter_tolerance,
                 max_seconds=float(max_seconds), linear_solver=linear_solver, column_scaling=column_scaling), callback)
        if values["failed"]:
            raise ValueError(values["message"])
        values["brief_report_text"], values["full_report_text"] = values.pop("brief_report"), values.pop("full_report")
        return Summary(values)

    def cost(self) -> float:
        """The cost at the present values."""
        return self._rows.problem.evaluate(apply_loss=True, derivatives=False)["cost"]

    def check(self) -> list[str]:
        """Checks the derivatives at the present values by finite differences, and other properties (CheckProblem).

        Returns a list of faults, one line each. Check before a solve: where all residuals are nearly 0, finite
        differences are lost in rounding, and correct derivatives may be listed as faults.
        """
        return self._rows.problem.check()

    def covariance(self, *selections: BlockArray | Selection, ambient: bool = False) -> Any:
        """The covariance of each selected block at the solution, if the residuals have variance 1.

        Returns one array (blocks, d, d) per selection; d is the size of the tangent space or, if ambient, of the block.
        A constant block has NaN. Raises ValueError if the residuals do not determine the blocks.
        """
        selections = [s if isinstance(s, Selection) else s[:] for s in selections]
        pairs = [(int(b), int(b)) for s in selections for b in s.blocks]
        matrices = iter(self._rows.problem.covariance(pairs, ambient))
        result = []
        for s in selections:
            found = [next(matrices) for _ in s.indices]
            size = next((len(m) for m in found if m is not None), s.array.size)
            result.append(np.array([np.full((size, size), np.nan) if m is None else m for m in found]))
        return result[0] if len(result) == 1 else result


# Losses of the squared norm s of a row (solver/loss.h).
Huber, SoftLOne, Cauchy, Arctan = _vesta.HuberLoss, _vesta.SoftLOneLoss, _vesta.CauchyLoss, _vesta.ArctanLoss
Tukey, Tolerant, Scaled = _vesta.TukeyLoss, _vesta.TolerantLoss, _vesta.ScaledLoss

# Manifolds (solver/manifold.h): quaternions are w, x, y, z unless scalar_first=False.
SO3, SE3, Sphere, Line = _vesta.QuaternionManifold, _vesta.Se3Manifold, _vesta.UnitVectorManifold, _vesta.LineManifold
Euclidean, Subset = _vesta.EuclideanManifold, _vesta.SubsetManifold


def Product(*parts: _vesta.Manifold) -> _vesta.Manifold:
    """The product of manifolds, such as Product(SO3(), Euclidean(3))."""
    return _vesta.ProductManifold(list(parts))

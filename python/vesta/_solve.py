# SPDX-License-Identifier: Apache-2.0
"""Problems of the extension module, made of rows of residuals."""
import numpy as np

from vesta import _vesta
from vesta._layout import layouts


def program_of(rows, layout):
    """The compiled program of `rows` for the rows of a layout."""
    num_variables = int(sum(layout.sizes))
    inputs = layout.places + [num_variables + d for d in range(len(rows.data))]
    instructions = [(op, inputs[a] if op == "input" else a, b, c, value) for op, a, b, c, value in rows.instructions]
    return _vesta.Program(num_variables + len(rows.data), instructions, rows.outputs)


class RowProblem:
    """A _vesta.Problem over blocks of a vector x.

    Residuals are added in groups; `positions` collects their numbers in the order of the extension module.
    """

    def __init__(self, x, blocks, manifolds=None):
        self.problem = _vesta.Problem()
        self.blocks = blocks
        self.order = blocks.order()  # entry of x per number of the problem
        self._positions = []
        starts = np.cumsum(blocks.sizes) - blocks.sizes
        x = np.asarray(x, float)
        manifolds = manifolds or [None] * len(blocks.sizes)
        begin = 0
        while begin < len(blocks.sizes):  # one call per run of blocks of one size and manifold
            size, end = blocks.sizes[begin], begin
            while end < len(blocks.sizes) and blocks.sizes[end] == size and manifolds[end] is manifolds[begin]:
                end += 1
            numbers = self.order[starts[begin]:starts[begin] + size * (end - begin)]
            self.problem.add_blocks(x[numbers].reshape(-1, size), manifolds[begin])
            begin = end

    def add_rows(self, rows, loss=None):
        """Adds residuals that are programs."""
        for layout in layouts(self.blocks, rows.variables):
            self.add_layout(rows, layout, loss)

    def add_layout(self, rows, layout, loss=None):
        """The same for the rows of one layout."""
        data = np.stack([d[layout.rows] for d in rows.data]) if rows.data else np.zeros((0, len(layout.rows)))
        self.problem.add_program(program_of(rows, layout), layout.sizes, layout.blocks, data, loss)
        self._positions.append(rows.positions[layout.rows].ravel())

    def add_callback(self, function, num_residuals, layout, positions, loss=None):
        """Adds residuals that a Python function computes for all rows of the layout."""
        self.problem.add_callback(function, num_residuals, layout.sizes, layout.blocks, loss)
        self._positions.append(positions)

    @property
    def positions(self):
        return np.concatenate(self._positions) if self._positions else np.zeros(0, int)

    def values(self, x):
        """x with the values of the problem."""
        result = np.array(x, float)
        result[self.order] = self.problem.get_values()
        return result

    def set_bounds(self, lower, upper):
        for i in np.flatnonzero((lower > -np.inf) | (upper < np.inf)):
            if self.blocks.block[i] >= 0:
                self.problem.set_bounds(int(self.blocks.block[i]), int(self.blocks.entry[i]), lower[i], upper[i])

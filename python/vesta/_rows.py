# SPDX-License-Identifier: Apache-2.0
"""From recorded residuals to programs: lists of operations that hold for many rows of residuals."""
import numpy as np

from vesta._trace import _SHIFT, equal_columns


class Rows:
    """Rows of residuals with one list of operations.

    positions: array (rows, residuals), the residuals' numbers in the function's result. instructions: tuples
    (operation, a, b, c, value); the operands are positions in the list. For "input", a is a slot. outputs: the position
    of each residual. variables: one array (rows,) per variable slot, indices into x. Slots of variables come first.
    data: one array (rows,) per data slot, or a pair (number of an argument, lanes).
    """

    def __init__(self, positions, instructions, outputs, variables, data):
        self.positions, self.instructions, self.outputs = positions, instructions, outputs
        self.variables, self.data = variables, data


class _LaneMaps:
    """Maps from rows to lanes, with equal maps represented by equal tuples.

    A tuple is (-1, start, step, count) for start + step * i, or (k, 0, 1, count) for array k. Composing maps of the
    first kind, which come from slices, takes no time that depends on the count.
    """

    def __init__(self):
        self._arrays, self._by_content, self._composed = [], {}, {}

    def canonical(self, lanes):
        """The tuple of an array."""
        start, step = int(lanes[0]), int(lanes[1] - lanes[0]) if len(lanes) > 1 else 1
        if (lanes == start + step * np.arange(len(lanes))).all():
            return -1, start, step, len(lanes)
        content = lanes.tobytes()
        if content not in self._by_content:
            self._by_content[content] = len(self._arrays)
            self._arrays.append(lanes)
        return self._by_content[content], 0, 1, len(lanes)

    def array(self, lanes):
        k, start, step, count = lanes
        return self._arrays[k] if k >= 0 else start + step * np.arange(count)

    def compose(self, inner, outer):
        """The map i -> inner[outer[i]]."""
        k, start, step, count = inner
        if (k, start, step) == (-1, 0, 1):
            return outer
        if k < 0 and outer[0] < 0:
            return -1, start + step * outer[1], step * outer[2], outer[3]
        key = inner, outer
        if key not in self._composed:
            at = self.array(outer)
            self._composed[key] = self.canonical(self._arrays[k][at] if k >= 0 else start + step * at)
        return self._composed[key]


class _Lowering:
    """Lowers residuals of the same number of rows; all columns share the slots."""

    def __init__(self, graph, maps, operand_maps):
        self.graph, self._maps, self._operand_maps = graph, maps, operand_maps
        self.instructions, self.slots = [], {}
        self.variables, self.data = [], []  # (instruction, array)
        self._done = {}

    def column(self, node, lanes):
        """The instruction for lanes `lanes` of a node."""
        stack = [(node, lanes)]
        while stack:  # without recursion: expressions can be deep
            key = n, at = stack[-1]
            if key in self._done:
                stack.pop()
                continue
            info = self.graph.nodes[n]
            operands = [(o, self._maps.compose(m, at)) for o, m in self._operands(n, info)]
            missing = [operand for operand in operands if operand not in self._done]
            if missing:
                stack.extend(missing)
                continue
            stack.pop()
            if not info.operands:
                self._done[key] = self._leaf(info, self._maps.array(at))
            else:
                self._done[key] = self._append(info.op, *(self._done[operand] for operand in operands))
        return self._done[node, lanes]

    def _operands(self, n, info):
        if n not in self._operand_maps:
            self._operand_maps[n] = [
                (o, (-1, 0, 1, info.size) if lanes is None else self._maps.canonical(lanes))
                for o, lanes in info.operands]
        return self._operand_maps[n]

    def _append(self, op, a=-1, b=-1, c=-1, value=0.0):
        self.instructions.append((op, a, b, c, value))
        return len(self.instructions) - 1

    def _leaf(self, info, lanes):
        content = info.values[lanes] if info.op == "data" else lanes
        if info.op == "data" and (content == content[0]).all():
            return self._append("constant", value=float(content[0]))
        key = info.op, content.tobytes(), info.values if info.op == "argument" else None
        if key not in self.slots:
            self.slots[key] = self._append("input")
            slot = (info.values, content) if info.op == "argument" else content
            (self.variables if info.op == "x" else self.data).append((self.slots[key], slot))
        return self.slots[key]

    def finish(self, positions, outputs):
        instructions = list(self.instructions)
        for slot, (place, _) in enumerate(self.variables + self.data):
            instructions[place] = ("input", slot, -1, -1, 0.0)
        return Rows(positions, instructions, outputs, [v for _, v in self.variables], [d for _, d in self.data])


def rows_of(graph, residuals):
    """residuals: symbolic array (rows, residuals per row). Returns a list of Rows with all of its rows."""
    ids = residuals.ids
    groups = equal_columns((ids >> _SHIFT).T)
    result = []
    maps, operand_maps = _LaneMaps(), {}
    for group in groups:
        lowering = _Lowering(graph, maps, operand_maps)
        outputs = []
        for column in ids[group].T:
            outputs.append(lowering.column(int(column[0] >> _SHIFT), maps.canonical(column & ((1 << _SHIFT) - 1))))
        positions = group[:, None] * ids.shape[1] + np.arange(ids.shape[1])
        result.append(lowering.finish(positions, outputs))
    return _join_equal(result)


def _join_equal(groups):
    """Joins groups that have equal instructions, such as residuals that a Python loop computed one by one."""
    joined = {}
    for rows in groups:
        key = (tuple(rows.instructions), tuple(rows.outputs), len(rows.variables), rows.positions.shape[1])
        joined.setdefault(key, []).append(rows)
    result = []
    for same in joined.values():
        first = same[0]
        if len(same) > 1:
            columns = [[np.concatenate([getattr(r, name)[k] for r in same]) for k in range(len(getattr(first, name)))]
                       for name in ("variables", "data")]
            first = Rows(np.concatenate([r.positions for r in same]), first.instructions, first.outputs, *columns)
        result.append(first)
    return result


def merge_rows(groups):
    """Merges rows that read the same variables into one row with more residuals, to share their common operations."""
    merged = []
    for rows in sorted(groups, key=lambda r: -len(r.variables)):
        slots = {v.tobytes(): k for k, v in enumerate(rows.variables)}
        for k, other in enumerate(merged):
            known = {v.tobytes(): j for j, v in enumerate(other.variables)}
            if len(other.positions) == len(rows.positions) and slots.keys() <= known.keys():
                merged[k] = _with(other, rows, [known[v] for v in slots])
                break
        else:
            merged.append(rows)
    return merged


def _with(rows, more, variable_slots):
    """rows with the residuals of `more`, whose variables are variable_slots of `rows`."""
    num_variables, shift = len(rows.variables), len(rows.instructions)
    known = {d.tobytes(): j for j, d in enumerate(rows.data)}
    data, data_slots = list(rows.data), []
    for values in more.data:
        key = values.tobytes()
        if key not in known:
            known[key] = len(data)
            data.append(values)
        data_slots.append(num_variables + known[key])
    slots = variable_slots + data_slots
    instructions = list(rows.instructions)
    for op, a, b, c, value in more.instructions:
        if op == "input":
            instructions.append((op, slots[a], -1, -1, value))
        else:
            instructions.append((op, *(k + shift if k >= 0 else -1 for k in (a, b, c)), value))
    return Rows(np.concatenate([rows.positions, more.positions], axis=1), instructions,
                rows.outputs + [o + shift for o in more.outputs], rows.variables, data)

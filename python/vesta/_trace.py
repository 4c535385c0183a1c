# SPDX-License-Identifier: Apache-2.0
"""Symbolic arrays, which record the operations of a numpy function.

A graph consists of nodes. A node is one operation on a number of lanes: lane i of a node depends on one lane of each
operand. A symbolic array refers to one lane per element. So numpy itself does all indexing, reshaping and broadcasting,
on arrays of lane numbers, and only arithmetic adds nodes.
"""
import numpy as np

_SHIFT = 32  # the id of a lane: node << _SHIFT | lane


class TraceError(TypeError):
    """The function cannot be recorded, for instance because it branches on a value."""


class Node:
    """op: the name of an operation, "x" (entries of x), "data" (fixed numbers, in `values`), or "argument" (numbers
    that are known after the recording; `values` is the number of the argument).

    operands: pairs (node, lanes). Lane i uses lane lanes[i] of the operand's node; lanes None means lane i.
    """

    __slots__ = ("op", "operands", "size", "values")

    def __init__(self, op, size, operands=(), values=None):
        self.op, self.size, self.operands, self.values = op, size, operands, values


class Graph:
    def __init__(self):
        self.nodes = []
        self._scalars = {}

    def add(self, node):
        self.nodes.append(node)
        return len(self.nodes) - 1

    def variables(self, size):
        """The vector x of all parameters, shape (size,)."""
        return _make(self, (size,), self.add(Node("x", size)), None)

    def argument(self, number, shape):
        """Fixed numbers whose values are not needed for the recording."""
        return _make(self, shape, self.add(Node("argument", int(np.prod(shape)), values=number)), None)

    def constant(self, values):
        values = np.asarray(values, dtype=float)
        if values.ndim == 0:
            key = values.tobytes()
            if key not in self._scalars:
                self._scalars[key] = self.add(Node("data", 1, values=values.reshape(1)))
            return _make(self, (), self._scalars[key], None)
        return _make(self, values.shape, self.add(Node("data", values.size, values=values.ravel())), None)

    def array_of(self, value):
        """value as a symbolic array: symbolic, a number, an array of numbers, or an array or list of both."""
        if isinstance(value, Symbolic):
            if value.graph is not self:
                raise TraceError("the function uses a symbolic array of another call")
            return value
        array = np.asarray(value)
        if array.dtype == object:
            ids = np.empty(array.shape, np.int64)
            for index, element in np.ndenumerate(array):
                ids[index] = self.array_of(element).ids
            return self.from_ids(ids)
        if array.dtype.kind not in "buif":
            raise TraceError(f"the function uses an array of type {array.dtype}")
        return self.constant(array)

    def from_ids(self, ids):
        ids = np.asarray(ids)
        if ids.size:
            node = int(ids.flat[0] >> _SHIFT)
            lanes = ids - (node << _SHIFT)
            if lanes.min() >= 0 and lanes.max() < 1 << _SHIFT:
                return _make(self, ids.shape, node, lanes)
        return _make(self, ids.shape, None, ids)

    def apply(self, op, *arguments):
        """Adds an operation, element by element with broadcasting."""
        arrays = [self.array_of(a) for a in arguments]
        shape = np.broadcast_shapes(*(a.shape for a in arrays))
        size = int(np.prod(shape))
        if all(a.node is not None for a in arrays):
            operands = tuple((a.node, a.lanes_for(shape)) for a in arrays)
            return _make(self, shape, self.add(Node(op, size, operands)), None)
        # Elements with different operand nodes need different nodes.
        ids = np.stack([np.broadcast_to(a.ids, shape).ravel() for a in arrays])
        result = np.empty(size, np.int64)
        for at in equal_columns(ids >> _SHIFT):
            operands = tuple((int(row[at[0]] >> _SHIFT), row[at] & ((1 << _SHIFT) - 1)) for row in ids)
            result[at] = (self.add(Node(op, at.size, operands)) << _SHIFT) + np.arange(at.size)
        return self.from_ids(result.reshape(shape))


def equal_columns(table):
    """Groups of equal columns: a list of arrays of column numbers."""
    left, groups = np.arange(table.shape[1]), []
    while left.size and len(groups) < 16:
        same = (table[:, left] == table[:, left[:1]]).all(axis=0)
        groups.append(left[same])
        left = left[~same]
    if left.size:  # many groups: by sorting
        _, inverse = np.unique(table[:, left], axis=1, return_inverse=True)
        inverse = np.asarray(inverse).ravel()
        order = np.argsort(inverse, kind="stable")
        groups += [left[g] for g in np.split(order, np.flatnonzero(np.diff(inverse[order])) + 1)]
    return groups


def _make(graph, shape, node, lanes):
    return (SymbolicArray if len(shape) else SymbolicNumber)(graph, shape, node, lanes)


def _fail(what):
    raise TraceError(f"{what} needs the value of a symbolic array")


class Symbolic(np.lib.mixins.NDArrayOperatorsMixin):
    """node, lanes: the lanes `lanes` (shape `shape`; None: all in order) of one node. Or node None, lanes: ids."""

    dtype = np.dtype(float)

    def __init__(self, graph, shape, node, lanes):
        self.graph, self.shape, self.node, self._lanes = graph, tuple(shape), node, lanes

    @property
    def ids(self):
        if self.node is None:
            return self._lanes
        lanes = np.arange(self.size).reshape(self.shape) if self._lanes is None else self._lanes
        return lanes + (self.node << _SHIFT)

    def lanes_for(self, shape):
        """Lanes of `node` after broadcasting to `shape`, flat; None for all in order."""
        if self._lanes is None:
            if self.shape == tuple(shape):
                return None
            return np.broadcast_to(np.arange(self.size).reshape(self.shape), shape).ravel()
        return np.broadcast_to(self._lanes, shape).ravel()

    @property
    def size(self):
        return int(np.prod(self.shape))

    @property
    def ndim(self):
        return len(self.shape)

    def __array_ufunc__(self, ufunc, method, *inputs, **kwargs):
        from vesta._numpy_functions import call_ufunc
        return call_ufunc(self.graph, ufunc, method, inputs, kwargs)

    def __array_function__(self, function, types, args, kwargs):
        from vesta._numpy_functions import call_function
        return call_function(self.graph, function, args, kwargs)

    def __bool__(self):
        _fail("a branch (use np.where)")

    def __float__(self):
        _fail("float() or a function outside of numpy, or an assignment into an array of numbers (use np.zeros_like),")

    def __int__(self):
        _fail("int()")

    def __index__(self):
        _fail("an index")

    __hash__ = None


class SymbolicNumber(Symbolic):
    """An array of no dimensions. numpy puts such numbers into arrays of objects, and calls the methods below."""

    item = property(lambda self: _fail("item()"))


for _name in ("sqrt", "exp", "expm1", "log", "log1p", "log2", "log10", "sin", "cos", "tan", "arcsin", "arccos",
              "arctan", "sinh", "cosh", "tanh", "square", "fabs", "floor"):
    setattr(SymbolicNumber, _name, lambda self, ufunc=getattr(np, _name): ufunc(self))


class SymbolicArray(Symbolic):
    """An array of at least one dimension, with the methods of a numpy array that need no values."""

    def __len__(self):
        return self.shape[0]

    def __iter__(self):
        return (self[i] for i in range(len(self)))

    def __getitem__(self, index):
        if self.node is None:
            return self.graph.from_ids(self._lanes[index])
        lanes = np.arange(self.size).reshape(self.shape) if self._lanes is None else self._lanes
        lanes = np.asarray(lanes[index])
        return _make(self.graph, lanes.shape, self.node, lanes)

    def __setitem__(self, index, value):
        ids = np.array(self.ids)
        ids[index] = self.graph.array_of(value).ids
        changed = self.graph.from_ids(ids)
        self.node, self._lanes = changed.node, changed._lanes

    def restructured(self, function):
        """function: changes the shape or the order of an array."""
        if self.node is None:
            return self.graph.from_ids(function(self._lanes))
        if self._lanes is None:
            lanes = np.arange(self.size).reshape(self.shape)
            changed = np.asarray(function(lanes))
            if changed.size == lanes.size and np.shares_memory(changed, lanes) and changed.flags.c_contiguous:
                return _make(self.graph, changed.shape, self.node, None)
        else:
            changed = np.asarray(function(self._lanes))
        return _make(self.graph, changed.shape, self.node, changed)

    def reshape(self, *shape, order="C"):
        return self.restructured(lambda a: a.reshape(*shape, order=order))

    def ravel(self, order="C"):
        return self.restructured(lambda a: a.ravel(order))

    flatten = ravel

    def transpose(self, *axes):
        return self.restructured(lambda a: a.transpose(*axes))

    @property
    def T(self):
        return self.transpose()

    def squeeze(self, axis=None):
        return self.restructured(lambda a: a.squeeze(axis))

    def swapaxes(self, a, b):
        return self.restructured(lambda x: x.swapaxes(a, b))

    def copy(self, order="C"):
        return _make(self.graph, self.shape, self.node, self._lanes)

    def astype(self, dtype, **_):
        if np.dtype(dtype) != float:
            _fail(f"astype({dtype})")
        return self

    def sum(self, axis=None, keepdims=False, **_):
        return np.sum(self, axis=axis, keepdims=keepdims)

    def prod(self, axis=None, keepdims=False, **_):
        return np.prod(self, axis=axis, keepdims=keepdims)

    def mean(self, axis=None, keepdims=False, **_):
        return np.mean(self, axis=axis, keepdims=keepdims)

    def dot(self, other):
        return np.dot(self, other)

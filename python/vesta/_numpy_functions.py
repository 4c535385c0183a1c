# SPDX-License-Identifier: Apache-2.0
"""numpy functions on symbolic arrays: what __array_ufunc__ and __array_function__ call."""
import numpy as np

from vesta._trace import SymbolicArray, TraceError, Symbolic

_DIRECT = {
    np.add: "add", np.subtract: "subtract", np.multiply: "multiply", np.true_divide: "divide", np.power: "pow",
    np.float_power: "pow", np.arctan2: "atan2", np.minimum: "min", np.maximum: "max", np.fmin: "min", np.fmax: "max",
    np.less: "less", np.less_equal: "less_equal", np.equal: "equal", np.logical_and: "and", np.bitwise_and: "and",
    np.negative: "negate", np.absolute: "abs", np.fabs: "abs", np.sqrt: "sqrt", np.exp: "exp", np.expm1: "expm1",
    np.log: "log", np.log1p: "log1p", np.sin: "sin", np.cos: "cos", np.tan: "tan", np.arcsin: "asin",
    np.arccos: "acos", np.arctan: "atan", np.sinh: "sinh", np.cosh: "cosh", np.tanh: "tanh", np.floor: "floor",
    np.isnan: "is_nan", np.logical_not: "not", np.invert: "not",
}


def _or(a, b):
    return ~(~a & ~b)


_COMPOSED = {
    np.positive: lambda a: a,
    np.square: lambda a: a * a,
    np.reciprocal: lambda a: 1.0 / a,
    np.exp2: lambda a: np.exp(a * np.log(2.0)),
    np.log2: lambda a: np.log(a) * (1 / np.log(2.0)),
    np.log10: lambda a: np.log(a) * (1 / np.log(10.0)),
    np.cbrt: lambda a: np.sign(a) * np.abs(a) ** (1 / 3),
    np.sign: lambda a: np.where(a > 0, 1.0, np.where(a < 0, -1.0, 0.0)),
    np.heaviside: lambda a, b: np.where(a > 0, 1.0, np.where(a < 0, 0.0, b)),
    np.ceil: lambda a: -np.floor(-a),
    np.greater: lambda a, b: np.less(b, a),
    np.greater_equal: lambda a, b: np.less_equal(b, a),
    np.not_equal: lambda a, b: ~np.equal(a, b),
    np.logical_or: _or,
    np.bitwise_or: _or,
    np.isfinite: lambda a: np.less_equal(np.abs(a), np.finfo(float).max),
    np.hypot: lambda a, b: norm(np.stack(np.broadcast_arrays(a, b)), axis=0),
    np.deg2rad: lambda a: a * (np.pi / 180),
    np.radians: lambda a: a * (np.pi / 180),
    np.rad2deg: lambda a: a * (180 / np.pi),
    np.degrees: lambda a: a * (180 / np.pi),
    np.arcsinh: lambda a: np.sign(a) * np.log(np.abs(a) + np.sqrt(a * a + 1)),
    np.logaddexp: lambda a, b: np.maximum(a, b) + np.log1p(np.exp(-np.abs(a - b))),
}


def call_ufunc(graph, ufunc, method, inputs, kwargs):
    if method == "reduce" and ufunc in (np.add, np.multiply):
        return (_sum if ufunc is np.add else _prod)(*inputs, **kwargs)
    if method != "__call__" or kwargs.get("out") is not None or "where" in kwargs:
        raise TraceError(f"np.{ufunc.__name__} with out=, where= or method {method} cannot be recorded")
    inputs = [graph.array_of(i) for i in inputs]
    if ufunc in _DIRECT:
        return graph.apply(_DIRECT[ufunc], *inputs)
    if ufunc in _COMPOSED:
        return _COMPOSED[ufunc](*inputs)
    if ufunc is np.matmul:
        return _matmul(*inputs)
    raise TraceError(f"np.{ufunc.__name__} cannot be recorded")


def _fold(a, axis, keepdims, operation, empty):
    """Applies an operation of two operands along axes."""
    ids = a.ids
    if axis is None:
        axes = tuple(range(ids.ndim))
    else:
        axes = tuple(k % ids.ndim for k in (axis if isinstance(axis, tuple) else (axis,)))
    kept = [k for k in range(ids.ndim) if k not in axes]
    terms = ids.transpose(*axes, *kept).reshape(-1, *(ids.shape[k] for k in kept))
    graph = a.graph
    # Pairs first, as numpy does: a tree has less rounding and shorter dependencies.
    terms = [graph.from_ids(t) for t in terms] or [graph.array_of(np.full(terms.shape[1:], empty))]
    while len(terms) > 1:
        pairs = [operation(terms[i], terms[i + 1]) for i in range(0, len(terms) - 1, 2)]
        terms = pairs + terms[len(terms) & ~1:]
    if not keepdims:
        return terms[0]
    shape = tuple(1 if k in axes else n for k, n in enumerate(ids.shape))
    return graph.from_ids(terms[0].ids.reshape(shape))


def _sum(a, axis=None, dtype=None, out=None, keepdims=False, **_):
    return _fold(a, axis, keepdims, lambda x, y: x + y, 0.0)


def _prod(a, axis=None, dtype=None, out=None, keepdims=False, **_):
    return _fold(a, axis, keepdims, lambda x, y: x * y, 1.0)


def _mean(a, axis=None, keepdims=False, **_):
    total = _sum(a, axis, keepdims=keepdims)
    return total * (total.size / a.size)


def norm(a, ord=None, axis=None, keepdims=False):
    if ord not in (None, 2) or (axis is None and a.ndim > 1 and ord is not None):
        raise TraceError(f"np.linalg.norm with ord={ord} cannot be recorded")
    return a.graph.apply("norm", _sum(a * a, axis, keepdims=keepdims))


def _matmul(a, b):
    if a.ndim == 1 and b.ndim == 1:
        return _sum(a * b, 0)
    if b.ndim == 1:
        return _sum(a * b, -1)
    if a.ndim == 1:
        return _sum(a[:, None] * b, -2)
    return _sum(a[..., :, :, None] * b[..., None, :, :], -2)


def _dot(a, b):
    if a.ndim == 0 or b.ndim == 0:
        return a * b
    if a.ndim > 2 or b.ndim > 2:
        raise TraceError("np.dot of more than two dimensions cannot be recorded; use @ or np.einsum")
    return _matmul(a, b)


def _cross(a, b, axisa=-1, axisb=-1, axisc=-1, axis=None):
    if axis is not None:
        axisa = axisb = axisc = axis
    a, b = np.moveaxis(a, axisa, -1), np.moveaxis(b, axisb, -1)
    if a.shape[-1] != 3 or b.shape[-1] != 3:
        raise TraceError("np.cross of vectors that do not have 3 entries cannot be recorded")
    a, b = [a[..., k] for k in range(3)], [b[..., k] for k in range(3)]
    return np.stack([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]], axis=axisc)


def _einsum(subscripts, *operands, **_):
    if not isinstance(subscripts, str) or "." in subscripts:
        raise TraceError("np.einsum without a string of subscripts, or with an ellipsis, cannot be recorded")
    left, arrow, right = subscripts.replace(" ", "").partition("->")
    terms = left.split(",")
    if not arrow:
        right = "".join(sorted(c for c in set(left) - {","} if left.count(c) == 1))
    if len(terms) != len(operands) or any(len(set(t)) < len(t) for t in terms):
        raise TraceError(f'np.einsum("{subscripts}") cannot be recorded')
    summed = [c for c in dict.fromkeys(left) if c not in right and c != ","]
    order = list(right) + summed
    product = None
    for term, operand in zip(terms, operands):
        aligned = np.transpose(operand, [term.index(c) for c in order if c in term])
        aligned = aligned.reshape(tuple(aligned.shape[[c for c in order if c in term].index(c)] if c in term else 1
                                        for c in order))
        product = aligned if product is None else product * aligned
    return _sum(product, tuple(range(len(right), len(order)))) if summed else product


def _nan_to_num(x, copy=True, nan=0.0, posinf=None, neginf=None):
    big = np.finfo(float).max
    posinf, neginf = big if posinf is None else posinf, -big if neginf is None else neginf
    return np.where(np.isnan(x), nan, np.where(x > big, posinf, np.where(x < -big, neginf, x)))


def _clip(a, a_min=None, a_max=None, **_):
    a = a if a_min is None else np.maximum(a, a_min)
    return a if a_max is None else np.minimum(a, a_max)


def _where(condition, *choices):
    if len(choices) != 2:
        raise TraceError("np.where of one argument needs the value of a symbolic array")
    return condition.graph.apply("select", condition, *choices)


def _like(value):
    return lambda a, *args, shape=None, **_: a.graph.constant(
        np.full(a.shape if shape is None else shape, value if value is not None else args[0]))


_FUNCTIONS = {
    np.sum: _sum, np.prod: _prod, np.mean: _mean, np.linalg.norm: norm, np.dot: _dot, np.inner: _dot,
    np.cross: _cross, np.einsum: _einsum, np.where: _where, np.nan_to_num: _nan_to_num, np.clip: _clip,
    np.zeros_like: _like(0.0), np.empty_like: _like(0.0), np.ones_like: _like(1.0), np.full_like: _like(None),
    np.outer: lambda a, b: a.ravel()[:, None] * b.ravel()[None, :],
    np.diff: lambda a, n=1, axis=-1: a if n == 0 else np.diff(
        np.moveaxis(np.moveaxis(a, axis, 0)[1:] - np.moveaxis(a, axis, 0)[:-1], 0, axis), n - 1, axis),
    np.trace: lambda a: _sum(a[np.arange(min(a.shape)), np.arange(min(a.shape))]),
    np.shape: lambda a: a.shape, np.size: lambda a, axis=None: a.size if axis is None else a.shape[axis],
    np.ndim: lambda a: a.ndim, np.polyval: lambda p, x: _polyval(p, x), np.copy: lambda a, **_: a,
    np.real: lambda a: a,
}

# Functions that only move elements.
_MOVING = {
    np.reshape, np.ravel, np.transpose, np.squeeze, np.expand_dims, np.broadcast_to, np.broadcast_arrays, np.moveaxis,
    np.swapaxes, np.rollaxis, np.tile, np.repeat, np.take, np.flip, np.fliplr, np.flipud, np.roll, np.rot90, np.delete,
    np.atleast_1d, np.atleast_2d, np.atleast_3d, np.concatenate, np.stack, np.vstack, np.hstack, np.dstack,
    np.column_stack, np.split, np.array_split, np.hsplit, np.vsplit, np.take_along_axis, np.compress, np.block,
    np.append,
}
# Their arguments that are not elements, by position.
_NOT_ELEMENTS = {np.take: (1,), np.repeat: (1,), np.delete: (1,), np.compress: (0,), np.take_along_axis: (1,)}


def _polyval(p, x):
    result = p[0]
    for coefficient in list(p)[1:]:
        result = result * x + coefficient
    return result


def _ids(graph, value):
    """Arrays as ids, also in lists and tuples; other values unchanged."""
    if isinstance(value, (list, tuple)) and any(isinstance(v, (Symbolic, np.ndarray, list, tuple)) for v in value):
        return type(value)(_ids(graph, v) for v in value)
    if isinstance(value, Symbolic) or (isinstance(value, np.ndarray) and value.dtype.kind in "fO"):
        return graph.array_of(value).ids
    return value


def _from_ids(graph, value):
    if isinstance(value, (list, tuple)):
        return type(value)(_from_ids(graph, v) for v in value)
    return graph.from_ids(value)


def _moved(graph, function, args, kwargs):
    if len(args) == 1 and isinstance(args[0], SymbolicArray) and not kwargs:
        return args[0].restructured(function)
    skipped = _NOT_ELEMENTS.get(function, ())
    first = args[0] if args else kwargs
    if not isinstance(first, (list, tuple, dict)) and 0 not in skipped and not isinstance(first, Symbolic):
        args = (graph.array_of(first), *args[1:])
    if isinstance(first, (list, tuple)):
        args = ([graph.array_of(v) if not isinstance(v, (list, tuple)) else v for v in first], *args[1:])
    args = [a if k in skipped else _ids(graph, a) for k, a in enumerate(args)]
    return _from_ids(graph, function(*args, **{k: _ids(graph, v) for k, v in kwargs.items()}))


def call_function(graph, function, args, kwargs):
    if function in _MOVING:
        return _moved(graph, function, args, kwargs)
    if function not in _FUNCTIONS:
        raise TraceError(f"np.{function.__name__} cannot be recorded")
    args = [graph.array_of(a) if isinstance(a, (np.ndarray, list)) and function is not np.einsum else a for a in args]
    if function is np.einsum:
        args = [a if isinstance(a, str) else graph.array_of(a) for a in args]
    if function is np.where:
        args[0] = graph.array_of(args[0])
    return _FUNCTIONS[function](*args, **kwargs)

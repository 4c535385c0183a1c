# SPDX-License-Identifier: Apache-2.0
"""Recorded functions have numpy's values and exact derivatives."""
import unittest

import numpy as np

import vesta
from vesta._trace import TraceError
from vesta.least_squares import _matrix, _recorded


def evaluate(function, x):
    """Residuals and Jacobian of the recorded function, in the order of the function."""
    problem = _recorded(function, np.asarray(x, float), None)
    values = problem.problem.evaluate(apply_loss=False, derivatives=True)
    residuals = np.empty(len(problem.positions))
    residuals[problem.positions] = values["residuals"]
    jacobian = _matrix(values, problem.positions, problem.order, len(x))
    return residuals, jacobian.toarray() if hasattr(jacobian, "toarray") else jacobian


def central_differences(function, x):
    x = np.asarray(x, float)
    columns = []
    for i in range(len(x)):
        step = np.zeros_like(x)
        step[i] = 1e-5 * max(1.0, abs(x[i]))
        columns.append((np.ravel(function(x + step)) - np.ravel(function(x - step))) / (2 * step[i]))
    return np.stack(columns, axis=1)


A = np.arange(12.0).reshape(3, 4) / 7 - 0.8
CAMERA = np.array([0, 1, 1, 0, 2])

# Functions of x with 12 entries between 0.2 and 0.9; each uses every entry.
FUNCTIONS = {
    "arithmetic": lambda x: (x + 2) * x / (1 + x) - 3 * x + (-x) ** 2 + 2 / x + (1 - x),
    "powers": lambda x: x**3 + x**0.5 + x**-1 + x**2.5 + 2**x + x**x + np.square(x) + np.reciprocal(x),
    "exponentials": lambda x: np.exp(x) + np.log(x) + np.log1p(x) + np.expm1(x) + np.log2(x) + np.log10(x) + np.exp2(x),
    "circular": lambda x: np.sin(x) + np.cos(x) + np.tan(x) + np.arcsin(x) + np.arccos(x) + np.arctan(x),
    "hyperbolic": lambda x: np.sinh(x) + np.cosh(x) + np.tanh(x) + np.arcsinh(x),
    "two operands": lambda x: np.arctan2(x, x[::-1] + 1) + np.hypot(x, 2.0) + np.logaddexp(x, 2 * x),
    "kinks": lambda x: np.abs(x - 0.5001) + np.minimum(x, 0.43) + np.maximum(x, x[::-1] + 0.01) + np.clip(x, 0.3, 0.7),
    "where": lambda x: np.where((x > 0.5) | ~(x <= 0.7), x * x, np.sin(x)) + np.sign(x) + np.floor(x + 0.3),
    "not finite": lambda x: np.nan_to_num(np.where(x > 0.5, x, np.nan)) + x + np.isfinite(x),
    "matrix": lambda x: np.concatenate([(A @ x.reshape(4, 3)).ravel(), x[:4] @ A.T, x.reshape(3, 4).T.dot(x[:3]),
                                        [x[4:8].dot(x[8:])]]),
    "einsum": lambda x: np.concatenate([np.einsum("ij,kj->ik", x.reshape(3, 4), A).ravel(),
                                        np.einsum("ij,ij->i", x.reshape(3, 4), A)]),
    "sums": lambda x: np.concatenate([x.reshape(3, 4).sum(axis=0), np.mean(x.reshape(3, 4), axis=1),
                                      np.prod(x.reshape(3, 4), axis=1), np.sum(x.reshape(3, 2, 2), axis=(0, 2)),
                                      [x.sum()]]),
    "norms": lambda x: np.concatenate([np.linalg.norm(x.reshape(4, 3), axis=1), [np.linalg.norm(x)]]),
    "cross": lambda x: np.cross(x.reshape(4, 3), x[:3]).ravel() + np.cross(x.reshape(4, 3), A[:, :3].T[0]).ravel() + x,
    "shapes": lambda x: np.concatenate([np.stack([x[:6], x[6:]], axis=1).ravel(), np.hstack([x[::2], x[1::2]]),
                                        np.tile(x[:2], 3), np.repeat(x[3:5], 2), np.roll(x, 2), np.flip(x),
                                        np.moveaxis(x.reshape(2, 3, 2), 0, 2).ravel(), np.diff(x), np.outer(x[:2], x[3:5]).ravel()]),
    "indices": lambda x: (x.reshape(3, 4)[CAMERA, 1:3] * x[4:6]).ravel(),
    "python loop": lambda x: np.array([x[i] * x[i + 1] - np.sin(x[i]) for i in range(11)]),
    "list of arrays": lambda x: np.array([x[:6] * 2, x[6:] ** 2]).T,
    "assignment": lambda x: _assigned(x),
    "rotation": lambda x: vesta.rotate(x.reshape(4, 3), np.roll(x, 1).reshape(4, 3)).ravel(),
    "polynomial": lambda x: np.polyval(A[0], x),
}


def _assigned(x):
    y = np.zeros_like(x)
    y[:6] = x[6:] * 2
    y[6:] = np.cos(x[:6])
    return y


class RecordedFunctions(unittest.TestCase):
    def test_values_and_derivatives(self):
        x = np.linspace(0.2, 0.9, 12) + 0.003 * np.arange(12) ** 2 % 0.01
        for name, function in FUNCTIONS.items():
            with self.subTest(name):
                residuals, jacobian = evaluate(lambda x: np.ravel(function(x)), x)
                np.testing.assert_allclose(residuals, np.ravel(np.asarray(function(x), float)), rtol=1e-14, atol=1e-14)
                np.testing.assert_allclose(jacobian, central_differences(function, x), rtol=1e-7, atol=1e-7)

    def test_derivatives_at_special_points(self):
        x = np.array([0.0, 0.0, 0.0, 1.0, 2.0, 3.0])
        _, jacobian = evaluate(lambda x: np.atleast_1d(np.linalg.norm(x[:3])) + x[3], x)
        np.testing.assert_array_equal(jacobian[0], [0, 0, 0, 1, 0, 0])
        _, jacobian = evaluate(lambda x: vesta.rotate(x[:3], x[3:]), x)
        np.testing.assert_array_equal(jacobian, np.hstack([[[0, 3, -2], [-3, 0, 1], [2, -1, 0]], np.eye(3)]))
        _, jacobian = evaluate(lambda x: np.where(x > 0, np.sqrt(x), x), x)
        np.testing.assert_allclose(np.diag(jacobian), [1, 1, 1, 0.5, 0.5 / np.sqrt(2), 0.5 / np.sqrt(3)], rtol=1e-15)

    def test_many_rows(self):
        # More rows than one chunk, and a number that no SIMD width divides.
        x = np.linspace(-1, 1, 1237)
        residuals, jacobian = evaluate(lambda x: x[1:] * np.sin(x[:-1]), x)
        np.testing.assert_allclose(residuals, x[1:] * np.sin(x[:-1]), rtol=1e-15, atol=1e-16)
        expected = np.zeros_like(jacobian)
        i = np.arange(1236)
        expected[i, i], expected[i, i + 1] = x[1:] * np.cos(x[:-1]), np.sin(x[:-1])
        np.testing.assert_allclose(jacobian, expected, rtol=1e-15, atol=1e-16)

    def test_what_cannot_be_recorded(self):
        import math
        for name, function in {
            "branch": lambda x: x if x[0] > 0 else -x,
            "math": lambda x: x * math.sin(x[0]),
            "max": lambda x: x - np.max(x),
            "sort": lambda x: np.sort(x),
            "solve": lambda x: np.linalg.solve(np.eye(3) * x[0], x[:3]),
            "assignment into numbers": lambda x: np.zeros(3).__setitem__(0, x[0]),
            "constant residual": lambda x: np.array([x[0], 3.0]),
        }.items():
            with self.subTest(name), self.assertRaises(TraceError):
                evaluate(function, np.ones(3))


if __name__ == "__main__":
    unittest.main()

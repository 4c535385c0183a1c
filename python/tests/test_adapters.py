# SPDX-License-Identifier: Apache-2.0
"""Run where jax or torch is installed."""
import importlib.util
import unittest

import numpy as np

import vesta


def fit(function, jac):
    t = np.linspace(0, 1, 40)
    y = 3 * np.exp(-2 * t)
    problem = vesta.Problem()
    p = problem.add_blocks([1.0, 1.0])
    problem.add_residuals(function, [p], [t[:, None], y[:, None]], jac=lambda *a: jac(1, *a))
    assert problem.check() == []
    problem.solve(function_tolerance=1e-14)
    np.testing.assert_allclose(p.values, [[3, 2]], rtol=1e-6)


class Adapters(unittest.TestCase):
    @unittest.skipUnless(importlib.util.find_spec("jax"), "jax is not installed")
    def test_jax(self):
        import jax.numpy as jnp

        fit(*vesta.from_jax(lambda p, t, y: p[0] * jnp.exp(-p[1] * t) - y))

    @unittest.skipUnless(importlib.util.find_spec("torch"), "torch is not installed")
    def test_torch(self):
        import torch

        fit(*vesta.from_torch(lambda p, t, y: p[:, :1] * torch.exp(-p[:, 1:] * t) - y))


if __name__ == "__main__":
    unittest.main()

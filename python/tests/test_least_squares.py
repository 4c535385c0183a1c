# SPDX-License-Identifier: Apache-2.0
import unittest

import numpy as np
import scipy.optimize
import scipy.sparse
import scipy.sparse.linalg

import vesta

RNG = np.random.default_rng(1)
T = np.linspace(0, 3, 200)
Y = 2.5 * np.exp(-1.3 * T) + 0.3 * np.sin(T) + 0.01 * RNG.standard_normal(200)
Y_OUTLIERS = Y + np.where(np.arange(200) % 17 == 0, 1.0, 0.0)


def decay(p, t=T, y=Y):
    return p[0] * np.exp(-p[1] * t) + p[2] * np.sin(t) - y


def decay_jacobian(p, t=T, y=Y):
    e = np.exp(-p[1] * t)
    return np.stack([e, -p[0] * t * e, np.sin(t)], axis=1)


class LeastSquares(unittest.TestCase):
    def assert_same(self, ours, theirs, rtol=1e-6):
        np.testing.assert_allclose(ours.x, theirs.x, rtol=rtol, atol=rtol)
        self.assertAlmostEqual(ours.cost / theirs.cost, 1, delta=1e-8)
        np.testing.assert_allclose(ours.fun, theirs.fun, atol=1e-5)

    def test_agrees_with_scipy(self):
        for jac, kind in ((None, "recorded"), ("2-point", "differences"), ("3-point", "differences"),
                          (decay_jacobian, "jac")):
            with self.subTest(kind):
                ours = vesta.least_squares(decay, [1, 1, 0], jac=jac)
                theirs = scipy.optimize.least_squares(decay, [1, 1, 0], ftol=1e-12, xtol=1e-12)
                self.assertEqual(ours.derivatives, kind)
                self.assertTrue(ours.success)
                self.assert_same(ours, theirs)
                np.testing.assert_allclose(ours.jac, decay_jacobian(ours.x), atol=1e-6)
                np.testing.assert_allclose(ours.grad, ours.jac.T @ ours.fun, atol=1e-12)

    def test_losses(self):
        for loss in ("huber", "soft_l1", "cauchy", "arctan"):
            with self.subTest(loss):
                arguments = dict(loss=loss, f_scale=0.02, args=(T, Y_OUTLIERS))
                start = [2, 1, 0.2]  # from [1, 1, 0] scipy finds a worse minimum with arctan
                ours = vesta.least_squares(decay, start, ftol=1e-14, **arguments)
                theirs = scipy.optimize.least_squares(decay, start, ftol=1e-15, xtol=1e-15, gtol=1e-12, **arguments)
                self.assert_same(ours, theirs, rtol=1e-5)

    def test_bounds(self):
        ours = vesta.least_squares(decay, [1, 1, 0], bounds=([0, 0, -1], [2.2, np.inf, 1]), ftol=1e-12)
        # The minimum with the first parameter held at its bound; scipy's interior point ends a little off it.
        held = vesta.least_squares(lambda p: decay([2.2, p[0], p[1]]), [1, 0], ftol=1e-14)
        np.testing.assert_allclose(ours.x, [2.2, *held.x], atol=1e-6)
        theirs = scipy.optimize.least_squares(decay, [1, 1, 0], bounds=([0, 0, -1], [2.2, np.inf, 1]))
        self.assertLessEqual(ours.cost, theirs.cost)
        self.assertLess(ours.optimality, 1e-6)
        self.assertEqual(list(ours.active_mask), [1, 0, 0])
        with self.assertRaisesRegex(ValueError, "bounds"):
            vesta.least_squares(decay, [3, 1, 0], bounds=([0, 0, -1], [2.2, np.inf, 1]))

    def test_sparse(self):
        # Broyden's tridiagonal function.
        n = 300

        def broyden(x):
            padded = np.concatenate([[-1.0], x, [-1.0]])
            return (3 - x) * x + 1 - padded[:-2] - 2 * padded[2:]

        def jacobian(x):
            return scipy.sparse.diags([-np.ones(n - 1), 3 - 2 * x, -2 * np.ones(n - 1)], [-1, 0, 1], format="csr")

        def concatenated(x):
            padded = np.concatenate([np.array([-1.0]), x, np.array([-1.0])])
            return (3 - x) * x + 1 - padded[:-2] - 2 * padded[2:]

        sparsity = scipy.sparse.diags([1, 1, 1], [-1, 0, 1], shape=(n, n))
        for name, function, arguments in (("recorded", concatenated, {}), ("jac", broyden, {"jac": jacobian}),
                                          ("differences", broyden, {"jac": "2-point", "jac_sparsity": sparsity})):
            with self.subTest(name):
                result = vesta.least_squares(function, -np.ones(n), ftol=1e-15, **arguments)
                self.assertEqual(result.derivatives, name)
                self.assertLess(np.abs(result.fun).max(), 1e-8)
                self.assertTrue(scipy.sparse.issparse(result.jac))
                np.testing.assert_allclose(result.jac.toarray(), jacobian(result.x).toarray(), atol=1e-6)

    def test_linear_operator(self):
        # Deconvolution of a signal; the Jacobian is a convolution by FFT.
        n = 64
        kernel = np.fft.rfft(np.exp(-0.5 * (np.minimum(np.arange(n), n - np.arange(n)) / 1.0) ** 2))
        blur = lambda v: np.fft.irfft(kernel * np.fft.rfft(v), n)
        x = np.random.default_rng(2).random(n)
        y = blur(x**3)

        class Jacobian(scipy.sparse.linalg.LinearOperator):
            def __init__(self, x):
                super().__init__(float, (n, n))
                self.x = x

            def _matvec(self, v):
                return blur(3 * self.x**2 * np.ravel(v))

            def _rmatvec(self, u):
                return 3 * self.x**2 * blur(np.ravel(u))

        result = vesta.least_squares(lambda x: blur(x**3) - y, np.full(n, 0.5), jac=Jacobian, ftol=1e-14, max_nfev=500)
        self.assertLess(np.abs(result.fun).max(), 1e-3)
        with self.assertRaisesRegex(ValueError, "LinearOperator"):
            vesta.least_squares(lambda x: blur(x**3) - y, np.full(n, 0.5), jac=Jacobian, loss="huber")

    def test_sparsity_shares_evaluations(self):
        n, calls = 200, []

        def function(x):
            calls.append(1)
            return x[1:] ** 2 - x[:-1] if isinstance(x, np.ndarray) else None

        pattern = scipy.sparse.diags([1, 1], [0, 1], shape=(n - 1, n))
        vesta.least_squares(function, np.ones(n), jac="2-point", jac_sparsity=pattern, max_nfev=1)
        self.assertLess(len(calls), 20)

    def test_falls_back_to_differences(self):
        def branching(p):
            return decay(p) if p[0] > 0 else np.ones(200)

        result = vesta.least_squares(branching, [1, 1, 0])
        self.assertEqual(result.derivatives, "differences")
        self.assertIn("branch", result.note)
        np.testing.assert_allclose(result.x, vesta.least_squares(decay, [1, 1, 0]).x, rtol=1e-6)

    def test_repeats_to_the_bit(self):
        first, second = (vesta.least_squares(decay, [1, 1, 0]) for _ in range(2))
        np.testing.assert_array_equal(first.x, second.x)

    def test_callback_stops(self):
        rows = []

        def callback(row):
            rows.append((int(row["iteration"]), float(row["cost"])))
            return len(rows) < 3

        result = vesta.least_squares(decay, [1, 1, 0], callback=callback)
        self.assertEqual(len(rows), 3)
        self.assertEqual(result.status, -2)

    def test_errors(self):
        with self.assertRaisesRegex(ValueError, "loss"):
            vesta.least_squares(decay, [1, 1, 0], loss="l7")
        with self.assertRaisesRegex(ValueError, "jac"):
            vesta.least_squares(decay, [1, 1, 0], jac="4-point")
        with self.assertRaises(ValueError):
            vesta.least_squares(lambda x: np.log(x - 5), np.ones(3))
        with self.assertRaisesRegex(ZeroDivisionError, "mine"):
            vesta.least_squares(self._raises, np.ones(3), jac="2-point")
        with self.assertRaisesRegex(ValueError, "shape"):
            vesta.least_squares(decay, [1, 1, 0], jac="2-point", jac_sparsity=np.ones((2, 3)))

    @staticmethod
    def _raises(x):
        raise ZeroDivisionError("mine")


if __name__ == "__main__":
    unittest.main()

# SPDX-License-Identifier: Apache-2.0
import unittest

import numpy as np
import scipy.optimize

import vesta

T = np.linspace(0, 3, 30)


def decay(x, t, y):
    return x[0] * np.exp(-x[1] * t) + x[2] - y


class LeastSquaresEach(unittest.TestCase):
    def setUp(self):
        rng = np.random.default_rng(0)
        # A number of problems that no SIMD width divides, and more than one task.
        true = np.stack([1 + rng.random(301), 0.5 + rng.random(301), 0.2 * rng.standard_normal(301)], axis=1)
        self.y = decay(true.T[:, :, None], T, 0.01 * rng.standard_normal((301, 30)))

    def test_agrees_with_scipy(self):
        result = vesta.least_squares_each(decay, np.ones((301, 3)), (T, self.y), ftol=1e-12)
        self.assertTrue(result.success.all())
        for i in range(0, 301, 50):
            theirs = scipy.optimize.least_squares(decay, np.ones(3), args=(T, self.y[i]), ftol=1e-12)
            np.testing.assert_allclose(result.x[i], theirs.x, rtol=1e-5)
            self.assertAlmostEqual(result.cost[i], theirs.cost, places=12)

    def test_problems_do_not_depend_on_each_other(self):
        whole = vesta.least_squares_each(decay, np.ones((301, 3)), (T, self.y))
        some = vesta.least_squares_each(decay, np.ones((5, 3)), (T, self.y[100:105]))
        np.testing.assert_array_equal(some.x, whole.x[100:105])

    def test_times_of_each_problem(self):
        t = T * np.linspace(0.5, 1.5, 301)[:, None]
        y = 2 * np.exp(-0.7 * t)
        result = vesta.least_squares_each(lambda x, t, y: x[0] * np.exp(-x[1] * t) - y, np.ones((301, 2)), (t, y),
                                          ftol=1e-15)
        np.testing.assert_allclose(result.x, np.tile([2, 0.7], (301, 1)), rtol=1e-6)

    def test_one_parameter(self):
        result = vesta.least_squares_each(lambda x, y: x[0] ** 2 - y, np.ones((4, 1)), (np.full((4, 3), 2.0),))
        np.testing.assert_allclose(result.x, np.full((4, 1), np.sqrt(2)), rtol=1e-6)

    def test_wrong_arguments(self):
        with self.assertRaisesRegex(ValueError, "shape"):
            vesta.least_squares_each(decay, np.ones(3), (T, self.y))
        with self.assertRaises(ValueError):
            vesta.least_squares_each(lambda x, y: sum(x[k] for k in range(13)) - y, np.ones((301, 13)), (self.y,))
        with self.assertRaises(vesta.TraceError):
            vesta.least_squares_each(lambda x, y: np.concatenate([x[0] - y[:, :3], np.sin(x[1]) - y[:, 3:]], axis=1),
                                     np.ones((301, 2)), (self.y,))


if __name__ == "__main__":
    unittest.main()

# SPDX-License-Identifier: Apache-2.0
import resource
import signal
import threading
import unittest

import numpy as np

import vesta


def random_rotations(count, rng):
    q = rng.standard_normal((count, 4))
    return q / np.linalg.norm(q, axis=1, keepdims=True)


def relative(a, b, measured):
    """Rotation vectors between measured relative rotations and those of the quaternions a and b."""
    between = vesta.multiply_quaternions(vesta.conjugate_quaternion(a), b)
    return 2 * vesta.multiply_quaternions(vesta.conjugate_quaternion(measured), between)[:, 1:]


def project(camera, point, pixel):
    """A camera of a rotation vector, a translation and a focal length."""
    p = vesta.rotate(camera[:, :3], point) + camera[:, 3:6]
    return camera[:, 6:7] * p[:, :2] / p[:, 2:] - pixel


def small_scene(rng):
    cameras = np.concatenate([0.1 * rng.standard_normal((5, 6)), np.full((5, 1), 100.0)], axis=1)
    points = rng.standard_normal((40, 3)) + [0, 0, 6]
    camera_of, point_of = np.repeat(np.arange(5), 40), np.tile(np.arange(40), 5)
    pixels = project(cameras[camera_of], points[point_of], 0) + 0.1 * rng.standard_normal((200, 2))
    return cameras, points, camera_of, point_of, pixels


class Problems(unittest.TestCase):
    def setUp(self):
        self.rng = np.random.default_rng(3)

    def bundle(self, jac=None, loss=None):
        cameras, points, camera_of, point_of, pixels = small_scene(self.rng)
        problem = vesta.Problem()
        c = problem.add_blocks(cameras + 0.01 * self.rng.standard_normal(cameras.shape))
        p = problem.add_blocks(points + 0.05 * self.rng.standard_normal(points.shape))
        problem.add_residuals(project, [c[camera_of], p[point_of]], [pixels], loss=loss, jac=jac)
        c[:2].set_constant()
        return problem, c, p

    def test_bundle_adjustment(self):
        results = []
        for jac in (None, "2-point"):
            self.rng = np.random.default_rng(3)
            problem, _, points = self.bundle(jac, vesta.Huber(0.3))
            self.assertEqual(problem.check(), [])
            summary = problem.solve(function_tolerance=1e-9, max_iterations=200)
            self.assertTrue(summary.converged)
            self.assertAlmostEqual(summary.final_cost, problem.cost(), places=12)
            self.assertEqual(summary.iterations["cost"][-1], summary.final_cost)
            results.append((summary.final_cost, points.values))
        self.assertAlmostEqual(results[0][0] / results[1][0], 1, places=6)
        np.testing.assert_allclose(results[0][1], results[1][1], atol=1e-3)

    def test_rotation_averaging(self):
        q = random_rotations(20, self.rng)
        i = self.rng.integers(0, 20, 100)
        j = (i + self.rng.integers(1, 19, 100)) % 20
        measured = vesta.multiply_quaternions(vesta.conjugate_quaternion(q[i]), q[j])
        problem = vesta.Problem()
        start = q + 0.1 * self.rng.standard_normal(q.shape)
        start[0] = q[0]
        rotations = problem.add_blocks(start / np.linalg.norm(start, axis=1, keepdims=True), vesta.SO3())
        rotations[0].set_constant()
        problem.add_residuals(relative, [rotations[i], rotations[j]], [measured])
        self.assertEqual(problem.check(), [])
        problem.solve(function_tolerance=0, gradient_tolerance=1e-12)
        same = np.abs(np.sum(rotations.values * q, axis=1))
        np.testing.assert_allclose(same, 1, atol=1e-12)
        np.testing.assert_allclose(np.linalg.norm(rotations.values, axis=1), 1, atol=1e-14)

    def test_given_jacobian(self):
        t = np.linspace(0, 1, 50)
        y = 3 * np.exp(-2 * t)
        problem = vesta.Problem()
        p = problem.add_blocks([1.0, 1.0])
        problem.add_residuals(lambda p, t, y: p[:, 0] * np.exp(-p[:, 1] * t) - y, [p], [t, y],
                              jac=lambda p, t, y: [np.stack([np.exp(-p[:, 1] * t), -t * p[:, 0] * np.exp(-p[:, 1] * t)],
                                                            axis=1)[:, None, :]])
        self.assertEqual(problem.check(), [])
        problem.solve(function_tolerance=1e-15)
        np.testing.assert_allclose(p.values, [[3, 2]], rtol=1e-6)

    def test_covariance(self):
        t = np.linspace(0, 1, 50)
        problem = vesta.Problem()
        p = problem.add_blocks([0.5, -1.0])
        problem.add_residuals(lambda p, t: p[:, 0] + p[:, 1] * t - np.sin(t), [p], [t])
        problem.solve()
        j = np.stack([np.ones_like(t), t], axis=1)
        np.testing.assert_allclose(problem.covariance(p), [np.linalg.inv(j.T @ j)], rtol=1e-10)

    def test_bounds_and_constants(self):
        problem = vesta.Problem()
        p = problem.add_blocks(np.zeros((3, 2)))
        problem.add_residuals(lambda p: p - np.array([1.0, 2.0]), [p])
        p[1].set_constant()
        p[2].set_bounds([-1, -1], [0.5, 5])
        problem.solve()
        np.testing.assert_allclose(p.values, [[1, 2], [0, 0], [0.5, 2]], atol=1e-12)
        p.values = 7.0
        np.testing.assert_array_equal(p.values, np.full((3, 2), 7.0))

    def test_losses_of_rows(self):
        for loss, rho in ((vesta.Cauchy(2.0), lambda s: 4 * np.log1p(s / 4)), (vesta.Scaled(None, 3.0), lambda s: 3 * s),
                          (vesta.Huber(1.0), lambda s: 2 * np.sqrt(s) - 1)):
            problem = vesta.Problem()
            p = problem.add_blocks([3.0, 4.0])
            problem.add_residuals(lambda p: p, [p], loss=loss)
            self.assertAlmostEqual(problem.cost(), 0.5 * rho(25.0), places=12)

    def test_wrong_arguments(self):
        problem, other = vesta.Problem(), vesta.Problem()
        p, q = problem.add_blocks(np.ones((3, 2))), other.add_blocks(np.ones((3, 2)))
        with self.assertRaisesRegex(ValueError, "another problem"):
            problem.add_residuals(lambda p: p, [q])
        with self.assertRaisesRegex(ValueError, "rows"):
            problem.add_residuals(lambda p, q: p - q, [p[[0, 1]], p])
        with self.assertRaisesRegex(ValueError, "shape"):
            problem.add_residuals(lambda p: p[:1], [p])
        with self.assertRaisesRegex(vesta.TraceError, "2-point"):
            problem.add_residuals(lambda p: p if p[0, 0] > 0 else -p, [p])
        with self.assertRaises(ValueError):
            problem.add_blocks(np.ones((3, 2)), vesta.SO3())
        with self.assertRaises(ValueError):
            problem.add_residuals(lambda a, b: a - b, [p[[0]], p[[0]]], jac="2-point")  # one block twice
        problem.add_residuals(lambda p: np.log(p - 2), [p])
        with self.assertRaises(ValueError):
            problem.solve()

    def test_exceptions_reach_the_caller(self):
        problem = vesta.Problem()
        p = problem.add_blocks(np.ones((3, 2)))
        calls = []

        def fails(p):
            calls.append(1)
            if len(calls) > 3:
                raise KeyError("mine")
            return p * p

        problem.add_residuals(fails, [p], jac="2-point")
        with self.assertRaisesRegex(KeyError, "mine"):
            problem.solve()

    def test_interrupt(self):
        problem, _, points = self.bundle()
        before = points.values

        def interrupt(row):
            if row["iteration"] == 2:
                signal.raise_signal(signal.SIGINT)

        with self.assertRaises(KeyboardInterrupt):
            problem.solve(callback=interrupt, function_tolerance=0)
        np.testing.assert_array_equal(points.values, before)
        problem.solve()

    def test_two_threads(self):
        problem, _, points = self.bundle(loss=vesta.Huber(0.3))
        problem.solve()
        results = [None, None]

        def solve(k):
            self_rng = np.random.default_rng(3)
            cameras, scene_points, camera_of, point_of, pixels = small_scene(self_rng)
            own = vesta.Problem()
            c = own.add_blocks(cameras + 0.01 * self_rng.standard_normal(cameras.shape))
            p = own.add_blocks(scene_points + 0.05 * self_rng.standard_normal(scene_points.shape))
            own.add_residuals(project, [c[camera_of], p[point_of]], [pixels], loss=vesta.Huber(0.3))
            c[:2].set_constant()
            own.solve()
            results[k] = p.values

        threads = [threading.Thread(target=solve, args=(k,)) for k in range(2)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        for result in results:
            np.testing.assert_array_equal(result, points.values)

    def test_memory_stays_level(self):
        def peak():
            return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss  # KiB

        for repeat in range(100):
            if repeat == 20:
                before = peak()
            self.rng = np.random.default_rng(3)
            self.bundle()[0].solve()
            vesta.least_squares(lambda x: x**2 - 2, np.ones(1000), jac="2-point" if repeat % 10 == 0 else None,
                                jac_sparsity=np.eye(1000))
        self.assertLess(peak() - before, 20_000)


if __name__ == "__main__":
    unittest.main()

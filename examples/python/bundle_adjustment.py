#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Bundle adjustment of a BAL file, with residuals in numpy.

  PYTHONPATH=build/python python3 examples/python/bundle_adjustment.py [FILE]

FILE: a file of "Bundle Adjustment in the Large" (Agarwal et al. 2010); by default a small scene is made.
"""
import sys

import numpy as np

import vesta


def read_bal(path):
    """Returns camera and point of each observation, pixels (n, 2), cameras (M, 9) and points (N, 3)."""
    with open(path) as file:
        numbers = np.array(file.read().split(), float)
    num_cameras, num_points, n = numbers[:3].astype(int)
    observations = numbers[3:3 + 4 * n].reshape(n, 4)
    rest = numbers[3 + 4 * n:]
    return (observations[:, 0].astype(int), observations[:, 1].astype(int), observations[:, 2:],
            rest[:9 * num_cameras].reshape(-1, 9), rest[9 * num_cameras:].reshape(-1, 3))


def project(cameras, points):
    """Pixels (n, 2) of points (n, 3). A camera is a rotation vector, a translation, focal length and two distortions."""
    p = vesta.rotate(cameras[:, :3], points) + cameras[:, 3:6]
    p = -p[:, :2] / p[:, 2:]
    r2 = vesta.dot(p, p)
    return p * (cameras[:, 6] * (1 + r2 * (cameras[:, 7] + r2 * cameras[:, 8])))[:, None]


def small_scene():
    rng = np.random.default_rng(0)
    cameras = np.concatenate([0.1 * rng.standard_normal((6, 6)), np.tile([500.0, 0.01, 0.0], (6, 1))], axis=1)
    points = rng.standard_normal((100, 3)) - [0, 0, 8]
    camera_of, point_of = np.repeat(np.arange(6), 100), np.tile(np.arange(100), 6)
    pixels = project(cameras[camera_of], points[point_of]) + 0.5 * rng.standard_normal((600, 2))
    return camera_of, point_of, pixels, cameras, points + 0.1 * rng.standard_normal((100, 3))


def main():
    camera_of, point_of, pixels, camera_values, point_values = read_bal(sys.argv[1]) if len(sys.argv) > 1 else small_scene()
    problem = vesta.Problem()
    cameras = problem.add_blocks(camera_values)
    points = problem.add_blocks(point_values)
    # One function for all residuals. It is recorded and differentiated; Huber's loss bounds the influence of outliers.
    problem.add_residuals(lambda camera, point, pixel: project(camera, point) - pixel,
                          [cameras[camera_of], points[point_of]], [pixels], loss=vesta.Huber(1.0))
    print(problem.solve(max_iterations=100))
    errors = np.linalg.norm(project(cameras.values[camera_of], points.values[point_of]) - pixels, axis=1)
    print(f"{len(pixels)} observations, median reprojection error {np.median(errors):.3f} pixels")


if __name__ == "__main__":
    main()

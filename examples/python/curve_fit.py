#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Fits curves: one with outliers, as with scipy, and ten thousand at once.

  PYTHONPATH=build/python python3 examples/python/curve_fit.py
"""
import numpy as np

from vesta import least_squares, least_squares_each


def decay(p, t, y):
    return p[0] * np.exp(-p[1] * t) + p[2] - y


def main():
    rng = np.random.default_rng(0)
    t = np.linspace(0, 3, 100)
    y = decay([2.5, 1.3, 0.5], t, 0.02 * rng.standard_normal(100))
    y[::10] += 1.0  # outliers
    plain = least_squares(decay, [1, 1, 0], args=(t, y))
    robust = least_squares(decay, [1, 1, 0], args=(t, y), loss="cauchy", f_scale=0.05)
    # The covariance for the variance of the residuals, estimated from them.
    inliers = np.abs(robust.fun) < 0.2
    covariance = np.linalg.inv(robust.jac[inliers].T @ robust.jac[inliers]) * np.var(robust.fun[inliers])
    print("without a loss   ", plain.x.round(3))
    print("with Cauchy's    ", robust.x.round(3), "+-", np.sqrt(np.diag(covariance)).round(3))

    true = np.stack([1 + rng.random(10000), 0.5 + rng.random(10000), rng.standard_normal(10000)], axis=1)
    samples = decay(true.T[:, :, None], t, 0.02 * rng.standard_normal((10000, 100)))
    fits = least_squares_each(decay, np.ones((10000, 3)), (t, samples))
    print(f"10,000 fits       {fits.success.sum()} converged, errors {np.abs(fits.x - true).mean(axis=0).round(4)}")


if __name__ == "__main__":
    main()

# SPDX-License-Identifier: Apache-2.0
"""Functions for residuals, on numbers and on recorded arrays. numpy's own functions work too."""
import numpy as np


def where(condition, a, b):
    """a where the condition holds, else b. Derivatives of the value that is not taken have no influence."""
    return np.where(condition, a, b)


def norm(a, axis=-1, keepdims=False):
    """The Euclidean norm along an axis. The derivative at 0 is 0."""
    return np.linalg.norm(a, axis=axis, keepdims=keepdims)


def dot(a, b):
    """The scalar product along the last axis."""
    return np.sum(a * b, axis=-1)


def rotate(rotation_vectors, points):
    """Rotates points (..., 3) by rotation vectors (..., 3), by Rodrigues' formula; exact derivatives also at 0."""
    squared = np.sum(rotation_vectors * rotation_vectors, axis=-1, keepdims=True)
    small = squared < 1e-8
    angle = np.sqrt(np.where(small, 1.0, squared))
    sine = np.where(small, 1 - squared / 6, np.sin(angle) / angle)
    cosine = np.where(small, 0.5 - squared / 24, (1 - np.cos(angle)) / np.where(small, 1.0, squared))
    across = np.cross(rotation_vectors, points)
    return points + sine * across + cosine * np.cross(rotation_vectors, across)


def rotate_by_quaternion(quaternions, points, scalar_first=True):
    """Rotates points (..., 3) by unit quaternions (..., 4)."""
    if scalar_first:
        w, v = quaternions[..., :1], quaternions[..., 1:]
    else:
        w, v = quaternions[..., 3:], quaternions[..., :3]
    across = 2 * np.cross(v, points)
    return points + w * across + np.cross(v, across)


def multiply_quaternions(a, b):
    """The product of quaternions (..., 4), scalar first: the rotation by b, then by a."""
    aw, av, bw, bv = a[..., :1], a[..., 1:], b[..., :1], b[..., 1:]
    return np.concatenate([aw * bw - np.sum(av * bv, axis=-1, keepdims=True), aw * bv + bw * av + np.cross(av, bv)],
                          axis=-1)


def conjugate_quaternion(q):
    """The inverse of unit quaternions (..., 4), scalar first."""
    return q * np.array([1.0, -1.0, -1.0, -1.0])

#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Optimises a pose graph: poses of a robot that drives in circles, from odometry and loop closures.

  PYTHONPATH=build/python python3 examples/python/pose_graph.py [FILE]

FILE: a file of g2o with vertices VERTEX_SE3:QUAT and edges EDGE_SE3:QUAT; by default a graph is made.
"""
import sys

import numpy as np

import vesta


def between(a, b):
    """The pose of b in the frame of a. Poses (n, 7): a quaternion w, x, y, z and a position."""
    inverse = vesta.conjugate_quaternion(a[:, :4])
    return np.concatenate([vesta.multiply_quaternions(inverse, b[:, :4]),
                           vesta.rotate_by_quaternion(inverse, b[:, 4:] - a[:, 4:])], axis=1)


def edge_error(a, b, measured, roots):
    """Six errors per edge: translation and rotation, weighted by the roots of the information matrices (n, 6, 6)."""
    found = between(a, b)
    turn = vesta.multiply_quaternions(vesta.conjugate_quaternion(measured[:, :4]), found[:, :4])
    error = np.concatenate([found[:, 4:] - measured[:, 4:], 2 * turn[:, 1:]], axis=1)
    return np.einsum("nij,nj->ni", roots, error)


def read_g2o(path):
    """Returns poses (N, 7), edges (n, 2), measurements (n, 7) and roots (n, 6, 6) of the information matrices."""
    poses, edges, measured, information = {}, [], [], []
    with open(path) as file:
        for line in file:
            kind, *words = line.split() or [""]
            if kind == "VERTEX_SE3:QUAT":
                p = np.array(words[1:8], float)
                poses[int(words[0])] = p[[6, 3, 4, 5, 0, 1, 2]]
            elif kind == "EDGE_SE3:QUAT":
                edges.append((int(words[0]), int(words[1])))
                p = np.array(words[2:9], float)
                measured.append(p[[6, 3, 4, 5, 0, 1, 2]])
                matrix = np.zeros((6, 6))
                matrix[np.triu_indices(6)] = np.array(words[9:30], float)
                information.append(matrix + np.triu(matrix, 1).T)
    index = {name: k for k, name in enumerate(poses)}
    roots = np.linalg.cholesky(np.array(information)).transpose(0, 2, 1)
    return np.array(list(poses.values())), np.array([[index[a], index[b]] for a, b in edges]), np.array(measured), roots


def circles():
    rng = np.random.default_rng(0)
    angle = np.arange(400) * (2 * np.pi / 40)
    zero = np.zeros(400)
    true = np.stack([np.cos(angle / 2), zero, zero, np.sin(angle / 2), 10 * np.cos(angle), 10 * np.sin(angle),
                     0.01 * np.arange(400)], axis=1)
    edges = np.array([(i, i + 1) for i in range(399)] + [(i, i + 40) for i in range(360)])
    measured = between(true[edges[:, 0]], true[edges[:, 1]])
    noise = rng.standard_normal((len(edges), 6)) * [0.01, 0.01, 0.01, 0.05, 0.05, 0.05]
    measured[:, :4] = vesta.multiply_quaternions(
        measured[:, :4], np.concatenate([np.ones((len(edges), 1)), noise[:, :3]], axis=1))
    measured[:, :4] /= np.linalg.norm(measured[:, :4], axis=1, keepdims=True)
    measured[:, 4:] += noise[:, 3:]
    start = [true[0]]
    for i in range(399):  # odometry alone
        q = vesta.multiply_quaternions(start[i][:4], measured[i, :4])
        start.append(np.concatenate([q, start[i][4:] + vesta.rotate_by_quaternion(start[i][:4], measured[i, 4:])]))
    roots = np.tile(np.diag([20.0] * 3 + [50.0] * 3), (len(edges), 1, 1))
    return np.array(start), edges, measured, roots


def main():
    start, edges, measured, roots = read_g2o(sys.argv[1]) if len(sys.argv) > 1 else circles()
    problem = vesta.Problem()
    poses = problem.add_blocks(start, vesta.Product(vesta.SO3(), vesta.Euclidean(3)))
    poses[0].set_constant()
    problem.add_residuals(edge_error, [poses[edges[:, 0]], poses[edges[:, 1]]], [measured, roots])
    print(problem.solve(max_iterations=100))
    print(f"{len(start)} poses moved by {np.linalg.norm(poses.values[:, 4:] - start[:, 4:], axis=1).max():.3f} at most")


if __name__ == "__main__":
    main()

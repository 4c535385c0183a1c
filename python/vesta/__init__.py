# SPDX-License-Identifier: Apache-2.0
"""Nonlinear least squares and Gaussian splats."""
from vesta._trace import TraceError  # noqa: F401
from vesta._vesta import num_threads, set_num_threads  # noqa: F401
from vesta.adapters import from_jax, from_torch  # noqa: F401
from vesta.functions import (  # noqa: F401
    conjugate_quaternion, dot, multiply_quaternions, norm, rotate, rotate_by_quaternion, where)
from vesta.least_squares import OptimizeResult, least_squares  # noqa: F401
from vesta.least_squares_each import least_squares_each  # noqa: F401
from vesta.problem import (  # noqa: F401
    Arctan, BlockArray, Cauchy, Euclidean, Huber, Line, Problem, Product, SE3, SO3, Scaled, SoftLOne, Sphere, Subset,
    Summary, Tolerant, Tukey)
from vesta.rasterization import Rasterization, rasterization  # noqa: F401
from vesta.scene import Evaluation, Run, Scene, View, evaluate, prune, refine, train  # noqa: F401
from vesta.splat import Splat  # noqa: F401

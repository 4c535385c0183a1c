# SPDX-License-Identifier: Apache-2.0
"""Nonlinear least squares and Gaussian splats."""
from vesta.least_squares import OptimizeResult, least_squares  # noqa: F401

# SPDX-License-Identifier: Apache-2.0
"""Nonlinear least squares and Gaussian splats."""

# SPDX-License-Identifier: Apache-2.0
"""Residuals written with jax or torch, for Problem.add_residuals."""
import numpy as np


def from_jax(function):
    """Returns (function, jac) in numpy for function(*blocks, *data) -> residuals (k,) of one row, written with jax.

        function, jac = vesta.from_jax(residual_of_one_row)
        problem.add_residuals(function, blocks, data, jac=lambda *a: jac(len(blocks), *a))

    jac(number of blocks, *arguments) -> a list of arrays (n, k, size). Both work on n rows at once (jax.vmap), in
    double precision.
    """
    import jax

    jax.config.update("jax_enable_x64", True)
    values = jax.jit(jax.vmap(function))
    derivatives = {}

    def jacobians(num_blocks, *arguments):
        if num_blocks not in derivatives:
            derivatives[num_blocks] = jax.jit(jax.vmap(jax.jacfwd(function, argnums=tuple(range(num_blocks)))))
        return [np.asarray(j) for j in derivatives[num_blocks](*arguments)]

    return lambda *arguments: np.asarray(values(*arguments)), jacobians


def from_torch(function):
    """The same for function(*blocks, *data) -> residuals (n, k) of n rows, written with torch.

    Row i of the result must depend on row i of the arguments only.
    """
    import torch

    def tensors(arguments):
        return [torch.from_numpy(np.ascontiguousarray(a, float)) for a in arguments]

    def values(*arguments):
        with torch.no_grad():
            return function(*tensors(arguments)).numpy()

    def jacobians(num_blocks, *arguments):
        inputs = tensors(arguments)
        blocks = [t.requires_grad_() for t in inputs[:num_blocks]]
        residuals = function(*inputs)
        rows = [torch.autograd.grad(residuals[:, k].sum(), blocks, retain_graph=True)
                for k in range(residuals.shape[1])]
        return [torch.stack([row[b] for row in rows], dim=1).numpy() for b in range(num_blocks)]

    return values, jacobians

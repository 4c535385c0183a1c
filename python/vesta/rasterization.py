# SPDX-License-Identifier: Apache-2.0
"""Images of splats, with derivatives."""
from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from vesta import _vesta
from vesta.splat import Splat

_MODES = ("RGB", "RGB+D", "RGB+ED", "D", "ED")


class Rasterization:
    """colors (C, height, width, 3), float32, or None without "RGB" in the mode; depth (C, height, width), with "D" in
    the mode the sum of the Gaussians' depths along the optical axis with their blending weights, otherwise divided by
    alpha; alpha (C, height, width), the opacity. depth and alpha are computed when they are first read."""

    def __init__(self, raster, render_mode):
        self._raster, self._is_sum = raster, render_mode in ("D", "RGB+D")
        self.colors = raster.colors() if "RGB" in render_mode else None
        self._sums = None

    def _depth_and_alpha(self):
        if self._sums is None:
            self._sums = self._raster.depth_and_alpha()
        return self._sums

    @property
    def depth(self) -> np.ndarray:
        depth, alpha = self._depth_and_alpha()
        return depth if self._is_sum else depth / np.maximum(alpha, np.float32(1e-10))

    @property
    def alpha(self) -> np.ndarray:
        return self._depth_and_alpha()[1]

    def vjp(self, d_colors: Any) -> dict[str, np.ndarray]:
        """The gradient of sum(d_colors * colors): a dictionary of arrays with the names and shapes of the splat's."""
        gradient = self._raster.vjp(np.asarray(d_colors, np.float32))
        return {name: gradient[name] for name in ("means", "quats", "log_scales", "opacity_logits", "sh")}

    def jvp(self, directions: Mapping[str, Any]) -> np.ndarray:
        """The derivative of colors along a change of the splat: a dictionary as from vjp; missing arrays are 0."""
        return self._raster.jvp({**self._zeros, **directions})


def rasterization(splat: Splat, viewmats: Any, Ks: Any, width: int, height: int, render_mode: str = "RGB",
                  backgrounds: Any = None, near_plane: float = 0.01) -> Rasterization:
    """Renders a splat in C views, with the arguments of gsplat's function of this name where both have them.

    viewmats (C, 4, 4), world to camera; Ks (C, 3, 3). render_mode: "RGB", "D" (accumulated depth) or "ED" (expected
    depth), or "RGB+D", "RGB+ED"; vesta gives colours and depth separately. backgrounds: one colour (3,)
    for all views; None: the splat's, else black.

    A torch.autograd.Function is a few lines:

        class Render(torch.autograd.Function):
            @staticmethod
            def forward(ctx, viewmats, Ks, width, height, *tensors):  # means, quats, log_scales, opacity_logits, sh
                splat = vesta.Splat(*(t.detach().numpy() for t in tensors))
                ctx.out = vesta.rasterization(splat, viewmats, Ks, width, height)
                return torch.from_numpy(ctx.out.colors)
            @staticmethod
            def backward(ctx, d_colors):
                gradient = ctx.out.vjp(d_colors.numpy())
                return (None,) * 4 + tuple(torch.from_numpy(gradient[n]) for n in
                                           ("means", "quats", "log_scales", "opacity_logits", "sh"))
    """
    if render_mode not in _MODES:
        raise ValueError(f'render_mode is "{render_mode}"; the modes are {", ".join(_MODES)}')
    viewmats, Ks = np.atleast_3d(np.asarray(viewmats, float)), np.asarray(Ks, float)
    if viewmats.shape[1:] != (4, 4) or Ks.shape != (len(viewmats), 3, 3):
        raise ValueError(f"viewmats and Ks have the shapes {viewmats.shape} and {Ks.shape}; "
                         "they need (C, 4, 4) and (C, 3, 3)")
    background = backgrounds if backgrounds is not None else splat.background or (0.0, 0.0, 0.0)
    if np.shape(background) != (3,):
        raise ValueError("backgrounds needs one colour (3,) for all views")
    arrays = splat.arrays()
    raster = _vesta.Rasterization(arrays, list(viewmats), list(Ks), int(width), int(height), float(near_plane),
                                  tuple(float(b) for b in background))
    result = Rasterization(raster, render_mode)
    result._zeros = {name: np.zeros_like(arrays[name])
                     for name in ("means", "quats", "log_scales", "opacity_logits", "sh")}
    return result

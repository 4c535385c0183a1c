# SPDX-License-Identifier: Apache-2.0
"""Gaussian splats as numpy arrays."""
from __future__ import annotations

from typing import Any

import numpy as np

from vesta import _vesta
from vesta.functions import multiply_quaternions

_ARRAYS = {"means": (3,), "quats": (4,), "log_scales": (3,), "opacity_logits": (), "sh": None}


def _harmonics_rotation(rotation, count):
    """The matrix (count, count) that rotates spherical-harmonics coefficients."""
    directions = np.random.default_rng(0).standard_normal((100, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    before = _vesta.sh_basis(directions @ rotation)[:, :count]  # rows are R^T d
    return np.linalg.lstsq(_vesta.sh_basis(directions)[:, :count], before, rcond=None)[0]


class Splat:
    """N Gaussians, as float32 arrays that may be changed in place:

    means (N, 3), world units; quats (N, 4), w x y z, not normalised; log_scales (N, 3), logarithms of the standard
    deviations; opacity_logits (N,); sh (N, K, 3), spherical harmonics, K = 1, 4, 9 or 16.

    background: colour behind the splat in training, or None; eps2d: variance in pixels^2 that a renderer adds;
    antialiased: whether opacities are compensated for it; origin: the world point at means (0, 0, 0).
    """

    def __init__(self, means: Any, quats: Any, log_scales: Any, opacity_logits: Any, sh: Any,
                 background: tuple[float, float, float] | None = None, eps2d: float = 0.3, antialiased: bool = False,
                 origin: Any = (0.0, 0.0, 0.0)) -> None:
        n = len(means)
        self.sh = np.array(sh, np.float32)
        for name, value in zip(_ARRAYS, (means, quats, log_scales, opacity_logits)):
            array = np.array(value, np.float32)
            if array.shape != (n, *_ARRAYS[name]):
                raise ValueError(f"{name} has the shape {array.shape}, not {(n, *_ARRAYS[name])}")
            setattr(self, name, array)
        if self.sh.ndim != 3 or self.sh.shape[0] != n or self.sh.shape[1] not in (1, 4, 9, 16) or self.sh.shape[2] != 3:
            raise ValueError(f"sh has the shape {self.sh.shape}, not ({n}, K, 3) with K = 1, 4, 9 or 16")
        self.background, self.eps2d, self.antialiased, self.origin = background, eps2d, antialiased, tuple(origin)

    @staticmethod
    def load(path: Any) -> Splat:
        """Reads .ply, .compressed.ply, .spz, .sog, .splat or .ksplat. `notes` lists ignored Gaussians."""
        arrays, notes = _vesta.read_splat(str(path))
        splat = Splat(**arrays)
        splat.notes = notes
        return splat

    def save(self, path: Any) -> list[str]:
        """Writes .ply, .compressed.ply, .spz, .sog, .splat or .glb. Returns notes about losses beyond rounding."""
        return _vesta.write_splat(str(path), self.arrays())

    def arrays(self) -> dict[str, Any]:
        """The arguments of Splat as a dictionary."""
        result = {name: getattr(self, name) for name in _ARRAYS}
        result.update(eps2d=self.eps2d, antialiased=self.antialiased, origin=self.origin)
        if self.background is not None:
            result["background"] = tuple(self.background)
        return result

    def __len__(self):
        return len(self.means)

    def __repr__(self):
        return f"Splat({len(self)} Gaussians, SH degree {self.sh_degree})"

    @property
    def sh_degree(self) -> int:
        return int(np.sqrt(self.sh.shape[1])) - 1

    @property
    def opacity(self) -> np.ndarray:
        """Opacities in 0..1, shape (N,)."""
        return 1 / (1 + np.exp(-self.opacity_logits))

    @property
    def scales(self) -> np.ndarray:
        """Standard deviations along the principal axes, shape (N, 3)."""
        return np.exp(self.log_scales)

    def __getitem__(self, index: Any) -> Splat:
        """A splat of the selected Gaussians (a mask, numbers or a slice); its arrays are copies."""
        index = np.atleast_1d(np.arange(len(self))[index])
        if not index.size:
            raise ValueError("the selection has no Gaussian")
        arrays = self.arrays()
        arrays.update({name: arrays[name][index] for name in _ARRAYS})
        return Splat(**arrays)

    def crop(self, low: Any, high: Any) -> Splat:
        """The Gaussians with means in the box from low to high, (x, y, z) in the world."""
        means = self.means + np.asarray(self.origin)
        return self[((means >= low) & (means <= high)).all(axis=1)]

    def transform(self, rotation: Any = np.eye(3), translation: Any = (0, 0, 0), scale: float = 1.0) -> Splat:
        """Moves every point p to scale * rotation @ p + translation, with the spherical harmonics.

        A splat with an origin other than 0 moves its origin, so that its means keep their digits.
        """
        rotation = np.asarray(rotation, float)
        if rotation.shape != (3, 3) or not np.allclose(rotation @ rotation.T, np.eye(3), atol=1e-6) \
                or np.linalg.det(rotation) < 0:
            raise ValueError("rotation needs to be a rotation matrix (3, 3)")
        if not scale > 0:
            raise ValueError("scale needs to be positive")
        arrays = self.arrays()
        origin = scale * rotation @ np.asarray(self.origin, float) + np.asarray(translation, float)
        means = scale * self.means.astype(float) @ rotation.T
        if not any(self.origin):
            means, origin = means + origin, np.zeros(3)
        arrays.update(means=means, origin=tuple(origin),
                      quats=multiply_quaternions(_vesta.quaternion_of(rotation)[None], self.quats.astype(float)),
                      log_scales=self.log_scales + np.float32(np.log(scale)),
                      sh=np.einsum("kj,njc->nkc", _harmonics_rotation(rotation, self.sh.shape[1]), self.sh))
        return Splat(**arrays)

    @staticmethod
    def merge(*splats: Splat) -> Splat:
        """One splat of all Gaussians, with the background of the first. Filters and origins must be equal."""
        first = splats[0]
        for splat in splats[1:]:
            if (splat.eps2d, splat.antialiased, splat.origin) != (first.eps2d, first.antialiased, first.origin):
                raise ValueError("splats with different eps2d, antialiased or origin cannot be merged")
        most = max(splat.sh.shape[1] for splat in splats)
        arrays = first.arrays()
        for name in _ARRAYS:
            parts = [getattr(splat, name) for splat in splats]
            if name == "sh":
                parts = [np.pad(p, ((0, 0), (0, most - p.shape[1]), (0, 0))) for p in parts]
            arrays[name] = np.concatenate(parts)
        return Splat(**arrays)

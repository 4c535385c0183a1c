# SPDX-License-Identifier: Apache-2.0
"""Scenes: photographs with cameras, and trainings on them."""
from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from vesta import _vesta
from vesta.splat import Splat


class View:
    """name; K (3, 3), pixels; viewmat (4, 4), world to camera (x right, y down, z forward); width, height; role:
    "train", "test" or "held out"; image, float32 (height, width, 3) in 0..1, read-only."""

    def __init__(self, scene, index, values):
        self._scene, self._index = scene, index
        self.__dict__.update(values)

    @property
    def image(self) -> np.ndarray:
        return self._scene.photograph(self._index)

    def __repr__(self):
        return f"View({self.name!r}, {self.width} x {self.height}, {self.role})"


class Scene:
    """views, and train and test, which select from them; points (n, 3); notes about ignored input."""

    def __init__(self, scene):
        self._scene = scene
        self.views = [View(scene, k, values) for k, values in enumerate(scene.views)]

    @staticmethod
    def load(path: Any, downscale: int = 1, test_every: int | None = None, test_list: Any = "", hold_out: bool = False,
             image_folder: str = "images", allow_missing: bool = False, photographs_mib: float | None = None,
             seed: int = 0, background: Sequence[float] = (0.0, 0.0, 0.0), eps2d: float = 0.3,
             antialiased: bool = False) -> Scene:
        """Loads a COLMAP or NeRF scene.

        downscale: divides the image size. test_every: every n-th view by name becomes a test view (0: none; None: as
        the scene says, otherwise every 8th). test_list: a file with the names of the test views instead. hold_out: set
        some training views aside, whose PSNR a training with train.target_psnr watches. photographs_mib: memory for
        decoded photographs; others are decoded when needed (None: half of the free memory). seed: for points
        where the scene has none. background: behind transparent
        pixels. eps2d, antialiased: the filter of splats that are trained on the scene.
        """
        return Scene(_vesta.load_scene(str(path), int(downscale), test_every, str(test_list), bool(hold_out),
                                       image_folder, bool(allow_missing), photographs_mib, int(seed),
                                       tuple(background), float(eps2d), bool(antialiased)))

    @staticmethod
    def from_arrays(images: Sequence[Any], Ks: Sequence[Any], world_to_cam: Sequence[Any], points: Any,
                    colors: Any = None, names: Sequence[str] | None = None, test_every: int = 8) -> Scene:
        """A scene of images (height, width, 3), bytes or numbers in 0..1, with matrices K (3, 3) and world to camera
        (4, 4), and points (n, 3), n >= 1, with colours (n, 3) in 0..1 (default: grey)."""
        points = np.asarray(points, float)
        colors = np.full(points.shape, 0.5) if colors is None else np.asarray(colors, float)
        if points.ndim != 2 or points.shape[1] != 3 or not len(points) or colors.shape != points.shape:
            raise ValueError("points and colors need the shape (n, 3) with n >= 1")
        if not len(images) == len(Ks) == len(world_to_cam) or not len(images):
            raise ValueError("images, Ks and world_to_cam need the same length, at least 1")
        names = [f"{k:05d}" for k in range(len(images))] if names is None else list(names)
        if len(set(names)) != len(images):
            raise ValueError("names need one different name per image")
        pixels = []
        for name, image in zip(names, images):
            image = np.asarray(image)
            image = image.astype(np.float32) / np.float32(255) if image.dtype == np.uint8 else image.astype(np.float32)
            if image.ndim != 3 or image.shape[2] != 3:
                raise ValueError(f"image {name} has the shape {image.shape}, not (height, width, 3)")
            pixels.append(image)
        viewmats = [np.asarray(m, float) for m in world_to_cam]
        return Scene(_vesta.scene_of_arrays(pixels, [np.asarray(k, float) for k in Ks], viewmats, names, points, colors,
                                            test_every))

    @property
    def train(self) -> list[View]:
        return [view for view in self.views if view.role == "train"]

    @property
    def test(self) -> list[View]:
        return [view for view in self.views if view.role == "test"]

    @property
    def points(self) -> np.ndarray:
        return self._scene.points

    @property
    def notes(self) -> list[str]:
        return self._scene.notes

    def __repr__(self):
        return f"Scene({len(self.train)} training views, {len(self.test)} test views, {len(self.points)} points)"


class Run:
    """The result of a training: splat; history, a list of dictionaries; metrics, its last row; status, "finished" or
    "stopped"; notes."""

    def __init__(self, arrays, history, stopped, notes):
        self.splat, self.history, self.metrics = Splat(**arrays), history, history[-1]
        self.status, self.notes = "stopped" if stopped else "finished", notes

    def __repr__(self):
        return (f"Run({self.status}, {len(self.splat)} Gaussians, test PSNR {self.metrics['test_psnr']:.2f} dB, "
                f"SSIM {self.metrics['test_ssim']:.4f})")


def _texts(options):
    texts = {}
    for name, value in (options or {}).items():
        if isinstance(value, (tuple, list, np.ndarray)):
            value = ",".join(repr(float(v)) for v in value)
        texts[name] = str(value).lower() if isinstance(value, bool) else str(value)
    return texts


def _run(scene, kind, arrays, preset, seed, options, callback, max_loss=None):
    texts = {"train.seed": str(seed), **_texts(options)}
    return Run(*_vesta.train(scene._scene, kind, arrays, preset, texts, max_loss, callback))


def train(scene: Scene, preset: str = "balanced", seed: int = 0, options: Mapping[str, Any] | None = None,
          callback: Callable[[dict], Any] | None = None) -> Run:
    """Trains a splat as `vesta train` does. The same scene, seed and options give the same bits.

    options: a dictionary of options by the names of `vesta config`, such as {"adam.iterations": 3000}. callback: called
    with each row of the history (a dictionary: iteration, test_psnr, ...); returning False stops the training. Ctrl-C
    raises KeyboardInterrupt.
    """
    return _run(scene, "train", None, preset, seed, options, callback)


def refine(splat: Splat, scene: Scene, preset: str = "balanced", seed: int = 0,
           options: Mapping[str, Any] | None = None, callback: Callable[[dict], Any] | None = None) -> Run:
    """Trains a splat further, without new Gaussians, as `vesta refine` does."""
    return _run(scene, "refine", splat.arrays(), preset, seed, options, callback)


def prune(splat: Splat, scene: Scene, keep: float | None = None, max_loss: float | None = None,
          preset: str = "balanced", seed: int = 0, options: Mapping[str, Any] | None = None,
          callback: Callable[[dict], Any] | None = None) -> Run:
    """Prunes a splat and trains the remaining Gaussians, as `vesta prune` does.

    Give one of keep, the fraction of the Gaussians to keep, and max_loss: removes as many as possible while the
    training loss rises by at most this fraction.
    """
    if (keep is None) == (max_loss is None):
        raise ValueError("give either keep or max_loss")
    if keep is not None and not 0 < keep <= 1:
        raise ValueError(f"keep is {keep}; choose a fraction above 0, at most 1")
    if max_loss is not None and not max_loss > 0:
        raise ValueError(f"max_loss is {max_loss}; choose a positive number")
    options = {**(options or {}), **({} if keep is None else {"pruning.keep_fraction": float(keep)})}
    return _run(scene, "prune", splat.arrays(), preset, seed, options, callback,
                None if max_loss is None else float(max_loss))


class Evaluation:
    """psnr, dB, and ssim: means over views; per_view: a list of dictionaries with name, psnr and ssim."""

    def __init__(self, per_view):
        self.per_view = per_view
        self.psnr = float(np.mean([row["psnr"] for row in per_view]))
        self.ssim = float(np.mean([row["ssim"] for row in per_view]))

    def __repr__(self):
        return f"Evaluation({len(self.per_view)} views, PSNR {self.psnr:.2f} dB, SSIM {self.ssim:.4f})"


def evaluate(splat: Splat, views: Sequence[View]) -> Evaluation:
    """Compares renderings with photographs. views: of one scene, such as scene.test."""
    views = list(views)
    if not views:
        raise ValueError("there are no views to evaluate")
    if any(view._scene is not views[0]._scene for view in views):
        raise ValueError("the views belong to different scenes")
    return Evaluation(_vesta.evaluate(views[0]._scene, splat.arrays(), [view._index for view in views]))

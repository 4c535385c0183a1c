#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Trains a splat on a scene, and looks at it.

  PYTHONPATH=build/python python3 examples/python/train_and_look.py [SCENE]

SCENE: a COLMAP or NeRF scene; by default images of coloured balls are made. Writes splat.ply and look.ppm to the
present folder if a scene is given.
"""
import sys

import numpy as np

import vesta


def look_at(eye):
    """The world-to-camera matrix of a camera at `eye` that looks at the origin."""
    forward = -np.asarray(eye) / np.linalg.norm(eye)
    right = np.cross(forward, [0, -1, 0])
    right /= np.linalg.norm(right)
    viewmat = np.eye(4)
    viewmat[:3, :3] = [right, np.cross(forward, right), forward]
    viewmat[:3, 3] = -viewmat[:3, :3] @ eye
    return viewmat


def balls():
    """A scene of 12 images of 200 coloured balls."""
    rng = np.random.default_rng(0)
    centres, colors = rng.uniform(-1, 1, (200, 3)), rng.random((200, 3))
    true = vesta.Splat(means=centres, quats=np.tile([1.0, 0, 0, 0], (200, 1)), log_scales=np.full((200, 3), -2.5),
                       opacity_logits=np.full(200, 3.0), sh=((colors - 0.5) / 0.282)[:, None])
    viewmats = np.array([look_at([4 * np.sin(a), 0.5, -4 * np.cos(a)]) for a in np.linspace(-0.7, 0.7, 12)])
    Ks = np.tile([[80.0, 0, 32], [0, 80, 32], [0, 0, 1]], (12, 1, 1))
    images = vesta.rasterization(true, viewmats, Ks, 64, 64).colors
    return vesta.Scene.from_arrays(images, Ks, viewmats, centres)


def main():
    scene = vesta.Scene.load(sys.argv[1]) if len(sys.argv) > 1 else balls()
    print(scene)
    run = vesta.train(scene, seed=0, options={} if len(sys.argv) > 1 else {"adam.iterations": 300},
                      callback=lambda row: print(f"iteration {row['iteration']}: test PSNR {row['test_psnr']:.2f} dB"))
    print(run)
    for row in vesta.evaluate(run.splat, scene.test).per_view:
        print(f"{row['name']}: {row['psnr']:.2f} dB")
    view = scene.test[0]
    out = vesta.rasterization(run.splat, [view.viewmat], [view.K], view.width, view.height)
    print(f"median depth {np.median(out.depth[out.depth > 0]):.2f}, {100 * out.alpha.mean():.0f} % covered")
    if len(sys.argv) > 1:
        run.splat.save("splat.ply")
        pixels = (np.clip(out.colors[0], 0, 1) * 255).astype(np.uint8)
        with open("look.ppm", "wb") as file:
            file.write(b"P6 %d %d 255\n" % (view.width, view.height) + pixels.tobytes())


if __name__ == "__main__":
    main()

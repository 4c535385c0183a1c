# SPDX-License-Identifier: Apache-2.0
"""Trainings by Python and by the program: the same bits."""
import hashlib
import json
import os
import struct
import subprocess
import tempfile
import unittest
import zlib
from pathlib import Path

import numpy as np

import vesta
from test_splats import camera, random_splat

PROGRAM = Path(os.environ.get("VESTA_PROGRAM", Path(__file__).resolve().parents[2] / "build/release/vesta"))


def write_png(path, image):
    """image: bytes (height, width, 3)."""
    height, width, _ = image.shape
    rows = b"".join(b"\0" + row.tobytes() for row in image)

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows)) +
                     chunk(b"IEND", b""))


def write_scene(folder, views=9, size=48):
    """A NeRF scene without points."""
    frames = []
    splat = random_splat(200, 0)
    for k, angle in enumerate(np.linspace(-0.6, 0.6, views)):
        viewmat, K = camera(angle, size=size)
        colors = vesta.rasterization(splat, [viewmat], [K], size, size).colors[0]
        write_png(folder / f"{k}.png", (255 * np.clip(colors, 0, 1)).astype(np.uint8))
        pose = np.linalg.inv(viewmat) @ np.diag([1.0, -1, -1, 1])  # y up, z backward
        frames.append({"file_path": f"{k}.png", "transform_matrix": pose.tolist()})
    intrinsics = {"fl_x": 60, "fl_y": 60, "cx": size / 2, "cy": size / 2, "w": size, "h": size}
    (folder / "transforms.json").write_text(json.dumps({**intrinsics, "frames": frames}))


@unittest.skipUnless(PROGRAM.exists(), f"needs the program {PROGRAM}")
class BitsOfTheProgram(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.temporary.cleanup)
        cls.folder = Path(cls.temporary.name)
        cls.scene = cls.folder / "scene"
        cls.scene.mkdir()
        write_scene(cls.scene)
        cls.start = cls.run_program("train", cls.scene, "--iterations=60")

    @classmethod
    def run_program(cls, command, *arguments):
        out = Path(tempfile.mkdtemp(dir=cls.folder))
        subprocess.run([PROGRAM, command, *arguments, f"--out={out}", "--seed=3", "--quiet"], check=True,
                       stdout=subprocess.DEVNULL)
        return out / "point_cloud.ply"

    def check(self, run, expected):
        path = self.folder / "python.ply"
        run.splat.save(path)
        self.assertEqual(*(hashlib.sha256(p.read_bytes()).hexdigest() for p in (path, expected)))

    def load(self):
        return vesta.Scene.load(self.scene, seed=3), vesta.Splat.load(self.start)

    def test_train(self):
        self.check(vesta.train(self.load()[0], seed=3, options={"adam.iterations": 60}), self.start)

    def test_refine(self):
        scene, splat = self.load()
        expected = self.run_program("refine", self.start, self.scene, "--iterations=20")
        self.check(vesta.refine(splat, scene, seed=3, options={"adam.iterations": 20}), expected)

    def test_prune(self):
        scene, splat = self.load()
        for goal in ({"keep": 0.5}, {"max_loss": 0.05}):
            for iterations in (0, 5, 40):
                flags = [f"--{name}={value}" for name, value in goal.items()]
                expected = self.run_program("prune", self.start, self.scene, f"--iterations={iterations}", *flags)
                self.check(vesta.prune(splat, scene, **goal, seed=3, options={"adam.iterations": iterations}), expected)


if __name__ == "__main__":
    unittest.main()

# SPDX-License-Identifier: Apache-2.0
import gc
import importlib.util
import pickle
import signal
import tempfile
import unittest
from pathlib import Path

import numpy as np

import vesta

NAMES = ("means", "quats", "log_scales", "opacity_logits", "sh")


def random_splat(count=60, degree=3, seed=0):
    rng = np.random.default_rng(seed)
    return vesta.Splat(means=rng.uniform(-1, 1, (count, 3)), quats=rng.standard_normal((count, 4)),
                       log_scales=rng.uniform(-3, -1.5, (count, 3)), opacity_logits=rng.uniform(-1, 3, count),
                       sh=0.3 * rng.standard_normal((count, (degree + 1) ** 2, 3)))


def camera(angle=0.0, distance=4.0, size=48):
    viewmat = np.eye(4)
    viewmat[:3, :3] = [[np.cos(angle), 0, -np.sin(angle)], [0, 1, 0], [np.sin(angle), 0, np.cos(angle)]]
    viewmat[2, 3] = distance
    return viewmat, np.array([[60.0, 0, size / 2], [0, 60.0, size / 2], [0, 0, 1]])


def small_scene(views=9, size=48):
    splat = random_splat(200, 0)
    cameras = [camera(angle, size=size) for angle in np.linspace(-0.6, 0.6, views)]
    viewmats, Ks = (np.array(m) for m in zip(*cameras))
    images = vesta.rasterization(splat, viewmats, Ks, size, size).colors
    colors = np.clip(0.5 + 0.282 * splat.sh[:, 0], 0, 1)
    return vesta.Scene.from_arrays(np.clip(images, 0, 1), Ks, viewmats, splat.means, colors)


class Splats(unittest.TestCase):
    def test_files(self):
        splat = random_splat()
        splat.background = (0.25, 0.5, 1.0)
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "a.ply"
            splat.save(path)
            again = vesta.Splat.load(path)
            for name in NAMES:
                np.testing.assert_array_equal(getattr(again, name), getattr(splat, name))
            self.assertEqual(again.background, splat.background)
            splat.save(Path(folder) / "a.spz")
            packed = vesta.Splat.load(Path(folder) / "a.spz")
            self.assertEqual(len(packed), 60)
            np.testing.assert_allclose(packed.means, splat.means, atol=1e-3)
            with self.assertRaises(FileNotFoundError):
                vesta.Splat.load(Path(folder) / "missing.ply")
            with self.assertRaises(ValueError):
                splat.save(Path(folder) / "a.xyz")

    def test_wrong_arrays(self):
        splat = random_splat()
        with self.assertRaisesRegex(ValueError, "quats"):
            vesta.Splat(splat.means, splat.quats[:, :3], splat.log_scales, splat.opacity_logits, splat.sh)
        with self.assertRaisesRegex(ValueError, "sh"):
            vesta.Splat(splat.means, splat.quats, splat.log_scales, splat.opacity_logits, splat.sh[:, :5])
        with self.assertRaises(ValueError):
            splat[np.zeros(60, bool)]

    def test_selections(self):
        splat = random_splat()
        half = splat[splat.means[:, 0] > 0]
        self.assertTrue((half.means[:, 0] > 0).all())
        box = splat.crop([-0.5] * 3, [0.5] * 3)
        self.assertEqual(len(box), (np.abs(splat.means).max(axis=1) <= 0.5).sum())
        both = vesta.Splat.merge(half, random_splat(5, 1))
        self.assertEqual(both.sh.shape, (len(half) + 5, 16, 3))
        again = pickle.loads(pickle.dumps(splat))
        np.testing.assert_array_equal(again.sh, splat.sh)

    def test_a_moved_splat_looks_the_same_to_a_moved_camera(self):
        splat = random_splat()
        viewmat, K = camera(0.3)
        expected = vesta.rasterization(splat, [viewmat], [K], 48, 48).colors
        rng = np.random.default_rng(4)
        for _ in range(4):
            rotation, _ = np.linalg.qr(rng.standard_normal((3, 3)))
            rotation *= np.sign(np.linalg.det(rotation))
            shift, scale = rng.standard_normal(3), 1.7
            moved = splat.transform(rotation, shift, scale)
            inverse = np.eye(4)
            inverse[:3, :3], inverse[:3, 3] = rotation.T, -rotation.T @ shift
            of_moved = viewmat.copy()
            of_moved[:3, 3] *= scale
            colors = vesta.rasterization(moved, [of_moved @ inverse], [K], 48, 48, near_plane=0.017).colors
            np.testing.assert_allclose(colors, expected, atol=2e-4)

    def test_a_moved_origin_keeps_the_digits_of_means(self):
        splat = random_splat()
        splat.origin = (4.5e6, 5e5, 0.0)
        turn = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])
        moved = splat.transform(turn, (10.0, 20, 30), 2.0)
        self.assertEqual(moved.origin, (-1e6 + 10, 9e6 + 20, 30))
        np.testing.assert_array_equal(moved.means, np.float32(2) * splat.means @ turn.T.astype(np.float32))
        back = moved.transform(turn.T, -turn.T @ [5.0, 10, 15], 0.5)
        self.assertEqual(back.origin, splat.origin)
        np.testing.assert_array_equal(back.means, splat.means)


class Rasterizations(unittest.TestCase):
    def setUp(self):
        self.splat = random_splat()
        self.viewmats, self.Ks = (np.array(m) for m in zip(camera(0.2), camera(-0.4)))

    def render(self, splat):
        return vesta.rasterization(splat, self.viewmats, self.Ks, 48, 48)

    def test_jvp_against_differences(self):
        rng = np.random.default_rng(1)
        out = self.render(self.splat)
        for name in NAMES:
            direction = rng.standard_normal(getattr(self.splat, name).shape).astype(np.float32)
            derivative = out.jvp({name: direction})
            step = 5e-4 if name == "means" else 2e-3
            ends = []
            for sign in (1, -1):
                moved = self.splat[:]
                setattr(moved, name, getattr(moved, name) + sign * step * direction)
                ends.append(self.render(moved).colors.astype(float))
            differences = (ends[0] - ends[1]) / (2 * step)
            # Cut-offs of faint Gaussians make single pixels jump.
            error = np.abs(derivative - differences)
            self.assertLess(np.median(error), 1e-3 * np.abs(differences).max(), name)
            self.assertLess(np.quantile(error, 0.98), 2e-2 * np.abs(differences).max(), name)

    def test_vjp_is_the_adjoint_of_jvp(self):
        rng = np.random.default_rng(2)
        out = self.render(self.splat)
        direction = {name: rng.standard_normal(getattr(self.splat, name).shape).astype(np.float32) for name in NAMES}
        d_colors = rng.standard_normal(out.colors.shape).astype(np.float32)
        gradient = out.vjp(d_colors)
        left = np.vdot(d_colors.astype(float), out.jvp(direction).astype(float))
        right = sum(np.vdot(gradient[name].astype(float), direction[name].astype(float)) for name in NAMES)
        self.assertAlmostEqual(left / right, 1, places=4)

    def test_depth_and_alpha(self):
        wall = vesta.Splat(means=[[0, 0, 0]], quats=[[1, 0, 0, 0]], log_scales=[[1, 1, -5]], opacity_logits=[3],
                           sh=np.zeros((1, 1, 3)))
        viewmat, K = camera(0.0)
        out = vesta.rasterization(wall, [viewmat], [K], 48, 48, render_mode="RGB+ED", backgrounds=(1, 0, 0))
        self.assertAlmostEqual(float(out.depth[0, 24, 24]), 4, places=3)
        self.assertAlmostEqual(float(out.alpha[0, 24, 24]), 1 / (1 + np.exp(-3)), places=3)
        np.testing.assert_allclose(out.colors[0, 24, 24], [0.5 + 0.5 * 0.0474, 0.4763, 0.4763], atol=2e-3)

    def test_depth_modes(self):
        # Two faint walls at depths 3 and 5, in front of nothing.
        weights = np.array([0.25, 0.75 * 0.2])
        logits = np.log([0.25 / 0.75, 0.2 / 0.8])
        walls = vesta.Splat(means=[[0, 0, -1], [0, 0, 1]], quats=[[1, 0, 0, 0]] * 2, log_scales=[[2, 2, -5]] * 2,
                            opacity_logits=logits, sh=np.zeros((2, 1, 3)), origin=(100.0, 0.0, 0.0))
        viewmat, K = camera(0.0)
        viewmat[0, 3] = -100
        for mode, depth in (("D", weights @ [3, 5]), ("ED", weights @ [3, 5] / weights.sum())):
            for colors in ("", "RGB+"):
                out = vesta.rasterization(walls, [viewmat], [K], 48, 48, render_mode=colors + mode)
                self.assertEqual(out.colors is None, colors == "")
                self.assertAlmostEqual(float(out.depth[0, 24, 24]), depth, places=2)
                self.assertAlmostEqual(float(out.alpha[0, 24, 24]), weights.sum(), places=3)

    def test_wrong_arguments(self):
        with self.assertRaisesRegex(ValueError, "render_mode"):
            vesta.rasterization(self.splat, self.viewmats, self.Ks, 48, 48, render_mode="normals")
        with self.assertRaises(ValueError):
            vesta.rasterization(self.splat, self.viewmats, self.Ks[:1], 48, 48)
        with self.assertRaisesRegex(ValueError, "rotation"):
            vesta.rasterization(self.splat, 2 * self.viewmats, self.Ks, 48, 48)
        with self.assertRaises(ValueError):
            self.render(self.splat).vjp(np.zeros((1, 48, 48, 3)))

    @unittest.skipUnless(importlib.util.find_spec("torch"), "torch is not installed")
    def test_torch(self):
        import torch

        viewmats, Ks = self.viewmats, self.Ks

        class Render(torch.autograd.Function):
            @staticmethod
            def forward(ctx, *tensors):
                ctx.out = vesta.rasterization(vesta.Splat(*(t.detach().numpy() for t in tensors)), viewmats, Ks, 48, 48)
                return torch.from_numpy(ctx.out.colors)

            @staticmethod
            def backward(ctx, d_colors):
                gradient = ctx.out.vjp(d_colors.numpy())
                return tuple(torch.from_numpy(gradient[name]) for name in NAMES)

        tensors = [torch.from_numpy(getattr(self.splat, name)).requires_grad_() for name in NAMES]
        (Render.apply(*tensors) ** 2).sum().backward()
        expected = self.render(self.splat)
        np.testing.assert_allclose(tensors[0].grad.numpy(), expected.vjp(2 * expected.colors)["means"])
        # Backward mode against the derivative along a direction.
        direction = [torch.randn_like(t) for t in tensors]
        along = sum((t.grad * d).sum().item() for t, d in zip(tensors, direction))
        forward = 2 * np.vdot(expected.colors, expected.jvp({n: d.numpy() for n, d in zip(NAMES, direction)}))
        self.assertAlmostEqual(along / forward, 1, places=3)


class Trainings(unittest.TestCase):
    OPTIONS = {"adam.iterations": 60}

    def test_train_refine_prune_evaluate(self):
        scene = small_scene()
        self.assertEqual((len(scene.train), len(scene.test)), (7, 2))
        rows = []
        run = vesta.train(scene, options={"adam.iterations": 200}, callback=rows.append)
        self.assertEqual(run.status, "finished")
        self.assertEqual(len(rows), len(run.history))
        self.assertGreater(run.metrics["train_psnr"], 25)
        measured = vesta.evaluate(run.splat, scene.test)
        self.assertAlmostEqual(measured.psnr, run.metrics["test_psnr"], places=4)
        self.assertEqual([row["name"] for row in measured.per_view], [view.name for view in scene.test])
        refined = vesta.refine(run.splat, scene, options=self.OPTIONS)
        self.assertEqual(len(refined.splat), len(run.splat))
        pruned = vesta.prune(run.splat, scene, keep=0.5, options=self.OPTIONS)
        self.assertLessEqual(len(pruned.splat), 0.55 * len(run.splat))

    def test_repeats_to_the_bit(self):
        first, second = (vesta.train(small_scene(), options=self.OPTIONS).splat for _ in range(2))
        for name in NAMES:
            np.testing.assert_array_equal(getattr(first, name), getattr(second, name))

    def test_callback_stops_and_raises(self):
        scene = small_scene()
        options = {"adam.iterations": 400, "adam.evaluations": 20}
        run = vesta.train(scene, options=options, callback=lambda row: row["iteration"] < 100)
        self.assertEqual(run.status, "stopped")
        with self.assertRaisesRegex(KeyError, "mine"):
            vesta.train(scene, options=options, callback=lambda row: {}["mine"])
        with self.assertRaises(KeyboardInterrupt):
            vesta.train(scene, options=options, callback=lambda row: signal.raise_signal(signal.SIGINT))

    def test_wrong_arguments(self):
        scene = small_scene()
        for options in ({"adam.iteration": 3}, {"adam.iterations": -3}):
            with self.assertRaisesRegex(ValueError, "adam.iteration"):
                vesta.train(scene, options=options)
        with self.assertRaises(ValueError):
            vesta.train(scene, preset="paperback")
        with self.assertRaises(FileNotFoundError):
            vesta.Scene.load("/no/such/scene")
        with self.assertRaises(ValueError):
            vesta.Scene.from_arrays([np.zeros((4, 4, 3))], [np.eye(3)], [np.eye(4)], np.zeros((0, 3)))

    def test_photographs_are_not_copied(self):
        scene = small_scene(3)
        view = scene.views[1]
        image = view.image
        self.assertEqual(image.shape, (48, 48, 3))
        self.assertTrue(np.shares_memory(image, view.image))
        with self.assertRaises(ValueError):
            image[0, 0, 0] = 1
        expected = image.copy()
        del scene, view
        gc.collect()
        np.testing.assert_array_equal(image, expected)

    def test_prune_within_a_loss(self):
        scene = small_scene()
        run = vesta.train(scene, options=self.OPTIONS)
        pruned = vesta.prune(run.splat, scene, max_loss=0.05, options={"adam.iterations": 0})
        self.assertLess(len(pruned.splat), len(run.splat))
        self.assertTrue(any("pruned from" in note for note in pruned.notes))
        for goals in ({}, {"keep": 0.5, "max_loss": 0.1}, {"keep": 0}, {"max_loss": 0}):
            with self.assertRaises(ValueError):
                vesta.prune(run.splat, scene, **goals)

    def test_memory_stays_level(self):
        import resource
        scene = small_scene(5, 24)
        for repeat in range(40):
            if repeat == 10:
                before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
            vesta.train(scene, options={"adam.iterations": 10})
        self.assertLess(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before, 20_000)


if __name__ == "__main__":
    unittest.main()

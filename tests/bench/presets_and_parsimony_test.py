"""bench/presets.py and bench/parsimony.py without a training: made-up records."""
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

BENCH = pathlib.Path(__file__).resolve().parents[2] / "bench"
sys.path.insert(0, str(BENCH))

import parsimony  # noqa: E402
import presets  # noqa: E402


def record(seconds, psnr, length=1, seed=0, scale=1, **settings):
    options = {"adam.length": length, "train.seed": seed, "train.downscale": scale, "lm.iterations": 0,
               **{key.replace("_", ".", 1): value for key, value in settings.items()}}
    return {"scene": "s", "flags": [], "options": options, "machine": "m", "commit": "c", "work": seconds,
            "iterations": 1, "peak_mib": 10, "gaussians": 100, "ply_mib": 1, "ssim": 0.5, "cost": 0.1,
            "wall_s": seconds, "seconds": seconds, "psnr": psnr}


class Presets(unittest.TestCase):
    def setUp(self):
        self._folder = tempfile.TemporaryDirectory()
        self.addCleanup(self._folder.cleanup)
        self.folder = pathlib.Path(self._folder.name)

    def write(self, name, rows):
        (self.folder / name).mkdir()
        (self.folder / name / "records.jsonl").write_text("".join(json.dumps(row) + "\n" for row in rows))
        return self.folder / name

    def scenes(self):
        """The second takes ten times as long, at another scale of its images."""
        return [self.write(name, [record(slow * 10, 30 + up, scale=scale), record(slow * 12, 30 + up, seed=1, scale=scale),
                                  record(slow * 2.2, 28 + up, 0.25, scale=scale), record(slow * 5.5, 29.98, 0.5, scale=scale),
                                  record(slow * 22, 30.2 + up, 2, scale=scale),
                                  record(slow * 3.3, 29 + up, 1, scale=2 * scale)])
                for name, slow, up, scale in (("a", 1, 0, 1), ("b", 10, 0.1, 2))]

    def test_figures_are_beside_the_default(self):
        points = presets.points_of_scene(self.scenes()[1], "seconds")
        self.assertEqual((points["adam.length=1"]["cost"], points["adam.length=1"]["psnr"]), (1, 0))
        self.assertAlmostEqual(points["adam.length=0.25"]["cost"], 0.2)
        self.assertAlmostEqual(points["adam.length=0.25"]["psnr"], -2)
        self.assertAlmostEqual(points["adam.length=1 train.downscale=x2"]["cost"], 0.3)
        self.assertAlmostEqual(points["adam.length=1"]["under the front"], 0)

    def test_chooses_the_cheapest_that_is_nearly_the_best(self):
        points = presets.averaged([presets.points_of_scene(folder, "seconds") for folder in self.scenes()])
        chosen = {budget: presets.choose(points, budget, 0.1)["name"] for budget in (0.35, 1.1, 2.2)}
        self.assertEqual(chosen, {0.35: "adam.length=1 train.downscale=x2", 1.1: "adam.length=0.5", 2.2: "adam.length=2"})
        self.assertEqual(presets.choose(points, 1.1, 0.01)["name"], "adam.length=1")
        self.assertIsNone(presets.choose(points, 0.1, 0.1))

    def test_only_what_ran_on_all_counts(self):
        folders = self.scenes() + [self.write("c", [record(1, 20), record(0.1, 19, 0.25)])]
        points = presets.averaged([presets.points_of_scene(folder, "seconds") for folder in folders])
        self.assertEqual([point["name"] for point in points], ["adam.length=0.25", "adam.length=1"])

    def test_runs_as_a_script(self):
        run = [sys.executable, "-B", BENCH / "presets.py"]
        result = subprocess.run([*run, *self.scenes()], capture_output=True, text=True)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("| best (cost up to 2.2) | adam.length=2 |", result.stdout)
        empty = self.folder / "empty"
        result = subprocess.run([*run, empty], capture_output=True, text=True)
        self.assertEqual(result.returncode, 1)
        self.assertIn(f"{empty}: no run that ended", result.stderr)


class Parsimony(unittest.TestCase):
    def test_means_are_beside_the_whole_splats_of_the_same_seeds(self):
        def row(way, keep, seed, psnr):
            return {"way": way, "keep": keep, "seed": seed, "gaussians": 100 * keep, "test_psnr": psnr, "test_ssim": 0.9,
                    "train_psnr": 30, "seconds": 5, "ply_mib": 1, "cost": 1}

        class Runs:
            rows = [row("whole", 1, 0, 30), row("whole", 1, 1, 32), row("worth", 0.5, 0, 29.9),
                    row("worth", 0.5, 1, 31.7), row("random", 0.5, 1, 30)]

        whole, worth, other = parsimony.summary(Runs, "s")
        self.assertEqual((whole["psnr_beside_whole"], whole["seeds"]), (0, 2))
        self.assertAlmostEqual(worth["psnr_beside_whole"], -0.2)
        self.assertAlmostEqual(worth["psnr_sd"], 1.8 / 2**0.5)
        self.assertEqual((other["way"], other["psnr_beside_whole"], other["psnr_sd"]), ("random", -2, 0))

    def test_a_record_is_found_again(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "deep" / "runs.jsonl"
            parsimony.Runs(path).add({"way": "worth", "keep": 0.5, "flags": []})
            runs = parsimony.Runs(path)
            self.assertIsNotNone(runs.find(way="worth", flags=[]))
            self.assertIsNone(runs.find(way="worth", flags=["--threads=1"]))


if __name__ == "__main__":
    unittest.main()

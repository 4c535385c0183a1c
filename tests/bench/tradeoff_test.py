"""bench/tradeoff.py without a training: fronts of made-up points, and runs of a program that makes its figures up."""
import json
import math
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

BENCH = pathlib.Path(__file__).resolve().parents[2] / "bench"
sys.path.insert(0, str(BENCH))

from training_front import front, knobs, runs, show  # noqa: E402

BASE = {"adam.length": 1000, "lm.iterations": 8, "adam.metric": "block", "train.downscale": 1, "train.seed": 0}

# Has few options; a second of Adam is a length of 1000, of LM an iteration. More is better. Notes each call.
PROGRAM = """#!{python} -IS
import json, math, pathlib, sys
here = pathlib.Path(__file__).resolve().parent
words = sys.argv[1:]
with (here / "calls").open("a") as calls:
    calls.write(" ".join(words) + "\\n")
values = dict(w[2:].split("=", 1) for w in words if w.startswith("--") and "=" in w and not w.startswith("--set="))
values.update(w[6:].split("=", 1) for w in words if w.startswith("--set="))
if words[0] == "config":
    print(json.dumps({{"options": {{"adam": {{"length": 1000, "metric": "block", "evaluations": 20}},
                                  "lm": {{"iterations": 8}}, "train": {{"downscale": 1, "seed": 0}}}}}}))
elif words[0] == "train":
    out = pathlib.Path(words[words.index("--out") + 1])
    length, lm, seed = (int(float(values[k])) for k in ("adam.length", "lm.iterations", "train.seed"))
    if values["adam.metric"] == "broken":
        print("vesta: first line", file=sys.stderr)
        sys.exit("vesta: there is no such metric")
    if values["adam.metric"] == "stopped":
        sys.exit(130)
    seconds = length / 1000 + lm
    psnr = 20 + math.log(length) + 0.1 * lm + 0.2 * seed + (0.05 if values["adam.metric"] == "good" else 0)
    if values["adam.metric"] == "exact":
        psnr = None
    out.mkdir()
    (out / "point_cloud.ply").write_text("x" * 1024)
    (out / "metrics.json").write_text(json.dumps({{
        "test": {{"psnr": psnr, "ssim": 0.5}}, "gaussians": length, "seconds": {{"total": seconds + 1, "eval": 1}},
        "work_megapixels": seconds, "peak_memory_mib": 7, "threads": 1, "device": "cpu",
        "history": [{{"stage": "adam", "iteration": length, "cost": 1 / length}}]}}))
elif words[0] == "eval":
    pathlib.Path(words[words.index("--json") + 1]).write_text(
        json.dumps({{"test": {{"psnr": 15, "ssim": 0.25}}, "cost": 2}}))
"""


def point(x, psnr, length=1000, ssim=0.5, **settings):
    return {"seconds": x, "psnr": psnr, "ssim": ssim, "cost": 1 / psnr, "length": length,
            "settings": {key.replace("_", ".", 1): value for key, value in settings.items()}}


def record(seconds=1.0, psnr=20.0, **options):
    options = {**BASE, **{key.replace("_", ".", 1): value for key, value in options.items()}}
    return {"scene": "s", "flags": [], "options": options, "machine": "m", "commit": "c", "work": 1, "iterations": 1,
            "peak_mib": 1, "gaussians": 1, "ply_mib": 1, "ssim": 0.5, "cost": 0.1, "wall_s": seconds,
            "seconds": seconds, "psnr": psnr}


class Fronts(unittest.TestCase):
    def test_hold_what_no_other_beats(self):
        good = [point(1, 20), point(3, 25), point(9, 26)]
        beaten = [point(2, 19), point(3, 24), point(4, 25), point(10, 26)]
        self.assertEqual(front.front_of(beaten + good[::-1], "seconds", "psnr"), good)
        self.assertEqual(front.front_of(beaten + good, "seconds", "cost"), good, "less cost is better")
        self.assertEqual(front.front_of([], "seconds", "psnr"), [])

    def test_are_linear_in_the_logarithm(self):
        points = [point(1, 20), point(100, 24)]
        self.assertAlmostEqual(front.best_at(points, "seconds", "psnr", 10), 22)
        self.assertIsNone(front.best_at(points, "seconds", "psnr", 0.9))
        self.assertEqual(front.best_at(points, "seconds", "psnr", 1), 20)
        self.assertEqual(front.best_at(points, "seconds", "psnr", 1000), 24)
        self.assertAlmostEqual(front.cost_of(points, "seconds", "psnr", point(5, 22)), 10)
        self.assertEqual(front.cost_of(points, "seconds", "psnr", point(5, 19)), 1)
        self.assertIsNone(front.cost_of(points, "seconds", "psnr", point(5, 24.1)))
        self.assertAlmostEqual(front.best_at(points, "seconds", "cost", 10), (1 / 20 + 1 / 24) / 2)

    def test_take_means_over_seeds(self):
        rows = [record(1, 20), record(3, 21, train_seed=1), {**record(train_seed=2), "failed": "it broke"},
                record(5, 30, lm_iterations=0)]
        two, one = front.points_of(rows, BASE)
        self.assertEqual((two["length"], two["settings"], two["seeds"]), (1000, {}, 2))
        self.assertEqual((two["seconds"], two["psnr"]), (2, 20.5))
        self.assertAlmostEqual(two["psnr_sd"], math.sqrt(0.5))
        self.assertEqual((one["settings"], one["seeds"], one["psnr_sd"]), ({"lm.iterations": 0}, 1, None))
        self.assertEqual(show.spread(two, "psnr"), "20.50 ± 0.71")
        self.assertEqual(show.spread(one, "psnr"), "30.00")

    def test_what_is_gained_is_beside_those_without_the_setting(self):
        default = [point(1, 20), point(100, 24, length=9)]
        mine = [point(10, 23, lm_iterations=0), point(20, 30, length=9, lm_iterations=0)]
        both = [point(1, 40, lm_iterations=0, adam_metric="d")]
        gains = front.beside_others(mine[0], default + mine + both, "seconds")
        self.assertAlmostEqual(gains["psnr"], 1)
        self.assertAlmostEqual(gains["times"], 10 ** 1.5 / 10)
        self.assertAlmostEqual(front.beside_others(default[1], default + mine + both, "seconds")["psnr"], 24 - 40)
        nothing = {"psnr": None, "ssim": None, "times": None}
        self.assertEqual(front.beside_others(point(0.5, 41), mine, "seconds"), nothing)

    def test_good_settings_are_those_on_the_front_the_best_first(self):
        points = [point(1, 20), point(100, 24), point(2, 23, a_a=1), point(2.5, 23.5, a_a=2), point(2, 23.4, b_b=1),
                  point(50, 21, c_c=1), point(1.5, 20, length=7, d_d=1, ssim=0.9),
                  point(0.1, 1, e_e=1)]
        values = [[{"a.a": 1}, {"a.a": 2}], [{"b.b": 1}], [{"c.c": 1}], [{"d.d": 1}], [{"e.e": 1}]]
        self.assertEqual(front.good_settings(points, values, 1000, "seconds"), [{"b.b": 1}, {"a.a": 2}])
        self.assertEqual(front.good_settings(points, values, 7, "seconds"), [{"d.d": 1}], "by SSIM alone")


class Plans(unittest.TestCase):
    def test_first_round(self):
        chosen = knobs.that_change(BASE, {"lm": [{"lm.iterations": 0}, {"lm.iterations": 8}],
                                          "metric": knobs.KNOBS["metric"]})
        self.assertEqual(chosen["lm"], [{"lm.iterations": 0}], "the default's value is none to try")
        both = knobs.that_change(BASE, {"a": [{"lm.iterations": 4, "adam.metric": "block"}]})
        self.assertEqual(both["a"], [{"lm.iterations": 4}])
        plan = knobs.one_at_a_time(BASE, chosen, [2000, 500], [500], [0, 1])
        self.assertEqual([run["train.seed"] for run in plan], [0] * 5 + [1] * 5)
        self.assertEqual([run["adam.length"] for run in plan[:5]], [500, 1000, 2000, 500, 500])
        self.assertEqual([knobs.words_of(knobs.changed(BASE, run)) for run in plan[:5]],
                         ["", "", "", "lm.iterations=0", "adam.metric=diagonal"])
        same = knobs.one_at_a_time(BASE, chosen, [2000.0, 500.0], [500.0], [0, 1])
        self.assertEqual(json.dumps(plan), json.dumps(same))
        with self.assertRaisesRegex(ValueError, "no option train.colour"):
            knobs.that_change(BASE, {"own": [{"train.colour": 1}]})

    def test_second_round_combines(self):
        good = {500: [{"lm.iterations": 0}, {"adam.metric": "d"}, {"lm.iterations": 2}, {"train.downscale": 2}],
                4000: [{"lm.iterations": 4}, {"lm.iterations": 4, "adam.metric": "d"}]}
        plan = knobs.combined(BASE, good, [400, 900, 5000], [0, 1])
        self.assertEqual([run["train.seed"] for run in plan], [0] * 5 + [1] * 5)
        self.assertEqual(knobs.words_of(knobs.changed(BASE, plan[4])), "adam.metric=d lm.iterations=4")
        self.assertEqual([(run["adam.length"], knobs.words_of(knobs.changed(BASE, run))) for run in plan[:4]],
                         [(length, f"adam.metric=d lm.iterations=0{more}") for length in (400, 900)
                          for more in ("", " train.downscale=2")])
        self.assertEqual(knobs.combined(BASE, {}, [400], [0]), [])

    def test_knobs_of_ones_own(self):
        self.assertEqual(knobs.parse_knob("lm"), ("lm", knobs.KNOBS["lm"]))
        self.assertEqual(knobs.parse_knob("a.b=1,0.5,true,word"),
                         ("a.b", [{"a.b": 1}, {"a.b": 0.5}, {"a.b": True}, {"a.b": "word"}]))
        self.assertEqual(knobs.words_of({"b.b": [0, 1.5], "a.a": False}), "a.a=false b.b=0,1.5")
        for word in ("nothing", "a.b", "a.b=", "ab=1"):
            with self.assertRaisesRegex(ValueError, "choose from"):
                knobs.parse_knob(word)


class Stand:
    """Runs at no cost, on a clock of its own."""

    base = BASE

    def __init__(self):
        self.now, self.ran = 0.0, []

    def clock(self):
        return self.now

    def blank(self, options):
        return {"scene": "s", "flags": [], "options": options, "machine": "m", "commit": "c"}

    def run(self, options):
        self.ran.append(options["adam.length"])
        seconds = options["adam.length"] / 100
        self.now += seconds
        if options["adam.metric"] == "broken":
            return {**self.blank(options), "failed": "it broke", "wall_s": seconds}
        return {**record(seconds), **self.blank(options)}


class WithFolder(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder, self.said = pathlib.Path(folder.name), []

    def records(self, **options):
        return runs.Records(self.folder / "out" / "records.jsonl", self.said.append, **options)


class Carrying(WithFolder):
    def carry_out(self, lengths, budget=math.inf, stand=None, retry=False, **changes):
        self.stand = stand or Stand()
        plan = [{**BASE, **changes, "adam.length": length} for length in lengths]
        return runs.carry_out(plan, self.stand, self.records(retry=retry), budget, self.said.append, self.stand.clock)

    def test_goes_on_where_it_was(self):
        self.assertEqual(self.carry_out([100, 200]), (0, 3))
        self.assertEqual(self.carry_out([100, 200, 400]), (0, 4))
        self.assertEqual(self.stand.ran, [400])
        self.carry_out([100], **{"train.seed": 1})
        self.assertEqual(self.stand.ran, [100], "another seed is another run")
        self.assertIn("[1/2] length 100, seed 0: 20.00 dB, SSIM 0.5000, 1.0 s; 0:00:02 left", self.said)

    def test_keeps_to_the_budget(self):
        # Foreseen by the run before: 1 s, then 8 s would end at 9, 2 s end at 3.
        self.assertEqual(self.carry_out([100, 800, 200], budget=4), (1, 3))
        self.assertEqual(self.stand.ran, [100, 200])
        self.assertEqual(self.carry_out([100, 800, 200], budget=0), (1, 0))
        self.assertEqual(self.stand.ran, [])
        self.assertEqual(self.carry_out([800], budget=8), (0, 8))

    def test_failures_are_kept_and_tried_again_when_asked(self):
        broken = {"adam.metric": "broken"}
        self.assertEqual(self.carry_out([100], **broken), (0, 1))
        self.assertIn("FAILED: it broke", self.said[-1])
        self.carry_out([100], **broken)
        self.assertEqual(self.stand.ran, [])
        self.carry_out([100], retry=True, **broken)
        self.assertEqual(self.stand.ran, [100])

    def test_what_is_no_record_is_passed_over(self):
        path = self.folder / "out" / "records.jsonl"
        self.carry_out([100, 200])
        whole = path.read_text().splitlines()
        lacking = record(adam_length=7)
        del lacking["psnr"]
        nan = {**record(adam_length=8), "ssim": math.nan}
        path.write_text("\n".join([whole[0], "no JSON", "[1]", '{"failed": "what?"}', json.dumps(lacking),
                                   json.dumps(nan), "", whole[1][:40]]))
        self.said.clear()
        self.carry_out([100, 200])
        self.assertEqual(self.stand.ran, [200])
        self.assertEqual([line.partition(".jsonl:")[2].partition(":")[0] for line in self.said[:-1]],
                         ["2", "3", "4", "5", "6", "8"])
        self.assertEqual(len(self.records().rows), 2, "the new record has a line of its own")


class Whole(WithFolder):
    """The script and a program that makes its figures up."""

    def setUp(self):
        super().setUp()
        self.program = self.folder / "program"
        self.program.write_text(PROGRAM.format(python=sys.executable))
        self.program.chmod(0o755)
        (self.folder / "scene").mkdir()
        # Stands in for a Python that has none.
        (self.folder / "none").mkdir()
        (self.folder / "none" / "matplotlib.py").write_text("raise ImportError\n")

    def run_script(self, *words, plot=False):
        env = {**os.environ, "PYTHONPATH": os.environ.get("PYTHONPATH", "") if plot else str(self.folder / "none")}
        command = [sys.executable, "-B", BENCH / "tradeoff.py", self.folder / "scene", "--program", self.program,
                   "--out", self.folder / "out", "--lengths=100,1000", "--seeds=0,1", *words]
        return subprocess.run(command, capture_output=True, text=True, env=env, check=False)

    def calls(self, verb):
        path = self.folder / "calls"
        return [line for line in path.read_text().splitlines() if line.startswith(verb)] if path.exists() else []

    def test_measures_and_goes_on(self):
        words = ["--knob_lengths=1000", "--knobs", "lm.iterations=0", "scale", "--rounds=1", "--", "--threads=1"]
        result = self.run_script(*words)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(len(self.calls("train")), 2 * (2 + 1 + 2))
        self.assertTrue(all("--threads=1" in call and "adam.evaluations=1" in call for call in self.calls("train")))
        self.assertEqual(len(self.calls("eval")), 4, "what was trained at another scale is measured at this one")
        self.assertFalse((self.folder / "out" / "run").exists())
        written = json.loads((self.folder / "out" / "front.json").read_text())
        self.assertEqual(written["bench"], "tradeoff")
        alone = next(row for row in written["rows"] if row["settings"] == {"lm.iterations": 0})
        self.assertEqual((alone["seeds"], alone["length"], alone["seconds"], alone["ply_mib"]), (2, 1000, 1, 2**-10))
        self.assertAlmostEqual(alone["psnr"], 20.1 + math.log(1000))
        self.assertIn("seconds, psnr", alone["fronts"])
        scaled = next(row for row in written["rows"] if row["settings"] == {"train.downscale": 4})
        self.assertEqual((scaled["psnr"], scaled["ssim"], scaled["cost"], scaled["fronts"]), (15, 0.25, 2, []))
        self.assertIs(written["targets"][0]["met"], True)
        self.assertIn("| 1000, lm.iterations=0 | 2 | 1.0 ± 0.0 |", result.stdout)
        self.assertIn("has no matplotlib", result.stderr)
        self.assertEqual(self.run_script(*words).returncode, 0)
        self.assertEqual(len(self.calls("train")), 10, "all of it has a record")
        others = self.run_script("--budget=0", "--knobs", "lm.iterations=0").stderr
        self.assertIn("6 runs are left out", others, "other flags are other runs")
        self.assertIn("no run to show", others)

    def test_combines_in_a_second_round(self):
        result = self.run_script("--knobs", "lm.iterations=9", "adam.metric=good,other", "--rounds=1")
        self.assertEqual(result.returncode, 0, result.stderr)
        (self.folder / "calls").unlink()
        result = self.run_script("--knobs", "lm.iterations=9", "adam.metric=good,other")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(len(self.calls("train")), 4, "at both lengths, of both seeds; the rest is known")
        self.assertTrue(all("lm.iterations=9" in call and "metric=good" in call for call in self.calls("train")))
        self.assertIn("adam.metric=good lm.iterations=9", result.stdout)

    def test_tells_of_runs_that_fail_and_of_those_broken_off(self):
        result = self.run_script("--knobs", "adam.metric=broken,exact", "--rounds=1")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("FAILED: vesta: there is no such metric", result.stderr)
        self.assertIn("FAILED: its PSNR is not finite", result.stderr)
        self.assertIn("4 runs failed", result.stderr)
        result = self.run_script("--knobs", "adam.metric=stopped", "--rounds=1")
        self.assertEqual(result.returncode, 130)
        self.assertIn("broken off", result.stderr)
        self.assertIn("| the default |", result.stdout)

    def test_refuses_in_a_line(self):
        def last_line(*words):
            result = self.run_script(*words)
            self.assertNotEqual(result.returncode, 0)
            return result.stderr.strip().splitlines()[-1]

        self.assertIn("no option lm.speed", last_line("--knobs", "lm.speed=1"))
        self.assertIn("choose from", last_line("--knobs", "speed"))
        self.assertIn("--seeds", last_line("--seeds=a"))
        self.assertIn("--lengths", last_line("--lengths=0"))
        self.assertIn("none", last_line("--program", str(self.folder / "none")))
        self.assertEqual(self.calls("train"), [])
        self.run_script("--knobs", "lm.iterations=0", "--rounds=1")
        path = self.folder / "out" / "records.jsonl"
        path.write_text(path.read_text().replace('"machine": "', '"machine": "Other '))
        self.assertIn("another machine", last_line())

    def test_plots(self):
        try:
            import matplotlib  # noqa: F401
        except ImportError:
            self.skipTest(f"{sys.executable} has no matplotlib (Debian: python3-matplotlib)")
        result = self.run_script("--knobs", "lm.iterations=0", "adam.metric=other", plot=True)
        self.assertEqual((result.returncode, "no matplotlib" in result.stderr), (0, False), result.stderr)
        self.assertTrue((self.folder / "out" / "front.png").read_bytes().startswith(b"\x89PNG"))
        text = (self.folder / "out" / "front.svg").read_text()
        self.assertIn("</svg>", text)
        self.run_script("--budget=0", plot=True)
        self.assertEqual((self.folder / "out" / "front.svg").read_text(), text, "the same points, the same bytes")


if __name__ == "__main__":
    unittest.main()

#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Races vesta's Python package beside vesta in C++, Ceres in C++ and scipy.

  PYTHONPATH=build/python python3 bench/python/race.py [--data DIR] [--rounds N] [--json FILE] [--fits N]

Bundle adjustment of the BAL files in DIR, written in numpy: seconds to within 0.1 % of the lowest cost. The seconds of
vesta.least_squares and vesta.Problem include the recording of the function. C++: build/release/bench/solver_vs_ceres.
Fits: N exponential decays of 30 samples, as one batch and by scipy in a loop (measured for 200 of them).
"""
import argparse
import json
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import scipy.optimize
import scipy.sparse

import vesta

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "bench"))
from report import print_targets, write_json  # noqa: E402

sys.path.insert(0, str(ROOT / "examples" / "python"))
from bundle_adjustment import project, read_bal  # noqa: E402


class Bundle:
    """A bundle adjustment problem as a function of one vector: all cameras, then all points."""

    def __init__(self, path):
        self.camera_of, self.point_of, self.pixels, self.cameras, self.points = read_bal(path)
        self.x0 = np.concatenate([self.cameras.ravel(), self.points.ravel()])

    def residuals(self, x):
        cameras = x[:self.cameras.size].reshape(-1, 9)
        points = x[self.cameras.size:].reshape(-1, 3)
        return (project(cameras[self.camera_of], points[self.point_of]) - self.pixels).ravel()

    def sparsity(self):
        rows = np.arange(2 * len(self.pixels))
        pattern = scipy.sparse.lil_matrix((rows.size, self.x0.size), dtype=int)
        for k in range(9):
            pattern[rows, np.repeat(self.camera_of, 2) * 9 + k] = 1
        for k in range(3):
            pattern[rows, self.cameras.size + np.repeat(self.point_of, 2) * 3 + k] = 1
        return pattern


class Reached(Exception):
    pass


def history_seconds(history, setup, target):
    """Seconds at which the cost is at most `target`, or infinity."""
    reached = np.flatnonzero(history["cost"] <= target)
    return setup + float(history["seconds"][reached[0]]) if reached.size else np.inf


def by_least_squares(bundle, target):
    start = time.perf_counter()
    result = vesta.least_squares(bundle.residuals, bundle.x0, max_nfev=100, ftol=1e-7,
                                 callback=lambda row: row["cost"] > target)
    # The solve began when its clock read 0; what follows it is the result's Jacobian.
    return history_seconds(result.history, result.setup_seconds, target), time.perf_counter() - start


def by_problem(bundle, target):
    start = time.perf_counter()
    problem = vesta.Problem()
    cameras, points = problem.add_blocks(bundle.cameras), problem.add_blocks(bundle.points)
    problem.add_residuals(lambda camera, point, pixel: project(camera, point) - pixel,
                          [cameras[bundle.camera_of], points[bundle.point_of]], [bundle.pixels])
    setup = time.perf_counter() - start
    summary = problem.solve(max_iterations=100, function_tolerance=1e-7, callback=lambda row: row["cost"] > target)
    return history_seconds(summary.iterations, setup, target), time.perf_counter() - start


def by_scipy(bundle, target, limit):
    """scipy's trust region method with LSMR, stopped at the target or after `limit` seconds."""
    start = time.perf_counter()

    def residuals(x):
        values = bundle.residuals(x)
        if 0.5 * values @ values <= target:
            raise Reached
        if time.perf_counter() - start > limit:
            raise TimeoutError
        return values

    try:
        scipy.optimize.least_squares(residuals, bundle.x0, jac_sparsity=bundle.sparsity(), x_scale="jac", ftol=1e-7,
                                     method="trf", tr_solver="lsmr")
    except Reached:
        return time.perf_counter() - start
    except TimeoutError:
        pass
    return np.inf


def in_cpp(path, rounds):
    """Rows of solver_vs_ceres by the name of the solver."""
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / path.name).symlink_to(path)
        out = Path(folder) / "rows.json"
        subprocess.run([ROOT / "build/release/bench/solver_vs_ceres", "--data", folder, "--threads",
                        str(vesta.num_threads()), "--repeats", str(rounds), "--seconds", "4", "--json", out], check=False,
                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        return {row["solver"]: row for row in json.loads(out.read_text())["rows"]}


def race_bundles(files, rounds, scipy_limit):
    rows, targets = [], []
    for path in files:
        bundle = Bundle(path)
        cpp = in_cpp(path, rounds)
        target = min(row["final cost"] for row in cpp.values()) * 1.001
        timings = {"least_squares": [], "Problem": []}
        for _ in range(rounds):
            timings["least_squares"].append(by_least_squares(bundle, target)[0])
            timings["Problem"].append(by_problem(bundle, target)[0])
        seconds = {f"vesta Python, {name}": statistics.median(values) for name, values in timings.items()}
        seconds["vesta C++, bundle adjustment"] = cpp["vesta"]["s to 1.001"]
        seconds["vesta C++, residual blocks"] = cpp["vesta bridge auto"]["s to 1.001"]
        seconds["Ceres, best"] = min(row["s to 1.001"] for name, row in cpp.items() if name.startswith("Ceres"))
        seconds["scipy trf, lsmr"] = by_scipy(bundle, target, scipy_limit)
        rows += [{"problem": path.stem, "solver": name, "seconds to 0.1 %": value} for name, value in seconds.items()]
        best = min(seconds["vesta Python, least_squares"], seconds["vesta Python, Problem"])
        scipy_seconds = min(seconds["scipy trf, lsmr"], scipy_limit)
        for name, value, goal, met in (
                ("Python / C++ bundle adjustment", best / seconds["vesta C++, bundle adjustment"], 2, lambda v, g: v <= g),
                ("best of Ceres / Python", seconds["Ceres, best"] / best, 1, lambda v, g: v >= g),
                ("scipy / Python (at least)", scipy_seconds / best, 50, lambda v, g: v >= g)):
            targets.append({"name": f"{path.stem}: {name}", "value": value, "goal": goal, "met": bool(met(value, goal))})
    return rows, targets


def race_fits(count):
    rng = np.random.default_rng(0)
    t = np.linspace(0, 3, 30)
    true = np.stack([1 + rng.random(count), 0.5 + rng.random(count), 0.2 * rng.standard_normal(count)])[:, :, None]

    def decay(x, t, y):
        return x[0] * np.exp(-x[1] * t) + x[2] - y

    y = decay(true, t, 0.01 * rng.standard_normal((count, 30)))
    seconds = []
    for _ in range(5):
        start = time.perf_counter()
        result = vesta.least_squares_each(decay, np.ones((count, 3)), (t, y))
        seconds.append(time.perf_counter() - start)
    some = min(count, 200)
    start = time.perf_counter()
    for i in range(some):
        theirs = scipy.optimize.least_squares(decay, np.ones(3), args=(t, y[i]))
        assert np.allclose(theirs.x, result.x[i], rtol=1e-4)
    loop = (time.perf_counter() - start) * count / some
    batch = statistics.median(seconds)
    rows = [{"problem": f"{count} fits", "solver": "vesta Python, least_squares_each", "seconds": batch},
            {"problem": f"{count} fits", "solver": "scipy in a loop", "seconds": loop}]
    return rows, [{"name": "fits: scipy in a loop / batch", "value": loop / batch, "goal": 100, "met": loop / batch >= 100}]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--fits", type=int, default=10000)
    parser.add_argument("--scipy_limit", type=float, default=60, help="seconds after which scipy is stopped")
    parser.add_argument("--json", type=Path)
    arguments = parser.parse_args()
    rows, targets = race_fits(arguments.fits)
    if arguments.data:
        files = sorted(arguments.data.glob("*.txt"))
        more_rows, more_targets = race_bundles(files, arguments.rounds, arguments.scipy_limit)
        rows, targets = more_rows + rows, more_targets + targets
    for row in rows:
        print("  ".join(f"{value:.4g}".rjust(10) if isinstance(value, float) else str(value).ljust(34)
                        for value in row.values()))
    print_targets(targets)
    if arguments.json:
        write_json(arguments.json, "python_race", rows, targets)


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""Quality against the number of Gaussians: by several criteria of who is dispensable, from the same splats, trained on in
the same way.

  bench/parsimony.py SCENE [--out DIR] [--keep 0.5,0.2,0.1] [--criteria worth,weight,...] [--seeds 0,1,2]
                     [--downscale 1] [--variant "FLAGS"]... [-- flags for `vesta train` and `vesta prune`]

For each seed the scene is trained once; that splat is pruned by each criterion to each part (`vesta prune`), and trained
on for as many iterations. Each run is a line of OUT/parsimony.jsonl, appended when it ends; what has a line is not run
again. A variant is a row of its own: more flags for `vesta prune`, by the criterion worth. Prints means over seeds with
their standard deviations, what is lost beside the splat that was pruned, and writes OUT/parsimony.json.
"""
import argparse
import json
import shutil
import statistics
import subprocess
import sys
from pathlib import Path

import markdown
import report

CRITERIA = ("worth", "weight", "sensitivity", "opacity", "random")


class Runs:
    """The records in a file, by what they are of."""

    def __init__(self, path):
        self._path = path
        path.parent.mkdir(parents=True, exist_ok=True)
        lines = path.read_text().splitlines() if path.exists() else []
        self.rows = [json.loads(line) for line in lines if line.strip()]

    def find(self, **identity):
        return next((row for row in self.rows if all(row[key] == value for key, value in identity.items())), None)

    def add(self, row):
        with self._path.open("a") as file:
            file.write(json.dumps(row) + "\n")
        self.rows.append(row)


def figures(folder):
    metrics = json.loads((folder / "metrics.json").read_text())
    return {"gaussians": metrics["gaussians"], "test_psnr": metrics["test"]["psnr"], "test_ssim": metrics["test"]["ssim"],
            "train_psnr": metrics["train"]["psnr"], "cost": metrics["history"][-1]["cost"],
            "seconds": metrics["seconds"]["total"] - metrics["seconds"]["eval"],
            "ply_mib": (folder / "point_cloud.ply").stat().st_size / 2**20}


def call(*words):
    result = subprocess.run([str(word) for word in words], capture_output=True, text=True)
    if result.returncode != 0:
        sys.exit(f"parsimony.py: {' '.join(map(str, words))}: {(result.stderr.strip().splitlines() or ['failed'])[-1]}")


def carry_out(options, flags, runs):
    identity = {"scene": options.scene.name, "downscale": options.downscale, "flags": flags}
    if any(row[key] != value for row in runs.rows for key, value in identity.items()):
        sys.exit(f"parsimony.py: {options.out} has runs of another scene, size or flags; give another --out")
    flags = [f"--downscale={options.downscale}", *flags]
    ways = [(criterion, [f"--set=parsimony.criterion={criterion}"]) for criterion in options.criteria]
    ways += [(variant, variant.split()) for variant in options.variant]
    for seed in options.seeds:
        start = options.out / f"start-{seed}"
        if not (start / "metrics.json").exists() or not runs.find(**identity, way="whole", seed=seed):
            call(options.program, "train", options.scene, "--out", start, f"--seed={seed}", *flags)
            runs.add({**identity, "way": "whole", "keep": 1, "seed": seed, **figures(start)})
        for keep in options.keep:
            for way, words in ways:
                if runs.find(**identity, way=way, keep=keep, seed=seed):
                    continue
                folder = options.out / "run"
                call(options.program, "prune", start / "point_cloud.ply", options.scene, "--out", folder,
                     f"--keep={keep}", f"--seed={seed}", *words, *flags)
                row = {**identity, "way": way, "keep": keep, "seed": seed, **figures(folder)}
                shutil.rmtree(folder)
                runs.add(row)
                print(f"{options.scene.name} seed {seed}: {keep:g} by {way}: {row['test_psnr']:.3f} dB, "
                      f"{row['seconds']:.1f} s", flush=True)


def summary(runs, scene):
    """A row for each part and way: means over the seeds that ran, beside the whole splats of the same seeds."""
    rows = []
    whole = {row["seed"]: row for row in runs.rows if row["way"] == "whole"}
    keys = {(row["keep"], row["way"]): None for row in runs.rows}
    for keep, way in sorted(keys, key=lambda key: -key[0]):
        of = [row for row in runs.rows if (row["keep"], row["way"]) == (keep, way)]
        lost = [row["test_psnr"] - whole[row["seed"]]["test_psnr"] for row in of]
        rows.append({"scene": scene, "keep": keep, "way": way, "seeds": len(of),
                     **{figure: statistics.fmean(row[figure] for row in of)
                        for figure in ("gaussians", "test_psnr", "test_ssim", "train_psnr", "seconds", "ply_mib")},
                     "psnr_sd": statistics.stdev(row["test_psnr"] for row in of) if len(of) > 1 else 0.0,
                     "psnr_beside_whole": statistics.fmean(lost)})
    return rows


def main():
    arguments, flags = report.split_at_dashes(sys.argv[1:])
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)

    def numbers(kind):
        return lambda text: [kind(part) for part in text.split(",")]

    root = Path(__file__).resolve().parents[1]
    parser.add_argument("scene", type=Path)
    parser.add_argument("--program", type=Path, default=root / "build/release/vesta")
    parser.add_argument("--out", type=Path)
    parser.add_argument("--keep", type=numbers(float), default=[0.5, 0.2, 0.1])
    parser.add_argument("--criteria", type=lambda text: [w for w in text.split(",") if w], default=list(CRITERIA))
    parser.add_argument("--seeds", type=numbers(int), default=[0, 1, 2])
    parser.add_argument("--downscale", type=int, default=1)
    parser.add_argument("--variant", action="append", default=[])
    options = parser.parse_args(arguments)
    options.out = options.out or root / "out/parsimony" / options.scene.name
    runs = Runs(options.out / "parsimony.jsonl")
    try:
        carry_out(options, flags, runs)
    except KeyboardInterrupt:
        print("broken off; the same command goes on")
    rows = summary(runs, options.scene.name)
    if rows:
        print(markdown.table(list(rows[0]), rows))
        report.write_json(options.out / "parsimony.json", "parsimony", rows, [])


if __name__ == "__main__":
    main()

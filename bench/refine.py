#!/usr/bin/env python3
"""Refines splats with the program and says by how much they are better: cost, and PSNR of the training and test views.

  bench/refine.py PROGRAM OUT_DIR PLY=SCENE ... [--json FILE] [-- flags for `vesta refine`]

PLY=SCENE: a splat of any trainer's and the scene it shows. PLY may be `adam`: then the program first trains the scene
by Adam alone. Each run's output lies in OUT_DIR. Prints a table; with --json also {"bench", "machine", "commit", "rows",
"targets"}: a lower cost, a higher train PSNR and a test PSNR no lower, of each.
"""
import argparse
import json
import subprocess
import sys
from pathlib import Path

import report

COLUMNS = ["splat", "gaussians", "seconds", "cost", "cost_after", "train_psnr", "train_psnr_after", "test_psnr",
           "test_psnr_after", "test_ssim", "test_ssim_after"]


def run(*words):
    subprocess.run([str(word) for word in words], check=True, stdout=subprocess.DEVNULL)


def refine(program, ply, scene, out, flags):
    name = f"{Path(ply).stem}, {Path(scene).name}"
    folder = out / name.replace(", ", "-")
    if ply == "adam":
        run(program, "train", scene, "--out", f"{folder}-start", "--lm_iterations=0")
        ply = f"{folder}-start/point_cloud.ply"
    run(program, "refine", ply, scene, "--out", folder, *flags)
    metrics = json.loads((folder / "metrics.json").read_text())
    before, after = metrics["history"][0], metrics["history"][-1]
    row = {"splat": name, "gaussians": metrics["gaussians"], "seconds": after["seconds"] - before["seconds"]}
    for figure in ("cost", "train_psnr", "test_psnr", "test_ssim"):
        row[figure], row[f"{figure}_after"] = before[figure], after[figure]
    return row


def targets_of(row):
    def target(what, unit, value, met):
        return {"name": f"{row['splat']}: {what}", "value": value, "unit": unit, "goal": 0, "met": met}

    cost = row["cost_after"] / row["cost"] - 1
    train, test = (row[f"{figure}_after"] - row[figure] for figure in ("train_psnr", "test_psnr"))
    return [target("change of the cost", "of it", cost, cost < 0), target("gain in train PSNR", "dB", train, train > 0),
            target("gain in test PSNR", "dB", test, test >= 0)]


def main():
    arguments, flags = report.split_at_dashes(sys.argv[1:])
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("splats", nargs="+", metavar="PLY=SCENE")
    parser.add_argument("--json", type=Path)
    options = parser.parse_args(arguments)
    pairs = [splat.split("=", 1) for splat in options.splats]
    if any(len(pair) != 2 for pair in pairs):
        parser.error("write PLY=SCENE")

    rows, targets = [], []
    print("  ".join(f"{column:>16}" for column in COLUMNS))
    for ply, scene in pairs:
        row = refine(options.program.resolve(), ply, scene, options.out, flags)
        rows.append(row)
        targets += targets_of(row)
        print("  ".join(f"{report.text(row[column]):>16}" for column in COLUMNS), flush=True)
    report.print_targets(targets)
    if options.json:
        report.write_json(options.json, "refine", rows, targets)


if __name__ == "__main__":
    main()

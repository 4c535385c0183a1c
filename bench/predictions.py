#!/usr/bin/env python3
"""Trains scenes and compares what the program said of the training with what it took.

  bench/predictions.py PROGRAM OUT_DIR SCENE ... [--seeds 0 1 2] [--limits 15 60] [--json FILE] [-- flags for `vesta train`]

Without --limits: seconds, MiB and Gaussians as predicted, and as first guessed, in parts of what they were. With them:
the part of each --time_limit that was used, and the quality reached. Prints a table; with --json also {"bench",
"machine", "commit", "rows", "targets"}: time within 15 %, memory within 10 %; limits used to 5 %.
"""
import argparse
import json
import subprocess
import sys
from pathlib import Path

import report

COLUMNS = ["scene", "seed", "seconds", "mib", "gaussians", "guessed_seconds", "guessed_mib", "guessed_gaussians",
           "predicted_seconds", "predicted_mib", "predicted_gaussians", "test_psnr", "test_ssim"]
LIMIT_COLUMNS = ["scene", "seed", "limit", "used", "iterations", "gaussians", "test_psnr", "test_ssim"]


def train(program, scene, out, flags):
    subprocess.run([str(program), "train", str(scene), "--out", str(out), *flags], check=True, stdout=subprocess.DEVNULL)
    return json.loads((out / "metrics.json").read_text())


def foretold(metrics):
    """What was said, each in parts of what it was; a figure that was not said is left out."""
    truth = {"seconds": metrics["seconds"]["total"], "mib": metrics["peak_memory_mib"],
             "gaussians": metrics["gaussians"]}
    row = dict(truth)
    for kind in ("guessed", "predicted"):
        for what, value in truth.items():
            if kind in metrics and value:
                row[f"{kind}_{what}"] = metrics[kind][what] / value
    return row


def limited(metrics, limit):
    return {"limit": limit, "used": metrics["seconds"]["total"] / limit,
            "iterations": metrics["history"][-1]["iteration"], "gaussians": metrics["gaussians"]}


def within(name, value, tolerance):
    return {"name": name, "value": value, "unit": "of it", "goal": tolerance, "met": abs(value - 1) <= tolerance}


def targets_of(row):
    name = f"{row['scene']}, seed {row['seed']}"
    if "limit" in row:
        return [within(f"{name}: used of {row['limit']:g} s", row["used"], 0.05)]
    return [within(f"{name}: {what} predicted", row[key], tolerance)
            for what, key, tolerance in (("seconds", "predicted_seconds", 0.15), ("MiB", "predicted_mib", 0.10))
            if key in row]


def main():
    arguments, flags = report.split_at_dashes(sys.argv[1:])
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("scenes", nargs="+", type=Path, metavar="SCENE")
    parser.add_argument("--seeds", nargs="+", type=int, default=[0])
    parser.add_argument("--limits", nargs="+", type=float, default=[])
    parser.add_argument("--json", type=Path)
    options = parser.parse_args(arguments)
    columns = LIMIT_COLUMNS if options.limits else COLUMNS
    rows = []
    print("  ".join(f"{column:>20}" for column in columns))
    for scene in options.scenes:
        for limit in options.limits or [None]:
            for seed in options.seeds:
                out = options.out / f"{scene.name}-{limit or 'all'}-{seed}"
                limits = [f"--time_limit={limit}"] if limit else []
                metrics = train(options.program, scene, out, [f"--seed={seed}", *limits, *flags])
                row = {"scene": scene.name, "seed": seed, **(limited(metrics, limit) if limit else foretold(metrics))}
                row["test_psnr"], row["test_ssim"] = metrics["test"]["psnr"], metrics["test"]["ssim"]
                rows.append(row)
                print("  ".join(f"{report.text(row.get(column)):>20}" for column in columns), flush=True)
    targets = [target for row in rows for target in targets_of(row)]
    report.print_targets(targets)
    if options.json:
        report.write_json(options.json, "predictions", rows, targets)


if __name__ == "__main__":
    main()

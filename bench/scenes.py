#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Trains real scenes and compares the quality with OpenSplat 1.1.5 (CPU mode, 2,000 iterations) on the same images.
Reports when vesta exceeds OpenSplat's test PSNR and SSIM, and the final figures.

  bench/scenes.py PROGRAM SCENES_DIR OUT_DIR [--json FILE] [--only NAME ...] [-- flags for `vesta train`]

SCENES_DIR contains llff-fern-tiny, llff-fern, mip360-bonsai and strecha-herzjesu-p25 as COLMAP scenes. Each run writes
to OUT_DIR/NAME. Prints a table; --json also writes {"bench", "machine", "commit", "rows", "targets"}. To compare
presets, pass `-- --preset=NAME`.
"""
import argparse
import json
import subprocess
import sys
from pathlib import Path

import report

# name: (scene, flags, PSNR and SSIM to exceed, goal for the seconds to do so: a fifth of OpenSplat's time)
RUNS = {
    "llff-fern-tiny": ("llff-fern-tiny", [], 26.99, 0.908, 20),
    "strecha-herzjesu-p25/2": ("strecha-herzjesu-p25", ["--downscale=2"], 23.25, 0.806, 55),
    "mip360-bonsai/2": ("mip360-bonsai", ["--downscale=2"], 22.06, 0.709, 45),
    "llff-fern": ("llff-fern", [], 24.46, 0.792, 190),
    "mip360-bonsai": ("mip360-bonsai", [], None, None, None),
}
COLUMNS = ["scene", "passed_s", "goal_s", "adam_s", "adam_psnr", "adam_ssim", "lm_s", "psnr", "ssim", "train_psnr",
           "gaussians", "total_s", "peak_mib"]


def train(program, name, scenes, out, flags):
    scene, scene_flags, psnr, ssim, seconds = RUNS[name]
    folder = out / name.replace("/", "-by-")
    subprocess.run([program, "train", scenes / scene, "--out", folder, *scene_flags, *flags], check=True,
                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    metrics = json.loads((folder / "metrics.json").read_text())
    history = metrics["history"]
    passed = None
    if psnr is not None:
        passed = next((row["seconds"] for row in history
                       if row["test_psnr"] >= psnr and row["test_ssim"] >= ssim), None)
    adam = [row for row in history if row["stage"] == "adam"][-1]
    lm = [row for row in history if row["stage"] == "lm"]
    return {"scene": name, "passed_s": passed, "goal_s": seconds, "adam_s": adam["seconds"],
            "adam_psnr": adam["test_psnr"], "adam_ssim": adam["test_ssim"], "lm_s": lm[-1]["seconds"] if lm else None,
            "psnr": metrics["test"]["psnr"], "ssim": metrics["test"]["ssim"], "train_psnr": metrics["train"]["psnr"],
            "gaussians": metrics["gaussians"], "total_s": metrics["seconds"]["total"],
            "peak_mib": metrics["peak_memory_mib"],
            "cost_falls": all(b["cost"] <= a["cost"] for a, b in zip(lm, lm[1:]))}


def main():
    arguments, flags = report.split_at_dashes(sys.argv[1:])
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=Path)
    parser.add_argument("scenes", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("--json", type=Path)
    parser.add_argument("--only", nargs="*", choices=list(RUNS), default=list(RUNS))
    options = parser.parse_args(arguments)

    rows, targets = [], []
    print("  ".join(f"{column:>10}" for column in COLUMNS))
    for name in options.only:
        row = train(options.program.resolve(), name, options.scenes, options.out, flags)
        rows.append(row)
        print("  ".join(f"{report.text(row[column]):>10}" for column in COLUMNS), flush=True)
        if row["goal_s"] is not None:
            targets.append({"name": f"{name}: seconds to OpenSplat's PSNR and SSIM", "value": row["passed_s"],
                            "unit": "s", "goal": row["goal_s"],
                            "met": row["passed_s"] is not None and row["passed_s"] <= row["goal_s"]})
    report.print_targets(targets)
    if options.json:
        report.write_json(options.json, "scenes", rows, targets)


if __name__ == "__main__":
    main()

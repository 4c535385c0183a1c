#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Plots test PSNR and SSIM over seconds of training from the CSV of lm_vs_adam --curves, one row per scene. The dashed
line is the target, and the dotted line the time at which the fastest Adam schedule reached it.

  bench/training_race/plot.py CURVES.csv... OUT.png [--methods PART_OF_NAME,...]
"""
import argparse
import csv
from collections import defaultdict

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

PANELS = (("test_psnr", "test PSNR, dB"), ("test_ssim", "test SSIM"))


def style(method, adams):
    if method == "ours":
        return {"color": "C3", "lw": 2.2, "zorder": 3}
    if method.startswith("paper"):
        return {"color": "C0", "lw": 1.4, "ls": "-" if method == "paper" else "--", "zorder": 2}
    if "views" in method:
        return {"color": "C2", "lw": 1, "ls": "--"}
    shade = 0.25 + 0.5 * adams.index(method) / max(1, len(adams) - 1)
    return {"color": str(shade), "lw": 1}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("curves", nargs="+")
    parser.add_argument("out")
    parser.add_argument("--methods", default="")
    arguments = parser.parse_args()
    scenes = defaultdict(lambda: defaultdict(list))
    for name in arguments.curves:
        with open(name, newline="") as file:
            for row in csv.DictReader(file):
                if row["method"] == "target" or any(part in row["method"] for part in arguments.methods.split(",")):
                    scenes[row["scene"]][row["method"]].append(row)
    if not scenes:
        parser.error("no curve of these methods")
    figure, axes = plt.subplots(len(scenes), 2, figsize=(12, 4.2 * len(scenes)), squeeze=False)
    for axis_row, (scene, methods) in zip(axes, scenes.items()):
        target = methods.pop("target", [None])[0]
        adams = [method for method in methods if method.startswith("adam") and "views" not in method]
        for axis, (column, label) in zip(axis_row, PANELS):
            for method, rows in methods.items():
                axis.plot([float(row["seconds"]) for row in rows], [float(row[column]) for row in rows], label=method,
                          **style(method, adams))
            best = max(float(row[column]) for rows in methods.values() for row in rows)
            worst = min(float(rows[-1][column]) for rows in methods.values())
            room = max(best - worst, 1e-6)
            if target:
                axis.axhline(float(target[column]), color="k", ls="--", lw=0.7)
                axis.axvline(float(target["seconds"]), color="k", ls=":", lw=0.7)
            axis.set(title=scene, xlabel="seconds of training", ylabel=label, ylim=(worst - 1.5 * room, best + 0.2 * room))
            axis.legend(fontsize=6, loc="lower right")
    figure.tight_layout()
    figure.savefig(arguments.out, dpi=80)


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""Draws what trainings from wrong cameras came to, by method: plot_cameras.py PLOT.png CAMERAS.json ... of bench/cameras.

One panel for each scene: how far its cameras stand off in the end (log scale) against the PSNR of its test views with their cameras
fitted; a dotted line where they stood at first.
"""
import json
import sys
from pathlib import Path

import plot_history

try:
    from matplotlib.figure import Figure
except ImportError:
    sys.exit(f"plot_cameras.py: {sys.executable} has no matplotlib; on Debian: apt-get install python3-matplotlib")

_KINDS = (("gauss_newton", "Gauss-Newton", "#d1495b", "o"), ("adam", "Adam", "#3b6fb6", "x"), ("exact", "right cameras", "#2f9e44", "*"),
          ("none", "not found along", "#868e96", "s"), ("auto", "auto", "#e8890c", "^"))


def load(paths):
    rows = []
    for path in paths:
        try:
            rows += json.loads(Path(path).read_text())["rows"]
        except (OSError, ValueError, KeyError) as error:
            sys.exit(f"{path}: not what bench/cameras writes ({error})")
    return rows


def draw(rows):
    scenes = list(dict.fromkeys(row["scene"] for row in rows))
    figure = Figure(figsize=(5 * len(scenes), 4), layout="constrained")
    for axes, scene in zip(figure.subplots(1, len(scenes), squeeze=False)[0], scenes):
        for prefix, label, color, marker in _KINDS:
            part = [row for row in rows if row["scene"] == scene and row["method"].startswith(prefix) and row["off_pixels"] > 0]
            axes.plot([row["off_pixels"] for row in part], [row["psnr_aligned"] for row in part], marker, color=color,
                      label=label if part else None)
        right = [row["psnr_aligned"] for row in rows if row["scene"] == scene and row["method"] == "exact"]
        for psnr in right:
            axes.axhline(psnr, ls=":", lw=1, color="#2f9e44")
        for start in (row["off_pixels"] for row in rows if row["scene"] == scene and row["method"] == "none"):
            axes.axvline(start, ls=":", lw=1, color="#868e96")
        axes.set_xscale("log")
        axes.set_title(scene)
        axes.set_xlabel("cameras off in the end, median pixels")
        axes.set_ylabel("PSNR of test views, aligned (dB)")
        axes.grid(True, which="both", alpha=0.25)
        axes.legend()
    return figure


if __name__ == "__main__":
    if len(sys.argv) < 3:
        sys.exit("usage: plot_cameras.py PLOT.png CAMERAS.json ...")
    plot_history.save(draw(load(sys.argv[2:])), sys.argv[1])

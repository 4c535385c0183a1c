#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Plots loss and PSNR of a training over time: plot_history.py DIR/metrics.json PLOT.png"""
import os
import sys

import history

try:
    from matplotlib.figure import Figure
    from matplotlib.ticker import FormatStrFormatter, LogLocator, NullFormatter
except ImportError:
    sys.exit(f"plot_history.py: {sys.executable} has no matplotlib; on Debian: apt-get install python3-matplotlib")

_COLORS = {"adam": "#3b6fb6", "lm": "#d1495b"}


def draw(rows):
    """Two plots over seconds: the training loss (log scale), and PSNR on test and training views."""
    figure = Figure(figsize=(10, 4), layout="constrained")
    cost, psnr = figure.subplots(1, 2)
    for stage in history.STAGES:
        part = history.stage_rows(rows, stage)
        if not part:
            continue
        name, color = history.NAMES[stage], _COLORS[stage]
        seconds = [row["seconds"] for row in part]
        cost.plot(seconds, [row["cost"] for row in part], "o-", ms=3, color=color, label=name)
        psnr.plot(seconds, [row["test_psnr"] for row in part], "o-", ms=3, color=color, label=f"{name}, test views")
        psnr.plot(seconds, [row["train_psnr"] for row in part], "--", lw=1, color=color, label=f"{name}, training views")
    cost.set_yscale("log")
    cost.yaxis.set_major_locator(LogLocator(subs=(1, 2, 3, 5, 7)))
    cost.yaxis.set_major_formatter(FormatStrFormatter("%g"))
    cost.yaxis.set_minor_formatter(NullFormatter())
    cost.set_ylabel("training loss: 0.8 L1 + 0.2 (1 - SSIM)")
    psnr.set_ylabel("PSNR (dB)")
    for axes in (cost, psnr):
        axes.set_xlabel("seconds")
        axes.grid(True, which="both", alpha=0.25)
        axes.legend()
    return figure


def save(figure, path):
    """Writes the figure as PNG atomically."""
    temporary = path + ".tmp"
    try:
        figure.savefig(temporary, format="png", dpi=120)
        os.replace(temporary, path)
    except OSError as error:
        sys.exit(f"{path}: cannot be written ({error.strerror}); choose a folder you can write")


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit("usage: plot_history.py METRICS_JSON PLOT_PNG")
    save(draw(history.load(sys.argv[1])), sys.argv[2])

#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Plots the cost of every solver over time, one panel per problem, from the CSV of solver_vs_ceres --curves.

  bench/solver_race/plot.py CURVES.csv OUT.png [--threads N]
"""
import argparse
import csv
from collections import defaultdict

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("curves")
    parser.add_argument("out")
    parser.add_argument("--threads", default="2")
    arguments = parser.parse_args()
    curves = defaultdict(lambda: defaultdict(list))
    with open(arguments.curves, newline="") as file:
        for row in csv.DictReader(file):
            if row["threads"] == arguments.threads:
                curves[row["problem"]][row["solver"]].append((float(row["seconds"]), float(row["cost"])))
    if not curves:
        parser.error(f"{arguments.curves}: no run with {arguments.threads} threads")
    columns = min(3, len(curves))
    rows = -(-len(curves) // columns)
    figure, axes = plt.subplots(rows, columns, figsize=(6 * columns, 4.2 * rows), squeeze=False)
    for axis in axes.flat[len(curves):]:
        axis.set_visible(False)
    colors = {}
    for axis, (problem, solvers) in zip(axes.flat, curves.items()):
        best = min(cost for moments in solvers.values() for _, cost in moments)
        for solver, moments in solvers.items():
            color = colors.setdefault(solver, f"C{len(colors) % 10}")
            # The first moment has time 0; the axis is logarithmic.
            points = [(max(t, 1e-4), max(c / best - 1, 1e-9)) for t, c in moments]
            axis.plot(*zip(*points), label=solver, color=color, lw=2 if solver.startswith("vesta") else 1,
                      ls="-" if solver.startswith("vesta") else "--")
        axis.axhline(1e-3, color="gray", lw=0.7)
        axis.set(title=problem, xscale="log", yscale="log", xlabel="seconds", ylabel="cost / best - 1")
        axis.legend(fontsize=6)
    figure.tight_layout()
    figure.savefig(arguments.out, dpi=72)


if __name__ == "__main__":
    main()

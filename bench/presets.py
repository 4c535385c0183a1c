#!/usr/bin/env python3
"""Presets from the fronts of several scenes, and how far those of the program lie from them.

  bench/presets.py DIR_OF_RECORDS... [--program build/release/vesta]

Each folder is one that `bench/tradeoff.py` wrote. Only settings that ran on all of them count, at the same length. Costs
are parts of what the default takes on the same scene, and gains decibels beside it, so that scenes can be averaged (over
seeds first). A preset is the setting of the highest mean PSNR whose mean cost is at most its budget; of those within
--close decibels of that, the cheapest. The rule is in this script and not in the program: it prints what to write there.
"""
import argparse
import collections
import json
import statistics
import sys
from pathlib import Path

import markdown
import report
from training_front import front, knobs, runs

# What each preset may take, in parts of the default's time.
BUDGETS = {"fast": 0.35, "balanced": 1.1, "best": 2.2}


def base_of(rows):
    """The default's options: of each key the value that most runs have, since a run changes few."""
    counts = collections.defaultdict(collections.Counter)
    for row in rows:
        for key, value in row["options"].items():
            counts[key][json.dumps(value)] += 1
    return {key: json.loads(values.most_common(1)[0][0]) for key, values in counts.items()}


def relative(settings, base):
    """Settings that mean the same on every scene: image scales as factors on the scene's own."""
    return {key: f"x{value / base[key]:g}" if key == knobs.SCALE else value for key, value in settings.items()}


def name_of(point):
    return knobs.words_of({knobs.LENGTH: point["length"], **point["settings"]})


def points_of_scene(folder, by):
    """By name: cost as a part of the default's, gain on the default, and distance to the front at the same cost."""
    rows = [row for row in runs.Records(folder / "records.jsonl", print).rows if "failed" not in row]
    if not rows:
        raise ValueError(f"{folder}: no run that ended; bench/tradeoff.py makes them")
    base = base_of(rows)
    points = [{**point, "settings": relative(point["settings"], base)} for point in front.points_of(rows, base)]
    default = next((point for point in points if not point["settings"] and point["length"] == 1), None)
    if default is None:
        raise ValueError(f"{folder}: the default was not run; bench/tradeoff.py runs it")
    best = front.front_of(points, by, "psnr")
    return {name_of(point): {
        "length": point["length"], "settings": point["settings"], "cost": point[by] / default[by],
        "psnr": point["psnr"] - default["psnr"], "ssim": point["ssim"] - default["ssim"],
        "mib": point["peak_mib"] / default["peak_mib"], "gaussians": point["gaussians"] / default["gaussians"],
        "under the front": front.best_at(best, by, "psnr", point[by]) - point["psnr"]} for point in points}


def averaged(scenes):
    """The settings that ran on all scenes, each figure a mean over them, with the worst scene's distance."""
    common = set.intersection(*(set(points) for points in scenes))
    result = []
    for name in sorted(common):
        each = [points[name] for points in scenes]
        means = {figure: statistics.fmean(point[figure] for point in each)
                 for figure in ("cost", "psnr", "ssim", "mib", "gaussians", "under the front")}
        result.append({"name": name, "length": each[0]["length"], "settings": each[0]["settings"], **means,
                       "worst": max(point["under the front"] for point in each),
                       "least gain": min(point["psnr"] for point in each)})
    return result


def choose(points, budget, close):
    """Of the points within the budget the cheapest that is nearly as good as the best. None where none is."""
    within = [point for point in points if point["cost"] <= budget]
    if not within:
        return None
    best = max(point["psnr"] for point in within)
    return min((point for point in within if point["psnr"] >= best - close), key=lambda point: point["cost"])


def row_of(point, preset=""):
    return {"preset": preset, "settings": point["name"], "cost": f"{point['cost']:.2f}", "dB": f"{point['psnr']:+.2f}",
            "SSIM": f"{point['ssim']:+.4f}", "worst scene, dB": f"{point['least gain']:+.2f}",
            "under the front, dB": f"{point['under the front']:.2f} (worst {point['worst']:.2f})",
            "memory": f"{point['mib']:.2f}", "Gaussians": f"{point['gaussians']:.2f}"}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folders", nargs="+", type=Path)
    parser.add_argument("--by", choices=("seconds", "work"), default="seconds")
    parser.add_argument("--close", type=float, default=0.05, help="dB that are not worth any time [0.05]")
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    try:
        points = averaged([points_of_scene(folder, options.by) for folder in options.folders])
    except (OSError, ValueError) as error:
        sys.exit(f"presets.py: {error}")
    points.sort(key=lambda point: point["cost"])
    print(f"Settings that ran on all {len(options.folders)} scenes, beside the default; cost in its {options.by}\n")
    print(markdown.table(list(row_of(points[0])), [row_of(point) for point in points]))
    chosen = {preset: choose(points, budget, options.close) for preset, budget in BUDGETS.items()}
    print("\nThe presets that follow\n")
    print(markdown.table(list(row_of(points[0])),
                         [row_of(point, f"{preset} (cost up to {BUDGETS[preset]:g})")
                          for preset, point in chosen.items() if point]))
    if options.json:
        report.write_json(options.json, "presets", points, [])


if __name__ == "__main__":
    main()

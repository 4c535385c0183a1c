#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Compares the JSON of a benchmark with a baseline, figure by figure, and fails if one is worse.

  bench/compare.py BASELINE NEW [--tolerance 0.02] [--time_tolerance 0.3]
  bench/compare.py --self_test

BASELINE and NEW are two files that a benchmark wrote with --json, or two folders of such files (bench/baselines and the
output folder of bench/baselines.py). Prints a line of ratios, new over baseline, for each row. There are three kinds of
columns:

  counted   iterations, digits, sizes, memory; marked * in the heading. A figure fails if it is worse than the baseline
            by more than the fraction --tolerance.
  of times  ratio of two times of one run; marked ~. A figure fails if it is worse by more than --time_tolerance.
  shown     all others are only printed: seconds depend more on the machine than on the code.

A missing row or file also fails, and so does a target that the baseline met and the new run missed. RULES assigns the
kinds. A benchmark without rules is compared by its targets only.
"""
import argparse
import copy
import json
import sys
from pathlib import Path

LESS, MORE, SAME = "less is better", "more is better", "any change is a failure"

# For each benchmark: "key", the columns that identify a row (by default all text columns); the columns compared as
# counts and as ratios of times; "rows", (column, prefix): compares only rows with this prefix.
RULES = {
    "toy_vs_ceres": {
        "counted": {"digits, vesta": MORE, "iterations, vesta": LESS},
    },
    "image_loss": {"of times": {"ratio": MORE}},
    "kernels": {
        "key": ["workload", "threads", "pass"],
        "counted": {"splats": SAME, "pairs": SAME, "vectors a pair": LESS, "useful": MORE, "lanes used": MORE,
                    "splats a pixel": SAME},
        "of times": {"% of floor": MORE},
    },
    "matrix_free_at_scale": {
        "key": ["side", "frames"],
        "counted": {"stored J, GiB": SAME, "peak memory, GiB": LESS, "LM iterations": LESS, "PCG iterations": LESS},
    },
    "solver_vs_ceres": {
        "key": ["problem", "threads", "solver"],
        "counted": {"final cost": LESS, "iterations": LESS, "inner": LESS},
        "rows": ("solver", "vesta"),
        # A target's value is a time of Ceres divided by a time of vesta.
        "targets": MORE,
    },
}


def keys_of(report, rule):
    if "key" in rule:
        return rule["key"]
    return [name for name, value in report["rows"][0].items() if isinstance(value, str)] if report["rows"] else []


def is_worse(old, new, direction, tolerance):
    if old is None:  # not reached, or not finite
        return False
    if new is None:
        return True
    slack = tolerance * abs(old)
    return (direction != MORE and new > old + slack) or (direction != LESS and new < old - slack)


def ratio_text(old, new):
    if old is None or new is None:
        return "=" if old is new else "-"
    if old == new:
        return "1"
    return f"{new / old:.3f}" if old != 0 else f"0>{new:.2g}"


def compare(baseline, new, tolerance, time_tolerance):
    """Returns the lines to print, and the failures."""
    rule = RULES.get(baseline["bench"], {})
    lines, faults = [], []
    if baseline["bench"] != new["bench"]:
        return lines, [f"{new['bench']} is compared with a baseline of {baseline['bench']}"]
    keys = keys_of(baseline, rule)
    counted, of_times = rule.get("counted", {}), rule.get("of times", {})
    judged = {**{name: (direction, tolerance, "*") for name, direction in counted.items()},
              **{name: (direction, time_tolerance, "~") for name, direction in of_times.items()}}
    new_rows = {tuple(row[key] for key in keys): row for row in new["rows"]}
    figures = [name for name in (baseline["rows"] or [{}])[0] if name not in keys]
    table = [[*keys, *(name + judged[name][2] if name in judged else name for name in figures)]]
    where, begin = rule.get("rows", ("", ""))
    for row in baseline["rows"]:
        key = tuple(row[name] for name in keys)
        title = ", ".join(str(part) for part in key)
        if key not in new_rows:
            faults.append(f"{title}: the row is missing")
            continue
        other, cells = new_rows[key], [str(part) for part in key]
        for name in figures:
            if name not in other:
                faults.append(f"{title}: {name} is missing")
                cells.append("missing")
                continue
            cell = ratio_text(row[name], other[name]) if not isinstance(row[name], str) else ""
            if name in judged and row.get(where, "").startswith(begin):
                direction, allowed, _ = judged[name]
                if is_worse(row[name], other[name], direction, allowed):
                    faults.append(f"{title}: {name} was {row[name]}, is {other[name]} ({direction})")
                    cell += "!"
            cells.append(cell)
        table.append(cells)
    widths = [max(len(row[column]) for row in table) for column in range(len(table[0]))]
    lines += ["  ".join(cell.rjust(width) for cell, width in zip(row, widths)) for row in table]

    new_targets = {target["name"]: target for target in new["targets"]}
    for target in baseline["targets"]:
        name = target["name"]
        if name not in new_targets:
            faults.append(f"target {name}: missing")
            continue
        other = new_targets[name]
        lines.append(f"target {name}: {ratio_text(target['value'], other['value'])} of the baseline's, "
                     f"{'met' if other['met'] else 'MISSED'}")
        if target["met"] and not other["met"]:
            faults.append(f"target {name}: was met with {target['value']}, is missed with {other['value']}")
        elif "targets" in rule and is_worse(target["value"], other["value"], rule["targets"], time_tolerance):
            faults.append(f"target {name}: was {target['value']}, is {other['value']} ({rule['targets']})")
    return lines, faults


def pairs_of(baseline, new):
    """Returns pairs of files. For two folders, there is one pair for each baseline file."""
    if baseline.is_dir() != new.is_dir():
        sys.exit("BASELINE and NEW must be two files, or two folders")
    if not baseline.is_dir():
        return [(baseline, new)]
    return [(path, new / path.name) for path in sorted(baseline.glob("*.json"))]


def run(baseline, new, tolerance, time_tolerance):
    all_faults = []
    for old_path, new_path in pairs_of(baseline, new):
        if not new_path.exists():
            all_faults.append(f"{new_path} is missing")
            continue
        old, other = json.loads(old_path.read_text()), json.loads(new_path.read_text())
        print(f"{old['bench']}: {other['machine']}, commit {other['commit']}\n"
              f"    baseline: {old['machine']}, commit {old['commit']}")
        lines, faults = compare(old, other, tolerance, time_tolerance)
        print("\n".join(lines), end="\n\n")
        all_faults += [f"{old['bench']}: {fault}" for fault in faults]
    for fault in all_faults:
        print(f"WORSE {fault}")
    print(f"{len(all_faults)} figures are worse than the baseline" if all_faults else "no figure is worse")
    return 1 if all_faults else 0


def self_test():
    """Checks that planted faults are reported, then that the stored baselines are valid."""
    def faults_after(bench, rows, change, targets=()):
        old = {"bench": bench, "rows": rows, "targets": list(targets)}
        new = copy.deepcopy(old)
        change(new)
        return compare(old, new, 0.02, 0.3)[1]

    def expect(faults, words):
        assert len(faults) == (1 if words else 0), faults
        assert not words or words in faults[0], faults

    toy = [{"problem": "A", "start": "1", "digits, vesta": 10.0, "iterations, vesta": 100, "digits, Ceres": 9.0}]
    race = [{"problem": "P", "threads": 1, "solver": solver, "s to 1.01": 1.0, "final cost": 5.0, "iterations": 10,
             "inner": 50, "peak MiB": 20} for solver in ("vesta", "Ceres CGNR")]
    loss = [{"operation": "value", "ms_1": 2.0, "ms_2": 1.0, "ratio": 2.0}]
    kernels = [{"workload": "w", "threads": 1, "pass": "forward", "ms": 1.0, "% of floor": 50.0, "pairs": 7}]
    target = {"name": "t", "value": 4.0, "met": True}

    def set_figure(name, value, row=0):
        return lambda report: report["rows"][row].__setitem__(name, value)

    def set_target(**figures):
        return lambda report: report["targets"][0].update(figures)

    for bench, rows, change, words in [
            ("toy_vs_ceres", toy, lambda report: None, ""),
            ("toy_vs_ceres", toy, set_figure("iterations, vesta", 101), ""),  # within the tolerance
            ("toy_vs_ceres", toy, set_figure("iterations, vesta", 103), "iterations, vesta was 100, is 103"),
            ("toy_vs_ceres", toy, set_figure("iterations, vesta", 50), ""),  # better
            ("toy_vs_ceres", toy, set_figure("digits, vesta", 9.0), "digits, vesta was 10.0, is 9.0"),
            ("toy_vs_ceres", toy, set_figure("digits, vesta", None), "is None"),
            ("toy_vs_ceres", toy, set_figure("digits, Ceres", 1.0), ""),  # not a figure of vesta
            ("toy_vs_ceres", toy, lambda report: report["rows"].clear(), "the row is missing"),
            ("toy_vs_ceres", toy, lambda report: report["rows"][0].pop("digits, vesta"), "digits, vesta is missing"),
            ("toy_vs_ceres", toy, lambda report: report.update(bench="kernels"), "compared with a baseline of"),
            ("solver_vs_ceres", race, set_figure("s to 1.01", 9.0), ""),  # seconds are only shown
            ("solver_vs_ceres", race, set_figure("inner", 60), "inner was 50, is 60"),
            ("solver_vs_ceres", race, set_figure("inner", 60, row=1), ""),  # a row of Ceres
            ("image_loss", loss, set_figure("ratio", 1.5), ""),
            ("image_loss", loss, set_figure("ratio", 1.3), "ratio was 2.0, is 1.3"),
            ("kernels", kernels, set_figure("% of floor", 30.0), "% of floor was 50.0"),
            ("kernels", kernels, set_figure("pairs", 6), "any change is a failure"),
            ("unknown", loss, set_figure("ratio", 0.1), "")]:
        expect(faults_after(bench, rows, change), words)
    for bench, change, words in [("unknown", set_target(value=3.0), ""),
                                 ("unknown", set_target(value=3.0, met=False), "was met with 4.0"),
                                 ("unknown", lambda report: report["targets"].clear(), "missing"),
                                 ("solver_vs_ceres", set_target(value=2.0), "was 4.0, is 2.0")]:
        expect(faults_after(bench, [], change, [target]), words)

    baselines = sorted((Path(__file__).parent / "baselines").glob("*.json"))
    assert baselines
    for path in baselines:
        baseline = json.loads(path.read_text())
        rule = RULES[baseline["bench"]]
        assert baseline["command"] and "dirty" not in baseline["commit"], path
        for row in baseline["rows"]:
            for name in [*rule.get("key", []), *rule.get("counted", {}), *rule.get("of times", {})]:
                assert name in row, f"{path}: a row has no {name}"
        lines, faults = compare(baseline, baseline, 0, 0)
        assert len(lines) > 1 and not faults, (path, faults)
    print(f"compare.py reports the planted faults; {len(baselines)} baselines are complete")
    return 0


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("baseline", type=Path, nargs="?")
    parser.add_argument("new", type=Path, nargs="?")
    parser.add_argument("--tolerance", type=float, default=0.02)
    parser.add_argument("--time_tolerance", type=float, default=0.3)
    parser.add_argument("--self_test", action="store_true")
    options = parser.parse_args()
    if options.self_test:
        return self_test()
    if options.new is None:
        parser.error("BASELINE and NEW are required")
    return run(options.baseline, options.new, options.tolerance, options.time_tolerance)


if __name__ == "__main__":
    sys.exit(main())

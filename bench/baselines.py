#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs the benchmarks of bench/baselines with the baselines' flags.

  bench/baselines.py BUILD_DIR OUT_DIR [--only NAME ...]

Writes OUT_DIR/NAME.json for each: the benchmark's JSON and the command line. To compare:

  bench/compare.py bench/baselines OUT_DIR

Each takes under three minutes on two cores. Run nothing else on the machine meanwhile. Update the baselines for a
release, or after a change that should move a figure: run this from a clean checkout with OUT_DIR bench/baselines, then
bench/tables.py bench/baselines --write.
"""
import argparse
import datetime
import json
import subprocess
import sys
from pathlib import Path

# Baseline name: program in BUILD_DIR/bench, and its flags.
RUNS = {
    "toy_vs_ceres": ["toy_vs_ceres"],
    "image_loss": ["image_loss"],
    "kernels": ["kernels", "--threads", "1,2"],
    "matrix_free_at_scale": ["matrix_free_at_scale"],
    "solver_vs_ceres": ["solver_vs_ceres", "--generated", "50x5000x8", "--threads", "1", "--repeats", "3", "--seconds",
                        "30"],
}


def run(build, name, out):
    program, *flags = RUNS[name]
    path = out / f"{name}.json"
    subprocess.run([build / "bench" / program, *flags, "--json", path], check=True, stdout=subprocess.DEVNULL,
                   stderr=subprocess.DEVNULL)
    report = json.loads(path.read_text())
    # Command and date come before the long list of rows.
    head = {"bench": report.pop("bench"), "command": " ".join([f"bench/{program}", *flags]),
            "machine": report.pop("machine"), "commit": report.pop("commit"),
            "date": datetime.date.today().isoformat()}
    report = {**head, **report}
    path.write_text(json.dumps(report, indent=1) + "\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", type=Path, help="build folder, such as build/release")
    parser.add_argument("out", type=Path)
    parser.add_argument("--only", nargs="*", choices=list(RUNS), default=list(RUNS))
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    for name in options.only:
        print(f"{name} ...", flush=True)
        run(options.build.resolve(), name, options.out)


if __name__ == "__main__":
    sys.exit(main())

# SPDX-License-Identifier: Apache-2.0
"""What the benchmarks written in Python have in common with those of bench/report.h: targets printed, JSON written."""
import functools
import json
import os
import platform
import subprocess
from pathlib import Path


def text(value):
    return "-" if value is None else value if isinstance(value, str) else f"{value:.4g}" if value < 1 else f"{value:.2f}"


def print_targets(targets):
    for target in targets:
        print(f"target {target['name']}: {text(target['value'])} (goal {target['goal']}) "
              f"{'met' if target['met'] else 'MISSED'}")


def split_at_dashes(words):
    """What stands before the first "--", and after it."""
    at = words.index("--") if "--" in words else len(words)
    return words[:at], words[at + 1:]


@functools.cache
def commit():
    """That of the sources, "unknown" without git."""
    return subprocess.run(["git", "rev-parse", "--short", "HEAD"], capture_output=True, text=True,
                          cwd=Path(__file__).parent).stdout.strip() or "unknown"


def machine():
    """The processor and its number of cores."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        lines = []
    models = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return f"{next(iter(models), platform.processor() or platform.machine())}, {os.cpu_count()} cores"


def write_json(path, bench, rows, targets):
    """{"bench", "machine", "commit", "rows", "targets"}, whole or not at all."""
    temporary = path.with_name(path.name + ".tmp")
    temporary.write_text(json.dumps({"bench": bench, "machine": machine(), "commit": commit(), "rows": rows,
                                     "targets": targets}, indent=2) + "\n")
    temporary.replace(path)

# SPDX-License-Identifier: Apache-2.0
"""Output of Python benchmarks in the format of bench/report.h: prints targets and writes JSON."""
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
    """Returns the words before the first "--", and the words after it."""
    at = words.index("--") if "--" in words else len(words)
    return words[:at], words[at + 1:]


@functools.cache
def commit():
    """The commit of the sources; "unknown" without git."""
    return subprocess.run(["git", "rev-parse", "--short", "HEAD"], capture_output=True, text=True,
                          cwd=Path(__file__).parent).stdout.strip() or "unknown"


def machine():
    """Model of the processor and number of cores."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        lines = []
    models = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return f"{next(iter(models), platform.processor() or platform.machine())}, {os.cpu_count()} cores"


def write_json(path, bench, rows, targets):
    """Writes {"bench", "machine", "commit", "rows", "targets"} atomically."""
    temporary = path.with_name(path.name + ".tmp")
    temporary.write_text(json.dumps({"bench": bench, "machine": machine(), "commit": commit(), "rows": rows,
                                     "targets": targets}, indent=2) + "\n")
    temporary.replace(path)

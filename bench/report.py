"""What the benchmarks written in Python have in common with those of bench/report.h: targets printed, JSON written."""
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


def write_json(path, bench, rows, targets):
    """{"bench", "machine", "commit", "rows", "targets"}, whole or not at all."""
    commit = subprocess.run(["git", "rev-parse", "--short", "HEAD"], capture_output=True, text=True,
                            cwd=Path(__file__).parent).stdout.strip() or "unknown"
    machine = f"{platform.processor() or platform.machine()}, {os.cpu_count()} cores"
    temporary = path.with_name(path.name + ".tmp")
    temporary.write_text(json.dumps({"bench": bench, "machine": machine, "commit": commit, "rows": rows,
                                     "targets": targets}, indent=2) + "\n")
    temporary.replace(path)

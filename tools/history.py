# SPDX-License-Identifier: Apache-2.0
"""Reads a training's history from the metrics.json of `vesta train` or `vesta refine`."""
import json
import sys

STAGES = ("adam", "lm")
NAMES = {"adam": "Adam", "lm": "LM"}
_FIELDS = ("stage", "iteration", "seconds", "cost", "train_psnr", "test_psnr", "test_ssim", "gaussians")


def load(path):
    """Rows of the file's history, in order. Exits with a one-line message if the file has no history."""
    try:
        with open(path, encoding="utf-8") as file:
            rows = json.load(file)["history"]
        if rows and all(field in row for row in rows for field in _FIELDS) and {r["stage"] for r in rows} <= set(STAGES):
            return rows
    except OSError as error:
        sys.exit(f"{path}: {error.strerror}")
    except (ValueError, KeyError, TypeError):
        pass
    sys.exit(f"{path}: not a metrics.json with a history; give the one that `vesta train` wrote")


def stage_rows(rows, stage):
    """The rows of one stage; empty if the run had no such stage."""
    return [row for row in rows if row["stage"] == stage]

#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Prints the final figures of each stage of a training: history_table.py DIR/metrics.json"""
import sys

import history

_HEADER = f"{'stage':<6}{'iterations':>11}{'seconds':>9}{'test PSNR':>11}{'test SSIM':>11}{'train PSNR':>12}{'Gaussians':>11}"


def _figure(value, width, digits):
    return f"{'-':>{width}}" if value is None else f"{value:>{width}.{digits}f}"


def table(rows):
    """Lines of text: a heading, then the last row of each stage. Seconds start at the begin of the run."""
    lines = [_HEADER]
    for stage in history.STAGES:
        for row in history.stage_rows(rows, stage)[-1:]:
            lines.append(
                f"{history.NAMES[stage]:<6}{row['iteration']:>11}{row['seconds']:>9.1f}"
                f"{_figure(row['test_psnr'], 11, 2)}{_figure(row['test_ssim'], 11, 4)}"
                f"{_figure(row['train_psnr'], 12, 2)}{row['gaussians']:>11}")
    return lines


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit("usage: history_table.py METRICS_JSON")
    print("\n".join(table(history.load(sys.argv[1]))))

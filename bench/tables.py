#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes the tables of docs/benchmarks.md from the figures in bench/baselines.

  bench/tables.py bench/baselines           prints the tables
  bench/tables.py bench/baselines --write   writes them between their markers in docs/benchmarks.md
  bench/tables.py bench/baselines --check   fails if a table in docs/benchmarks.md differs from its baseline
  bench/tables.py --self_test               changes a figure and checks that --check reports it

The lines <!-- table NAME --> and <!-- end of table --> mark a table; NAME is one of TABLES.
"""
import argparse
import json
import re
import sys
from pathlib import Path

import report

PAGE = Path(__file__).parent.parent / "docs/benchmarks.md"
MARKERS = re.compile(r"(<!-- table (\S+) -->\n).*?(<!-- end of table -->)", re.DOTALL)
ENOUGH_DIGITS = 4  # correct digits that count as solved, as in Ceres's own example

GROUPS = {"NIST, both starts": ("start 1", "start 2"), "More, Garbow, Hillstrom, standard start": ("1x",),
          "from 10 times the start": ("10x",), "from 100 times the start": ("100x",),
          "within bounds, standard start": ("1x, bounds",)}


def columns(names):
    """Returns a function that selects these columns of a baseline's rows: {"name in the file": "heading"}."""
    def table(rows):
        return list(names.values()), [[row[name] for name in names] for row in rows]
    return table


def solved(rows):
    """Counts the problems that each solver solved, by group."""
    def count(starts, solver):
        return sum(row[f"digits, {solver}"] >= ENOUGH_DIGITS for row in rows if row["start"] in starts)
    return ["problems", "solved by vesta", "by Ceres", "of"], [
        [name, str(count(starts, "vesta")), str(count(starts, "Ceres")),
         str(sum(row["start"] in starts for row in rows))] for name, starts in GROUPS.items()]


# Table name: the baseline, and the function from its rows to headings and cells.
TABLES = {
    "generated_bundle": ("solver_vs_ceres", columns({
        "solver": "solver", "s to 1.01": "s to 1.01", "s to 1.001": "s to 1.001", "s to 1.00001": "s to 1.00001",
        "iterations": "iterations", "inner": "inner iterations", "peak MiB": "peak MiB"})),
    "small_problems": ("toy_vs_ceres", solved),
    "matrix_free": ("matrix_free_at_scale", columns({
        "stored J, GiB": "stored J would take, GiB", "peak memory, GiB": "peak memory, GiB",
        "LM iterations": "LM iterations", "PCG iterations": "PCG iterations",
        "largest relative error": "largest relative error"})),
    "image_loss": ("image_loss", columns({
        "operation": "operation", "ms_1": "ms, 1 thread", "ms_2": "ms, 2 threads", "ratio": "speed-up"})),
}


def cell(value):
    if isinstance(value, float):
        return f"{value:.0f}" if value.is_integer() else f"{value:.3g}"
    return report.text(value)


def markdown(name, baselines):
    baseline, table = TABLES[name]
    data = json.loads((baselines / f"{baseline}.json").read_text())
    headings, rows = table(data["rows"])
    lines = [headings, ["---"] * len(headings), *([cell(value) for value in row] for row in rows)]
    return (f"`build/release/{data['command']}`\\\n{data['machine']}; commit {data['commit']}, {data['date']}\n\n" +
            "".join(f"| {' | '.join(line)} |\n" for line in lines))


def with_tables(page, baselines):
    return MARKERS.sub(lambda match: match[1] + markdown(match[2], baselines) + match[3], page)


def faults_of(page, baselines):
    names = [match[2] for match in MARKERS.finditer(page)]
    if sorted(names) != sorted(TABLES):
        return [f"the page has the tables {names}, TABLES has {list(TABLES)}"]
    pairs = zip(MARKERS.finditer(page), MARKERS.finditer(with_tables(page, baselines)))
    return [f"table {old[2]} differs from its baseline: run bench/tables.py bench/baselines --write"
            for old, new in pairs if old[0] != new[0]]


def self_test(baselines):
    page = with_tables(PAGE.read_text(), baselines)
    assert not faults_of(page, baselines)
    for name in TABLES:
        start = page.index(f"<!-- table {name} -->")
        digit = re.compile(r"\d").search(page, page.index("---", start + 20))
        changed = page[:digit.start()] + str(9 - int(digit[0])) + page[digit.end():]
        assert len(faults_of(changed, baselines)) == 1, name
    assert faults_of(page.replace("<!-- table image_loss -->", ""), baselines)
    print(f"tables.py reports a changed figure in each of {len(TABLES)} tables")
    return 0


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("baselines", type=Path, nargs="?", default=Path(__file__).parent / "baselines")
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--check", action="store_true")
    parser.add_argument("--self_test", action="store_true")
    options = parser.parse_args()
    if options.self_test:
        return self_test(options.baselines)
    if options.write:
        PAGE.write_text(with_tables(PAGE.read_text(), options.baselines))
    elif options.check:
        faults = faults_of(PAGE.read_text(), options.baselines)
        print("\n".join(faults) or f"docs/benchmarks.md has the figures of {options.baselines}")
        return 1 if faults else 0
    else:
        print("\n".join(markdown(name, options.baselines) for name in TABLES))
    return 0


if __name__ == "__main__":
    sys.exit(main())

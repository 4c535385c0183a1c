#!/usr/bin/env python3
"""The JSON that a benchmark wrote, as Markdown: its rows as a table, its targets as another.

  bench/markdown.py FILE.json [--columns a,b,c] [--where column=value]...
"""
import argparse
import json


def text(value):
    if value is None:
        return "-"
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def table(names, rows):
    lines = ["| " + " | ".join(names) + " |", "|" + "---|" * len(names)]
    lines += ["| " + " | ".join(text(row.get(name)) for name in names) + " |" for row in rows]
    return "\n".join(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file")
    parser.add_argument("--columns")
    parser.add_argument("--where", action="append", default=[])
    arguments = parser.parse_args()
    with open(arguments.file) as file:
        report = json.load(file)
    rows = report["rows"]
    for condition in arguments.where:
        column, _, value = condition.partition("=")
        rows = [row for row in rows if text(row.get(column)) == value]
    names = arguments.columns.split(",") if arguments.columns else list(report["rows"][0])
    print(f"{report['bench']}: {report['machine']}, commit {report['commit']}\n")
    print(table(names, rows))
    if report["targets"]:
        print()
        print(table(["name", "value", "unit", "goal", "met"], report["targets"]))


if __name__ == "__main__":
    main()

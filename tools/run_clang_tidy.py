#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs clang-tidy on the sources that changed since a base commit, newest changes first, within a time box.

  tools/run_clang_tidy.py BUILD_DIR [--base COMMIT] [--seconds N] [--jobs N]

Without a base (or where it is the commit checked out) all sources are checked. BUILD_DIR is configured to compile each
by itself. A changed header is checked through the source of its name, or the one that BUILD_DIR/tests/headers compiles
for it. Files not reached in time are named as such and do not fail.
"""
import argparse
import concurrent.futures
import json
import os
import pathlib
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent


def git(*args):
    done = subprocess.run(["git", "-C", str(ROOT), *args], capture_output=True, text=True)
    return done.stdout.split("\n")[:-1] if done.returncode == 0 else []


def changed_since(base):
    """Paths from ROOT of files that changed since they left `base` and are there still; None: there is no such base, or
    it is the commit checked out."""
    merge_base = git("merge-base", "HEAD", base) if base else []
    if not merge_base or merge_base == git("rev-parse", "HEAD"):
        return None
    return git("diff", "--name-only", "--diff-filter=d", merge_base[0])


def names_to_check(base):
    """Paths from ROOT in the order of their last change, newest first, and what they are."""
    changed = changed_since(base)
    if changed is not None:
        return changed, f"files changed since {base}"
    by_date = git("log", "--name-only", "--format=")
    return list(dict.fromkeys(name for name in by_date if name)), "all files, newest first"


def commands_by_file(build_dir):
    """Path -> one compile command: files compiled once per instruction set are checked for the first."""
    commands = {}
    for entry in json.loads((build_dir / "compile_commands.json").read_text()):
        commands.setdefault(pathlib.Path(entry["file"]), entry)
    return commands


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("build_dir", type=pathlib.Path)
    parser.add_argument("--base", help="commit or branch to compare with")
    parser.add_argument("--seconds", type=float, default=420, help="time box")
    parser.add_argument("--jobs", type=int, default=len(os.sched_getaffinity(0)))
    args = parser.parse_args()
    deadline = time.monotonic() + args.seconds
    build_dir = args.build_dir.resolve()

    commands = commands_by_file(build_dir)
    names, what = names_to_check(args.base)
    through = []
    for name in names:
        if name.endswith(".cpp"):
            through.append(ROOT / name)
        elif name.endswith(".h"):
            by_itself = build_dir / "tests/headers" / (name + ".cpp")
            through.append(by_itself if by_itself in commands else (ROOT / name).with_suffix(".cpp"))
    files = [file for file in dict.fromkeys(through) if file in commands]
    print(f"clang-tidy: {len(files)} sources ({what}), at most {args.seconds:.0f} s", flush=True)

    database = build_dir / "tidy"
    database.mkdir(exist_ok=True)
    (database / "compile_commands.json").write_text(json.dumps(list(commands.values())))

    def check(file):
        left = deadline - time.monotonic()
        if left <= 0:
            return None
        try:
            return subprocess.run(["clang-tidy", "--quiet", "-p", str(database), str(file)], timeout=left,
                                  capture_output=True, text=True)
        except subprocess.TimeoutExpired:
            return None

    cut, faulty = 0, 0
    with concurrent.futures.ThreadPoolExecutor(args.jobs) as pool:
        for done in pool.map(check, files):
            if done is None:
                cut += 1
            elif done.returncode != 0:
                faulty += 1
                print(done.stdout, done.stderr, sep="\n", flush=True)
    print(f"clang-tidy: {len(files) - cut} checked, {faulty} with findings, {cut} not reached within the time box")
    return 1 if faulty or (files and cut == len(files)) else 0


if __name__ == "__main__":
    sys.exit(main())

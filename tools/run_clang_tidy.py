#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs clang-tidy on sources that changed since a base commit, newest first, within a time limit.

  tools/run_clang_tidy.py BUILD_DIR [--base COMMIT] [--seconds N] [--jobs N]

Without a base, or if it is the current commit, all sources are checked. BUILD_DIR must be configured without unity build.
A changed header is checked through the source that BUILD_DIR/tests/headers has for it, or else the source of the same
name. Files not reached in time are counted in the summary and are not failures, unless no file was reached.
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
    """Paths relative to ROOT of existing files that changed since the merge base with `base`; None if there is no such
    base, or if it is the current commit."""
    merge_base = git("merge-base", "HEAD", base) if base else []
    if not merge_base or merge_base == git("rev-parse", "HEAD"):
        return None
    return git("diff", "--name-only", "--diff-filter=d", merge_base[0])


def names_to_check(base):
    """Returns paths relative to ROOT, and a description of them. All files are sorted by last change, newest first."""
    changed = changed_since(base)
    if changed is not None:
        return changed, f"files changed since {base}"
    by_date = git("log", "--name-only", "--format=")
    return list(dict.fromkeys(name for name in by_date if name)), "all files, newest first"


def commands_by_file(build_dir):
    """Maps each path to one compile command. Files compiled once per instruction set are checked for the first one."""
    commands = {}
    for entry in json.loads((build_dir / "compile_commands.json").read_text()):
        commands.setdefault(pathlib.Path(entry["file"]), entry)
    return commands


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("build_dir", type=pathlib.Path)
    parser.add_argument("--base", help="commit or branch to compare with")
    parser.add_argument("--seconds", type=float, default=420, help="time limit")
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
    print(f"clang-tidy: {len(files) - cut} checked, {faulty} with findings, {cut} not reached within the time limit")
    return 1 if faulty or (files and cut == len(files)) else 0


if __name__ == "__main__":
    sys.exit(main())

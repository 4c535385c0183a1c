#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Prints ptxas's report on every kernel of a CUDA build: registers, stack, spills, shared memory.

  tools/cuda_resources.py BUILD_DIR [--markdown] [--by_architecture]

Compiles each .cu of kernels, solver and problems again with the options of the build, for each of its architectures, and
discards the output. Fails if a kernel spills registers.
"""
import argparse
import json
import pathlib
import re
import shlex
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent

def compile_verbosely(entry):
    words = shlex.split(entry["command"])
    words = words[words.index(next(w for w in words if w.endswith("nvcc"))):]
    kept, skip = [], False
    for word in words:
        if skip:
            skip = False
        elif word in ("-o", "-MF", "-MT"):
            skip = True
        elif word not in ("-MD", "-MMD"):
            kept.append(word)
    return subprocess.run([*kept, "-Xptxas", "-v", "-o", "/dev/null"], capture_output=True, text=True,
                          cwd=entry["directory"])


def kernels_in(log):
    name, frame = None, (0, 0)
    for line in log.splitlines():
        if match := re.search(r"Compiling entry function '(\S+)' for '(\S+)'", line):
            name = match.groups()
        elif match := re.search(r"(\d+) bytes stack frame, (\d+) bytes spill stores", line):
            frame = tuple(map(int, match.groups()))
        elif (match := re.search(r"Used (\d+) registers", line)) and name:
            shared = re.search(r"(\d+) bytes smem", line)
            yield {"name": name[0], "arch": name[1], "registers": int(match.group(1)), "stack": frame[0],
                   "spills": frame[1], "shared": int(shared.group(1)) if shared else 0}
            name = None


def readable(names):
    done = subprocess.run(["c++filt"], input="\n".join(names), capture_output=True, text=True, check=True)
    for name in done.stdout.splitlines():
        name = re.sub(r"vesta::|baseline::|device::|splat::|device_passes::|device_updates::|device_density::|gs::|\(anonymous namespace\)::", "", name)
        # A launcher has the name of its kernel.
        match = re.match(r"void (?:RunBlockKernel|RunForEach)<(.*)>\(", name)
        yield match.group(1).strip() if match else name


def print_all(rows, markdown):
    form = "| {file} | {name} | {registers} | {stack} | {spills} | {shared} |" if markdown else \
        "{registers:4} registers {stack:5} stack {spills:4} spilled {shared:6} shared  {name}"
    for row in sorted(rows, key=lambda row: (row["file"], row["name"])):
        print(form.format(**{**row, "name": row["name"].replace("|", "\\|")}))


def print_worst(rows):
    print("| architecture | kernels | most registers | of | stack, most bytes | kernels that spill | bytes spilled |")
    print("|---|---|---|---|---|---|---|")
    for arch in sorted({row["arch"] for row in rows}, key=lambda arch: int(re.sub(r"\D", "", arch))):
        here = [row for row in rows if row["arch"] == arch]
        worst = max(here, key=lambda row: row["registers"])
        print("| {} | {} | {} | {} | {} | {} | {} |".format(
            arch, len(here), worst["registers"], worst["name"].replace("|", "\\|"), max(row["stack"] for row in here),
            sum(row["spills"] > 0 for row in here), sum(row["spills"] for row in here)))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("build_dir", type=pathlib.Path)
    parser.add_argument("--markdown", action="store_true")
    parser.add_argument("--by_architecture", action="store_true", help="print one line per architecture with its maxima")
    args = parser.parse_args()
    rows = []
    for entry in json.loads((args.build_dir / "compile_commands.json").read_text()):
        file = pathlib.Path(entry["file"])
        ours = file.suffix == ".cu" and file.relative_to(ROOT).parts[0] in ("kernels", "solver", "problems")
        # Tests compile some of these files for the host.
        if not ours or "nvcc" not in entry["command"]:
            continue
        done = compile_verbosely(entry)
        if done.returncode != 0:
            print(done.stderr)
            return 1
        found = list(kernels_in(done.stdout + done.stderr))
        for row, name in zip(found, readable([row["name"] for row in found])):
            rows.append({**row, "file": file.relative_to(ROOT).as_posix(), "name": name})
    if args.by_architecture:
        print_worst(rows)
    else:
        print_all(rows, args.markdown)
    spilling = [f"{row['name']} ({row['arch']})" for row in rows if row["spills"] > 0]
    print(f"\n{len(rows)} kernels, {len(spilling)} spill{': ' if spilling else ''}{', '.join(spilling)}")
    return 1 if spilling or not rows else 0


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks that objects compiled for AVX2 or AVX-512 export no weak function that other code could link to.

The linker keeps one copy of a weak function, that of the first object. If this copy was compiled for AVX-512 and the
baseline path calls it, the program dies with SIGILL on other machines. A function is safe if its name can occur only in
objects of one instruction set: it is in the inline namespace of that set, or its name contains a type from there. Weak
data (nm's V and u: tables, type information) contains no instructions and may be shared.

  tools/check_isa_symbols.py BUILD_DIR               all objects of the targets *_avx2 and *_avx512 under BUILD_DIR
  tools/check_isa_symbols.py --isa avx2 OBJECT...    these objects
"""
import argparse
import pathlib
import re
import subprocess
import sys

# Instruction set: its names, from its inline namespace and xsimd's architecture types. An AVX-512 object must not
# instantiate xsimd for AVX2: the name would collide with the AVX2 object's.
OWN = {
    "avx2": re.compile(r"\bvesta::(\w+::)*avx2::|\bxsimd::(avx2|fma3<xsimd::avx2>)"),
    "avx512": re.compile(r"\bvesta::(\w+::)*avx512::|\bxsimd::avx512(bw|dq|cd|f)\b"),
}


def unsafe_functions(nm, isa, file):
    listing = subprocess.run([nm, "--demangle", "--defined-only", str(file)], check=True, capture_output=True, text=True)
    for line in listing.stdout.splitlines():
        kind, name = line[17:].split(" ", 1)
        if kind == "W" and not OWN[isa].search(name):
            yield name


def objects_under(build_dir):
    for isa in OWN:
        for folder in sorted(build_dir.rglob(f"CMakeFiles/*_{isa}.dir")):
            for file in sorted(folder.rglob("*.o")):
                yield isa, file


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--nm", default="nm", help="the nm program")
    parser.add_argument("--isa", choices=sorted(OWN), help="instruction set of the objects named")
    parser.add_argument("--expect", help="succeed when this symbol is the only fault (the script's own test)")
    parser.add_argument("paths", nargs="+", type=pathlib.Path, help="build folder, or objects with --isa")
    args = parser.parse_args()

    if args.isa:
        objects = [(args.isa, path) for path in args.paths]
    else:
        objects = [found for path in args.paths for found in objects_under(path)]
    if not objects:
        print("check_isa_symbols: no object of a target *_avx2 or *_avx512 found; build first")
        return 1
    faults = []
    for isa, file in objects:
        for name in unsafe_functions(args.nm, isa, file):
            print(f"{file}: weak function outside vesta::{isa}: {name}")
            faults.append(name)
    if args.expect:
        return 0 if faults == [args.expect] else 1
    if faults:
        print("Give it internal linkage (static, an unnamed namespace), move it into the inline namespace VESTA_ISA, "
              "or let it take a type of that namespace as an argument.")
        return 1
    print(f"isa symbols: {len(objects)} objects, no weak function outside their instruction set")
    return 0


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Compiles each header by itself that changed since a base commit, or includes one that did, however indirectly.

  tools/check_headers.py BUILD_DIR [--base COMMIT]

Whether a header leans on what its user happened to include before depends on nothing else. Without a base, where it is
the commit checked out, and where how headers are compiled has changed, all are compiled. BUILD_DIR is configured, by
Ninja (cmake/HeaderTests.cmake).
"""
import argparse
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
HOW = re.compile(r"CMakeLists\.txt|CMakePresets\.json|cmake/.*|tests/headers/.*|tools/(check_headers|run_clang_tidy)\.py")
INCLUDE = re.compile(r'^#include "([^"]+)"', re.MULTILINE)

sys.path.insert(0, str(ROOT / "tools"))
from run_clang_tidy import changed_since  # noqa: E402


def leans_on(changed, name, known):
    """Whether `name` is in `changed` or includes what is; known: the answers so far."""
    if name not in known:
        known[name] = name in changed
        path = ROOT / name
        if not known[name] and path.exists():
            known[name] = any(leans_on(changed, included, known) for included in INCLUDE.findall(path.read_text()))
    return known[name]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("build_dir", type=pathlib.Path)
    parser.add_argument("--base", help="commit or branch to compare with")
    args = parser.parse_args()
    sources = args.build_dir / "tests/headers"
    names = sorted(str(path.relative_to(sources))[:-len(".cpp")] for path in sources.rglob("*.h.cpp"))
    names = [name for name in names if (ROOT / name).exists()]  # what was configured before may be there still
    changed = changed_since(args.base)
    what = "all"
    if changed is not None and not any(HOW.fullmatch(name) for name in changed):
        known = {}
        names, what = [name for name in names if leans_on(set(changed), name, known)], "of what changed"
    print(f"headers: {len(names)} to compile, {what}", flush=True)
    objects = [f"tests/headers/CMakeFiles/header_tests.dir/{name}.cpp.o" for name in names]
    if not objects:
        return 0
    return subprocess.run(["ninja", "-C", str(args.build_dir), "-k", "0", *objects], check=False).returncode


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Compiles each header that changed since a base commit, or includes a changed one, even indirectly.

  tools/check_headers.py BUILD_DIR [--base COMMIT]

This finds headers that rely on includes of their users. Compiles all headers without a base, if it is the current
commit, or if the rules for compiling headers changed. BUILD_DIR must be configured with Ninja
(cmake/HeaderTests.cmake).
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
    """True if `name` is in `changed` or includes such a file, even indirectly; known: cache of the answers."""
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
    names = [name for name in names if (ROOT / name).exists()]  # the folder may contain sources of deleted headers
    changed = changed_since(args.base)
    what = "all"
    if changed is not None and not any(HOW.fullmatch(name) for name in changed):
        known = {}
        names, what = [name for name in names if leans_on(set(changed), name, known)], "affected by changes"
    print(f"headers: {len(names)} to compile, {what}", flush=True)
    objects = [f"tests/headers/CMakeFiles/header_tests.dir/{name}.cpp.o" for name in names]
    if not objects:
        return 0
    return subprocess.run(["ninja", "-C", str(args.build_dir), "-k", "0", *objects], check=False).returncode


if __name__ == "__main__":
    sys.exit(main())

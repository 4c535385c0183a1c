#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Fails if GPU code duplicates host code, which should then be one template over the backend.

A file device_X in kernels, solver, problems or splatting is compared with its twin X: the file X in the same folder or,
if device_X is in a folder named device, in a sibling of that folder. Headers are compared with headers, sources with
sources. The comparison ignores comments, includes, template heads, namespaces, lines without a letter, and the words in
which memory spaces and scalar types differ. The shorter file may have at most the fraction LIMIT of its lines in common
with the other.

  check_twins.py              prints a table of all twins; status 1 if one exceeds the limit
  check_twins.py --self_test  checks that planted twins are found, and different files are not
"""
import argparse
import collections
import pathlib
import re
import sys

ROOMS = ("kernels", "solver", "problems", "splatting")
HEADERS, SOURCES = (".h", ".cuh"), (".cpp", ".inl", ".cu")
LIMIT = 0.30
# Intentional duplicates: classes with the members of their host twins, so that a template over the backend accepts
# either. The limit still applies to their source files.
SAME_MEMBERS = {
    "kernels/core/device_buffer.h",
    "kernels/gaussian_splatting/device/device_splat_view.h",
    "kernels/image/device_photometric_loss.h",
    "kernels/image/device_photometric_loss.h",
    "problems/gaussian_splatting/model/device_splat_backend.h",
}

DROPPED_LINES = re.compile(r"#|(inline )?namespace\b|template\b|using namespace\b|extern template\b")
DROPPED_WORDS = re.compile(r"[Dd]evice_|_?device\b|Device|Host|Cuda|Cpu|<\s*(S|T|B|float|double|Backend)\s*>|\bB::|\bS\b|\bfloat\b")


def lines_of(text):
    """The lines of a source without everything that the comparison ignores."""
    text = re.sub(r"/\*.*?\*/", "", text, flags=re.S)
    text = re.sub(r"//[^\n]*", "", text)
    text = re.sub(r"template\s*<[^;{}()]*?>\s*\n", "\n", text)
    result = []
    for line in text.splitlines():
        line = line.strip()
        if DROPPED_LINES.match(line):
            continue
        line = re.sub(r"\s+", "", DROPPED_WORDS.sub("", line))
        if re.search(r"[A-Za-z]", line):
            result.append(line)
    return result


def share(a, b):
    """Fraction of the lines of the shorter text that are in the other; each line of the other matches once."""
    a, b = collections.Counter(lines_of(a)), collections.Counter(lines_of(b))
    shorter = min(sum(a.values()), sum(b.values()))
    return sum((a & b).values()) / shorter if shorter else 0.0


def twins(root):
    """Yields pairs of paths: GPU code and host code."""
    for room in ROOMS:
        for device in sorted((root / room).rglob("device_*")):
            for kinds in (HEADERS, SOURCES):
                if device.suffix in kinds:
                    stem = device.stem.removeprefix("device_")
                    folders = device.parent.parent.iterdir() if device.parent.name == "device" else [device.parent]
                    for host in (folder / (stem + suffix) for folder in sorted(folders) for suffix in kinds):
                        if host.is_file():
                            yield device, host


def check(root, out):
    """Prints the table to out; returns the names of the files over the limit."""
    over = []
    for device, host in twins(root):
        found = share(device.read_text(), host.read_text())
        name = device.relative_to(root).as_posix()
        allowed = name in SAME_MEMBERS
        print(f"{100 * found:4.0f} %  {name} in {host.name}{' (the same members)' if allowed else ''}", file=out)
        if found > LIMIT and not allowed:
            over.append(name)
    return over


def self_test():
    import io
    import tempfile

    host = """#include <a.h>
namespace vesta {
template <class S>
void Scale(const HostBuffer<S>& x, double scale) {
  // Of the host.
  for (Index i = 0; i < x.size(); ++i) Visit(x[i], scale);
  Finish(scale);
}
}  // namespace vesta
"""
    same = host.replace("template <class S>\n", "").replace("HostBuffer<S>", "DeviceBuffer<float>").replace("Of the host", "Here")
    other = "void Launch(Index count) {\n  Check(count);\n  Run(Blocks(count));\n  Finish(scale);\n}\n"
    assert share(host, same) == 1.0, share(host, same)
    assert share(host, other) == 1 / 3, share(host, other)  # one of the three lines of the shorter text
    with tempfile.TemporaryDirectory() as folder:
        root = pathlib.Path(folder)
        room = root / "problems" / "made_up"
        room.mkdir(parents=True)
        (room / "scale.inl").write_text(host)
        (room / "device_scale.cpp").write_text(same)
        (room / "device_alone.cpp").write_text(same)  # has no twin
        (room / "scale.h").write_text("void Scale();\n")
        (room / "device_scale.h").write_text("int Other();\n")
        table = io.StringIO()
        assert check(root, table) == ["problems/made_up/device_scale.cpp"], table.getvalue()
        assert len(table.getvalue().splitlines()) == 2, table.getvalue()
    print("check_twins.py: the planted twins are found")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--self_test", action="store_true")
    if parser.parse_args().self_test:
        return self_test()
    over = check(pathlib.Path(__file__).resolve().parent.parent, sys.stdout)
    for name in over:
        print(f"{name}: over {100 * LIMIT:.0f} % of it duplicates its host twin: write one template over the backend", file=sys.stderr)
    return 1 if over else 0


if __name__ == "__main__":
    sys.exit(main())

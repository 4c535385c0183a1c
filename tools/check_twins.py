#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Fails where code for a GPU repeats code for the host.

A file device_X in kernels, solver, problems or splatting has a twin X where one lies in the same folder, or where its
folder is named device in a folder beside it: header beside header, source beside source. Both are stripped of comments, includes, heads of templates, namespaces, lines without a letter,
and of the words by which memory spaces and scalars differ. Then at most a share of the lines of the shorter may stand
in the other: beyond it the text is to be one, a template over the backend.

  check_twins.py              the table of all twins; status 1 where one is over the limit
  check_twins.py --self_test  sees that planted twins are found, and strangers are not
"""
import argparse
import collections
import pathlib
import re
import sys

ROOMS = ("kernels", "solver", "problems", "splatting")
HEADERS, SOURCES = (".h", ".cuh"), (".cpp", ".inl", ".cu")
LIMIT = 0.30
# What is declared twice on purpose: each is a class whose members are those of its host twin, so that a template over
# the backend takes either. Their bodies are held to the limit like all others.
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
    """The lines of a source that say something, without what differs between memory spaces."""
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
    """The part of the shorter one's lines that stand in the other, each line of which counts once."""
    a, b = collections.Counter(lines_of(a)), collections.Counter(lines_of(b))
    shorter = min(sum(a.values()), sum(b.values()))
    return sum((a & b).values()) / shorter if shorter else 0.0


def twins(root):
    """Pairs of paths: code for a GPU, and for the host."""
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
    """Prints the table to out; returns the names of those over the limit."""
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
    assert share(host, other) == 1 / 3, share(host, other)  # one line of the shorter's three, braces apart
    with tempfile.TemporaryDirectory() as folder:
        root = pathlib.Path(folder)
        room = root / "problems" / "made_up"
        room.mkdir(parents=True)
        (room / "scale.inl").write_text(host)
        (room / "device_scale.cpp").write_text(same)
        (room / "device_alone.cpp").write_text(same)  # without a twin
        (room / "scale.h").write_text("void Scale();\n")
        (room / "device_scale.h").write_text("int Other();\n")
        table = io.StringIO()
        assert check(root, table) == ["problems/made_up/device_scale.cpp"], table.getvalue()
        assert len(table.getvalue().splitlines()) == 2, table.getvalue()
    print("check_twins.py: planted twins are found")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--self_test", action="store_true")
    if parser.parse_args().self_test:
        return self_test()
    over = check(pathlib.Path(__file__).resolve().parent.parent, sys.stdout)
    for name in over:
        print(f"{name}: over {100 * LIMIT:.0f} % of it repeats its host twin: make them one", file=sys.stderr)
    return 1 if over else 0


if __name__ == "__main__":
    sys.exit(main())

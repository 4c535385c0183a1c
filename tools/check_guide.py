#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks that the code and the report shown in the guide are the compiled code and the printed report.

  tools/check_guide.py                 code in docs/guide, and in the README where it names a file, is in that file
  tools/check_guide.py --report FILE   the report shown in docs/guide/reading_a_report.md has the same lines as the one
                                       in FILE, apart from numbers
  tools/check_guide.py --self_test     checks that planted faults are reported

A fence ```cpp, ```cmake or ```python names the file of its text: ```cpp examples/registration/registration.cpp. The file must
contain the lines consecutively; the whole block may have a different indentation. Targets of links to files must exist.
"""
import argparse
import itertools
import pathlib
import re
import sys
import tempfile
import textwrap

FENCE = re.compile(r"^```(\w*)[ \t]*(\S*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
LINK = re.compile(r"\]\((?!https?:)([^)#]+)(?:#[^)]*)?\)")
SOURCE_LANGUAGES = ("cpp", "cmake", "python")
REPORT = "docs/guide/reading_a_report.md"


def stands_in(block, text):
    wanted, lines = textwrap.dedent(block).splitlines(), text.splitlines()
    return any(textwrap.dedent("\n".join(lines[i:i + len(wanted)])).splitlines() == wanted
               for i in range(len(lines) - len(wanted) + 1))


def faults_of(root, page):
    text = (root / page).read_text(encoding="utf-8")
    for match in FENCE.finditer(text):
        language, name, block = match.groups()
        where = f"{page}:{text.count(chr(10), 0, match.start()) + 1}"
        if language not in SOURCE_LANGUAGES:
            continue
        if not name:
            if page.startswith("docs/guide"):
                yield f"{where}: the code block does not name its source file: ```{language} FILE"
        elif not (root / name).is_file():
            yield f"{where}: there is no file {name}"
        elif not stands_in(block, (root / name).read_text(encoding="utf-8")):
            yield f"{where}: {name} does not contain this text"
    for target in LINK.findall(FENCE.sub("", text)):
        if not (root / page).parent.joinpath(target).exists():
            yield f"{page}: the target of the link {target} does not exist"


def all_faults(root):
    pages = ["README.md", *sorted(p.relative_to(root).as_posix() for p in (root / "docs/guide").glob("*.md"))]
    return len(pages), [fault for page in pages for fault in faults_of(root, page)]


def skeleton(report):
    """The lines of a report from its first block to the heading of its table, with numbers replaced."""
    lines = []
    for line in report.partition("\n\n")[2].splitlines():
        lines.append(re.sub(r"[-+.\w]*\d[-+.\w]*", "#", line))
        if re.match(r" *iter +cost", line):
            break
    return [re.sub(r"\s+", " ", line).strip() for line in lines]


def compare_report(root, report):
    text = (root / REPORT).read_text(encoding="utf-8")
    shown = next((block for _, _, block in FENCE.findall(text) if block.startswith("Levenberg-Marquardt")), "")
    start = max(0, report.find("Levenberg-Marquardt"))
    for ours, theirs in itertools.zip_longest(skeleton(shown), skeleton(report[start:]), fillvalue=""):
        if ours != theirs:
            return [f"{REPORT} shows '{ours}' where the report now has '{theirs}'; show a current report"]
    return []


def self_test():
    sound = "```cpp a.cpp\nint a;\nint b;\n```\n[a](../../a.cpp)\n```sh\nls\n```\n"
    planted = {
        "not verbatim": "```cpp a.cpp\nint a;\nint c;\n```\n",
        "not contiguous": "```cpp a.cpp\nint a;\nint d;\n```\n",
        "no file": "```cpp\nint a;\n```\n",
        "missing file": "```cmake CMakeLists.txt\nproject(a)\n```\n",
        "dead link": "[b](b.md)\n",
    }
    missed = []
    with tempfile.TemporaryDirectory() as folder:
        root = pathlib.Path(folder)
        (root / "docs/guide").mkdir(parents=True)
        (root / "README.md").write_text("")
        (root / "a.cpp").write_text("void f() {\n  int a;\n  int b;\n  int d;\n}\n")
        for name, text in {"sound": sound, **planted}.items():
            (root / "docs/guide/page.md").write_text(text)
            if len(all_faults(root)[1]) != (name != "sound"):
                missed.append(name)
        report = "Levenberg-Marquardt: converged\n\ncost 1.5e+00\n\n iter cost\n 0 1\n"
        (root / REPORT).write_text(f"```\n{report}```\n")
        if compare_report(root, "noise\n" + report.replace("1.5", "27")):
            missed.append("sound report")
        if not compare_report(root, report.replace("iter cost", "iter cost change")):
            missed.append("another column")
    print(f"self-test: failed for {missed}" if missed else f"self-test: all {len(planted) + 1} planted faults reported")
    return 1 if missed else 0


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--report", type=pathlib.Path)
    parser.add_argument("--self_test", action="store_true")
    args = parser.parse_args()
    if args.self_test:
        return self_test()
    root = pathlib.Path(__file__).resolve().parent.parent
    count, faults = all_faults(root)
    if args.report:
        faults += compare_report(root, args.report.read_text(encoding="utf-8"))
    print("\n".join(faults) if faults else f"guide: {count} pages match the compiled code")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())

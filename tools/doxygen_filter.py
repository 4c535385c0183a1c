#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Doxygen's INPUT_FILTER: prints a header with its plain // comments converted to Doxygen comments.

  tools/doxygen_filter.py FILE         prints the header
  tools/doxygen_filter.py --self_test  checks a small header

A block of // lines directly above a declaration documents it, and so does a // comment after it, with the // lines
below in the same column. The block at the top of a file documents the file. Comments inside function bodies are not
converted. The number of lines stays, so that Doxygen's line numbers match.
"""
import pathlib
import re
import sys

SCOPE = re.compile(r"\b(namespace|class|struct|union|enum)\b")
COMMENT = re.compile(r'^((?:[^"/]|"(?:[^"\\]|\\.)*"|/(?!/))*?)//(?!/)(.*)$')


def escaped(text):
    """Escapes the markup of Doxygen and Markdown, except code, so that a comment is shown as written."""
    return re.sub(r"([\\@<>#&%$|*~])", r"\\\1", text)


class Scopes:
    """Counts braces to distinguish the scopes of declarations from function bodies."""

    def __init__(self):
        self.stack, self.pending = [], ""

    def declaring(self):
        return all(self.stack)

    def read(self, code):
        code = re.sub(r"\"(?:[^\"\\]|\\.)*\"|'(?:[^'\\]|\\.)'", "", code)
        for piece in re.findall(r"[{};]|[^{};]+", code):
            if piece == "{":
                head = re.sub(r"template\s*<[^{};]*?>\s*(?=class|struct|requires|union|\w)", "", self.pending)
                self.stack.append(bool(SCOPE.search(head)) and not head.rstrip().endswith(("=", ")")))
                self.pending = ""
            elif piece == "}":
                if self.stack:
                    self.stack.pop()
                self.pending = ""
            elif piece == ";":
                self.pending = ""
            else:
                self.pending += piece


def converted(lines):
    scopes, out = Scopes(), []
    column = None  # of the comment after a declaration; the next line may continue it
    i = 0
    if lines and "SPDX-License-Identifier" in lines[0]:  # the licence does not describe the file
        out.append("//")
        i = 1
    first = i
    while i < len(lines):
        match = COMMENT.match(lines[i])
        if not match:
            if not lines[i].startswith("#"):
                scopes.read(lines[i])
            out.append(lines[i])
            column, i = None, i + 1
            continue
        code, text = match.groups()
        if code.strip():  # after code
            scopes.read(code)
            documents = scopes.declaring() and code.rstrip()[-1] in ";,)" + "".join(map(chr, range(48, 123)))
            out.append(f"{code}///<{escaped(text)}" if documents else lines[i])
            column = len(code) if documents else None
            i += 1
            continue
        if column is not None and len(code) == column:  # continues the comment above
            out.append(f"{code}///<{escaped(text)}")
            i += 1
            continue
        column = None
        block = [i]
        while block[-1] + 1 < len(lines) and lines[block[-1] + 1].lstrip().startswith("//"):
            block.append(block[-1] + 1)
        following = lines[block[-1] + 1].strip() if block[-1] + 1 < len(lines) else ""
        about_file = i == first
        documents = about_file or scopes.declaring() and following not in ("", "}") and not following.startswith("#")
        for k in block:
            indent, text = COMMENT.match(lines[k]).groups()
            out.append(f"{indent}///{escaped(text)}" if documents else lines[k])
        i = block[-1] + 1
        if about_file and following == "#pragma once":
            out.append("/// \\file")
            i += 1
    return out


SAMPLE = '''\
// SPDX-License-Identifier: Apache-2.0
// About the file.
#pragma once

namespace a {

// Alone, about nothing.

// A class of <things>.
template <class T>
class C {
 public:
  // What f does.
  int f() const {
    // Not a declaration.
    return 1;  // nor this
  }
  int size = 0;  // of it, and
                 // more
  enum class E {
    kOne,  // the first
    kTwo   // the last
  };
};
}  // namespace a
'''
EXPECTED = {2: "/// About the file.", 3: "/// \\file", 7: "// Alone", 9: "/// A class of \\<things\\>.", 13: "/// What f does.",
            15: "    // Not", 16: "return 1;  // nor", 18: "///< of it", 19: "///< more", 21: "///< the first",
            22: "///< the last", 25: "}  // namespace"}


def self_test():
    out = converted(SAMPLE.splitlines())
    wrong = [f"line {n}: {out[n - 1]}" for n, text in EXPECTED.items() if text not in out[n - 1]]
    print("\n".join(wrong) if wrong else f"self-test: {len(EXPECTED)} comments are converted as expected")
    return 1 if wrong or len(out) != len(SAMPLE.splitlines()) else 0


def main():
    if sys.argv[1:] == ["--self_test"]:
        return self_test()
    print("\n".join(converted(pathlib.Path(sys.argv[1]).read_text(encoding="utf-8").splitlines())))
    return 0


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks that comments, messages and documents are written in plain English (CONTRIBUTING.md, "Words").

  tools/check_prose.py              fails if a rate is over its limit; names each file over it, with the phrases
  tools/check_prose.py PATH...      the same for these files and folders only, without the limits of the whole
  tools/check_prose.py --self_test  plants one fault of each kind and expects its report

A flag is a phrase that makes readers stop: a clause where a noun should stand ("what is held"), an inverted sentence, an
archaic word. Limits: 1.5 flags per 1,000 words for each kind of text, and for each file of over 200 words.
"""
import collections
import pathlib
import re
import subprocess
import sys

LIMIT = 1.5  # flags per 1,000 words
LONG_LIMIT = 0.01  # fraction of sentences over LONG words
LONG = 30
LEAST_WORDS = 200  # a shorter file counts towards the whole only

PATTERNS = {
    "a clause in place of a noun": r'\bwhat (is|was|are|were|has|had|it|they|there|a|an|the|each|no|that|he|one|goes?|comes?|stays?)\b'
                                   r'|\b(those|that|these) (that|which|of|who|with|there)\b',
    "'who' for a thing": r'\b(whoever|whom)\b|\bwho (goes|stays|looks|asks|takes|sees|saves|alone|cannot|came)\b',
    "an inverted sentence": r'(?:^|[.;:(] ?)(?:of|in|by|from|with|to) (?:several|those|what|which|whom|each|a|the|all|two|such|no)\b[^.;]{3,60}, '
                            r'|\bof (which|what|whom|those)\b',
    "'where there is' for 'if'": r'\bwhere (there|it|they|that|this|these|what|one|none|nothing|no) (is|are|was|were|has|have)\b',
    "an archaic word": r'\b(anew|wherein|thereof|therein|by and by|once more|in place of|for want of|for to)\b|\bbeside (it|them|that|this)\b',
    "a passive of speech": r'\b(is|are|was|were|be) (said|told|asked|looked at|gone on with|spoken|heeded|foretold|foreseen)\b',
    "an empty verb": r'\b(goes? by|has room|takes? no part|is to come|there (?:is|are) none|there is no other)\b',
    "'nothing', 'none' as the subject": r'\b(nothing|nobody|none) (of|is|are|was|that|has|knows|says|asks|but)\b',
    "'as many as' for a number": r'\bas (many|much|often|few|large) (times|of|more|goes?)\b',
}
FLAGS = {name: re.compile(pattern, re.I | re.M) for name, pattern in PATTERNS.items()}
CODE = {".h", ".cpp", ".inl", ".cu", ".cuh"}
SCRIPTS = {".py", ".sh", ".cmake"}


def comments(text, suffix):
    """Runs of comment lines, each as one text."""
    mark = re.compile(r"(?:^|\s)#(?!!)\s?(.*)" if suffix in SCRIPTS else r"(?:^|\s)//[/!]?\s?(.*)")
    found, block = [], []
    for line in [*text.split("\n"), ""]:
        match = mark.search(line)
        if match:
            block.append(match[1])
        elif block:
            found.append(" ".join(block))
            block = []
    return found


def strings(text):
    """Literals of at least four words."""
    return [m[1] for m in re.finditer(r'"((?:[^"\\\n]|\\.){25,})"', text) if m[1].count(" ") >= 3]


def paragraphs(text):
    """Paragraphs, list items and table cells of Markdown, without code and link targets."""
    text = re.sub(r"```.*?```", "\n\n", text, flags=re.S)
    text = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", re.sub(r"`[^`]*`", "X", text))
    found = []
    for part in re.split(r"\n\s*\n|\n(?=[*\-|#]|\d+\.)", text):
        part = part.strip()
        if part.startswith("|"):
            found += [cell.strip() for cell in part.split("|") if cell.strip(" -:\n")]
        elif part and not part.startswith("#"):
            found.append(" ".join(part.split()))
    return found


def texts(name, text):
    """Kind of text -> its pieces."""
    suffix = pathlib.PurePath(name).suffix
    if suffix == ".md":
        return {} if name.endswith("CHANGELOG.md") else {"documents": paragraphs(text)}
    if suffix in CODE | SCRIPTS:
        return {"comments": comments(text, suffix), "messages": strings(text)}
    return {}


def count(files):
    """(totals by kind, lines of report) of {name: text}."""
    totals, report = collections.defaultdict(collections.Counter), []
    for name, text in sorted(files.items()):
        words, hits = 0, []
        for kind, pieces in texts(name, text).items():
            for piece in pieces:
                for sentence in re.split(r"(?<=[.!?:;])\s+", piece):
                    length = len(sentence.split())
                    if length < 3:
                        continue
                    found = [(m[0].strip(), flag) for flag, pattern in FLAGS.items() for m in pattern.finditer(sentence)]
                    totals[kind].update(words=length, sentences=1, flags=len(found), long=length > LONG)
                    words += length
                    hits += found
        if words > LEAST_WORDS and 1000 * len(hits) > LIMIT * words:
            report.append(f"{name}: {1000 * len(hits) / words:.1f} flags per 1,000 words")
            report += [f'  "{phrase}": {flag}' for phrase, flag in hits]
    return totals, report


def check(files, whole):
    totals, report = count(files)
    for kind, c in sorted(totals.items()):
        rate, long = 1000 * c["flags"] / c["words"], c["long"] / c["sentences"]
        print(f"prose: {kind}: {c['words']} words, {rate:.1f} flags per 1,000, {100 * long:.1f} % of sentences over {LONG} words")
        if whole and (rate > LIMIT or long > LONG_LIMIT):
            report.append(f"{kind}: over the limit of {LIMIT} flags per 1,000 words, or of {100 * LONG_LIMIT:.0f} % long sentences")
    print("\n".join(report))
    return 1 if report else 0


def self_test():
    plain = "The solver computes one step and returns the reduction of the cost. " * 20
    planted = ["what is held of it", "those that stay", "whoever asks", "of which two", "where there is one", "anew",
               "is told of it", "goes by the first", "nothing is left", "as many of them"]
    for phrase in planted:
        for name in ("a.h", "a.md", "a.sh"):
            mark = {"a.h": "// ", "a.sh": "# "}.get(name, "")
            assert count({name: mark + plain + "It says " + phrase + " here."})[1], (name, phrase)
            assert not count({name: mark + plain})[1], name
    assert count({"a.cpp": f'Fail("{plain} what is held");'})[1], "messages"
    assert not count({"a.md": plain + "\n```\nwhat is held\n```\n"})[1], "code is not prose"
    assert not count({"a.h": "// what is held"})[1], "short files count only in the whole"
    print("prose: each planted fault is found")


def main():
    if sys.argv[1:] == ["--self_test"]:
        return self_test()
    root = pathlib.Path(__file__).resolve().parent.parent
    listed = subprocess.run(["git", "-C", root, "ls-files", "--", *[str(pathlib.Path(p).resolve()) for p in sys.argv[1:]]],
                            capture_output=True, text=True, check=True).stdout.split("\n")
    files = {name: (root / name).read_text(errors="replace") for name in listed
             if name and (root / name).is_file() and pathlib.PurePath(name).suffix in CODE | SCRIPTS | {".md"}
             and name != "tools/check_prose.py"}
    return check(files, whole=not sys.argv[1:])


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/env python3
"""How fast the viewer is, and what it costs a training.

  bench/viewer.py PROGRAM OUT_DIR SCENE [--iterations N] [--rounds N] [--seconds S] [--json FILE]

Trains SCENE without a page, with one that nobody looks at, and with one that is looked at without a break, round by round in
turns; then asks for pictures of 504 x 378 and 1152 x 864 pixels (0.2 and 1 megapixels) of the splat and of the training, as a page
does, for S seconds each. Each frame has another camera. Prints tables; with --json also {"bench", "machine", "commit",
"rows", "targets"}: a page that nobody looks at may cost 5 % of the time. Times are the least over the rounds, as other work on a machine only
adds: of the clock, and of the processor.
"""
import argparse
import contextlib
import http.client
import json
import os
import signal
import subprocess
import sys
import threading
import time
import urllib.parse
from pathlib import Path

import report

SIZES = ((504, 378), (1152, 864))


@contextlib.contextmanager
def running(*words):
    """(process, address, token) of a program that serves a page; without one the last two are None."""
    process = subprocess.Popen([str(word) for word in words], stdout=subprocess.PIPE, text=True)
    line = next((line for line in process.stdout if "http://" in line or "a first guess" in line), "")
    link = urllib.parse.urlsplit(line.split()[-1]) if "http://" in line else None
    try:
        yield process, link and link.netloc, link and link.query.partition("=")[2]
    finally:
        if process.poll() is None:
            process.send_signal(signal.SIGINT)
        process.stdout.read()
        process.wait()


class Looker:
    """Asks for frames one after the other, from the cameras of the photographs."""

    def __init__(self, address, token):
        self._connection = http.client.HTTPConnection(address, timeout=60)
        self._headers = {"X-Vesta-Token": token}
        self._asked = 0

    def _get(self, path):
        self._connection.request("GET", path, headers=self._headers)
        reply = self._connection.getresponse()
        return reply.status, reply.read()

    def wait_for_scene(self):
        """The number of its views."""
        while True:
            status, body = self._get("/scene")
            if status == 200:
                return len(json.loads(body)["views"])
            time.sleep(0.05)

    def frame(self, views, width, height):
        self._asked += 1
        status, body = self._get(f"/frame?kind=render&photo={self._asked % views}&width={width}&height={height}")
        assert status == 200, body

    def frames_a_second(self, views, size, seconds):
        self.frame(views, *size)
        begin, count = time.monotonic(), 0
        while time.monotonic() - begin < seconds:
            self.frame(views, *size)
            count += 1
        return count / (time.monotonic() - begin)


def look_until_it_ends(address, token):
    with contextlib.suppress(OSError, http.client.HTTPException):
        looker = Looker(address, token)
        views = looker.wait_for_scene()
        while True:
            looker.frame(views, *SIZES[0])


def train(program, scene, out, iterations, kind):
    """(seconds of the clock, of the processor) that the stage of Adam and all of the program took."""
    words = [program, "train", scene, "--out", out, f"--iterations={iterations}", "--noreport"]
    before = os.times()
    with running(*words, *([] if kind == "none" else ["--view"])) as (process, address, token):
        looker = threading.Thread(target=look_until_it_ends, args=(address, token)) if kind == "looked at" else None
        if looker:
            looker.start()
        process.stdout.read()
        process.wait()
    after = os.times()
    if looker:
        looker.join()
    seconds = json.loads((out / "metrics.json").read_text())["seconds"]["adam"]
    return seconds, after.children_user + after.children_system - before.children_user - before.children_system


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("scene", type=Path)
    parser.add_argument("--iterations", type=int, default=600)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--seconds", type=float, default=5)
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)

    kinds = ("none", "not looked at", "looked at")
    times = {kind: [] for kind in kinds}
    for _ in range(options.rounds):
        for kind in kinds:
            times[kind].append(train(options.program, options.scene, options.out / "run", options.iterations, kind))
    rows = []
    for kind in kinds:
        clock, cpu = (min(column) for column in zip(*times[kind]))
        rows.append({"what": f"training, page: {kind}", "seconds": clock, "cpu_seconds": cpu})
        print(f"training, page: {kind:<14}{clock:8.2f} s of the clock{cpu:8.2f} s of the processor")

    splat = options.out / "run" / "point_cloud.ply"
    long_run = (options.program, "train", options.scene, "--out", options.out / "long", "--iterations=1000000", "--view")
    for what, words in (("splat", (options.program, "view", splat, options.scene)), ("training", long_run)):
        with running(*words) as (_, address, token):
            looker = Looker(address, token)
            views = looker.wait_for_scene()
            for size in SIZES:
                rate = looker.frames_a_second(views, size, options.seconds)
                rows.append({"what": f"{size[0]} x {size[1]} of a {what}", "frames_a_second": rate})
                print(f"{size[0]:>4} x {size[1]} of a {what:<10}{rate:8.1f} frames a second")

    cost = {name: rows[1][name] / rows[0][name] - 1 for name in ("seconds", "cpu_seconds")}
    targets = [{"name": f"a page that nobody looks at, {name}", "value": value, "unit": "of it", "goal": 0.05,
                "met": value <= 0.05} for name, value in cost.items()]
    report.print_targets(targets)
    if options.json:
        report.write_json(options.json, "viewer", rows, targets)


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Makes the README's animation: the viewer in Chromium orbits the demo's scene once during its training. Needs Chromium,
and ffmpeg with libwebp.

  tools/viewer_film.py BUILD OUT.webp [--frames N] [--iterations N] [--quality Q]

BUILD is the folder of the programs. The script drags in the page to orbit the scene in N frames. Each frame waits for a
training iteration; the early frames, when most changes, are fewer iterations apart.
"""
import argparse
import pathlib
import signal
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "tests" / "apps" / "viewer"))
from chromium import Browser, find_browser  # noqa: E402

SIZE = (900, 660)  # page size, pixels
FRAMES_A_SECOND = 8
IS_STILL = "still && !isDrawing && drawn.frames > 0"


def round_the_scene(page, frames, iterations, folder):
    """Saves the frames as folder/NNN.jpg."""
    page.front()
    page.wait(f"scene && {IS_STILL}", 120)
    height = page.get("canvas.clientHeight")
    middle = [page.get("canvas.clientWidth") / 2, height / 2]
    step = 2 * height / frames  # by the height rotates by 180 degrees
    for k in range(frames):
        iteration = int(0.9 * iterations * (k / frames) ** 2)
        page.wait(f"training.iteration >= {iteration}", 600)
        if page.get("training.status") == "over":
            sys.exit(f"the training ended after {k} frames: give more --iterations")
        before = page.get("drawn.frames")
        page.drag(middle, [middle[0] - step, middle[1]], 2)
        page.wait(f"drawn.frames > {before} && {IS_STILL}", 60)
        page.screenshot(folder / f"{k:03}.jpg", 95)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", type=pathlib.Path)
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("--frames", type=int, default=40)
    parser.add_argument("--iterations", type=int, default=1500)
    parser.add_argument("--quality", type=int, default=32)
    options = parser.parse_args()
    program = find_browser()
    if program is None:
        sys.exit("no Chromium on this machine")
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        scene = folder / "scene"
        subprocess.run([options.build / "vesta_demo_scene", "--out", scene, "--width=400", "--height=300"], check=True)
        training = subprocess.Popen([options.build / "vesta", "train", scene, "--out", folder / "out", "--view",
                                     f"--iterations={options.iterations}", "--noreport"],
                                    stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        try:
            link = next(line for line in training.stdout if "http://" in line).split()[-1]
            with Browser(program, folder) as browser:
                round_the_scene(browser.open(link, *SIZE), options.frames, options.iterations, folder)
        finally:
            training.send_signal(signal.SIGINT)
            training.stdout.read()
            training.wait()
        made = folder / "film.webp"
        subprocess.run(["ffmpeg", "-loglevel", "error", "-framerate", str(FRAMES_A_SECOND), "-i", folder / "%03d.jpg",
                        "-vf", "scale=540:-2", "-c:v", "libwebp_anim", "-quality", str(options.quality),
                        "-compression_level", "6", "-loop", "0", made], check=True)
        unfinished = options.out.with_name(options.out.name + ".unfinished")
        unfinished.write_bytes(made.read_bytes())
        unfinished.replace(options.out)
    print(f"wrote {options.out}: {options.out.stat().st_size / 1e6:.2f} MB")


if __name__ == "__main__":
    main()

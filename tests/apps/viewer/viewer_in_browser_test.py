#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The viewer in Chromium: the page loads, a drag changes the image, photographs and differences are shown, and two pages
can be open. A training that optimises cameras is paused, saved and stopped from its page. No page logs errors or sends
requests elsewhere.
Skipped (77) if there is no Chromium.

  viewer_in_browser_test.py VESTA DEMO_SCENE     (the two programs)
"""
import contextlib
import pathlib
import signal
import subprocess
import sys
import tempfile

from chromium import Browser, find_browser

PICTURE = "by('picture').toDataURL()"
IS_STILL = "still && !isDrawing && drawn.frames > 0"


@contextlib.contextmanager
def serving(*command):
    """Yields (link, process) of a program that serves a page; its exit status must be 0."""
    process = subprocess.Popen([str(word) for word in command], stdout=subprocess.PIPE, text=True)
    try:
        line = next((line for line in process.stdout if "http://" in line), None)
        assert line, "the program printed no link"
        yield line.split()[-1], process
    finally:
        if process.poll() is None:
            process.send_signal(signal.SIGINT)
        process.communicate(timeout=60)


def check_quiet(page, link):
    lines, asked = page.troubles()
    assert not lines, lines
    assert asked and all(address.startswith(link.split("?")[0]) for address in asked), asked


def choose(page, kind):
    """Selects the kind of image to show; returns the image."""
    before = page.get("drawn.frames")
    page.get(f"document.querySelector('[name=kind][value={kind}]').click()")
    page.wait(f"drawn.frames > {before} && {IS_STILL}")
    assert kind == "render" or page.get("by('kind-note').textContent"), f"{kind} has a description"
    return page.get(PICTURE)


def look_at_splat(browser, link):
    first, second = browser.open(link), browser.open(link)
    for page in (first, second):
        page.front()
        page.wait(IS_STILL)
    first.front()
    pictures = [first.get(PICTURE)]
    for kind in ("truth", "difference", "count", "removal_cost", "coverage", "render"):
        pictures.append(choose(first, kind))
    assert pictures[0] == pictures[-1] and len(set(pictures)) == 6, "each kind must have its own image"
    before = first.get("drawn.frames")
    first.drag((300, 300), (360, 320))
    first.wait(f"drawn.frames > {before} && {IS_STILL}")
    assert first.get(PICTURE) != pictures[0], "a drag must change the image"
    assert first.get("photo === null")
    first.get("by('next').click()")
    first.wait(f"photo === 0 && {IS_STILL}")
    second.front()
    assert second.get("photo") == 0 and second.get("drawn.frames") > 0
    for page in (first, second):
        check_quiet(page, link)
    stranger = browser.open(link.split("?")[0] + "?token=0")
    stranger.wait("document.body.textContent.includes('the token is missing or wrong')")


def look_without_scene(browser, link):
    page = browser.open(link)
    page.wait(IS_STILL)
    assert page.get("[...document.querySelectorAll('.of-scene')].every(label => label.hidden)"), "hidden without a scene"
    check_quiet(page, link)


def hold_training(browser, link, process, out):
    page = browser.open(link)
    page.wait(f"training.iteration > 20 && {IS_STILL}")
    page.get("by('pause').click()")
    page.wait("training.status === 'paused'")
    page.get("follow()")
    iteration = page.get("training.iteration")
    page.get("by('checkpoint').click()")
    page.wait("training.message.includes('saved')")
    assert page.get("training.iteration") == iteration, "paused"
    assert (out / "checkpoint.vesta").exists()
    page.get("by('pause').click()")
    page.wait(f"training.iteration > {iteration} && training.status === 'running'")
    stands = "scene.views[1].position.join()"
    page.wait(f"{stands} !== '{page.get(stands)}' && photo === 0 && {IS_STILL}", 60)
    check_quiet(page, link)
    page.get("by('stop').click()")
    assert process.wait(60) == 0
    assert (out / "point_cloud.ply").exists()


def main():
    browser_program = find_browser()
    if browser_program is None:
        print("skipped: no Chromium on this machine")
        return 77
    vesta, demo_scene = sys.argv[1:3]
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        scene, out = folder / "scene", folder / "out"
        subprocess.run([demo_scene, "--out", str(scene)], check=True, stdout=subprocess.DEVNULL)
        train = (vesta, "train", scene, "--out", out, "--iterations=20000", "--downscale=2", "--set=adam.evaluations=2",
                 "--refine_cameras=pose")
        with Browser(browser_program, folder) as browser:
            with serving(*train, "--view") as (link, process):
                hold_training(browser, link, process, out)
            for splat in ("point_cloud.ply", "checkpoint.vesta"):
                with serving(vesta, "view", out / splat, scene, "--downscale=2") as (link, process):
                    look_at_splat(browser, link)
                assert process.returncode == 0, "the program must end by Ctrl-C"
            with serving(vesta, "view", out / "point_cloud.ply") as (link, process):
                look_without_scene(browser, link)
    print("pages load, move, and pause a training")
    return 0


if __name__ == "__main__":
    sys.exit(main())

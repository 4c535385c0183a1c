#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Opens a report in Chromium without a network: it requests nothing, and its console stays empty. A page with both
faults is tested first, to show that the test detects them. Skipped (77) if there is no Chromium.

  report_in_browser_test.py VESTA DEMO_SCENE     (the two programs)
"""
import json
import pathlib
import shutil
import subprocess
import sys
import tempfile

FAULTY = '<!DOCTYPE html><img src="http://vesta.invalid/a.png"><script>undefined_function()</script>'


def run(*command):
    subprocess.run([str(word) for word in command], check=True, stdout=subprocess.DEVNULL)


def visit(browser, page, folder):
    """Returns (lines of the console, addresses requested by the page)."""
    log = folder / "net.json"
    done = subprocess.run([browser, "--headless=new", "--no-sandbox", "--disable-gpu", "--no-first-run",
                           "--disable-background-networking", "--disable-component-update", "--disable-sync", f"--user-data-dir={folder / 'profile'}",
                           "--host-resolver-rules=MAP * ~NOTFOUND", "--enable-logging=stderr", "--v=0",
                           f"--log-net-log={log}", f"--screenshot={folder / 'shot.png'}", "--window-size=1200,2000",
                           page.as_uri()], capture_output=True, text=True, timeout=100)
    console = [line for line in done.stderr.splitlines() if ":CONSOLE" in line]
    text = log.read_text(encoding="utf-8")
    try:
        events = json.loads(text)["events"]
    except json.JSONDecodeError:  # the browser ended before it closed the list
        events = json.loads(text.rstrip().rstrip(",") + "]}")["events"]
    asked = {event["params"]["url"] for event in events if "url" in event.get("params", {})}
    # Requests by the browser's own services are not the page's.
    own = ("google", "gvt1.com", "data:", "chrome")
    if not (folder / "shot.png").exists():
        sys.exit("the browser made no screenshot:\n" + done.stderr[-2000:])
    return console, {url for url in asked if not any(name in url for name in own)}


def main():
    browser = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    if browser is None:
        print("skipped: no Chromium on this machine")
        return 77
    vesta, demo_scene = sys.argv[1:3]
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        faulty = folder / "faulty.html"
        faulty.write_text(FAULTY, encoding="utf-8")
        console, asked = visit(browser, faulty, folder)
        assert console and asked, f"a faulty page is not detected: {console} {asked}"
        run(demo_scene, "--out", folder / "scene")
        for run_name, iterations in (("one", 20), ("two", 40)):
            run(vesta, "train", folder / "scene", "--out", folder / run_name, f"--iterations={iterations}",
                "--set=adam.evaluations=2", "--downscale=2")
        run(vesta, "report", folder / "one", folder / "two", "--out", folder / "both.html")
        console, asked = visit(browser, folder / "both.html", folder)
        assert not console, console
        assert not asked, asked
    print("no request, nothing in the console")
    return 0


if __name__ == "__main__":
    sys.exit(main())

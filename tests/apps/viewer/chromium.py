# SPDX-License-Identifier: Apache-2.0
"""Headless Chromium, controlled by the DevTools protocol over a pipe. Needs no other package."""
import base64
import json
import os
import pathlib
import shutil
import subprocess
import time


def find_browser():
    return shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")


class Browser:
    """A browser with its profile in the folder; a context manager that ends it."""

    def __init__(self, program, folder):
        self._to_read, to_write = os.pipe()
        to_read, self._to_write = os.pipe()

        def wire():  # the browser reads from descriptor 3 and writes to 4
            ends = [os.dup(to_read), os.dup(to_write)]
            os.dup2(ends[0], 3), os.dup2(ends[1], 4)

        self._log = open(pathlib.Path(folder) / "browser.log", "w", encoding="utf-8")
        self._process = subprocess.Popen(
            [program, "--headless=new", "--no-sandbox", "--disable-gpu", "--no-first-run",
             "--disable-background-networking", "--disable-component-update", "--disable-sync",
             f"--user-data-dir={pathlib.Path(folder) / 'profile'}", "--remote-debugging-pipe", "about:blank"],
            preexec_fn=wire, pass_fds=(3, 4), stdout=self._log, stderr=self._log)
        os.close(to_read), os.close(to_write)
        self._bytes, self._count = b"", 0
        self.events = []

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._process.terminate()
        self._process.wait(20)
        self._log.close()

    def _message(self):
        while b"\0" not in self._bytes:
            part = os.read(self._to_read, 1 << 20)
            if not part:
                raise EOFError("the browser has ended")
            self._bytes += part
        line, self._bytes = self._bytes.split(b"\0", 1)
        return json.loads(line)

    def call(self, method, session=None, **params):
        self._count += 1
        asked = {"id": self._count, "method": method, "params": params}
        if session:
            asked["sessionId"] = session
        os.write(self._to_write, json.dumps(asked).encode() + b"\0")
        while True:
            message = self._message()
            if message.get("id") == self._count:
                if "error" in message:
                    raise RuntimeError(f"{method}: {message['error']}")
                return message["result"]
            self.events.append(message)

    def open(self, address, width=1200, height=800):
        return Page(self, address, width, height)


class Page:
    def __init__(self, browser, address, width, height):
        self._browser = browser
        self._target = browser.call("Target.createTarget", url="about:blank", width=width,
                                    height=height, newWindow=True)["targetId"]
        self._session = browser.call("Target.attachToTarget", targetId=self._target, flatten=True)["sessionId"]
        for domain in ("Runtime", "Log", "Network", "Page"):
            self._call(f"{domain}.enable")
        self._call("Page.navigate", url=address)

    def _call(self, method, **params):
        return self._browser.call(method, self._session, **params)

    def front(self):
        """Brings the page to the front: only that page is drawn."""
        self._call("Page.bringToFront")

    def get(self, expression):
        """Evaluates a JavaScript expression, awaits the result and returns it."""
        done = self._call("Runtime.evaluate", expression=expression, awaitPromise=True, returnByValue=True)
        if "exceptionDetails" in done:
            raise RuntimeError(f"{expression}: {done['exceptionDetails']}")
        return done["result"].get("value")

    def wait(self, condition, seconds=30):
        """Waits until the expression is true. An exception counts as false, because the page may still be loading."""
        asked = f"(() => {{ try {{ return Boolean({condition}); }} catch {{ return false; }} }})()"
        end = time.monotonic() + seconds
        while not self.get(asked):
            if time.monotonic() > end:
                raise TimeoutError(f"never: {condition}")
            time.sleep(0.05)

    def drag(self, start, end, steps=8):
        self._mouse("mousePressed", start, 1)
        for i in range(1, steps + 1):
            self._mouse("mouseMoved", [a + (b - a) * i / steps for a, b in zip(start, end)], 1)
        self._mouse("mouseReleased", end, 0)

    def _mouse(self, kind, at, buttons):
        self._call("Input.dispatchMouseEvent", type=kind, x=at[0], y=at[1], button="left", buttons=buttons, clickCount=1)

    def screenshot(self, path, quality=80):
        shot = self._call("Page.captureScreenshot", format="jpeg", quality=quality)
        pathlib.Path(path).write_bytes(base64.b64decode(shot["data"]))

    def troubles(self):
        """Returns the lines of the console and the requested addresses."""
        lines, asked = [], []
        for event in self._browser.events:
            if event.get("sessionId") != self._session:
                continue
            params = event["params"]
            if event["method"] == "Runtime.exceptionThrown":
                lines.append(params["exceptionDetails"].get("exception", {}).get("description", str(params)))
            if event["method"] == "Runtime.consoleAPICalled":
                lines.append(str([argument.get("value") for argument in params["args"]]))
            if event["method"] == "Log.entryAdded":
                lines.append(params["entry"]["text"])
            if event["method"] == "Network.requestWillBeSent":
                asked.append(params["request"]["url"])
        return lines, asked

# SPDX-License-Identifier: GPL-3.0-only
"""A page in headless Chromium, by its DevTools protocol through a pipe: nothing but the program is
needed (https://chromedevtools.github.io/devtools-protocol)."""

import base64
import fcntl
import json
import os
import select
import shutil
import subprocess
import time

NAMES = ("chromium", "chromium-browser", "google-chrome")
SOFTWARE = ("--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist")


def program():
    """Where Chromium is; None where it is not."""
    return next(filter(None, map(shutil.which, NAMES)), None)


class Browser:
    """One window. What goes wrong in its pages is in `complaints`, what they load in `requests`."""

    def __init__(self, profile, width=1280, height=768, timeout=300):
        self.complaints, self.requests, self.timeout = [], [], timeout
        (low_in, self._to), (self._from, low_out) = os.pipe(), os.pipe()
        # Above 3 and 4, so that neither is lost when these are set.
        theirs_in, theirs_out = (fcntl.fcntl(low, fcntl.F_DUPFD, 10) for low in (low_in, low_out))
        self._read, self._answers, self._seen, self._sent = b"", {}, [], 0
        self._process = subprocess.Popen(
            # It talks on file descriptors 3 and 4.
            ["bash", "-c", f'exec "$@" 3<&{theirs_in} 4>&{theirs_out}', "bash", program()]
            + ["--headless=new", "--remote-debugging-pipe", "--no-sandbox", "--no-first-run"]
            + ["--hide-scrollbars", f"--window-size={width},{height}", *SOFTWARE]
            + ["--disable-dev-shm-usage", "--disable-background-networking"]
            + [f"--user-data-dir={profile}", "about:blank"],
            pass_fds=(theirs_in, theirs_out),
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        for descriptor in (low_in, low_out, theirs_in, theirs_out):
            os.close(descriptor)
        pages = self._call("Target.getTargets", session=None)["targetInfos"]
        page = next(target["targetId"] for target in pages if target["type"] == "page")
        self._session = None
        self._session = self._call("Target.attachToTarget", targetId=page, flatten=True)[
            "sessionId"
        ]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self._call(f"{domain}.enable")
        self._call(
            "Emulation.setDeviceMetricsOverride",
            width=width,
            height=height,
            deviceScaleFactor=1,
            mobile=False,
        )

    def open(self, path):
        self._seen.clear()
        self._call("Page.navigate", url=path.resolve().as_uri())
        self._wait(lambda: "Page.loadEventFired" in self._seen)

    def run(self, code):
        """The value of an expression; what it promises is awaited."""
        found = self._call(
            "Runtime.evaluate", expression=code, awaitPromise=True, returnByValue=True
        )
        if "exceptionDetails" in found:
            raise AssertionError(_words(found["exceptionDetails"]))
        return found["result"].get("value")

    def drawn(self):
        """Waits until what was changed is on the screen."""
        self.run("new Promise((go) => requestAnimationFrame(() => requestAnimationFrame(go)))")

    def drag(self, start, end, steps=4, shift=False):
        """With the left button, over pixels of the page."""
        more = {"modifiers": 8 if shift else 0, "button": "left", "clickCount": 1}
        way = [[a + (b - a) * k / steps for a, b in zip(start, end)] for k in range(steps + 1)]
        self._mouse("mouseMoved", start, {**more, "button": "none"})
        self._mouse("mousePressed", start, {**more, "buttons": 1})
        for point in way[1:]:
            self._mouse("mouseMoved", point, {**more, "buttons": 1})
        self._mouse("mouseReleased", end, more)

    def move(self, point):
        self._mouse("mouseMoved", point, {"button": "none"})

    def press(self, key):
        """A key that is called as KeyboardEvent.key says."""
        codes = {"ArrowRight": 39, "ArrowLeft": 37, "Tab": 9, " ": 32}
        for kind in ("rawKeyDown", "keyUp"):
            self._call(
                "Input.dispatchKeyEvent",
                type=kind,
                key=key,
                code=key,
                windowsVirtualKeyCode=codes[key],
            )

    def picture(self, path):
        data = self._call("Page.captureScreenshot", format="png")["data"]
        path.write_bytes(base64.b64decode(data))

    def close(self):
        try:
            self._call("Browser.close", session=None)
            self._process.wait(10)
        except (OSError, AssertionError, subprocess.TimeoutExpired):
            self._process.kill()
            self._process.wait()
        os.close(self._to)
        os.close(self._from)

    def _mouse(self, kind, point, more):
        self._call("Input.dispatchMouseEvent", type=kind, x=point[0], y=point[1], **more)

    def _call(self, method, session=True, **parameters):
        self._sent += 1
        message = {"id": self._sent, "method": method, "params": parameters}
        if session and getattr(self, "_session", None):
            message["sessionId"] = self._session
        os.write(self._to, json.dumps(message).encode() + b"\0")
        self._wait(lambda: message["id"] in self._answers)
        answer = self._answers.pop(message["id"])
        assert "error" not in answer, f"{method}: {answer['error']}"
        return answer["result"]

    def _wait(self, done):
        end = time.monotonic() + self.timeout
        while not done():
            left = end - time.monotonic()
            assert left > 0 and select.select([self._from], [], [], left)[0], "Chromium is silent"
            read = os.read(self._from, 1 << 20)
            assert read, "Chromium has ended"
            *messages, self._read = (self._read + read).split(b"\0")
            for message in map(json.loads, messages):
                self._take(message)

    def _take(self, message):
        if "id" in message:
            self._answers[message["id"]] = message
            return
        method, what = message["method"], message["params"]
        self._seen.append(method)
        if method == "Runtime.exceptionThrown":
            self.complaints.append(_words(what["exceptionDetails"]))
        elif method == "Runtime.consoleAPICalled" and what["type"] in ("error", "warning"):
            self.complaints.append(" ".join(str(value.get("value")) for value in what["args"]))
        elif method == "Log.entryAdded" and what["entry"]["level"] in ("error", "warning"):
            self.complaints.append(what["entry"]["text"])
        elif method == "Network.requestWillBeSent":
            self.requests.append(what["request"]["url"])


def _words(details):
    return details.get("exception", {}).get("description") or details["text"]

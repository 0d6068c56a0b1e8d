"""Chromium, asked through its DevTools protocol: real time, real keys and clicks, and what its console says."""

import base64
import json
import os
import subprocess
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
from slides import browser


class PageError(Exception):
    pass


class Page:
    """One page in a Chromium of its own; use as a context. `complaints` are its errors and warnings so far."""

    def __init__(self, width=1280, height=900):
        self.size = width, height
        self.profile = tempfile.TemporaryDirectory(prefix="ch5-chromium-", ignore_cleanup_errors=True)
        self.complaints, self.number, self.session = [], 0, None
        to_chromium, self.write = os.pipe()
        self.read, from_chromium = os.pipe()
        # The protocol's pipes are the descriptors 3 and 4.
        command = ["sh", "-c", f'exec "$0" "$@" 3<&{to_chromium} 4>&{from_chromium}', browser.chromium(),
                   *browser.HEADLESS, "--remote-debugging-pipe", f"--user-data-dir={self.profile.name}"]
        self.process = subprocess.Popen(command, pass_fds=(to_chromium, from_chromium), stdin=subprocess.DEVNULL,
                                        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        os.close(to_chromium)
        os.close(from_chromium)
        self.rest = b""

    def __enter__(self):
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        self.session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log"):
            self.call(f"{domain}.enable")
        self.show_as(*self.size)
        return self

    def __exit__(self, *_):
        self.process.kill()
        self.process.wait()
        os.close(self.write)
        os.close(self.read)
        self.profile.cleanup()

    def call(self, method, **parameters):
        """Sends a command and returns its result; raises PageError with Chromium's words."""
        self.number += 1
        message = {"id": self.number, "method": method, "params": parameters}
        if self.session:
            message["sessionId"] = self.session
        os.write(self.write, json.dumps(message).encode() + b"\0")
        while True:
            answer = self.next_message()
            if answer.get("id") == self.number:
                if "error" in answer:
                    raise PageError(f"{method}: {answer['error']['message']}")
                return answer["result"]
            self.note(answer)

    def next_message(self):
        while b"\0" not in self.rest:
            data = os.read(self.read, 1 << 20)
            if not data:
                raise PageError("Chromium has ended")
            self.rest += data
        message, self.rest = self.rest.split(b"\0", 1)
        return json.loads(message)

    def note(self, event):
        what = event.get("params", {})
        if event.get("method") == "Runtime.exceptionThrown":
            details = what["exceptionDetails"]
            self.complaints.append(details.get("exception", {}).get("description", details["text"]))
        elif event.get("method") == "Runtime.consoleAPICalled" and what["type"] in ("error", "warning", "assert"):
            self.complaints.append(str([one.get("value") for one in what["args"]]))
        elif event.get("method") == "Log.entryAdded" and what["entry"]["level"] in ("error", "warning"):
            self.complaints.append(what["entry"]["text"])

    def show_as(self, width, height, dark=False):
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=width < 700)
        self.call("Emulation.setEmulatedMedia",
                  features=[{"name": "prefers-color-scheme", "value": "dark" if dark else "light"}])

    def open(self, address, ready="document.readyState === 'complete'"):
        """Loads an address anew, and waits for an expression to hold (or for the promise that it is)."""
        self.call("Page.navigate", url="about:blank")
        self.call("Page.navigate", url=address)
        self.evaluate(f"new Promise(done => {{ const look = async () => {{ try {{ if (await ({ready})) return done(); }} "
                      "catch {} setTimeout(look, 20); }; look(); })")

    def evaluate(self, expression):
        """The value of an expression or promise in the page; raises PageError with the page's exception."""
        done = self.call("Runtime.evaluate", expression=expression, awaitPromise=True, returnByValue=True, userGesture=True)
        if "exceptionDetails" in done:
            details = done["exceptionDetails"]
            raise PageError(details.get("exception", {}).get("description", details["text"]))
        return done["result"].get("value")

    def press(self, key, text=""):
        code = {"Enter": 13, "ArrowRight": 39, "ArrowLeft": 37, "Tab": 9}[key]
        text = {"Enter": "\r"}.get(key, text)
        for kind in ("keyDown", "keyUp"):
            self.call("Input.dispatchKeyEvent", type=kind, key=key, code=key, windowsVirtualKeyCode=code,
                      **({"text": text} if text and kind == "keyDown" else {}))

    def click(self, selector, across=0.5, down=0.5):
        """Clicks into an element, at a fraction of its width and height."""
        x, y = self.evaluate(f"(() => {{ const node = document.querySelector({selector!r}); node.scrollIntoView(); const box = "
                             f"node.getBoundingClientRect(); return [box.x + box.width * {across}, "
                             f"box.y + box.height * {down}]; }})()")
        for kind in ("mousePressed", "mouseReleased"):
            self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", clickCount=1)

    def image(self, path):
        """The whole page as PNG."""
        height = self.evaluate("document.documentElement.scrollHeight")
        clip = {"x": 0, "y": 0, "width": self.evaluate("innerWidth"), "height": height, "scale": 1}
        data = self.call("Page.captureScreenshot", format="png", captureBeyondViewport=True, clip=clip)["data"]
        Path(path).write_bytes(base64.b64decode(data))

"""Chromium without a window, driven by its own DevTools protocol: https://chromedevtools.github.io/devtools-protocol."""

import base64
import json
import shutil
import subprocess
import time
import urllib.request
from contextlib import contextmanager

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome")
FLAGS = (
    "--headless=new",
    "--no-sandbox",  # tests may run as root in a container
    "--disable-gpu",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",  # WebGL without a graphics card
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-dev-shm-usage",
    "--remote-debugging-port=0",
    "--remote-allow-origins=*",
)
PATIENCE = 300.0
"""Seconds after which something that is waited for does not come: far more than a busy machine takes."""


def find():
    """The path of a Chromium or Chrome, None where there is none."""
    return next(filter(None, map(shutil.which, NAMES)), None)


class Page:
    """A tab: what it says, what it asks for, and what can be done to it."""

    def __init__(self, socket):
        self.socket, self.number = socket, 0
        self.errors, self.requests = [], []
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.send(f"{domain}.enable")

    def send(self, method, **params):
        self.number += 1
        self.socket.send(json.dumps({"id": self.number, "method": method, "params": params}))
        while True:
            message = json.loads(self.socket.recv())
            if message.get("id") == self.number:
                assert "error" not in message, message["error"]
                return message["result"]
            self._hear(message)

    def _hear(self, message):
        what, params = message.get("method"), message.get("params", {})
        if what == "Runtime.exceptionThrown":
            self.errors.append(params["exceptionDetails"])
        elif what == "Runtime.consoleAPICalled" and params["type"] in ("error", "warning", "assert"):
            self.errors.append([argument.get("value") for argument in params["args"]])
        elif what == "Log.entryAdded" and params["entry"]["level"] in ("error", "warning"):
            text = params["entry"]["text"]
            # a screenshot reads what was drawn, and the driver says that this is slow
            if "GL Driver Message" not in text or "Performance" not in text:
                self.errors.append(text)
        elif what == "Network.requestWillBeSent":
            self.requests.append(params["request"]["url"])

    def open(self, address, width=1400, height=900):
        self.resize(width, height)
        self.send("Page.navigate", url=address)
        root = "document.documentElement"
        self.wait(f"location.href === {address!r} && {root} !== null && {root}.dataset.ready === 'yes'")

    def resize(self, width, height):
        self.send(
            "Emulation.setDeviceMetricsOverride",
            width=width,
            height=height,
            deviceScaleFactor=1,
            mobile=False,
        )

    def run(self, code):
        """Value of an expression in the page."""
        result = self.send("Runtime.evaluate", expression=code, returnByValue=True, awaitPromise=True)
        assert "exceptionDetails" not in result, result["exceptionDetails"]
        return result["result"].get("value")

    def wait(self, condition):
        end = time.monotonic() + PATIENCE
        while not self.run(condition):
            assert time.monotonic() < end, f"{condition} did not come true; errors: {self.errors}"
            time.sleep(0.05)

    def drawn(self):
        """Wait until what was asked for is on the screen."""
        frames = "requestAnimationFrame(() => requestAnimationFrame(() => done(true)))"
        assert self.run(f"new Promise((done) => {frames})")

    def picture(self, path):
        """Write a screenshot."""
        self.drawn()
        data = base64.b64decode(self.send("Page.captureScreenshot", format="png")["data"])
        path.write_bytes(data)
        return path

    def key(self, key, code, text=""):
        for kind in ("keyDown", "keyUp"):
            more = {"text": text} if text and kind == "keyDown" else {}
            self.send("Input.dispatchKeyEvent", type=kind, key=key, code=code, **more)

    def click(self, x, y):
        for kind in ("mousePressed", "mouseReleased"):
            self.send("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", clickCount=1)

    def choose(self, element, value):
        """Pick an option as a reader does, who makes the page hear of it."""
        change = f"const e = document.getElementById({element!r}); e.value = {value!r};"
        self.run(f"(() => {{ {change} e.dispatchEvent(new Event('change')); return e.value; }})()")


@contextmanager
def opened(folder):
    """A browser with one tab; `folder` holds its profile."""
    import websocket

    command = [find(), *FLAGS, f"--user-data-dir={folder}", "about:blank"]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        port_file, end = folder / "DevToolsActivePort", time.monotonic() + PATIENCE
        while not (port_file.exists() and port_file.read_text().strip()):
            assert time.monotonic() < end, "the browser did not start"
            assert process.poll() is None, "the browser stopped at once"
            time.sleep(0.05)
        port = port_file.read_text().split()[0]
        with urllib.request.urlopen(f"http://127.0.0.1:{port}/json/list", timeout=PATIENCE) as answer:
            tab = next(tab for tab in json.load(answer) if tab["type"] == "page")
        socket = websocket.create_connection(tab["webSocketDebuggerUrl"], timeout=PATIENCE, max_size=None)
        try:
            yield Page(socket)
        finally:
            socket.close()
    finally:
        process.terminate()
        process.wait(timeout=PATIENCE)

"""A headless Chromium driven over a pipe: what a page shows, writes to its console and asks the network for."""

import json
import os
import shutil
import signal
import subprocess
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import pytest

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
needs_chromium = pytest.mark.skipif(CHROMIUM is None, reason="no Chromium is installed: apt-get install chromium")
OPTIONS = (
    "--headless=new",
    "--no-sandbox",
    "--disable-gpu",
    "--remote-debugging-pipe",
    "--disable-background-networking",
    "--no-first-run",
)
PATIENCE = 60.0
GO = """new Promise(done => {
  addEventListener('hashchange', () => setTimeout(done), {once: true});
  location.hash = %s;
})"""


class Browser:
    """One page in a browser without network."""

    def __init__(self, write, read):
        self._write, self._read, self._left, self._number, self.events = write, read, b"", 0, []
        target = self.ask("Target.createTarget", url="about:blank")["targetId"]
        self._session = None
        self._session = self.ask("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network", "Accessibility"):
            self.ask(f"{domain}.enable")
        self.ask(
            "Network.emulateNetworkConditions", offline=True, latency=0, downloadThroughput=0, uploadThroughput=0
        )

    def ask(self, method, **parameters):
        """Send a command and return its result; events that come meanwhile are kept."""
        self._number += 1
        session = {"sessionId": self._session} if getattr(self, "_session", None) else {}
        message = {"id": self._number, "method": method, "params": parameters, **session}
        os.write(self._write, json.dumps(message).encode() + b"\0")
        while True:
            answer = self._next()
            if answer.get("id") == self._number:
                assert "error" not in answer, answer
                return answer["result"]
            self.events.append(answer)

    def open(self, path, fragment=""):
        """Load a file and wait until it is shown."""
        self.visit(f"{Path(path).resolve().as_uri()}{fragment}")

    def visit(self, url):
        """Load an address and wait until it is shown."""
        self.events.clear()
        self.ask("Page.navigate", url=url)
        while not any(event.get("method") == "Page.loadEventFired" for event in self.events):
            self.events.append(self._next())

    def run(self, expression):
        """Return the value of an expression on the page."""
        told = self.ask("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        assert "exceptionDetails" not in told, told["exceptionDetails"]
        return told["result"].get("value")

    def go(self, fragment):
        """Go to another place of the page."""
        self.run(GO % json.dumps(fragment))

    def press(self, key):
        """Press a key."""
        for kind in ("keyDown", "keyUp"):
            text = {"text": "\r"} if key == "Enter" and kind == "keyDown" else {}
            self.ask(
                "Input.dispatchKeyEvent",
                type=kind,
                key=key,
                code=key,
                windowsVirtualKeyCode=13 if text else 0,
                **text,
            )

    def look(self, width=1280, height=900, scheme="light", media=""):
        """Set the size of the window and what the user prefers."""
        self.ask("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=False)
        self.ask(
            "Emulation.setEmulatedMedia", media=media, features=[{"name": "prefers-color-scheme", "value": scheme}]
        )

    @property
    def complaints(self):
        """Errors and warnings of the console."""
        wrong = {"Runtime.exceptionThrown", "Log.entryAdded"}
        return [event["params"] for event in self.events if event.get("method") in wrong or _is_bad_call(event)]

    @property
    def requests(self):
        """Addresses that were asked for, other than files and data."""
        sent = [event for event in self.events if event.get("method") == "Network.requestWillBeSent"]
        urls = [event["params"]["request"]["url"] for event in sent]
        return [url for url in urls if not url.startswith(("file:", "data:"))]

    def _next(self):
        deadline = time.monotonic() + PATIENCE
        while b"\0" not in self._left:
            assert time.monotonic() < deadline, "Chromium does not answer"
            piece = os.read(self._read, 1 << 20)
            assert piece, "Chromium has ended"
            self._left += piece
        message, _, self._left = self._left.partition(b"\0")
        return json.loads(message)


def _is_bad_call(event):
    return event.get("method") == "Runtime.consoleAPICalled" and event["params"]["type"] in {"error", "warning"}


@contextmanager
def browser() -> Iterator[Browser]:
    """Give a browser, and end it with all that it has started."""
    to_read, write = os.pipe()
    read, to_write = os.pipe()
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as home:
        # The browser reads from its descriptor 3 and writes to 4.
        moved = f'exec 3<&{to_read} 4>&{to_write}; exec "$@"'
        words = ["bash", "-c", moved, "bash", CHROMIUM, *OPTIONS, f"--user-data-dir={home}", "about:blank"]
        process = subprocess.Popen(
            words, pass_fds=(to_read, to_write), stderr=subprocess.DEVNULL, start_new_session=True
        )
        os.close(to_read)
        os.close(to_write)
        try:
            yield Browser(write, read)
        finally:
            os.close(write)
            os.close(read)
            with suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()

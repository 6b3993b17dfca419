"""A headless Chromium that opens one page and is controlled through the DevTools protocol."""

import itertools
import json
import shutil
import subprocess
import time
import urllib.request

import pytest

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")


class Browser:
    """A browser with one open page, for use in a `with` statement."""

    def __init__(self, url, directory, size=(900, 700)):
        if CHROMIUM is None:
            pytest.skip("chromium is not installed")
        self._client = pytest.importorskip("websockets.sync.client")
        self._process = subprocess.Popen(
            [CHROMIUM, "--headless=new", "--no-sandbox", "--use-angle=swiftshader",
             "--enable-unsafe-swiftshader", "--remote-debugging-port=0", "--no-first-run",
             f"--user-data-dir={directory}", f"--window-size={size[0]},{size[1]}", url],
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        )  # fmt: skip
        self._numbers = itertools.count(1)
        self._socket = self._connect(directory)

    def _connect(self, directory):
        for _ in range(300):
            time.sleep(0.1)
            try:
                port = (directory / "DevToolsActivePort").read_text().split()[0]
                with urllib.request.urlopen(f"http://127.0.0.1:{port}/json") as answer:
                    pages = [p for p in json.load(answer) if p["type"] == "page"]
                if pages:
                    return self._client.connect(pages[0]["webSocketDebuggerUrl"], max_size=None)
            except OSError:
                continue
        raise AssertionError("chromium did not start within 30 s")

    def call(self, method, **parameters):
        """Calls a method of the DevTools protocol and returns its result."""
        number = next(self._numbers)
        self._socket.send(json.dumps({"id": number, "method": method, "params": parameters}))
        while True:
            answer = json.loads(self._socket.recv(timeout=60))
            if answer.get("id") == number:
                assert "error" not in answer, answer
                return answer["result"]

    def mouse(self, kind, x, y, pressed=True):
        """Sends a mouse event such as "mouseMoved" at a pixel, with the left button down or up."""
        self.call(
            "Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left",
            buttons=int(pressed), clickCount=1,
        )  # fmt: skip

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._socket.close()
        self._process.terminate()
        self._process.wait(20)

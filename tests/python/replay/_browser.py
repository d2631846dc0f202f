"""Chromium without a window, told what to do through two pipes: pages are opened, scripts run in them, the
mouse clicks, pictures are taken. [Chrome DevTools Protocol,
https://chromedevtools.github.io/devtools-protocol]"""

from __future__ import annotations

import base64
import fcntl
import json
import os
import select
import shutil
import subprocess
import time
from pathlib import Path
from typing import Any

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
_FLAGS = (
    "--headless", "--no-sandbox", "--disable-gpu-sandbox", "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader", "--disable-quic", "--no-first-run", "--disable-background-networking",
    "--disable-component-update", "--disable-sync", "--hide-scrollbars", "--remote-debugging-pipe",
    "--force-device-scale-factor=1", "--host-resolver-rules=MAP * ~NOTFOUND",
)  # fmt: skip
#: Graphics without a graphics card on a busy machine take their time [s].
_PATIENCE = 120.0
_ENDS = (3, 4)  # of the pipes in the browser: it reads from 3 and writes to 4

#: Goes first into every page: what it complains of, and what it asks for.
_WATCH = """
window.told = { errors: [] };
addEventListener("error", (event) => told.errors.push(String(event.message)));
addEventListener("unhandledrejection", (event) => told.errors.push(String(event.reason)));
addEventListener("securitypolicyviolation", (event) => told.errors.push(`blocked: ${event.blockedURI}`));
for (const kind of ["error", "warn"]) console[kind] = (...words) => told.errors.push(words.join(" "));
"""

#: For scripts of tests.
_HELPERS = """
const wait = (ms) => new Promise((done) => setTimeout(done, ms));
const drawn = async () => {
  for (let i = 0; i < 3; ++i) await new Promise(requestAnimationFrame);
};
const choose = async (id, value) => {
  byId(id).value = value;
  for (const kind of ["input", "change"]) byId(id).dispatchEvent(new Event(kind));
  await drawn();
};
const press = async (element) => { element.click(); await drawn(); };
const pixels = (canvas) => {
  const copy = document.createElement("canvas");
  [copy.width, copy.height] = [canvas.width, canvas.height];
  const context = copy.getContext("2d", { willReadFrequently: true });
  context.drawImage(canvas, 0, 0);
  return context.getImageData(0, 0, copy.width, copy.height);
};
const at = (canvas, x, y) => {
  const { data, width } = pixels(canvas), ratio = canvas.width / canvas.clientWidth;
  return [...data.slice(4 * (Math.round(y * ratio) * width + Math.round(x * ratio))).slice(0, 4)];
};
const count = (canvas, wanted) => {
  const { data } = pixels(canvas);
  let n = 0;
  for (let i = 0; i < data.length; i += 4) n += wanted(...data.subarray(i, i + 4)) ? 1 : 0;
  return n;
};
"""


class Browser:
    """A page in a browser; ``with Browser(page, folder) as browser``. ``folder`` gets its profile."""

    def __init__(self, page: Path, folder: Path, size: tuple[int, int] = (1280, 800)) -> None:
        ends = [_high(end) for _ in range(2) for end in os.pipe()]  # read and write, of two pipes
        self._to, self._from = ends[1], ends[2]

        def take_ends() -> None:
            os.dup2(ends[0], _ENDS[0])
            os.dup2(ends[3], _ENDS[1])

        words = [
            str(CHROMIUM),
            *_FLAGS,
            f"--user-data-dir={folder / 'profile'}",
            f"--window-size={size[0]},{size[1]}",
        ]
        self._process = subprocess.Popen(
            [*words, "about:blank"], preexec_fn=take_ends, pass_fds=_ENDS,
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        )  # fmt: skip
        os.close(ends[0])
        os.close(ends[3])
        self._count, self._rest, self._session = 0, b"", ""
        #: Addresses that were asked for.
        self.requests: list[str] = []
        try:
            self._open(page, size)
        except BaseException:
            self.close()
            raise

    def _open(self, page: Path, size: tuple[int, int]) -> None:
        target = self.send("Target.createTarget", url="about:blank")["targetId"]
        self._session = self.send("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Network"):
            self.send(f"{domain}.enable")
        metrics = {"deviceScaleFactor": 1, "mobile": False}
        self.send("Emulation.setDeviceMetricsOverride", width=size[0], height=size[1], **metrics)
        self.send("Page.addScriptToEvaluateOnNewDocument", source=_WATCH)
        self.requests = []
        self.send("Page.navigate", url=f"file://{page}")
        deadline = time.monotonic() + _PATIENCE
        while self.run("return document.body && document.body.dataset.state") is None:
            assert time.monotonic() < deadline, "the page did not open in time"
            time.sleep(0.05)
        self.run("await drawn()")

    def send(self, method: str, **params: Any) -> dict[str, Any]:
        """The answer to a command."""
        self._count += 1
        message = {"id": self._count, "method": method, "params": params}
        if self._session:
            message["sessionId"] = self._session
        os.write(self._to, json.dumps(message).encode() + b"\0")
        while True:
            answer = self._read()
            if answer.get("method") == "Network.requestWillBeSent":
                self.requests.append(answer["params"]["request"]["url"])
            if answer.get("id") == self._count:
                assert "error" not in answer, answer
                result: dict[str, Any] = answer["result"]
                return result

    def _read(self) -> dict[str, Any]:
        deadline = time.monotonic() + _PATIENCE
        while b"\0" not in self._rest:
            left = deadline - time.monotonic()
            assert left > 0.0, "the browser did not answer in time"
            if select.select([self._from], [], [], left)[0]:
                data = os.read(self._from, 1 << 20)
                assert data, "the browser has ended"
                self._rest += data
        text, self._rest = self._rest.split(b"\0", 1)
        message: dict[str, Any] = json.loads(text)
        return message

    def run(self, script: str) -> Any:
        """What the body of an asynchronous function returns in the page."""
        code = f"(async () => {{ {_HELPERS} {script} }})()"
        answer = self.send("Runtime.evaluate", expression=code, awaitPromise=True, returnByValue=True)
        assert "exceptionDetails" not in answer, answer["exceptionDetails"]
        return answer["result"].get("value")

    def click(self, x: float, y: float) -> None:
        """Of the left button at a pixel of the page."""
        for kind in ("mousePressed", "mouseReleased"):
            self.send("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", clickCount=1)
        self.run("await drawn()")

    def key(self, key: str) -> None:
        """Pressed and let go."""
        for kind in ("keyDown", "keyUp"):
            self.send("Input.dispatchKeyEvent", type=kind, key=key)
        self.run("await drawn()")

    def picture(self, path: Path) -> None:
        """What is to be seen, as a PNG file."""
        path.write_bytes(base64.b64decode(self.send("Page.captureScreenshot", format="png")["data"]))

    @property
    def errors(self) -> list[str]:
        """What the page complained of."""
        errors: list[str] = self.run("return told.errors")
        return errors

    def close(self) -> None:
        """Ends the browser."""
        self._process.terminate()
        self._process.wait()
        os.close(self._to)
        os.close(self._from)

    def __enter__(self) -> Browser:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def _high(end: int) -> int:
    """The same end of a pipe with a number that is none of those of the browser."""
    moved = fcntl.fcntl(end, fcntl.F_DUPFD_CLOEXEC, 10)
    os.close(end)
    return moved

"""Firefox, driven over its WebDriver BiDi socket: what it shows, asks for and complains of."""

from __future__ import annotations

import asyncio
import base64
import json
import os
import re
import shutil
import subprocess
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from threading import Thread
from typing import Any, final

from tornado.websocket import WebSocketClientConnection, websocket_connect

PREFERENCES: dict[str, bool | int | str] = {
    "app.update.enabled": False,
    "browser.shell.checkDefaultBrowser": False,
    "browser.startup.homepage_override.mstone": "ignore",
    "datareporting.policy.dataSubmissionEnabled": False,
    "network.captive-portal-service.enabled": False,
    "network.connectivity-service.enabled": False,
    "ui.prefersReducedMotion": 1,
    "webgl.force-enabled": True,
}
PATIENCE = 120.0  # seconds for an answer


@final
class Firefox:
    """A running Firefox with one tab.

    Args:
        address: of its BiDi socket.
    """

    def __init__(self, address: str) -> None:
        self._events: list[dict[str, Any]] = []
        self._calls = 0
        # a loop in a thread of its own: another browser's driver may run one in this thread
        self._loop = asyncio.new_event_loop()
        Thread(target=self._loop.run_forever, daemon=True).start()
        self._socket: WebSocketClientConnection = self._wait(_connected(f"{address}/session"))
        self.call("session.new", capabilities={})
        self.call("session.subscribe", events=["log.entryAdded", "network.beforeRequestSent"])
        self._tab: str = self.call("browsingContext.getTree")["contexts"][0]["context"]
        self.resize(920, 560)

    def _wait(self, work: Any) -> Any:
        return asyncio.run_coroutine_threadsafe(work, self._loop).result(PATIENCE)

    def call(self, method: str, **parameters: Any) -> dict[str, Any]:
        """Send a command and return its result; events that come before it are kept."""
        self._calls += 1
        result: dict[str, Any] = self._wait(self._answer(self._calls, method, parameters))
        return result

    async def _answer(self, number: int, method: str, parameters: dict[str, Any]) -> dict[str, Any]:
        await self._socket.write_message(
            json.dumps({"id": number, "method": method, "params": parameters})
        )
        while (text := await self._socket.read_message()) is not None:
            message = json.loads(text)
            if message.get("id") != number:
                self._events.append(message)
            elif message["type"] == "error":
                raise AssertionError(f"{method}: {message['error']}: {message['message']}")
            else:
                return dict(message["result"])
        raise AssertionError(f"{method}: Firefox closed its socket")

    def open(self, address: str) -> None:
        """Open a page, and wait until it is ready or says why not."""
        # a page of a view that has ended looks for its server until it is left
        self.call("browsingContext.navigate", context=self._tab, url="about:blank", wait="complete")
        self._events.clear()
        self.call("browsingContext.navigate", context=self._tab, url=address, wait="complete")
        notice = self.js(
            """(async () => { const notice = document.getElementById('notice');
            while (!document.body.classList.contains('ready') && notice.hidden)
                await new Promise(done => setTimeout(done, 20));
            return notice.textContent; })()"""
        )
        assert notice == ""

    def js(self, expression: str) -> Any:
        """Return what an expression, or the promise it gives, comes to."""
        result = self.call(
            "script.evaluate",
            expression=f"(async () => JSON.stringify(await ({expression})))()",
            target={"context": self._tab},
            awaitPromise=True,
        )
        assert result["type"] == "success", result
        return json.loads(result["result"].get("value", "null"))

    def seek(self, t: float) -> None:
        """Stop the clock at a time and wait for two pictures, so that the scene has followed."""
        self.js(
            f"""(mecanique.clock.pause(), mecanique.clock.seek({t!r}),
            new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done))))"""
        )

    def press(self, key: str) -> None:
        actions = [{"type": "keyDown", "value": key}, {"type": "keyUp", "value": key}]
        keyboard = {"type": "key", "id": "keyboard", "actions": actions}
        self.call("input.performActions", context=self._tab, actions=[keyboard])

    def point(self, *steps: tuple[str, Sequence[float]]) -> None:
        """Move the mouse, and press and release its button."""
        actions: list[dict[str, Any]] = []
        for kind, (x, y) in steps:
            if kind == "move":
                place = {"x": round(x), "y": round(y)}
                actions.append({"type": "pointerMove", **place, "duration": 30})
            else:
                actions.append({"type": f"pointer{kind.capitalize()}", "button": 0})
        mouse = {"type": "pointer", "id": "mouse", "actions": actions}
        self.call("input.performActions", context=self._tab, actions=[mouse])

    def resize(self, width: int, height: int) -> None:
        size = {"width": width, "height": height}
        self.call("browsingContext.setViewport", context=self._tab, viewport=size)

    def screenshot(self) -> bytes:
        return base64.b64decode(
            self.call("browsingContext.captureScreenshot", context=self._tab)["data"]
        )

    def requests(self) -> list[str]:
        """What the page asked for, but for what is written in it."""
        asked = [
            e["params"]["request"]["url"]
            for e in self._events
            if e["method"] == "network.beforeRequestSent"
        ]
        return [url for url in asked if not url.startswith(("data:", "blob:"))]

    def complaints(self) -> list[str]:
        logged = [event["params"] for event in self._events if event["method"] == "log.entryAdded"]
        return [entry["text"] for entry in logged if entry["level"] in ("warn", "error")]

    def close(self) -> None:
        self.call("browser.close")
        self._loop.call_soon_threadsafe(self._loop.stop)


async def _connected(address: str) -> WebSocketClientConnection:
    return await websocket_connect(address, max_message_size=1 << 28)


def missing() -> str:
    """Say what is not installed; WebGL without a graphics card needs a display, even in memory."""
    if _program() is None:
        return "no Firefox found; install Debian's firefox-esr or set MECANIQUE_FIREFOX to its path"
    if "DISPLAY" not in os.environ and shutil.which("Xvfb") is None:
        return "no display for Firefox's WebGL; install Debian's xvfb"
    return ""


def _program() -> str | None:
    return (
        os.environ.get("MECANIQUE_FIREFOX")
        or shutil.which("firefox-esr")
        or shutil.which("firefox")
    )


@contextmanager
def firefox(profile: Path) -> Iterator[Firefox]:
    """Start Firefox with a new profile, and end it.

    Args:
        profile: an empty directory.
    """
    lines = [
        f"user_pref({json.dumps(name)}, {json.dumps(value)});"
        for name, value in PREFERENCES.items()
    ]
    (profile / "user.js").write_text("\n".join(lines), encoding="utf-8")
    program = _program()
    assert program is not None
    command = [
        program,
        "--headless",
        "--no-remote",
        "--profile",
        str(profile),
        "--remote-debugging-port",
        "0",
    ]
    with (
        _display() as display,
        _running([*command, "about:blank"], DISPLAY=display, HOME=str(profile)) as process,
    ):
        started = Firefox(_told(process, r"WebDriver BiDi listening on (ws://\S+)"))
        yield started
        started.close()
        process.wait(PATIENCE)


@contextmanager
def _display() -> Iterator[str]:
    if "DISPLAY" in os.environ:
        yield os.environ["DISPLAY"]
        return
    command = ["Xvfb", "-displayfd", "2", "-screen", "0", "1280x960x24", "-nolisten", "tcp"]
    with _running(command) as process:
        yield ":" + _told(process, r"^(\d+)$")


@contextmanager
def _running(command: list[str], **environment: str) -> Iterator[subprocess.Popen[str]]:
    with subprocess.Popen(
        command,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        encoding="utf-8",
        env=os.environ | environment,
    ) as process:
        try:
            yield process
        finally:
            process.terminate()


def _told(process: subprocess.Popen[str], pattern: str) -> str:
    """What a process writes to its error stream; the rest is read too, so that it never waits."""
    stream = process.stderr
    assert stream is not None
    heard = []
    for line in stream:
        if found := re.search(pattern, line):
            Thread(target=stream.read, daemon=True).start()
            return found[1]
        heard.append(line)
    raise AssertionError(f"{process.args!r} ended before it was ready: {heard}")

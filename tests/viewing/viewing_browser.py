"""A real browser that watches itself: every request, console message and page error is recorded."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from playwright.sync_api import ConsoleMessage, Dialog, Page

FLAGS = (
    "--no-sandbox --disable-quic --no-first-run --disable-background-networking"
    " --disable-component-update --disable-sync --use-gl=angle --use-angle=swiftshader"
    " --enable-unsafe-swiftshader --ignore-gpu-blocklist"
    # without a graphics card, letters are drawn and layers joined faster by the processor itself
    " --disable-gpu-rasterization --disable-gpu-compositing"
    # no second page, for an address bar that nobody sees; the others are Playwright's own
    " --disable-features=WebUIOmniboxPopup,WebUIOmniboxAimPopup,PaintHolding,HttpsUpgrades"
    ",MediaRouter,OptimizationHints,DestroyProfileOnBrowserClose"
)

COPIED = "GPU stall due to ReadPixels"
"""Chromium's own note where the processor joins layers: each picture of WebGL is copied to it."""

PAUSE = 0.05
"""Between two questions of whether something has happened [s]: each costs a page 7 ms."""

# Some 20 pictures a second, of nothing: each call reaches WebGL, which checks it as ever, but there
# is nothing left to draw.
UNDRAWN = """
{
  const next = window.requestAnimationFrame.bind(window);
  window.requestAnimationFrame = (then) => setTimeout(() => next(then), 35);
}
for (const { prototype } of [WebGLRenderingContext, WebGL2RenderingContext]) {
  const { drawArrays, drawElements } = prototype;
  prototype.drawArrays = function (mode, first) {
    drawArrays.call(this, mode, first, 0);
  };
  prototype.drawElements = function (mode, count, type, offset) {
    drawElements.call(this, mode, 0, type, offset);
  };
}
"""


def until(condition: Callable[[], bool], seconds: float = 60.0) -> None:
    """Wait for something to happen."""
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "it did not happen in time"
        time.sleep(PAUSE)


@dataclass
class Visit:
    """A page that was opened, and what happened while it was open."""

    page: Page
    requests: list[str] = field(default_factory=list)
    messages: list[str] = field(default_factory=list)
    errors: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.heard: dict[Any, Callable[[Any], None]] = {
            "request": lambda request: self.requests.append(request.url),
            "console": self.hear,
            "pageerror": lambda error: self.errors.append(str(error)),
            "dialog": self.dismiss,
        }
        for event, listener in self.heard.items():
            self.page.on(event, listener)

    def hear(self, message: ConsoleMessage) -> None:
        if message.type in ("error", "warning") and COPIED not in message.text:
            self.messages.append(f"{message.type}: {message.text}")

    def dismiss(self, dialog: Dialog) -> None:
        self.errors.append(f"a dialog: {dialog.message}")
        dialog.dismiss()

    def leave(self) -> None:
        """Leave a blank page, as good as a fresh one."""
        for event, listener in self.heard.items():
            self.page.remove_listener(event, listener)
        if self.page.url.startswith("file:"):  # files share what they store; servers have ports
            self.page.evaluate("sessionStorage.clear()")
        self.page.goto("about:blank")
        self.page.mouse.move(-1, -1)

    def js(self, expression: str, argument: Any = None) -> Any:
        return self.page.evaluate(expression, argument)

    def seek(self, t: float) -> None:
        """Stop the clock at a time and wait for two pictures, so that the scene has followed."""
        self.js("t => { mecanique.clock.pause(); mecanique.clock.seek(t); }", t)
        self.settle()

    def until(self, expression: str) -> None:
        """Wait for a condition, asked from here: the page's own policy forbids evaluation later."""
        for _ in range(2400):
            if self.js(expression):
                return
            self.page.wait_for_timeout(1000 * PAUSE)
        raise AssertionError(f"never became true: {expression}")

    def settle(self, pictures: int = 2) -> None:
        """Wait for some pictures."""
        self.js(
            """async (pictures) => {
                for (let k = 0; k < pictures; k++) await new Promise(requestAnimationFrame);
            }""",
            pictures,
        )

    def body(self, k: int) -> list[float]:
        """Position and quaternion of a body in the viewer's scene, in a mechanism's axes."""
        found = self.js(
            """k => {
                const { position, quaternion } = mecanique.stage.nodes[k];
                return [...position.toArray(), ...quaternion.toArray()];
            }""",
            k,
        )
        return [float(x) for x in found]

    def clean(self) -> None:
        """Nothing was requested but the page itself, and nothing was complained about."""
        assert self.requests[1:] == []
        assert self.messages == []
        assert self.errors == []

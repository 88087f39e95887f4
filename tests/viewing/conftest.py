"""A real browser that watches itself: every request, console message and page error is recorded."""

from __future__ import annotations

import os
import shutil
import signal
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, ConsoleMessage, Page, sync_playwright
from playwright.sync_api import Error as PlaywrightError
from viewing_scenes import write_page

from mecanique.viewing.scene.scene import Scene

FLAGS = (
    "--no-sandbox --disable-quic --no-first-run --disable-background-networking"
    " --disable-component-update --disable-sync --use-gl=angle --use-angle=swiftshader"
    " --enable-unsafe-swiftshader --ignore-gpu-blocklist"
)


@pytest.fixture(autouse=True)
def interruptible() -> Iterator[None]:
    """Let Ctrl-C work here and in what is started from here, even in a background job."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@dataclass
class Visit:
    """A page that was opened, and what happened while it was open."""

    page: Page
    requests: list[str] = field(default_factory=list)
    messages: list[str] = field(default_factory=list)
    errors: list[str] = field(default_factory=list)

    def hear(self, message: ConsoleMessage) -> None:
        if message.type in ("error", "warning"):
            self.messages.append(f"{message.type}: {message.text}")

    def js(self, expression: str, argument: Any = None) -> Any:
        return self.page.evaluate(expression, argument)

    def seek(self, t: float) -> None:
        """Stop the clock at a time and wait for two pictures, so that the scene has followed."""
        self.js("t => { mecanique.clock.pause(); mecanique.clock.seek(t); }", t)
        self.settle()

    def settle(self) -> None:
        self.js(
            "() => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))"
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


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    path = (
        os.environ.get("MECANIQUE_CHROMIUM")
        or shutil.which("chromium")
        or shutil.which("chromium-browser")
    )
    if path is None:
        reason = (
            "no Chromium found; install Debian's chromium or set MECANIQUE_CHROMIUM to its path"
        )
        if "chromium" in os.environ.get("MECANIQUE_REQUIRE_BROWSERS", ""):
            pytest.fail(reason)
        pytest.skip(reason)
    with sync_playwright() as playwright:
        started = playwright.chromium.launch(executable_path=path, args=FLAGS.split())
        yield started
        started.close()


@pytest.fixture
def visit(browser: Browser) -> Iterator[Callable[..., Visit]]:
    """Open an address in a fresh page; keywords go to the browser's context."""
    contexts = []

    def open_(address: str, *, wait: bool = True, **options: Any) -> Visit:
        # pages that do not start by themselves leave the machine free for the rest of the tests
        usual: dict[str, Any] = {
            "viewport": {"width": 920, "height": 560},
            "reduced_motion": "reduce",
        }
        context = browser.new_context(**(usual | options))
        contexts.append(context)
        seen = Visit(context.new_page())
        seen.page.on("request", lambda request: seen.requests.append(request.url))
        seen.page.on("console", seen.hear)
        seen.page.on("pageerror", lambda error: seen.errors.append(str(error)))
        seen.page.goto(address)
        if wait:
            try:
                seen.page.wait_for_selector("body.ready", timeout=60_000)
            except PlaywrightError as error:
                raise AssertionError(
                    f"the page did not start: {seen.messages} {seen.errors}"
                ) from error
        return seen

    yield open_
    for context in contexts:
        context.close()


@pytest.fixture
def show(visit: Callable[..., Visit], tmp_path: Path) -> Callable[..., Visit]:
    """Write a scene's page and open it without any network."""

    def open_(scene: Scene, **options: Any) -> Visit:
        path = write_page(scene, tmp_path / "page.html")
        return visit(path.as_uri(), offline=True, **options)

    return open_

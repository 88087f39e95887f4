"""A browser for all tests of the room, and pages opened in it."""

from __future__ import annotations

import os
import shutil
import signal
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, sync_playwright
from playwright.sync_api import Error as PlaywrightError
from viewing_browser import FLAGS, Visit
from viewing_scenes import write_page

from mecanique.viewing.scene.scene import Scene


@pytest.fixture(autouse=True)
def interruptible() -> Iterator[None]:
    """Let Ctrl-C work here and in what is started from here, even in a background job."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


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
            "device_scale_factor": 0.5,
        }
        context = browser.new_context(**(usual | options))
        contexts.append(context)
        context.set_default_timeout(120_000)
        seen = Visit(context.new_page())
        seen.page.on("request", lambda request: seen.requests.append(request.url))
        seen.page.on("console", seen.hear)
        seen.page.on("pageerror", lambda error: seen.errors.append(str(error)))
        seen.page.goto(address)
        if wait:
            try:
                seen.page.wait_for_selector("body.ready")
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

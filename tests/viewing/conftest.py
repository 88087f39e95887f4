"""A browser for all tests of the room, and pages opened in it."""

from __future__ import annotations

import os
import shutil
import signal
from collections import defaultdict
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, Page, sync_playwright
from playwright.sync_api import Error as PlaywrightError
from viewing_browser import FLAGS, UNDRAWN, Visit
from viewing_firefox import Firefox, firefox, missing
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


@pytest.fixture(scope="session")
def fox(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Firefox]:
    if reason := missing():
        if "firefox" in os.environ.get("MECANIQUE_REQUIRE_BROWSERS", ""):
            pytest.fail(reason)
        pytest.skip(reason)
    with firefox(tmp_path_factory.mktemp("firefox")) as started:
        yield started


@pytest.fixture(scope="session")
def spare() -> dict[str, list[Page]]:
    """Pages that tests are done with, by what they were opened with."""
    return defaultdict(list)


@pytest.fixture
def visit(browser: Browser, spare: dict[str, list[Page]]) -> Iterator[Callable[..., Visit]]:
    """Open an address in a page of its own; keywords go to the browser's context.

    The picture is `drawn` only where a test looks at it: without a graphics card that takes as long
    as all else that a page does. Each page serves one test after another: to fill a blank one takes
    half as long as to open one.
    """
    visits: list[tuple[str, Visit]] = []

    def open_(address: str, *, wait: bool = True, drawn: bool = False, **options: Any) -> Visit:
        # pages that do not start by themselves leave the machine free for the rest of the tests
        usual: dict[str, Any] = {
            "viewport": {"width": 920, "height": 560},
            "reduced_motion": "reduce",
            "device_scale_factor": 0.5,
        }
        kind = repr((drawn, sorted(options.items())))
        if spare[kind]:
            page = spare[kind].pop()
        else:
            context = browser.new_context(**(usual | options))
            context.set_default_timeout(120_000)
            if not drawn:
                context.add_init_script(UNDRAWN)
            page = context.new_page()
        seen = Visit(page)
        visits.append((kind, seen))
        page.goto(address)
        if wait:
            try:
                page.wait_for_selector("body.ready")
            except PlaywrightError as error:
                raise AssertionError(
                    f"the page did not start: {seen.messages} {seen.errors}"
                ) from error
        return seen

    yield open_
    for kind, seen in visits:
        seen.leave()
        spare[kind].append(seen.page)


@pytest.fixture
def show(visit: Callable[..., Visit], tmp_path: Path) -> Callable[..., Visit]:
    """Write a scene's page and open it without any network."""

    def open_(scene: Scene, **options: Any) -> Visit:
        path = write_page(scene, tmp_path / "page.html")
        return visit(path.as_uri(), offline=True, **options)

    return open_

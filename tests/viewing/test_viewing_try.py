"""The documentation's page that runs Python in the browser."""

from __future__ import annotations

import os
import shutil
import sys
import threading
from collections.abc import Iterator
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
from playwright.sync_api import Browser

import mecanique as mq

DOCS = Path(__file__).parents[2] / "docs"
DISTRIBUTION = os.environ.get("MECANIQUE_PYODIDE", "")
"""Folder of Pyodide's distribution, which no registry offers."""

# answers as Pyodide does, and knows no Python
STUB = """
export async function loadPyodide() {
  const modules = {};
  const files = {};
  return {
    FS: { writeFile(name, bytes) { files[name] = new TextDecoder().decode(bytes); } },
    setStdout() {},
    async loadPackagesFromImports(text) { this.asked = text; },
    async loadPackage(names) { if (names.join() !== "numpy,scipy,sympy") throw new Error(names); },
    unpackArchive(bytes, kind) {
      if (kind !== "zip" || bytes.byteLength < 1e6) throw new Error("no archive");
    },
    registerJsModule(name, module) { modules[name] = module; },
    runPython(text) { if (!text.includes("def show")) throw new Error("no show"); },
    async runPythonAsync(text) {
      if (text !== this.asked) throw new Error("its imports were not asked for");
      if (text.includes("wrong")) throw new Error("NameError: wrong");
      modules.mecanique_page.put("<math><mi>q</mi></math>", "");
      modules.mecanique_page.put("", "<b>as text</b>");
      for (const name in files) modules.mecanique_page.offer(`copy of ${name}`, files[name]);
    },
  };
}
"""


class Quiet(SimpleHTTPRequestHandler):
    """Hands out files without a word."""

    def log_message(self, *_: object) -> None:
        pass


@pytest.fixture
def site(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[tuple[Path, str]]:
    """The page as it is built, on a server of its own: its folder and its address."""
    monkeypatch.syspath_prepend(DOCS)
    from pack import pack

    sys.modules.pop("pack")
    folder = tmp_path / "try"
    shutil.copytree(DOCS / "try", folder)
    pack(folder / "mecanique.zip")
    server = ThreadingHTTPServer(("127.0.0.1", 0), partial(Quiet, directory=str(folder)))
    thread = threading.Thread(target=server.serve_forever)
    thread.start()
    yield folder, f"http://127.0.0.1:{server.server_port}/index.html"
    server.shutdown()
    thread.join()
    server.server_close()


def test_it_shows_what_a_program_shows_and_why_it_stops(
    site: tuple[Path, str], browser: Browser
) -> None:
    folder, address = site
    page = browser.new_page()
    page.goto(f"{address}?pyodide=https://example.org/")
    assert page.input_value("#folder") == "pyodide/"
    page.click("button")
    page.wait_for_selector("#shown .error")
    assert "Python could not be loaded from" in page.inner_text("#shown .error")
    (folder / "stub").mkdir()
    (folder / "stub" / "pyodide.mjs").write_text(STUB, encoding="utf-8")
    page.fill("#folder", "stub")
    page.click("button")
    page.wait_for_selector("#shown math")
    assert page.inner_text("#shown pre") == "<b>as text</b>"
    assert page.inner_text("#state") == "Done."
    page.fill("#program", "wrong")
    page.click("button")
    page.wait_for_selector("#shown .error")
    assert page.inner_text("#shown") == "NameError: wrong"
    page.close()


def test_files_are_given_to_the_program_and_offered_by_it(
    site: tuple[Path, str], browser: Browser, tmp_path: Path
) -> None:
    folder, address = site
    (folder / "stub").mkdir()
    (folder / "stub" / "pyodide.mjs").write_text(STUB, encoding="utf-8")
    file = tmp_path / "arm.urdf"
    file.write_text("<robot/>", encoding="utf-8")
    page = browser.new_page()
    page.goto(address)
    page.select_option("#example", "convert")
    assert page.input_value("#program") == text_of("CONVERT")
    page.fill("#folder", "stub")
    page.set_input_files("#files", file)
    page.click("button")
    link = page.wait_for_selector("#shown a")
    assert link is not None
    assert link.inner_text() == "Save copy of arm.urdf"
    with page.expect_download() as download:
        link.click()
    assert download.value.suggested_filename == "copy of arm.urdf"
    assert Path(download.value.path()).read_text(encoding="utf-8") == "<robot/>"
    page.close()


def text_of(constant: str) -> str:
    """A text of the page's script."""
    script = (DOCS / "try" / "try.js").read_text(encoding="utf-8")
    return script.partition(f"const {constant} = `")[2].partition("`;")[0]


def test_the_program_that_converts_proves_what_it_saves() -> None:
    shown: list[Any] = []
    saved: dict[str, str] = {}
    names = {"show": shown.append, "save": saved.__setitem__}
    exec(text_of("CONVERT"), names)
    assert list(saved) == ["arm.xml", "arm.sdf", "arm.urdf"]
    assert all(conversion.worst <= 1e-12 for conversion in shown)
    assert {mq.read(text).nv for text in saved.values()} == {1}


def test_results_are_shown_as_html_as_pictures_or_as_text(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("matplotlib")
    shown: list[tuple[str, str]] = []
    page = ModuleType("mecanique_page")
    vars(page)["put"] = lambda html, text: shown.append((html, text))
    monkeypatch.setitem(sys.modules, "mecanique_page", page)
    names: dict[str, Any] = {}
    exec(text_of("SHOW"), names)
    pendulum = mq.textbook.load("rigid_bar_pendulum")
    motion = mq.simulate(pendulum, q={"q": 1.0}, duration=1.0, samples=31)
    names["show"](mq.derive(pendulum), motion.plot(), motion.summary())
    (equations, _), (plot, _), (nothing, text) = shown
    assert "<math" in equations
    assert plot.startswith('<img src="data:image/png;base64,iVBORw0KGgo')
    assert (nothing, text) == ("", motion.summary())


def test_it_names_the_build_that_the_distribution_lacks(
    site: tuple[Path, str], browser: Browser
) -> None:
    """Pyodide's own loader, whose package on npm has Python alone."""
    folder, address = site
    core = DOCS.parent / "node_modules" / "pyodide"
    if not core.is_dir():
        pytest.skip("no Pyodide found; run npm install")
    (folder / "pyodide").symlink_to(core)
    page = browser.new_page()
    page.goto(address)
    page.click("button")
    page.wait_for_selector("#shown .error", timeout=120_000)
    assert "numpy" in page.inner_text("#shown .error")
    assert page.inner_text("#state") == "Stopped."
    page.close()


@pytest.mark.slow
@pytest.mark.skipif(not DISTRIBUTION, reason="MECANIQUE_PYODIDE names no distribution of Pyodide")
def test_it_derives_verifies_and_moves_a_mechanism(
    site: tuple[Path, str], browser: Browser
) -> None:
    folder, address = site
    (folder / "pyodide").symlink_to(Path(DISTRIBUTION).resolve())
    page = browser.new_page()
    page.goto(address)
    page.click("button")
    page.wait_for_selector("#shown iframe", timeout=300_000)
    assert page.locator("#shown svg").count() >= 1
    assert page.locator("#shown math").count() > 1
    assert "agrees" in page.inner_text("#shown caption")
    page.close()

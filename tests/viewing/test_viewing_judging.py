"""The page that judges formulas by itself, opened as a student opens it, and in a SCORM runtime."""

from __future__ import annotations

import json
import threading
import zipfile
from collections.abc import Iterator
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page

from mecanique.teaching import export_exercise, grade

ROOT = Path(__file__).parents[2]
RUNTIME = ROOT / "node_modules" / "scorm-again" / "dist" / "scorm12.min.js"
CART = "(M + m) x'' + m l cos q q'' - m l sin q q'^2 + c x' = F"
POLE = r"\ddot{x} \cos q + l \ddot{q} + g \sin q = 0"

ANSWERS = (
    (f"{CART}\n{POLE}", "Right."),
    (CART, "incomplete\n1 of 2 equations missing"),
    (f"{CART}\n{POLE.replace('+ g', '- g')}", "Wrong\nEquation 1: right\nEquation 2: wrong"),
    (f"{CART}\n{POLE.replace('+ g', '- g')}", "A likely cause: the sign of"),
    ("0 = 0", "it holds for any motion"),
    ("Lagrange says so", "cannot judge it\nthis page cannot read the letter"),
)


@pytest.fixture
def page(browser: Browser) -> Iterator[Page]:
    opened = browser.new_page(viewport={"width": 900, "height": 900})
    yield opened
    opened.close()


def answer(page: Page, text: str) -> str:
    page.fill("#answer", text)
    page.click("text=Judge")
    return page.inner_text("#verdict")


def test_a_page_judges_without_a_server(page: Page, tmp_path: Path) -> None:
    file = export_exercise("cart_pole", "page", tmp_path / "cart.html")
    troubles: list[str] = []
    page.on("console", lambda message: troubles.append(message.text))
    page.on("pageerror", lambda error: troubles.append(str(error)))
    page.on("request", lambda request: troubles.append(request.url))
    page.goto(file.as_uri())
    assert troubles == [file.as_uri()]
    assert page.locator("svg").bounding_box() is not None
    assert "Pendulum hanging from a cart" in page.inner_text("h1")
    for text, said in ANSWERS:
        assert said in answer(page, text)
    assert troubles == [file.as_uri()]


def test_what_a_page_leaves_to_the_teacher_is_graded(page: Page, tmp_path: Path) -> None:
    file = export_exercise("cart_pole", "page", tmp_path / "cart.html")
    page.goto(file.as_uri())
    page.fill("#answer", f"We find that\n{CART}\nand\n{POLE}")
    with page.expect_download() as download:
        page.click("text=Save for the teacher")
    (tmp_path / "answers").mkdir()
    download.value.save_as(tmp_path / "answers" / "anna.json")
    sheet = '[[question]]\nid = "cart_pole"\nsystem = "cart_pole"\n'
    (tmp_path / "sheet.toml").write_text(sheet, encoding="utf-8")
    grades = grade(tmp_path / "sheet.toml", tmp_path / "answers")
    assert grades.totals == {"anna": 1.0}


FRAME = """<!doctype html><script src="runtime.js"></script>
<script>window.API = new Scorm12API({ autocommit: false });</script>
<iframe src="index.html" width="800" height="700"></iframe>"""


class Quiet(SimpleHTTPRequestHandler):
    """Hands out files without a word."""

    def log_message(self, *_: object) -> None:
        pass


@pytest.fixture
def served(tmp_path: Path) -> Iterator[tuple[Path, str]]:
    server = ThreadingHTTPServer(("127.0.0.1", 0), partial(Quiet, directory=str(tmp_path)))
    thread = threading.Thread(target=server.serve_forever, daemon=True)
    thread.start()
    yield tmp_path, f"http://127.0.0.1:{server.server_port}"
    server.shutdown()
    server.server_close()
    thread.join()


@pytest.mark.skipif(not RUNTIME.exists(), reason="needs npm's scorm-again")
@pytest.mark.parametrize(
    ("text", "points", "status"),
    [
        (f"{CART}\n{POLE}", "100", "passed"),
        (CART, "50", "failed"),
        ("x'' = 0", "0", "failed"),
        ("as on the sheet", "", "incomplete"),
    ],
)
def test_a_scorm_runtime_gets_the_score(
    page: Page, served: tuple[Path, str], text: str, points: str, status: str
) -> None:
    folder, address = served
    archive = export_exercise("cart_pole", "scorm", folder / "cart.zip")
    with zipfile.ZipFile(archive) as opened:
        opened.extractall(folder)
    (folder / "runtime.js").write_bytes(RUNTIME.read_bytes())
    (folder / "frame.html").write_text(FRAME, encoding="utf-8")
    errors: list[str] = []
    page.on("pageerror", lambda error: errors.append(str(error)))
    page.goto(f"{address}/frame.html")
    frame = page.frame_locator("iframe")
    frame.locator("#answer").fill(text)
    frame.locator("text=Judge").click()
    core = json.loads(page.evaluate("JSON.stringify(API.cmi.core)"))
    assert core["score"]["raw"] == points
    assert (core["score"]["min"], core["score"]["max"]) == ("0", "100")
    assert core["lesson_status"] == status
    assert page.evaluate("API.cmi.suspend_data") == text
    page.evaluate("document.querySelector('iframe').remove()")
    page.wait_for_function("API.isTerminated()")
    assert page.evaluate("API.lmsGetLastError()") == "0"
    assert errors == []

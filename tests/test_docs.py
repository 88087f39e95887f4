"""Every cell of the documentation runs, every page is reached, and every public name is told."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import pytest

import mecanique as mq
from mecanique.urdf.dialect import OWN_NAMESPACE
from mecanique.urdf.rules import RULES

DOCS = Path(__file__).parents[1] / "docs"
PAGES = sorted(path for path in DOCS.rglob("*.md") if not {"_generated", "paper"} & set(path.parts))
CELL = re.compile(r"^```\{code-cell\}\n(.*?)^```$", re.DOTALL | re.MULTILINE)


@pytest.fixture
def generate(monkeypatch: pytest.MonkeyPatch) -> object:
    monkeypatch.syspath_prepend(DOCS)
    yield __import__("generate")
    sys.modules.pop("generate", None)


SLOW = {"closed_loops", "elements_that_guide"}


@pytest.mark.parametrize(
    "page",
    [
        pytest.param(path, id=path.stem, marks=[pytest.mark.slow] * (path.stem in SLOW))
        for path in PAGES
        if CELL.search(path.read_text(encoding="utf-8"))
    ],
)
def test_every_cell_runs(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    for number, text in enumerate(CELL.findall(page.read_text(encoding="utf-8"))):
        exec(compile(text, f"{page.name}, cell {number}", "exec"), names)


def test_every_page_is_in_a_table_of_contents() -> None:
    named: set[Path] = set()
    for page in PAGES:
        for block in re.findall(
            r"^```\{toctree\}\n(.*?)^```$", page.read_text("utf-8"), re.DOTALL | re.MULTILINE
        ):
            lines = [line for line in block.splitlines() if line and not line.startswith(":")]
            named.update((page.parent / f"{line}.md").resolve() for line in lines)
    assert {page.resolve() for page in PAGES} - named == {(DOCS / "index.md").resolve()}


def test_links_lead_somewhere() -> None:
    for page in PAGES:
        for link in re.findall(r"\]\(([^)#:]+)\)", page.read_text(encoding="utf-8")):
            assert (page.parent / link).exists(), f"{page.name}: {link}"


def test_every_public_name_stands_in_one_chapter(generate: object) -> None:
    pages = dict(generate.api_pages())  # type: ignore[attr-defined]
    text = "\n".join(pages.values())
    for name in mq.__all__:
        if name != "textbook":
            assert text.count(f":: mecanique.{name}\n") == 1, name


def test_tables_are_made_from_the_code(generate: object) -> None:
    rules = generate.lint_rules()  # type: ignore[attr-defined]
    assert all(f"| {code} |" in rules for code in RULES)
    assert "`drake:ball_constraint`" in generate.urdf_tags()  # type: ignore[attr-defined]
    measurements = generate.benchmarks()  # type: ignore[attr-defined]
    assert "bench_import.py` | Measure what starting costs" in measurements
    verdicts = generate.validation(["simple_pendulum"])  # type: ignore[attr-defined]
    assert "| `simple_pendulum` | agrees |" in verdicts


def test_the_page_on_urdf_lists_our_own_tags() -> None:
    from mecanique.urdf import dialect

    page = (DOCS / "urdf.md").read_text(encoding="utf-8")
    assert OWN_NAMESPACE in page
    for value in vars(dialect).values():
        if isinstance(value, str) and value.startswith("mecanique:"):
            assert f"`{value}`" in page

"""Every cell of the documentation runs, every page is reached, and every public name is told."""

from __future__ import annotations

import inspect
import re
import sys
from pathlib import Path

import pytest

import mecanique as mq
from mecanique.urdf.dialect import NAMESPACE
from mecanique.urdf.rules import RULES

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
PAGES = sorted(path for path in DOCS.rglob("*.md") if not {"_generated", "paper"} & set(path.parts))
LINK = re.compile(r"\]\(([^)\s]+)\)|(?:src|href)=\"([^\"]+)\"")
CELL = re.compile(r"^```\{code-cell\}\n(?::tags: .*\n)?(.*?)^```$", re.DOTALL | re.MULTILINE)


@pytest.fixture
def generate(monkeypatch: pytest.MonkeyPatch) -> object:
    monkeypatch.syspath_prepend(DOCS)
    yield __import__("generate")
    sys.modules.pop("generate", None)


SLOW = {"closed_loops", "elements_that_guide", "singular"}


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
    if page.stem == "tour":
        written = {path.name for path in tmp_path.iterdir()}
        assert written == {"controller", "motion.npz", "page.html", "cart_pole.urdf"}


def test_every_page_is_in_a_table_of_contents() -> None:
    named: set[Path] = set()
    for page in PAGES:
        for block in re.findall(
            r"^```\{toctree\}\n(.*?)^```$", page.read_text("utf-8"), re.DOTALL | re.MULTILINE
        ):
            lines = [line for line in block.splitlines() if line and not line.startswith(":")]
            named.update((page.parent / f"{line}.md").resolve() for line in lines)
    assert {page.resolve() for page in PAGES} - named == {(DOCS / "index.md").resolve()}


@pytest.mark.parametrize("page", [*PAGES, *ROOT.glob("*.md")], ids=lambda page: page.stem)
def test_links_lead_somewhere(page: Path) -> None:
    for link in LINK.findall(page.read_text(encoding="utf-8")):
        path, _, place = (link[0] or link[1]).partition("#")
        if ":" in path or "gallery/" in path:  # on the web, or written when the site is built
            continue
        there = page.parent / path if path else page
        assert there.exists(), link
        if place:
            assert place in headings(there.read_text(encoding="utf-8")), link


def headings(text: str) -> set[str]:
    """Return the anchors of a page's headings."""
    titles = re.findall(r"^#+ (.+)$", text, re.MULTILINE)
    return {re.sub(r"[^\w -]", "", title).lower().replace(" ", "-") for title in titles}


def test_every_public_name_stands_in_one_chapter(generate: object) -> None:
    pages = dict(generate.api_pages())  # type: ignore[attr-defined]
    overview = pages.pop("api_names")
    text = "\n".join(pages.values())
    for name in mq.__all__:
        assert text.count(f":: mecanique.{name}\n") == 1, name
        assert overview.count(f"<mecanique.{name}>`") == 1, name
    sections = dict(part.split("\n", 1) for part in pages["api_describe"].split("\n## ")[1:])
    for section, names in {"Bodies and shapes": "Body rod", "Expressions": "sin time"}.items():
        assert all(f":: mecanique.{name}\n" in sections[section] for name in names.split())
    assert "| A hinge: the child turns about an axis by its coordinate [rad]. |" in overview


def test_no_bars_of_a_docstring_are_taken_for_a_substitution() -> None:
    """What stands between bars is a name to be replaced, unless it is in backticks."""
    for name in mq.__all__:
        thing = getattr(mq, name)
        parts = [thing, *vars(thing).values()] if inspect.isclass(thing) else [thing]
        for part in parts:
            said = re.sub(r"`[^`]*`|^ +>>>.*$|^ +\.\.\. .*$", "", part.__doc__ or "", flags=re.M)
            assert not re.search(r"\|[^\s|][^|]*\|", said), f"{name}: {said}"


def test_tables_are_made_from_the_code(generate: object) -> None:
    rules = generate.lint_rules()  # type: ignore[attr-defined]
    assert all(f"| {code} |" in rules for code in RULES)
    assert "`drake:ball_constraint`" in generate.urdf_tags()  # type: ignore[attr-defined]
    measurements = generate.benchmarks()  # type: ignore[attr-defined]
    assert "| `bench_import.py` | Measure what starting costs" in measurements
    # (tau - m g l sin(q))/(m l l): m l is used twice
    assert "| `simple_pendulum` | 7 | 1 | 4 | 1 | 1 |" in generate.operations()  # type: ignore[attr-defined]
    forms = generate.forms(["simple_pendulum", "compound_pendulum"])  # type: ignore[attr-defined]
    assert "| `q'' + g sin(q)/l = 0` | Equations of motion | Whittaker, sect. 44 |" in forms
    assert "| elsewhere, or by a factor of parameters | Huygens, part IV:" in forms
    verdicts = generate.validation(["simple_pendulum"])  # type: ignore[attr-defined]
    assert "| `simple_pendulum` | agrees |" in verdicts


def test_the_page_on_urdf_lists_our_own_tags() -> None:
    from mecanique.urdf.dialect import SCREW
    from mecanique.urdf.reading.native_tags import NATIVE_TAGS

    page = (DOCS / "urdf.md").read_text(encoding="utf-8")
    assert NAMESPACE in page
    for tag in (SCREW, *NATIVE_TAGS):
        assert f"`{tag}`" in page


def test_signs_after_formulas_stay_with_them(monkeypatch: pytest.MonkeyPatch) -> None:
    nodes = pytest.importorskip("docutils.nodes")
    new_document = pytest.importorskip("docutils.utils").new_document
    monkeypatch.syspath_prepend(DOCS)
    conf = __import__("conf")
    sys.modules.pop("conf")
    parts = [nodes.Text("of "), nodes.math("", "a"), nodes.Text("; "), nodes.math("", "b")]
    tree = new_document("page")
    tree += nodes.paragraph("", "", *parts, nodes.Text(" then"))
    conf.keep_signs(None, tree, "page")
    ((before, kept, *rest),) = tree
    assert (before.astext(), kept.astext(), kept["classes"]) == ("of ", "a;", ["kept"])
    assert [part.astext() for part in rest] == [" ", "b", " then"]

"""The parts of the documentation that the code already says."""

from __future__ import annotations

import ast
import base64
import inspect
import os
import shutil
import textwrap
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import suppress
from html import escape
from importlib import import_module
from itertools import pairwise
from multiprocessing import get_context
from pathlib import Path

from pack import pack

import mecanique as mq
from mecanique.generation.build import build_program
from mecanique.lazy import find_homes
from mecanique.urdf.dialect import EXTENSIONS
from mecanique.urdf.rules import RULES
from mecanique.verification.facts import check_facts
from mecanique.viewing.gallery import Card, gallery

TRY = Path(__file__).parent / "try"
"""The page that runs Python in the browser."""
BENCHMARKS = Path(__file__).parents[1] / "tests" / "benchmarks"
ALIASES = {"AnyForce": "mecanique.model.force_base", "Joint": "mecanique.model.joints"}
"""Where names of several classes together are defined, and what they are is said below them."""
SAMPLES = 20
"""States of each verdict in the table of validation."""
COUNTED = (
    "simple_pendulum",
    "double_pendulum",
    "cart_pole",
    "gyroscope",
    "slider_crank",
    "four_bar_linkage",
    "squeezer",
    "whipple_bicycle",
)
"""Systems whose operations are counted."""
REVISIONS = ("talos_reduced", "talos_full_v2")
"""Two revisions of a humanoid in example-robot-data."""
API = {
    "Describe": ("mecanique.model", "mecanique.textbook", "mecanique.urdf", "mecanique.formats"),
    "Derive": ("mecanique.derivation",),
    "Verify": ("mecanique.verification", "mecanique.reference"),
    "Move": ("mecanique.motion",),
    "Show": ("mecanique.viewing", "mecanique.figure"),
    "Check": ("mecanique.checking", "mecanique.urdf.lint"),
    "Hand out": ("mecanique.generation",),
    "Errors": ("mecanique.errors",),
}
"""The chapters of the API reference, each with the rooms its names live in; the deepest counts."""
SECTIONS = {
    "Mechanisms": ("mecanique",),
    "Bodies and shapes": ("mecanique.model.bodies",),
    "Joints": (
        "mecanique.model.joints",
        "mecanique.model.joint_base",
        "mecanique.model.free_bodies",
    ),
    "Forces": ("mecanique.model.forces", "mecanique.model.force_base"),
    "Loops, contacts and guides": ("mecanique.model.constraints",),
    "Expressions": ("mecanique.model.expression", "mecanique.model.functions"),
    "Catalogue and files": ("mecanique.textbook", "mecanique.formats", "mecanique.urdf"),
}
"""The sections of a long chapter, likewise, by the rooms where their names are defined."""
LONG = 30
"""A chapter of more names has sections."""
ELSEWHERE = {
    "degrees_of_freedom": "Describe",
    "Freedom": "Describe",
    "assemble": "Describe",
    "assembly_branches": "Describe",
    "write_urdf": "Hand out",
    "convert": "Hand out",
    "Conversion": "Hand out",
}
"""Names that a reader looks for in another chapter than that of their room."""
FIRST = (
    "Mechanism",
    "Body",
    "Joint",
    "Parameter",
    "Coordinates",
    "Loop",
    "Revolute",
    "Prismatic",
    "Helical",
    "Universal",
    "Spherical",
    "Planar",
    "Floating",
    "Fixed",
    "Equations",
    "derive",
    "verify",
    "Verdict",
    "simulate",
    "Motion",
    "picture",
    "view",
    "export",
    "check",
    "Check",
    "generate",
    "Code",
    "MecaniqueError",
)
"""Names that open their chapters, in this order: what one meets first."""
MATHEMATICS = {"coordinate", "exp", "log", "sign", "sqrt", "time", "velocity"}
MATHEMATICS |= {"acos", "asin", "atan", "atan2", "cos", "sin", "tan", "tanh"}
"""Functions within expressions, which close their chapter."""


def write_all(directory: Path) -> None:
    """Write all generated pages.

    MECANIQUE_DOCS_SYSTEMS limits gallery and verdicts to some systems, MECANIQUE_DOCS_GALLERY the
    gallery alone.
    """
    directory.mkdir(exist_ok=True)
    (directory / "lint_rules.md").write_text(lint_rules(), encoding="utf-8")
    (directory / "urdf_tags.md").write_text(urdf_tags(), encoding="utf-8")
    (directory / "benchmarks.md").write_text(benchmarks(), encoding="utf-8")
    (directory / "operations.md").write_text(operations(), encoding="utf-8")
    (directory / "forms.md").write_text(forms(chosen()), encoding="utf-8")
    (directory / "revisions.md").write_text(revisions(), encoding="utf-8")
    for name, text in api_pages():
        (directory / f"{name}.md").write_text(text, encoding="utf-8")
    shutil.copytree(TRY, directory / "pages" / "try", dirs_exist_ok=True)
    pack(directory / "pages" / "try" / "mecanique.zip")
    pages = os.environ.get("MECANIQUE_DOCS_GALLERY", "").split()
    with ProcessPoolExecutor(1, get_context("spawn")) as beside:
        verdicts = beside.submit(validation, chosen())
        cards = gallery(directory / "pages" / "gallery", pages or [*chosen(), *corners()])
        (directory / "validation.md").write_text(verdicts.result(), encoding="utf-8")
    (directory / "cards.md").write_text(show_cards(cards), encoding="utf-8")
    faults = [f"{card.name}: {card.fault}" for card in cards if card.fault]
    if faults:
        raise RuntimeError("pages of the gallery failed: " + "; ".join(faults))


def chosen() -> list[str]:
    """Return the systems to show: all, unless MECANIQUE_DOCS_SYSTEMS names some."""
    return os.environ.get("MECANIQUE_DOCS_SYSTEMS", "").split() or list(mq.textbook.names())


def corners() -> tuple[str, ...]:
    """Return the systems with corners, which the gallery shows, too; none if some are named."""
    return () if os.environ.get("MECANIQUE_DOCS_SYSTEMS") else mq.textbook.names(corners=True)


def show_cards(cards: Sequence[Card]) -> str:
    """Return the pictures of the gallery, each a link to its page."""
    shown = []
    for card in cards:
        link = f'<a href="gallery/{card.name}.html">'
        data = base64.b64encode(card.picture.encode()).decode()
        picture = f'<img src="data:image/svg+xml;base64,{data}" alt="">' if data else ""
        shown.append(f"<li>{link}{picture}<span>{escape(card.title)}</span></a></li>")
    return "\n".join(["```{raw} html", '<ul class="cards">', *shown, "</ul>", "```", ""])


def validation(systems: list[str]) -> str:
    """Return the table of verdicts, computed now.

    Raises:
        RuntimeError: if a verdict disagrees, or a fact does not hold.
    """
    rows = []
    for name in systems:
        verdict = mq.verify(mq.textbook.load(name), samples=SAMPLES)
        facts = check_facts(name)
        broken = [row.statement for row in facts if not row.holds]
        if broken or not verdict.agrees:
            raise RuntimeError(f"{verdict}\n" + "\n".join(broken))
        count = len(facts)
        source = cell(mq.textbook.entry(name).source)
        rows.append(f"| `{name}` | agrees | {verdict.worst:.0e} | {count} of {count} | {source} |")
    head = "| system | verdict | worst difference | facts that hold | source |"
    return table(head, rows)


def benchmarks() -> str:
    """Return the table of the measurements in tests/benchmarks."""
    rows = []
    for path in sorted(BENCHMARKS.glob("*.py")):
        text = ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or ""
        says = text.partition("\n")[0]
        rows.append(f"| `{path.name}` | {cell(says)} |")
    return table("| name | what it measures |", rows)


def operations() -> str:
    """Return the table of operations that the accelerations of a state take."""
    rows = []
    for name in COUNTED:
        found = build_program(mq.derive(mq.textbook.load(name)), "rhs").count()
        parts = (found.additions, found.multiplications, found.divisions, found.functions)
        rows.append(f"| `{name}` | {found.total} | " + " | ".join(map(str, parts)) + " |")
    head = "| system | operations | additions | multiplications | divisions | functions |"
    return table(head, rows)


def forms(systems: Sequence[str]) -> str:
    """Return the table of the lines of derivations that books have, and where each is printed."""
    rows = []
    for name in systems:
        for line, place in mq.textbook.entry(name).forms.items():
            where = find_section(name, line) or "elsewhere, or by a factor of parameters"
            rows.append(f"| `{name}` | `{line}` | {where} | {cell(place)} |")
    return table("| system | form | step of the derivation | book |", rows)


def find_section(name: str, line: str) -> str:
    """Return the title of the step that prints a line, of the derivation or of its reductions."""
    mechanism = mq.textbook.load(name)
    for derive in (mq.derive, mq.routh, mq.reduce_loops):
        title = ""
        with suppress(mq.MecaniqueError):
            for shown in derive(mechanism).text(steps=True).splitlines():
                number, _, heading = shown.partition(". ")
                title = heading if number.isdecimal() else title
                if line in (shown.strip(), shown.rpartition("], ")[2]):
                    return title or "Symbols"
    return ""


def revisions() -> str:
    """Return what changed from one revision of a humanoid to the next, as `diff` prints it."""
    earlier, later = (mq.robot(name) for name in REVISIONS)
    return f"```text\n{mq.diff(earlier, later)}\n```\n"


def lint_rules() -> str:
    """Return the table of the linter's rules."""
    rows = [
        f"| {rule.code} | {rule.name} | {rule.severity} | {cell(rule.why)} | {cell(rule.remedy)} |"
        for rule in RULES.values()
    ]
    return table("| code | name | severity | why it matters | remedy |", rows)


def urdf_tags() -> str:
    """Return the table of the extensions below `robot` that other programs share."""
    rows = [
        f"| `{each.tag}` | {cell(each.meaning)} | "
        + "; ".join(f"`{child.tag}`: {cell(child.meaning)}" for child in each.children.values())
        + " |"
        for each in EXTENSIONS.values()
    ]
    return table("| tag | meaning | children |", rows)


def api_pages() -> Iterator[tuple[str, str]]:
    """Yield the name and text of every chapter, with all public names, and of an overview.

    Raises:
        RuntimeError: if a public name stands in no chapter.
    """
    homes = {name: at for name, at in find_homes(mq.__file__).items() if name in mq.__all__}
    homes["textbook"] = "mecanique.textbook"
    chapters: dict[str, list[str]] = {title: [] for title in API}
    for name, module in homes.items():
        chapters[chapter_of(name, module)].append(name)
    overview = []
    for title, members in chapters.items():
        page = [f"# {title}", ""]
        overview += [f"## [{title}](../_generated/api_{slug(title)}.md)", ""]
        for section, names in sections_of(sorted(members, key=place_of)):
            if section:
                page += [f"## {section}", ""]
                overview += [f"### {section}", ""]
            lines = table("| name | what it is |", [line_of(name) for name in names])
            page += [lines, *map(directive, names)]
            overview.append(lines)
        yield f"api_{slug(title)}", "\n".join(page)
    yield "api_names", "\n".join(overview)


def sections_of(names: list[str]) -> Iterator[tuple[str, list[str]]]:
    """Yield the sections of a chapter; a short one has a single section without a title."""
    if len(names) <= LONG:
        yield "", names
        return
    for section, rooms in SECTIONS.items():
        yield section, [name for name in names if room_of(name) in rooms]


def room_of(name: str) -> str:
    """Return the room of `SECTIONS` in which a public name is defined."""
    module: str = getattr(inspect.unwrap(getattr(mq, name)), "__module__", f"mecanique.{name}")
    module = ALIASES.get(name, module)
    rooms = [room for rooms in SECTIONS.values() for room in rooms if belongs(module, room)]
    return max(rooms, key=len)


def line_of(name: str) -> str:
    """Return the row of a public name in an overview: a link, and its first sentence."""
    said = text_below(name) if name in ALIASES else inspect.getdoc(getattr(mq, name)) or ""
    first = " ".join(said.partition("\n\n")[0].split())
    return f"| {{py:obj}}`{name} <mecanique.{name}>` | {cell(first)} |"


def place_of(name: str) -> tuple[int, str]:
    """Return the sort key of a public name in its chapter: what one meets first, then A to Z."""
    if name in FIRST:
        return FIRST.index(name), ""
    return len(FIRST) + (name in MATHEMATICS), name.casefold()


def chapter_of(name: str, module: str) -> str:
    """Return the chapter of a public name.

    Raises:
        RuntimeError: if there is none.
    """
    if name in ELSEWHERE:
        return ELSEWHERE[name]
    fitting = [(room, title) for title, rooms in API.items() for room in rooms]
    fitting = [(room, title) for room, title in fitting if belongs(module, room)]
    if not fitting:
        raise RuntimeError(f"the public name {name} stands in no chapter")
    return max(fitting, key=lambda pair: len(pair[0]))[1]


def belongs(module: str, room: str) -> bool:
    """Return whether a module is a room or lies within it."""
    return module == room or module.startswith(f"{room}.")


def directive(name: str) -> str:
    """Return the directive that documents one public name."""
    thing = getattr(mq, name)
    if name in ALIASES:
        text = textwrap.indent(text_below(name), "   ")
        return f"```{{eval-rst}}\n.. py:data:: mecanique.{name}\n\n{text}\n```\n"
    if inspect.ismodule(thing):
        members = ", ".join(each for each in thing.__all__ if each[0].islower())
        return f"```{{eval-rst}}\n.. automodule:: mecanique.{name}\n   :members: {members}\n```\n"
    if inspect.isclass(thing):
        kind = "autoexception" if issubclass(thing, Exception) else "autoclass"
    else:
        kind = "autofunction" if callable(thing) else "autodata"
    return f"```{{eval-rst}}\n.. {kind}:: mecanique.{name}\n```\n"


def text_below(name: str) -> str:
    """Return the string that follows the definition of an alias."""
    source = inspect.getsource(import_module(ALIASES[name]))
    body = ast.parse(source).body
    for line, following in pairwise(body):
        if isinstance(line, ast.AnnAssign) and ast.unparse(line.target) == name:
            return str(ast.literal_eval(ast.unparse(following)))
    raise RuntimeError(f"{ALIASES[name]} does not define {name}")


def table(head: str, rows: list[str]) -> str:
    """Return a Markdown table."""
    ruler = "|" + " --- |" * (head.count("|") - 1)
    return "\n".join([head, ruler, *rows, ""])


def cell(text: str) -> str:
    """Return text for a cell of a table."""
    return text.replace("|", "\\|").replace("<", "&lt;")


def slug(title: str) -> str:
    """Return the file name of a chapter."""
    return title.lower().replace(",", "").replace(" ", "_")

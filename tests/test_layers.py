"""The rooms import one way, and the two walls stand: read from the imports themselves.

Imports count wherever they stand: at the top of a module, in a function, behind TYPE_CHECKING.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from functools import cache
from graphlib import CycleError, TopologicalSorter
from importlib import import_module
from pathlib import Path

import pytest

SOURCE = Path(__file__).parents[1] / "src" / "mecanique"

ORDER: dict[str, list[str]] = {
    "": [
        "lazy notebook version wording",
        "arrays errors safe_xml",
        "files",
        "doors plugins",
        "model",
        "textbook",
        "program",
        "threads urdf derivation",
        "formats",
        "reference",
        "verification",
        "conversion",
        "checking",
        "generation",
        "motion",
        "figure",
        "teaching",
        "serving",
        "viewing",
        "cli",
        "__main__",
    ],
    "model": [
        "expression",
        "functions units",
        "coordinates parameters placement quaternions values",
        "statements",
        "constraint_base force_base joint_base",
        "bodies constraints forces joints",
        "mechanism",
        "free_bodies guides mechanism_units states teeth",
        "dynamics random_positions slips",
    ],
    "model.constraints": [
        "contacts cords gears loops velocity_constraints",
        "elements friction",
    ],
    "model.bodies": ["visuals tensor", "body", "shapes"],
    "model.mechanism": [
        "origin",
        "description",
        "element_laws homogeneity letters",
        "state_space",
        "validation",
        "mechanism",
    ],
    "formats": ["locate sources", "solids scope", "mjcf sdf", "read"],
    "textbook": ["facts", "joints system", "corners systems", "catalogue"],
    "urdf": [
        "limits markup meshes names robots solids",
        "dialect rules",
        "findings",
        "parse",
        "toml_loops reading",
        "read write",
        "lint",
    ],
    "urdf.reading": [
        "fields letters packages",
        "expressions",
        "native_tags xacro",
        "joints",
        "links",
        "extensions",
        "document",
    ],
    "program": ["tape", "evaluation half_angles listing traced", "solving sweeps"],
    "derivation": [
        "tolerances",
        "laws tree",
        "mechanics scalars",
        "numeric printing",
        "symbolic",
        "linear switching",
        "special_motions",
        "coordinates",
        "glossary",
        "document",
        "steady",
        "equations",
        "methods",
        "reduction",
    ],
    "derivation.mechanics": [
        "letters vectors",
        "elements",
        "chart",
        "recursion",
        "forces",
        "contacts switching",
        "loops",
    ],
    "derivation.numeric": [
        "dynamics paths",
        "recursion",
        "free_bodies lagrange",
        "constraints",
        "newton_euler",
        "virtual_work",
    ],
    "derivation.numeric.constraints": ["rows", "independent multipliers redundancy"],
    "derivation.symbolic": [
        "symbols vectors",
        "derivation",
        "kinematics",
        "inertias named_inertias",
        "constraints forces multipliers",
        "cutting",
        "balances",
        "lagrange newton_euler solution virtual_work",
        "reduced",
        "result",
    ],
    "reference": [
        "tolerances vectors",
        "standin",
        "engine originals",
        "loops",
        "reference",
    ],
    "reference.engine": [
        "answers differentiation package",
        "load",
        "chart",
        "forces",
        "rhs",
        "tree",
    ],
    "reference.engine.forces": ["sites", "elements loads"],
    "reference.loops": [
        "nullspace",
        "contacts",
        "closures",
        "closed",
        "assembly",
        "freedom independent singular",
    ],
    "verification": [
        "foreign states stencil verdict",
        "rows",
        "diff engines modes rounding transformation",
        "facts",
        "causes",
        "against",
        "compare",
        "chapter survey",
    ],
    "verification.causes": ["evidence", "joints links", "search"],
    "verification.chapter": ["row", "examples sections"],
    "checking": ["budget", "grammar", "judgement", "verdict", "conventions mistakes", "check"],
    "checking.grammar": [
        *("tree", "letters tape mathml", "scanner conditions", "reader"),
    ],
    "checking.judgement": [
        *("truth", "equilibria motion proof", "steady", "quantities", "formula"),
    ],
    "checking.mistakes": ["units", "hypotheses", "of_quantities", "search"],
    "teaching": [
        "answers marks question",
        "exercise class_page",
        "benchmark stack",
        "course_formats",
    ],
    "serving": ["agents"],
    "generation": [
        "dop853 identifiers program",
        "mechanics",
        "build targets",
        "compiled verdict",
        "languages named_results",
    ],
    "generation.mechanics": [
        "closed_form constrained",
        "articulated dynamics",
        "free_body_forces switching",
    ],
    "generation.targets": ["target", "c javascript python", "jax", "fmu"],
    "motion": [
        "tolerances",
        "record",
        "compile",
        "trajectory",
        "switching",
        "simulation",
        "analysis",
        "output",
        "motion",
        "ensemble inertial linear",
    ],
    "motion.switching": ["holding rows", "law", "corners"],
    "motion.simulation": [
        "problem",
        "integrators",
        "choice watching",
        "integrate",
    ],
    "motion.simulation.integrators": ["taylor", "methods", "compiled"],
    "figure": [
        "paper",
        "solids",
        "setting",
        "coordinates",
        "mechanism",
        "freebody",
        "draw",
    ],
    "figure.paper": ["marks", "lettering files"],
    "viewing": ["scene", "corners", "engine page", "live", "show", "gallery"],
    "viewing.scene": ["inspection", "scene", "drawn", "texts", "from_motion"],
    "viewing.page": ["panels", "page"],
    "viewing.live": ["live", "view"],
    "cli": [
        "options printing",
        "linear words",
        "derive describe formulas motions pictures verify",
    ],
}
"""What lies in each room, from the bottom up: one imports only from lines above its own."""

MODULES = sorted(SOURCE.rglob("*.py"))
INSIDE = [path for path in MODULES if path != SOURCE / "__init__.py"]


def name_of(path: Path) -> str:
    """Return a module's dotted name inside the package; a package's is that of its folder."""
    parts = path.relative_to(SOURCE).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def literal(node: ast.Call) -> str | None:
    """Return the name given to a dynamic import, "." if it is relative, None if it is no import."""
    called = (
        node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
    )
    if called not in {"import_module", "__import__"} or not node.args:
        return None
    first = node.args[0]
    if isinstance(first, ast.Constant):
        return str(first.value)
    if not isinstance(first, ast.JoinedStr):
        return None
    start = first.values[0]
    if isinstance(start, ast.Constant):
        return str(start.value)
    own = isinstance(start, ast.FormattedValue) and ast.unparse(start.value) == "__name__"
    return None if own else "."  # a room may reach into itself


@cache
def imports(text: str) -> tuple[str, ...]:
    """Return every module a text imports, as a dotted name; relative imports as a lone dot."""
    return tuple(read_imports(text))


def read_imports(text: str) -> Iterator[str]:
    """Read them one by one."""
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            if node.level:
                yield "."
            else:
                yield from (f"{node.module}.{alias.name}" for alias in node.names)
        elif isinstance(node, ast.Call) and (name := literal(node)) is not None:
            yield name


NAMES = {name_of(path): path for path in INSIDE}


def own_modules(text: str) -> set[str]:
    """Return the package's own modules a text imports, without the package's name."""
    found = set()
    for name in imports(text):
        if not name.startswith("mecanique."):
            continue
        inner = name.removeprefix("mecanique.")
        parent = inner.rpartition(".")[0]
        found.add(inner if inner in NAMES or parent not in NAMES else parent)
    return found


def rooms_in(text: str) -> set[str]:
    """Return the rooms a text imports from."""
    return {name.split(".")[0] for name in own_modules(text)}


def outside(text: str) -> set[str]:
    """Return the other packages a text imports."""
    return {name.split(".")[0] for name in imports(text)}


@cache
def edges() -> dict[str, set[str]]:
    """Return what each module of the package imports from it."""
    return {name: own_modules(path.read_text(encoding="utf-8")) for name, path in NAMES.items()}


def place(room: str, name: str) -> str | None:
    """Return the entry of a room's order that a module lies in; None for the room's own front."""
    prefix = f"{room}." if room else ""
    if not name.startswith(prefix):
        return None
    inner = name.removeprefix(prefix)
    entries = [entry for line in ORDER[room] for entry in line.split()]
    homes = [entry for entry in entries if inner == entry or inner.startswith(f"{entry}.")]
    return max(homes, key=len) if homes else inner.split(".")[0]


@pytest.mark.parametrize("room", ORDER)
def test_a_room_imports_only_what_lies_below_it(room: str) -> None:
    rank = {entry: i for i, line in enumerate(ORDER[room]) for entry in line.split()}
    for name, targets in edges().items():
        here = place(room, name)
        if here is None or name == room:
            continue
        assert here in rank, f"{name} has no place in the order of {room or 'the house'}"
        for target in targets:
            there = place(room, target)
            if there is not None and target != room and there != here:
                assert rank[there] < rank[here], f"{name} imports {target}, which lies no lower"


def test_there_is_no_circle() -> None:
    try:
        TopologicalSorter(edges()).prepare()
    except CycleError as error:
        pytest.fail(" -> ".join(error.args[1]))


def test_every_module_can_be_imported_by_its_dotted_name() -> None:
    """No function of the same name hides a module from `import a.b.c as d`."""
    for name in sorted(NAMES.keys() - {"__main__"}):
        scope: dict[str, object] = {}
        exec(f"import mecanique.{name} as module", scope)
        assert scope["module"] is import_module(f"mecanique.{name}"), name


def test_inside_the_package_imports_are_absolute_and_name_a_room() -> None:
    for name, path in NAMES.items():
        names = set(imports(path.read_text(encoding="utf-8")))
        assert "." not in names, name
        assert "mecanique" not in names or name.startswith("cli"), name


def test_the_derivation_never_sees_the_engine_and_the_engine_never_sees_the_derivation() -> None:
    derivation = [
        path.read_text(encoding="utf-8")
        for name, path in NAMES.items()
        if name.startswith("derivation")
    ]
    engine = [
        path.read_text(encoding="utf-8")
        for name, path in NAMES.items()
        if name.startswith("reference")
    ]
    assert derivation
    assert engine
    for text in derivation:
        assert not rooms_in(text) & {"reference", "urdf", "verification", "motion", "viewing"}
        assert not outside(text) & {"pinocchio", "pin", "example_robot_data", "coal", "eigenpy"}
    # nor its arithmetic: a slip in how programs are differentiated would agree with itself
    for text in engine:
        assert not rooms_in(text) & {"derivation", "program"}


def test_only_the_reference_imports_pinocchio() -> None:
    users = {
        name_of(path).split(".")[0]
        for path in MODULES
        if outside(path.read_text(encoding="utf-8")) & {"pinocchio", "pin"}
    }
    assert users == {"reference"}


def test_only_the_verdict_on_code_sees_the_engine() -> None:
    for name, path in NAMES.items():
        if name.startswith("generation") and name != "generation.verdict":
            assert "reference" not in rooms_in(path.read_text(encoding="utf-8")), name


def test_only_the_reference_mentions_pinocchio_as_a_module() -> None:
    """No way around by an attribute of the reference room either."""
    for name, path in NAMES.items():
        text = path.read_text(encoding="utf-8")
        if "pinocchio" in text and not name.startswith("reference"):
            for node in ast.walk(ast.parse(text)):
                assert not (isinstance(node, ast.Attribute) and node.attr == "pinocchio"), path


@pytest.mark.parametrize(
    ("text", "rooms"),
    [
        ("import mecanique.reference.engine.load", {"reference"}),
        ("from mecanique.urdf.write import write_urdf", {"urdf"}),
        ("from mecanique import motion, viewing", {"motion", "viewing"}),
        ("def f():\n    from mecanique.derivation import derive", {"derivation"}),
        ("import importlib\nimportlib.import_module('mecanique.viewing.page')", {"viewing"}),
        ("import_module(f'mecanique.motion.{name}')", {"motion"}),
        ("import numpy, math", set()),
    ],
)
def test_the_reader_of_imports_finds_them_all(text: str, rooms: set[str]) -> None:
    assert rooms_in(text) == rooms


def test_the_reader_of_imports_finds_other_packages_and_relative_imports() -> None:
    assert outside("import pinocchio as pin\nfrom numpy.linalg import norm") == {
        "pinocchio",
        "numpy",
    }
    assert "." in set(imports("from .scene import Scene"))
    assert "." in set(imports("import_module(f'{room}.page')"))
    assert not set(imports("import_module(f'{__name__}.page')"))

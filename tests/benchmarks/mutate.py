"""How many changes of one operator the tests of the core catch, and those of its room. Run by hand.

    python tests/benchmarks/mutate.py [NUMBER] [--seed SEED] [--room ROOM] [--again OUTPUT]
        [--tests FILE …]

Takes NUMBER places of the rooms where laws stand at random and changes one operator at each: a
sign, + for −, · for /, a product's order, a comparison, an index or a number. Each change meets the
tests that run its line, fastest first, then the others of their files, in a fork of a process that
has collected all tests; the code of the loaded functions is exchanged, nothing is written into the
source. A test that fails, or that never ends, has caught the change. Text is left alone: strings,
error messages, functions that return a string. A part of a run is a fair sample: the order is
random.
A change meets the tests of the room that owns its law first (OWNERS), and those of others only if
it passes these. So each is "caught" by the owner, caught "elsewhere", or has SURVIVED; at the end
stand both rates, that of the owners and that of all tests.
--room changes one room alone, --again tries what passed the owner's tests in a former run once
more, --tests meets them with these tests alone.
"""

from __future__ import annotations

import argparse
import ast
import gc
import hashlib
import json
import os
import random
import resource
import sys
import tempfile
from collections import Counter
from collections.abc import Callable, Iterator
from functools import _lru_cache_wrapper, partial
from importlib import import_module
from inspect import unwrap
from itertools import accumulate, pairwise, zip_longest
from pathlib import Path
from time import process_time
from types import CodeType, FunctionType, ModuleType
from typing import Any, NamedTuple

os.environ |= {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}

import coverage
import hypothesis.strategies  # loaded once, for all forks
import pinocchio  # noqa: F401
import pytest
import scipy.integrate
import scipy.optimize  # noqa: F401
import sympy  # noqa: F401

ROOT = Path(__file__).parents[2]
SOURCE = ROOT / "src"
OWNERS = {
    "derivation": "derivation",
    "reference": "reference",
    "verification": "verification",
    "model": "model",
    "program": "program",
    "generation/mechanics": "generation",
}
"""The folder of tests, by the room whose laws they hold."""
ROOMS = tuple(OWNERS)
TEXT = ("derivation/printing", "derivation/document", "derivation/glossary")
SUITES = [
    *(str(ROOT / "tests" / folder) for folder in (*OWNERS.values(), "rolling", "textbook")),
    *(str(ROOT / "tests" / f"test_{name}.py") for name in ("forces", "potentials")),
    *(
        str(ROOT / "tests" / "motion" / f"test_motion_{name}.py")
        for name in ("loops", "linear", "linear_letters")
    ),
]
"""Those of the core, of what is derived and generated, and of motions singular and in letters."""
ENOUGH = 30
"""CPU seconds of its owner's tests that a change meets, the fastest first, and of others."""
PATIENCE = 20
"""CPU seconds that these may take beyond five times what they take with nothing changed."""
MEMORY = 6 * 2**30
"""Bytes that they may take, as what never ends may also grow without end."""

PAIRS = (
    (ast.Add, ast.Sub),
    (ast.Mult, ast.Div),
    (ast.Lt, ast.GtE),
    (ast.Gt, ast.LtE),
    (ast.Eq, ast.NotEq),
    (ast.Is, ast.IsNot),
    (ast.In, ast.NotIn),
)
OPERATORS: dict[type, type] = {
    ast.USub: ast.UAdd,
    **{one: other for pair in PAIRS for one, other in (pair, pair[::-1])},
}

WITHOUT_SHRINKING = (hypothesis.Phase.explicit, hypothesis.Phase.generate)
"""A test of random cases that fails once has caught the change."""

SURVIVED, ELSEWHERE = "SURVIVED", "elsewhere"

EQUIVALENT = {
    tuple(entry.splitlines()[:3])
    for entry in (Path(__file__).parent / "equivalent.txt")
    .read_text(encoding="utf-8")
    .split("\n\n")[1:]
}
"""Changes that nothing can catch: module, line and change."""

SHARING = {
    str(path.relative_to(ROOT))
    for path in (ROOT / "tests").rglob("test_*.py")
    if "derive_system" in path.read_text(encoding="utf-8")
}
"""Files of tests that share what systems.py keeps."""

LISTS = (ast.List, ast.ListComp, ast.Set, ast.JoinedStr)
"""What is joined by +, so that − would only raise."""


class Change(NamedTuple):
    """A module with one operator changed."""

    path: Path
    lines: range
    code: str
    text: str
    tree: ast.Module
    at_import: bool
    """Whether it stands outside all functions, where lines run before any test."""

    @property
    def key(self) -> tuple[str, str, str]:
        """The module's name, the line that begins with what is changed, and the change."""
        return self.path.stem, self.code, self.text


class Place(NamedTuple):
    """What can be changed, and the expression that shows it."""

    node: Any
    shown: ast.AST


def is_product(node: ast.AST) -> bool:
    """Return whether the order of a matrix product can be changed: a square has none."""
    match node:
        case ast.BinOp(left, ast.MatMult(), right):
            return ast.dump(left) != ast.dump(right)
    return False


def places(node: ast.AST, operand_of: ast.AST | None = None) -> Iterator[Place]:
    """Yield what can be changed below a node, in a fixed order."""
    if isinstance(node, (ast.JoinedStr, ast.Raise, ast.arguments)):
        return
    if isinstance(node, ast.FunctionDef) and getattr(node.returns, "id", "") == "str":
        return
    match node:
        case ast.BinOp() | ast.AugAssign() | ast.UnaryOp():
            known = type(node.op) in OPERATORS or is_product(node)
            if known and not any(isinstance(part, LISTS) for part in ast.iter_child_nodes(node)):
                yield Place(node, node)
        case ast.Compare(ops=[_]):
            yield Place(node, node)
        case ast.Constant(value=int() | float()) if operand_of and not isinstance(node.value, bool):
            yield Place(node, operand_of)
    if isinstance(node, (ast.BinOp, ast.Subscript)):
        operand_of = node
    elif not isinstance(node, (ast.Tuple, ast.Slice, ast.UnaryOp)):
        operand_of = None
    for name, value in ast.iter_fields(node):
        if name not in ("annotation", "returns", "decorator_list"):
            for child in value if isinstance(value, list) else [value]:
                if isinstance(child, ast.AST):
                    yield from places(child, operand_of)


def changed(node: Any) -> None:
    """Change an operator, an index or a number in place."""
    if isinstance(node, ast.Compare):
        node.ops = [OPERATORS[type(node.ops[0])]()]
    elif isinstance(node, ast.Constant):
        value: Any = node.value
        node.value = (2 * value if isinstance(value, float) else value - 1) if value else value + 1
    elif isinstance(node.op, ast.MatMult):
        node.left, node.right = node.right, node.left
    else:
        node.op = OPERATORS[type(node.op)]()


def modules() -> list[Path]:
    """Return the modules of the core."""
    every = [path for room in ROOMS for path in sorted((SOURCE / "mecanique" / room).rglob("*.py"))]
    return [path for path in every if not any(text in str(path) for text in TEXT)]


def name_of(path: Path) -> str:
    """Return the name by which a module is imported."""
    parts = path.relative_to(SOURCE).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def every_place(room: str | None = None) -> list[tuple[Path, int]]:
    """Return every place that can be changed, of one room or all: a module and its number there."""
    top = SOURCE / "mecanique" / (room or "")
    return [
        (path, k)
        for path in modules()
        if path.is_relative_to(top)
        for k, _ in enumerate(places(ast.parse(path.read_text())))
    ]


def change_at(path: Path, number: int) -> Change:
    """Return a module with one place changed."""
    source = path.read_text(encoding="utf-8")
    tree = ast.parse(source)
    node, shown = list(places(tree))[number]
    before = ast.unparse(shown)
    changed(node)
    functions = [f for f in ast.walk(tree) if isinstance(f, (ast.FunctionDef, ast.Lambda))]
    return Change(
        path=path,
        lines=range(node.lineno, node.end_lineno + 1),
        code=source.splitlines()[node.lineno - 1].strip(),
        text=f"{before} → {ast.unparse(shown)}",
        tree=tree,
        at_import=not any(node is inner for f in functions for inner in ast.walk(f)),
    )


def owner_of(path: Path) -> str:
    """Return the folder of tests that owns what a module states."""
    inside = path.relative_to(SOURCE / "mecanique")
    return next(folder for room, folder in OWNERS.items() if inside.is_relative_to(room))


def file_of(test: str) -> str:
    """Return the file of a test."""
    return test.split("::")[0]


class Record(NamedTuple):
    """The CPU time of each test, and the tests that run a line, by file and line."""

    seconds: dict[str, float]
    tests: dict[str, dict[int, list[str]]]

    @classmethod
    def read(cls, path: Path) -> Record:
        """Read what note() has written."""
        found = json.loads(path.read_text(encoding="utf-8"))
        names = list(found["seconds"])
        tests = {
            file: {int(line): [names[k] for k in run] for line, run in lines.items()}
            for file, lines in found["tests"].items()
        }
        return cls(found["seconds"], tests)

    def covering(self, change: Change) -> tuple[list[str], list[str]]:
        """Return the owner's tests that run what was changed, then those beside; and all others."""
        of_module = self.tests.get(str(change.path.relative_to(ROOT)), {})
        lines = of_module if change.at_import else change.lines
        direct = {test for line in lines for test in of_module.get(line, ())}
        # what a shared fixture or a cache holds was computed by the first of the tests that use it
        files = {file_of(test) for test in direct}
        files |= SHARING if files & SHARING else set()
        beside = {test for test in self.seconds if file_of(test) in files} - direct
        folder = f"tests/{owner_of(change.path)}/"
        own = {test for test in direct | beside if test.startswith(folder)}
        return (
            self._fastest(direct & own, beside & own),
            self._fastest(direct - own, beside - own),
        )

    def _fastest(self, *groups: set[str]) -> list[str]:
        """Return as many tests of the groups, one after the other, as time is enough for."""
        ordered = [test for tests in groups for test in sorted(tests, key=self.seconds.__getitem__)]
        total = accumulate(self.seconds[test] for test in ordered)
        return [test for test, spent in zip(ordered, total, strict=True) if spent < ENOUGH]


def codes(code: CodeType) -> Iterator[CodeType]:
    """Yield a code and those of all functions inside it."""
    yield code
    for inner in code.co_consts:
        if isinstance(inner, CodeType):
            yield from codes(inner)


def signature(code: CodeType) -> tuple[object, ...]:
    """Return what tells a function from all others of its module, changed or not."""
    # a product's order is also that of the names
    return code.co_name, code.co_firstlineno, *map(frozenset, (code.co_varnames, code.co_names))


def install(change: Change) -> None:
    """Change a loaded module: the code of its functions, and its constants wherever they went."""
    code = compile(change.tree, str(change.path), "exec", dont_inherit=True)
    new = {signature(inner): inner for inner in codes(code)}
    gc.unfreeze()  # what conftest.py has frozen is not among the objects
    for found in gc.get_objects():
        if isinstance(found, FunctionType) and found.__code__.co_filename == code.co_filename:
            found.__code__ = new.get(signature(found.__code__), found.__code__)
        elif isinstance(found, _lru_cache_wrapper):
            found.cache_clear()
    if not change.at_import:
        return
    home = sys.modules[name_of(change.path)]
    fresh = {**vars(home)}
    exec(code, fresh)
    for name, value in list(vars(home).items()):
        if isinstance(value, type) and value.__module__ == home.__name__:
            renew(value, fresh[name])
        if name.startswith("__") or isinstance(value, (type, FunctionType, ModuleType)):
            continue
        for module in list(sys.modules.values()):
            if module.__dict__.get(name) is value:
                setattr(module, name, fresh[name])


def renew(known: type, fresh: type) -> None:
    """Take the values of a class, and the defaults of its functions, from another."""
    for name, value in vars(fresh).items():
        if isinstance(value, FunctionType) and isinstance(vars(known)[name], FunctionType):
            function = unwrap(vars(known)[name])
            function.__defaults__ = value.__defaults__
            function.__kwdefaults__ = value.__kwdefaults__
        elif not name.startswith("__") and not callable(value):
            setattr(known, name, value)
            inherit(known, name, value)


def inherit(known: type, name: str, value: object) -> None:
    """Give a field's default to the constructors that the class's heirs have of their own."""
    heirs: list[type] = known.__subclasses__()
    for heir in heirs:
        make = unwrap(vars(heir).get("__init__", inherit))
        if name not in vars(heir) and make.__defaults__:
            names = make.__code__.co_varnames[: make.__code__.co_argcount]
            defaults = zip(names[::-1], make.__defaults__[::-1], strict=False)
            renewed = [value if key == name else default for key, default in defaults]
            make.__defaults__ = tuple(renewed[::-1])
        inherit(heir, name, value)


class Mutation:
    """Takes the place of pytest's loop over the tests."""

    def __init__(self, drawn: list[tuple[Path, int]], noted: Path) -> None:
        self._drawn = drawn
        self._noted = noted
        self._out = os.fdopen(os.dup(1), "w")

    def pytest_runtestloop(self, session: pytest.Session) -> bool:
        """Run all tests once, change, test and print a table."""
        for path in modules():
            import_module(name_of(path))  # also what is imported late
        if not self._noted.exists() and fork(lambda: note(session, self._noted)):
            raise SystemExit("the tests fail as they are")
        noted = Record.read(self._noted)
        count: Counter[str] = Counter()
        for number, (path, place) in enumerate(self._drawn, 1):
            change = change_at(path, place)
            own, others = noted.covering(change)
            outcome = SURVIVED
            if change.key in EQUIVALENT:
                outcome = "equivalent"
            elif self._caught(session, change, own, noted):
                outcome = "caught"
            elif self._caught(session, change, others, noted):
                outcome = ELSEWHERE
            count[outcome] += 1
            where = f"{path.relative_to(SOURCE / 'mecanique')}:{change.lines.start}"
            tests = f"{len(own):4} of the owner's, {len(others):4} other tests"
            self._say(f"{number:4} {outcome:10} {tests}  {where}  {change.text}")
            if outcome in (SURVIVED, ELSEWHERE):
                self._say(f"       {change.code}")
        by_owner, anywhere = count["caught"], count["caught"] + count[ELSEWHERE]
        met = max(anywhere + count[SURVIVED], 1)
        self._say(
            f"{len(self._drawn)} tried, {by_owner} caught by the owner's tests, "
            f"{count[ELSEWHERE]} elsewhere, {count['equivalent']} equivalent, "
            f"{count[SURVIVED]} open: of those that are not equivalent {by_owner / met:.1%} are "
            f"caught by the owner's tests, {anywhere / met:.1%} by any"
        )
        return True

    @staticmethod
    def _caught(session: pytest.Session, change: Change, tests: list[str], noted: Record) -> bool:
        usual = sum(noted.seconds[test] for test in tests)
        return bool(tests) and fork(partial(meet, session, change, tests, usual)) != 0

    def _say(self, line: str) -> None:
        print(line, file=self._out, flush=True)


def fork(work: Callable[[], int]) -> int:
    """Return what a function returns in a fork of this process; negative if that was stopped."""
    child = os.fork()
    if not child:
        code = 99
        try:
            code = work()
        finally:
            os._exit(code)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])


def run(session: pytest.Session, items: list[pytest.Item]) -> Iterator[pytest.Item]:
    """Run tests; yield each before it starts. The first that fails is the last."""
    for item, after in zip_longest(items, items[1:]):
        yield item
        item.config.hook.pytest_runtest_protocol(item=item, nextitem=after)
        if session.testsfailed:
            return


def meet(session: pytest.Session, change: Change, tests: list[str], usual: float) -> int:
    """Return how many tests fail with a change; one is enough. They take usual CPU seconds."""
    limit = int(PATIENCE + 5 * usual)
    resource.setrlimit(resource.RLIMIT_CPU, (limit, limit + 5))
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    install(change)
    items = {item.nodeid: item for item in session.items}
    for _ in run(session, [items[test] for test in tests if test in items]):
        pass
    return session.testsfailed


def note(session: pytest.Session, into: Path) -> int:
    """Note which tests run a line, and how long each takes; return how many fail."""
    tracer = coverage.Coverage(data_file=None, source=[str(SOURCE)], config_file=False)
    tracer.start()
    seconds: dict[str, float] = {}
    start, last = process_time(), ""
    for item in run(session, session.items):
        seconds[last] = process_time() - start
        start, last = process_time(), item.nodeid
        tracer.switch_context(last)
    seconds[last] = process_time() - start
    tracer.stop()
    seconds.pop("", None)
    data = tracer.get_data()
    number = {name: k for k, name in enumerate(seconds)}
    tests = {
        str(Path(file).relative_to(ROOT)): {
            line: [number[test] for test in names if test]
            for line, names in data.contexts_by_lineno(file).items()
        }
        for file in data.measured_files()
    }
    into.write_text(json.dumps({"seconds": seconds, "tests": tests}), encoding="utf-8")
    return session.testsfailed


def again(output: Path) -> Iterator[tuple[Path, int]]:
    """Yield the places of what the owner's tests passed in a former run, wherever they are now."""
    printed = output.read_text(encoding="utf-8").splitlines()
    lost = [
        (*line.split("  ")[-2:], code.strip())
        for line, code in pairwise(printed)
        if SURVIVED in line or ELSEWHERE in line
    ]
    wanted = {(Path(where.split(":")[0]).stem, code, change) for where, change, code in lost}
    for path in modules():
        before = {change.split(" → ")[0] for stem, _, change in wanted if stem == path.stem}
        for number, place in enumerate(places(ast.parse(path.read_text())) if before else ()):
            if ast.unparse(place.shown) in before and change_at(path, number).key in wanted:
                yield path, number


def unknown() -> Iterator[str]:
    """Yield the lines of equivalent changes that stand in no module any more."""
    lines = {
        (path.stem, line.strip())
        for path in modules()
        for line in path.read_text(encoding="utf-8").splitlines()
    }
    yield from (f"{entry[0]}: {entry[1]}" for entry in EQUIVALENT if entry[:2] not in lines)


def record_of(suites: list[str]) -> Path:
    """Return the file of what these tests run, which holds until the source or a test changes."""
    sources = [SOURCE, *(Path(suite) for suite in suites)]
    files = (path for top in sources for path in ([top] if top.is_file() else top.rglob("*.py")))
    state = hashlib.sha256(b"".join(path.read_bytes() for path in sorted(files))).hexdigest()
    return Path(tempfile.gettempdir()) / f"mecanique_tests_by_line_{state[:12]}.json"


def main() -> None:
    """Load all tests; see Mutation."""
    asked = argparse.ArgumentParser(description="Count how many changed operators are caught.")
    asked.add_argument("number", type=int, nargs="?", default=300)
    asked.add_argument("--seed", type=int, default=1)
    asked.add_argument("--room", choices=ROOMS, help="what to change; all of them by default")
    asked.add_argument(
        "--again", type=Path, help="try what the owner's tests passed in this output again"
    )
    asked.add_argument("--tests", nargs="+", default=SUITES, help="files or folders")
    asked.add_argument("--record", type=Path, help="the file of what these tests run")
    given = asked.parse_args()
    drawn = (
        list(again(given.again))
        if given.again
        else random.Random(given.seed).sample(every_place(given.room), given.number)
    )
    suites = [str(Path(suite).resolve()) for suite in given.tests]
    print(f"seed {given.seed}, {len(drawn)} changes", flush=True)
    for line in unknown():
        print(f"in equivalent.txt but no longer in the source: {line}", flush=True)
    mutation = Mutation(drawn, given.record or record_of(suites))
    sys.path.insert(0, str(SOURCE))
    os.chdir(ROOT)
    with open(os.devnull, "w", encoding="utf-8") as nowhere:
        os.dup2(nowhere.fileno(), 1)
        os.dup2(nowhere.fileno(), 2)
    hypothesis.settings.register_profile("found", phases=WITHOUT_SHRINKING)
    hypothesis.settings.load_profile("found")
    options = ["-q", "-x", "-n", "0", "--assert=plain", "--tb=no", "-p", "no:cacheprovider"]
    pytest.main([*options, *suites], plugins=[mutation])


if __name__ == "__main__":
    main()

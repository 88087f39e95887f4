"""How many changes of one operator the tests of the core catch. Run by hand.

    python tests/benchmarks/mutate.py [NUMBER [SEED]]

Takes NUMBER places of derivation, reference and verification at random and changes one operator
at each: a sign, + for −, · for /, a product's order, a comparison, an index or a number. Each
change meets the tests that run its line, fastest first, in a fork of a process that has the
libraries loaded; nothing is written into the source. A test that fails, or that never ends, has
caught the change. Text is left alone: strings, error messages, functions that return a string.
"""

from __future__ import annotations

import ast
import json
import os
import random
import resource
import sys
import tempfile
from collections.abc import Iterable, Iterator
from importlib.machinery import ModuleSpec, SourceFileLoader
from importlib.util import spec_from_file_location
from pathlib import Path
from time import process_time
from types import CodeType
from typing import Any, NamedTuple

os.environ |= {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}

import coverage
import hypothesis.strategies  # noqa: F401  loaded once, for all forks
import pinocchio  # noqa: F401
import pytest
import scipy.integrate
import scipy.optimize  # noqa: F401
import sympy  # noqa: F401

ROOT = Path(__file__).parents[2]
SOURCE = ROOT / "src"
ROOMS = ("derivation", "reference", "verification")
TEXT = ("derivation/printing", "derivation/document", "derivation/glossary")
SUITES = [
    *(str(ROOT / "tests" / room) for room in (*ROOMS, "textbook")),
    *(str(ROOT / "tests" / "motion" / f"test_motion_{name}.py") for name in ("loops", "linear")),
    str(ROOT / "tests" / "motion" / "test_motion_linear_letters.py"),
]
"""Those of the core, and of motions what tests singular positions and letters."""
PATIENCE = 60
"""CPU seconds that a change may take beyond ten times what its tests take without it."""

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

LISTS = (ast.List, ast.ListComp, ast.Set, ast.JoinedStr)
"""What is joined by +, so that − would only raise."""

EQUIVALENT: dict[tuple[str, str], str] = {
    ("loads", "-1 → +1"): "the second axis is the last",
    ("newton_euler", "-1 → +1"): "the second axis is the last",
    ("lagrange", "-1 → +1"): "the second axis is the last",
    ("constraints", "along @ parting → parting @ along"): "an inner product",
    ("jets", "orders - 1 → orders - 0"): "one coefficient more, before a power that vanishes",
    ("chart", "2 * count → 1 * count"): "constant slopes without drift have no second rate either",
    (
        "rhs",
        "list(engine.model.joints)[1:] → list(engine.model.joints)[0:]",
    ): "the first joint overwrites what the universe put there",
    ("independent", "x[0] → x[1]"): "all these jets have one shape",
    (
        "newton_euler",
        "6 * len(at.bodies) → 5 * len(at.bodies)",
    ): "the size above which the faster of two ways is taken",
    (
        "search",
        "max(mechanism.nv, 1) ** 2 → max(mechanism.nv, 1) ** 1",
    ): "how many states are looked at, a matter of time",
    ("freedom", "1e-06 * size → 2e-06 * size"): "a tolerance; nothing lies between",
    ("axes", "1 - 1e-12 → 1 - 2e-12"): "a tolerance; nothing lies between",
    (
        "links",
        "1e-12 * max(np.abs(inertia).max(), 1e-300) → 2e-12 * max(np.abs(inertia).max(), 1e-300)",
    ): "a tolerance; nothing lies between",
    ("facts", "moved[k] += 1e-30j → moved[k] -= 1e-30j"): "a rate that is compared with zero",
    ("survey", "perf_counter() - start → perf_counter() + start"): "a duration that is printed",
}
"""Changes that nothing can catch, by module and what is changed, and why."""


class Change(NamedTuple):
    """One changed operator.

    Args:
        path: of the module.
        lines: that hold the changed expression.
        text: before and after.
        tree: the module with the change.
    """

    path: Path
    lines: range
    text: str
    tree: ast.Module


class Record(NamedTuple):
    """What the tests run, as they are.

    Args:
        seconds: CPU time of each test.
        tests: that run a line, by file and line.
    """

    seconds: dict[str, float]
    tests: dict[str, dict[int, list[str]]]

    def covering(self, change: Change) -> list[str]:
        """Return the tests that run what was changed, the fastest first."""
        of_module = self.tests.get(str(change.path.relative_to(ROOT)), {})
        found = {test for line in change.lines for test in of_module.get(line, ())}
        if "" in found:  # it runs at import, for all
            found = {test for tests in of_module.values() for test in tests}
        return sorted(found - {""}, key=lambda test: self.seconds[test])


class Place(NamedTuple):
    """What can be changed, and the expression that shows it."""

    node: Any
    shown: ast.AST


def places(node: ast.AST, operand_of: ast.AST | None = None) -> Iterator[Place]:
    """Yield what can be changed below a node, in a fixed order."""
    if isinstance(node, (ast.JoinedStr, ast.Raise, ast.arguments)):
        return
    if isinstance(node, ast.FunctionDef) and getattr(node.returns, "id", "") == "str":
        return
    match node:
        case ast.BinOp() | ast.AugAssign() | ast.UnaryOp():
            known = type(node.op) in OPERATORS or isinstance(node.op, ast.MatMult)
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
        node.value = 2 * value if isinstance(value, float) else value - 1 if value else 1
    elif isinstance(node.op, ast.MatMult):
        node.left, node.right = node.right, node.left
    else:
        node.op = OPERATORS[type(node.op)]()


def every_place() -> list[tuple[Path, int]]:
    """Return every place that can be changed: a module and its number there."""
    modules = [
        path for room in ROOMS for path in sorted((SOURCE / "mecanique" / room).rglob("*.py"))
    ]
    core = [path for path in modules if not any(text in str(path) for text in TEXT)]
    return [(path, k) for path in core for k, _ in enumerate(places(ast.parse(path.read_text())))]


def change_at(path: Path, number: int) -> Change:
    """Return a module with one place changed."""
    tree = ast.parse(path.read_text())
    node, shown = list(places(tree))[number]
    before = ast.unparse(shown)
    changed(node)
    lines = range(node.lineno, node.end_lineno + 1)
    return Change(path, lines, f"{before} → {ast.unparse(shown)}", tree)


class Changed(SourceFileLoader):
    """Loads a changed module in the place of the one on disk."""

    def __init__(self, name: str, change: Change) -> None:
        super().__init__(name, str(change.path))
        self._tree = change.tree

    def get_code(self, fullname: str) -> CodeType:
        """Compile the changed module; nothing is cached."""
        return compile(self._tree, self.path, "exec", dont_inherit=True)


class Finder:
    """Finds the changed module before the one on disk."""

    def __init__(self, change: Change) -> None:
        parts = change.path.relative_to(SOURCE).with_suffix("").parts
        self._name = ".".join(parts[:-1] if parts[-1] == "__init__" else parts)
        self._change = change

    def find_spec(self, name: str, path: Any = None, target: Any = None) -> ModuleSpec | None:
        """Return where a module comes from, if it is the changed one."""
        if name != self._name:
            return None
        loader = Changed(name, self._change)
        return spec_from_file_location(name, self._change.path, loader=loader)


class Chosen:
    """Keeps pytest to some tests, in their order."""

    def __init__(self, tests: list[str]) -> None:
        self._rank = {test: k for k, test in enumerate(tests)}

    @pytest.hookimpl(trylast=True)
    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        """Leave out and sort."""
        kept = [item for item in items if item.nodeid in self._rank]
        items[:] = sorted(kept, key=lambda item: self._rank[item.nodeid])


class Recorder:
    """Notes what each test runs and how long it takes."""

    def __init__(self, tracer: coverage.Coverage) -> None:
        self._tracer = tracer
        self.seconds: dict[str, float] = {}

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Iterator[None]:
        """Run one test."""
        self._tracer.switch_context(item.nodeid)
        start = process_time()
        result = yield
        self.seconds[item.nodeid] = process_time() - start
        return result


def run(arguments: Iterable[str], plugin: object) -> int:
    """Run pytest silently; return its exit code."""
    sys.path.insert(0, str(SOURCE))
    os.chdir(ROOT)
    with open(os.devnull, "w") as nowhere:
        os.dup2(nowhere.fileno(), 1)
        os.dup2(nowhere.fileno(), 2)
    return int(
        pytest.main(
            ["-q", "--assert=plain", "-p", "no:cacheprovider", *arguments], plugins=[plugin]
        )
    )


def fork(work: Any) -> int:
    """Return what a function returns in a fork of this process; negative if that was stopped."""
    sys.stdout.flush()
    child = os.fork()
    if not child:
        code = 99
        try:
            code = work()
        finally:
            os._exit(code)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])


def record(into: Path) -> Record:
    """Run all tests once, or read what an earlier run noted."""

    def work() -> int:
        tracer = coverage.Coverage(data_file=None, source=[str(SOURCE)], config_file=False)
        recorder = Recorder(tracer)
        tracer.start()
        code = run(SUITES, recorder)
        tracer.stop()
        data = tracer.get_data()
        tests = {
            str(Path(file).relative_to(ROOT)): data.contexts_by_lineno(file)
            for file in data.measured_files()
        }
        into.write_text(json.dumps({"seconds": recorder.seconds, "tests": tests}))
        return code

    if not into.exists() and (code := fork(work)):
        raise SystemExit(f"the tests fail as they are: pytest ends with {code}")
    found = json.loads(into.read_text())
    by_line = {f: {int(k): v for k, v in lines.items()} for f, lines in found["tests"].items()}
    return Record(found["seconds"], by_line)


def survives(change: Change, tests: list[str], seconds: float) -> bool:
    """Return whether all tests pass with a change."""

    def work() -> int:
        limit = int(PATIENCE + 10 * seconds)
        resource.setrlimit(resource.RLIMIT_CPU, (limit, limit + 5))
        sys.meta_path.insert(0, Finder(change))
        files = sorted({str(ROOT / test.split("::")[0]) for test in tests})
        return run(["-x", *files], Chosen(tests))

    return not tests or fork(work) in (0, 5)


def main() -> None:
    """Change, test and print a table."""
    number, seed = (int(x) for x in (sys.argv[1:] + ["300", "1"][len(sys.argv) - 1 :])[:2])
    noted = record(Path(tempfile.gettempdir()) / "mecanique_tests_by_line.json")
    caught = equivalent = 0
    drawn = random.Random(seed).sample(every_place(), number)
    for k, (path, place) in enumerate(drawn):
        change = change_at(path, place)
        tests = noted.covering(change)
        left = survives(change, tests, sum(noted.seconds[test] for test in tests))
        known = EQUIVALENT.get((path.stem, change.text))
        caught, equivalent = caught + (not left), equivalent + (left and known is not None)
        outcome = "caught" if not left else "equivalent" if known else "SURVIVED"
        where = f"{path.relative_to(SOURCE / 'mecanique')}:{change.lines.start}"
        print(f"{k + 1:4} {outcome:10} {len(tests):4} tests  {where}  {change.text}", flush=True)
    survived = number - caught - equivalent
    print(f"{number} changes: {caught} caught, {equivalent} equivalent, {survived} survived")


if __name__ == "__main__":
    main()

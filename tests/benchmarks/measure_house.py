"""How large the source is, how it reads, and what runs for a pendulum. By hand.

    python tests/benchmarks/measure_house.py [ROOT ...]

Prints a column for each checkout; the one that this file is in by default. Code lines have a token
that is no comment and no docstring; a function's length is in code lines, its inner functions
included. A name counts where it is a token of its own; files of the textbook are no part of a law.
What runs is that of the second call, on a pendulum with one joint, by `sys.setprofile`: files of
the package, their lines, functions, and the deepest stack of the package's own frames."""

from __future__ import annotations

import ast
import io
import json
import os
import statistics
import subprocess
import sys
import tempfile
import tokenize
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

VAGUE = ("found", "each", "one", "own", "other")

_SILENT = {
    tokenize.COMMENT,
    tokenize.NL,
    tokenize.NEWLINE,
    tokenize.INDENT,
    tokenize.DEDENT,
    tokenize.ENCODING,
    tokenize.ENDMARKER,
}

WALK = """
import json, sys
from pathlib import Path

import mecanique as mq

pendulum = mq.textbook.load("rigid_bar_pendulum")
motion = mq.simulate(pendulum, q=[0.3], duration=1.0)
root = str(Path(mq.__file__).parent)
acts = {
    "derive": lambda: str(mq.derive(pendulum)),
    "simulate": lambda: mq.simulate(pendulum, q=[0.3], duration=1.0),
    "check": lambda: mq.check(pendulum, "m l^2/3 q'' + m g l/2 sin(q) = 0"),
    "verify": lambda: mq.verify(pendulum, samples=10),
    "export": lambda: mq.export(motion, sys.argv[1]),
}
for name, act in acts.items():
    act()
    files, functions, depth, deepest = set(), set(), 0, 0

    def note(frame, event, argument):
        global depth, deepest
        code = frame.f_code
        if not code.co_filename.startswith(root):
            return
        if event == "call":
            files.add(code.co_filename)
            functions.add((code.co_filename, code.co_qualname))
            depth += 1
            deepest = max(deepest, depth)
        elif event == "return":
            depth -= 1

    sys.setprofile(note)
    try:
        act()
    finally:
        sys.setprofile(None)
    lines = sum(len(Path(file).read_bytes().splitlines()) for file in files)
    print(json.dumps([name, len(files), lines, len(functions), deepest]))
"""


def find_docstrings(tree: ast.Module) -> set[int]:
    """Return the lines of docstrings, and of the texts that explain constants."""
    lines: set[int] = set()
    for node in ast.walk(tree):
        for child in (
            getattr(node, "body", []) if isinstance(getattr(node, "body", 0), list) else []
        ):
            if (
                isinstance(child, ast.Expr)
                and isinstance(child.value, ast.Constant)
                and isinstance(child.value.value, str)
            ):
                lines.update(range(child.lineno, (child.end_lineno or child.lineno) + 1))
    return lines


def list_imports(tree: ast.Module) -> Iterator[str]:
    """Yield the modules of the package that a file imports, and what it takes from them."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            yield from (f"{node.module}.{alias.name}" for alias in node.names)
            yield node.module


def measure_text(root: Path) -> dict[str, str]:
    """Return the figures of a checkout's text by name."""
    source = root / "src" / "mecanique"
    code = tokens = comments = total = 0
    lengths: list[int] = []
    names: Counter[str] = Counter()
    importers: dict[str, set[str]] = {}
    laws = {"Rolling|Blade": 0, "Cord|Belt": 0}
    files = sorted(path for path in source.rglob("*.py") if "__pycache__" not in path.parts)
    dotted = {
        ".".join(path.relative_to(source.parent).with_suffix("").parts): path for path in files
    }
    for module, path in dotted.items():
        text = path.read_text(encoding="utf-8")
        tree = ast.parse(text)
        silent = find_docstrings(tree)
        marked: set[int] = set()
        named: set[str] = set()
        for token in tokenize.generate_tokens(io.StringIO(text).readline):
            if token.type == tokenize.COMMENT:
                comments += 1
            elif token.type not in _SILENT and token.start[0] not in silent:
                tokens += 1
                marked.update(range(token.start[0], token.end[0] + 1))
                if token.type == tokenize.NAME:
                    names[token.string] += 1
                    named.add(token.string)
        code += len(marked)
        total += len(text.splitlines())
        for node in ast.walk(tree):
            if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)):
                last = node.end_lineno or node.lineno
                lengths.append(sum(line in marked for line in range(node.lineno, last + 1)))
        for taken in set(list_imports(tree)) & dotted.keys():
            importers.setdefault(taken, set()).add(module)
        for law in laws:
            laws[law] += not named.isdisjoint(law.split("|")) and ".textbook." not in module
    once = [
        module
        for module, users in importers.items()
        if len(users) == 1 and ".textbook.systems." not in module
    ]
    lengths.sort()
    return {
        "files": f"{len(files)}",
        "lines": f"{total:,}",
        "code lines": f"{code:,}",
        "tokens a code line": f"{tokens / code:.2f}",
        "comments per 100 code lines": f"{100 * comments / code:.1f}",
        "function median / p99 / max": f"{statistics.median(lengths):.0f} / "
        f"{lengths[int(0.99 * len(lengths))]} / {lengths[-1]}",
        "modules with one importer": f"{len(once)}",
        **{f"name {name!r}": f"{names[name]:,}" for name in VAGUE},
        **{f"files that name {law}": f"{number}" for law, number in laws.items()},
    }


def measure_walk(root: Path) -> dict[str, str]:
    """Return what runs for a pendulum, by act: files / lines / functions / deepest stack."""
    environment = {**os.environ, "PYTHONPATH": str(root / "src")}
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run(
            [sys.executable, "-c", WALK, str(Path(folder) / "page.html")],
            capture_output=True,
            encoding="utf-8",
            check=True,
            env=environment,
            cwd=folder,
        )
    rows = [json.loads(line) for line in done.stdout.splitlines() if line.startswith("[")]
    return {
        f"{name}: files / lines / functions / stack": " / ".join(f"{n:,}" for n in figures)
        for name, *figures in rows
    }


def main() -> None:
    """Print the table."""
    roots = [Path(root).resolve() for root in sys.argv[1:]] or [Path(__file__).parents[2]]
    columns = [measure_text(root) | measure_walk(root) for root in roots]
    print(f"{'':44}", *(f"{root.name:>24}" for root in roots))
    for name in columns[0]:
        print(f"{name:44}", *(f"{column.get(name, ''):>24}" for column in columns))


if __name__ == "__main__":
    main()

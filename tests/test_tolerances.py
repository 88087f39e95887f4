"""Every comparison states its tolerances: what numpy and pytest take by default is not meant."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]

FOLDERS = ("examples", "src", "tests")

COMPARISONS = {"np.testing.assert_allclose", "np.allclose", "np.isclose"}


def omissions(tree: ast.AST) -> Iterator[str]:
    """Yield each comparison that leaves a tolerance to numpy or to pytest.

    In numpy, `atol` alone keeps a relative tolerance, which hides what large values are off by;
    `rtol` alone keeps an absolute one in `allclose`, within which all small values are alike.
    pytest takes 1e-6 of the value where neither is given.
    """
    for node in ast.walk(tree):
        match node:
            case ast.Call(func=function, keywords=keywords):
                name, stated = ast.unparse(function), {each.arg for each in keywords}
                silent = name in COMPARISONS and not {"rtol", "atol"} <= stated
                if silent or (name == "pytest.approx" and not {"rel", "abs"} & stated):
                    yield f"line {node.lineno}: {ast.unparse(node)}"


@pytest.mark.parametrize(
    "code",
    [
        "np.testing.assert_allclose(a, b)",
        "np.testing.assert_allclose(a, b, atol=1e-9)",
        "np.allclose(a, b, rtol=1e-9)",
        "assert not any(np.isclose(a, b, atol=1e-9))",
        "assert a == pytest.approx(b, nan_ok=True)",
    ],
)
def test_the_rule_finds(code: str) -> None:
    assert len(list(omissions(ast.parse(code)))) == 1


def test_the_rule_passes() -> None:
    code = "np.allclose(a, b, rtol=0, atol=1e-9), x == pytest.approx(y, abs=1e-9), assert_equal(a)"
    assert not list(omissions(ast.parse(code)))


def test_every_comparison_states_its_tolerances() -> None:
    files = [path for folder in FOLDERS for path in sorted((ROOT / folder).rglob("*.py"))]
    found: list[str] = []
    for path in files:
        text = path.read_text(encoding="utf-8")
        if "close(" in text or "approx(" in text:
            where = path.relative_to(ROOT).as_posix()
            found += [f"{where}, {omission}" for omission in omissions(ast.parse(text))]
    assert found == []

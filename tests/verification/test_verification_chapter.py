"""The register: every equation of the chapter has a row, and its misprints are detected."""

from __future__ import annotations

import json
from typing import Any

import pytest
from click.testing import CliRunner

from mecanique.cli import app
from mecanique.derivation.printing.expressions import to_sympy
from mecanique.derivation.scalars.series import Series
from mecanique.verification.chapter import examples, register, sections
from mecanique.verification.chapter.row import (
    ChapterRow,
    agreement,
    decision,
    identity,
    misprint,
    open_point,
)

ERRORS = {"1.26", "Ex. 1.2 2", "Ex. 1.2 5"}

WRONG_IN_WORDS = {
    "sect. 1.1 a",
    "sect. 1.2 a",
    "before 1.3",
    "after 1.3",
    "before 1.11",
    "after 1.12",
    "after 1.26",
    "before 1.27",
    "after 1.27",
    "Ex. 1.2 words a",
    "after Ex.1.2.h",
    "sect. 1.3.5",
}


@pytest.fixture(scope="module")
def printed() -> dict[str, Any]:
    """What forms as printed are off by, by the numbers of their rows; `every_row` fills it."""
    return {}


@pytest.fixture(scope="module")
def every_row(printed: dict[str, Any]) -> tuple[ChapterRow, ...]:
    def keep(number: str, states: str, how: str, off: Any, *more: Any, **words: str) -> ChapterRow:
        printed[number] = list(off)
        return misprint(number, states, how, off, *more, **words)

    with pytest.MonkeyPatch.context() as patch:
        for module in (examples, sections):
            patch.setattr(module, "misprint", keep)
        return register.__wrapped__()


@pytest.fixture(scope="module")
def rows(every_row: tuple[ChapterRow, ...]) -> dict[str, ChapterRow]:
    found = {row.number: row for row in every_row}
    assert len(found) == len(every_row)
    return found


def test_every_numbered_equation_has_a_row_in_order(rows: dict[str, ChapterRow]) -> None:
    numbered = [number for number in rows if number.startswith("1.") and " " not in number]
    assert numbered == [f"1.{k}" for k in range(1, 34)]
    assert {f"Ex.1.2.{letter}" for letter in "abcdefghij"} <= set(rows)


def test_what_does_not_hold_as_printed_is_mended_and_proven(rows: dict[str, ChapterRow]) -> None:
    assert {row.number for row in rows.values() if _wrong(row, "equation")} == ERRORS
    assert all(row.sound for row in rows.values())
    sign = rows["1.26"]
    assert sign.right == "q'' + (3/2)(g/l) sin(q) = 0"
    assert "minus" not in sign.proof
    assert "plus sign" in sign.proof


def test_what_is_printed_is_off_by_what_the_proof_says(
    rows: dict[str, ChapterRow], printed: dict[str, Any]
) -> None:
    from sympy import Function, Symbol, simplify, symbols

    m, k, l = symbols("m k l", positive=True)
    t = Symbol("t")
    q, x, y, theta = (Function(name)(t) for name in ("q", "x", "y", "theta"))
    v, a = q.diff(t), q.diff(t, 2)
    turning = m * (x**2 + y**2) * theta.diff(t, 2)
    expected: dict[str, list[Any]] = {
        "sect. 1.2 a": [-1],  # one of ten distances follows from the others
        "after 1.3": [m * l**2 / 3 * (a - v)],
        "after 1.12": [m * (x * y.diff(t, 2) - y * x.diff(t, 2)) - turning],
        "1.26": ["-3*g*sin(q)/l"],
        "after 1.26": ["-3*g*sin(q)/l"],
        "Ex. 1.2 2": [0, -4 * l / 3],
        "Ex. 1.2 5": [0, 0, 0, -v / 2],  # v_F = -q', and the mass is at E
        "Ex. 1.2 words a": [l, l / 3],
        "after Ex.1.2.h": [-k / 4, -m * 3 / 16, -m / 2],  # slopes by q and q'', none by q'
    }
    assert printed.keys() == expected.keys()
    for number, offs in expected.items():
        assert rows[number].holds is False
        for difference, off in zip(printed[number], offs, strict=True):
            if isinstance(difference, Series):
                assert str(to_sympy(difference)) == off
            else:
                assert simplify(difference - off) == 0, number


def test_numeric_rows_state_their_residual(rows: dict[str, ChapterRow]) -> None:
    equations = [row for row in rows.values() if row.about == "equation"]
    numeric = [row for row in equations if row.kind == "numeric"]
    assert numeric
    assert all(row.residual is not None and row.residual < 1e-9 for row in numeric)
    symbolic = [row for row in equations if row.kind == "symbolic identity"]
    assert all(row.residual is None for row in symbolic)
    assert (len(numeric), len(symbolic)) == (15, 63)


def test_sentences_that_are_wrong_are_named_with_what_is_right(rows: dict[str, ChapterRow]) -> None:
    assert {row.number for row in rows.values() if _wrong(row, "sentence")} == WRONG_IN_WORDS
    assert all(rows[number].right and rows[number].proof for number in WRONG_IN_WORDS)
    assert "B is at x = 3 l, E at 2 l" in rows["Ex. 1.2 words a"].proof
    assert "rates of the angular momenta" in rows["after 1.3"].right
    assert "q and q''" in rows["after Ex.1.2.h"].right
    assert "work done by the external forces" in rows["after 1.27"].right
    assert rows["after 1.27"].kind == "read"
    right = [row for row in rows.values() if row.about == "sentence" and row.holds]
    assert len(right) == 20


def test_what_is_not_checked_is_said_with_its_reason(rows: dict[str, ChapterRow]) -> None:
    left = [row for row in rows.values() if row.holds is None]
    assert len(left) == 11
    assert all(row.kind == "not checked" and row.how and row.sound for row in left)
    assert "not checked: " in str(rows["figures"])


def test_no_sentence_of_the_chapter_holds_without_a_fact() -> None:
    assert not decision("0", "", "").holds
    assert not decision("0", "", "", True, False).holds
    assert not decision("0", "", "", True, False).sound
    assert decision("0", "", "", True, True).holds
    assert open_point("0", "", "why").to_dict()["holds"] is None


def _wrong(row: ChapterRow, about: str) -> bool:
    return row.holds is False and row.about == about


def test_a_false_statement_is_detected() -> None:
    from sympy import Symbol, sin

    x = Symbol("x")
    assert not identity("0", "", "", sin(x) - x).holds
    assert not identity("0", "", "", x - x, x).sound
    assert not identity("0", "", "").sound
    assert not agreement("0", "", "", (1.0, 1.0), (1.0, 1.1)).holds
    # however large or small the sides are
    assert not agreement("0", "", "", (1e-12, 1.1e-12)).holds
    assert agreement("0", "", "", (1e12, 1e12 * (1 + 1e-15))).holds
    unproven = misprint("0", "", "", [sin(x) - x], [sin(x) - 2 * x], right="sin(x) = 2 x", proof="")
    assert not unproven.sound
    assert "IS NOT PROVEN" in str(unproven)
    assert misprint("0", "", "", [x - x], [x], right="", proof="").holds


def test_the_command_prints_text_and_json(
    every_row: tuple[ChapterRow, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("mecanique.verification.chapter.register", lambda: every_row)
    text = CliRunner().invoke(app, ["book"])
    assert text.exit_code == 0
    assert (
        "3 in error as printed (1.26, Ex. 1.2 2, Ex. 1.2 5), each with its right form proven"
        in text.output
    )
    assert "12 in error as printed (sect. 1.2 a, after 1.3," in text.output
    assert "; 11 points not checked" in text.output
    data = json.loads(CliRunner().invoke(app, ["book", "--json"]).output)
    assert {row["number"] for row in data if row["holds"] is False} == ERRORS | WRONG_IN_WORDS
    assert sum(row["holds"] is None for row in data) == 11
    assert all(row["sound"] for row in data)

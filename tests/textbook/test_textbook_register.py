"""The register: every equation of the chapter has a row, and its misprints are detected."""

from __future__ import annotations

import json

import pytest
from typer.testing import CliRunner

from mecanique.cli import app
from mecanique.textbook.register import register
from mecanique.textbook.register.row import Row, agreement, identity, misprint

ERRORS = {"1.26", "Ex. 1.2 2", "Ex. 1.2 5"}


@pytest.fixture(scope="module")
def rows() -> dict[str, Row]:
    return {row.number: row for row in register()}


def test_every_numbered_equation_has_a_row_in_order(rows: dict[str, Row]) -> None:
    numbered = [number for number in rows if number.startswith("1.") and " " not in number]
    assert numbered == [f"1.{k}" for k in range(1, 34)]
    assert {f"Ex.1.2.{letter}" for letter in "abcdefghij"} <= set(rows)


def test_what_does_not_hold_as_printed_is_mended_and_proven(rows: dict[str, Row]) -> None:
    assert {number for number, row in rows.items() if not row.holds} == ERRORS
    assert all(row.sound for row in rows.values())
    sign = rows["1.26"]
    assert sign.right == "q'' + (3/2)(g/l) sin(q) = 0"
    assert "minus" not in sign.proof
    assert "plus sign" in sign.proof


def test_numeric_rows_state_their_residual(rows: dict[str, Row]) -> None:
    numeric = [row for row in rows.values() if row.kind == "numeric"]
    assert numeric
    assert all(row.residual is not None and row.residual < 1e-9 for row in numeric)
    symbolic = [row for row in rows.values() if row.kind == "symbolic identity"]
    assert all(row.residual is None for row in symbolic)
    assert (len(numeric), len(symbolic)) == (15, 63)


def test_a_false_statement_is_detected() -> None:
    from sympy import Symbol, sin

    x = Symbol("x")
    assert not identity("0", "", "", sin(x) - x).holds
    assert not identity("0", "", "", x - x, x).sound
    assert not identity("0", "", "").sound
    assert not agreement("0", "", "", (1.0, 1.0), (1.0, 1.1)).holds
    unproven = misprint("0", "", "", [sin(x) - x], [sin(x) - 2 * x], right="sin(x) = 2 x", proof="")
    assert not unproven.sound
    assert "IS NOT PROVEN" in str(unproven)
    assert misprint("0", "", "", [x - x], [x], right="", proof="").holds


def test_the_command_prints_text_and_json() -> None:
    text = CliRunner().invoke(app, ["book"])
    assert text.exit_code == 0
    assert (
        "3 in error as printed (1.26, Ex. 1.2 2, Ex. 1.2 5), each with its right form proven"
        in text.output
    )
    data = json.loads(CliRunner().invoke(app, ["book", "--json"]).output)
    assert {row["number"] for row in data if not row["holds"]} == ERRORS
    assert all(row["sound"] for row in data)

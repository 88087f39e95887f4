"""The verdict: one number decides, what is not finite counts, every form says the same."""

from __future__ import annotations

import json
import math
import pickle
from dataclasses import replace

import pytest

import mecanique as mq
from mecanique.model.mechanism.origin import Finding
from mecanique.verification import Row, Verdict
from mecanique.verification.verdict import Change, EngineReading, dissenters_among

GOOD = Row("mass matrix", ("jets", "Pinocchio"), 2e-16, (0.5,), (1.5,), 0.0)
BAD = Row("bias", ("jets", "Pinocchio"), 0.25, (0.1,), (-2.0,), 3.0)


def verdict(*rows: Row) -> Verdict:
    return Verdict(
        "p<b>", rows, 100, 7, 1e-9, ("q",), ("q'",), {"numpy": "2.0"}, ("left out: nothing",)
    )


def test_it_agrees_when_every_row_is_within_the_tolerance() -> None:
    found = verdict(GOOD, replace(GOOD, worst=1e-9))
    assert found.agrees
    assert found.worst == 1e-9
    assert str(found).startswith(
        "p<b>: agrees at 100 random states (seed 7), worst relative difference 1.0e-09"
    )


def test_it_disagrees_when_one_row_does_and_says_where() -> None:
    found = verdict(GOOD, BAD)
    assert not found.agrees
    assert found.worst == 0.25
    text = str(found)
    assert text.startswith("p<b>: DISAGREES at 100 random states (seed 7): bias (tolerance 1e-09)")
    assert "bias, jets and Pinocchio: worst at q = 0.1, q' = -2, t = 3" in text
    assert "mass matrix, jets" not in text
    assert text.endswith("left out: nothing")


@pytest.mark.parametrize("worst", [math.nan, math.inf])
def test_what_is_not_finite_never_agrees_and_stays_json(worst: float) -> None:
    found = verdict(
        replace(GOOD, worst=worst, remark="jets is not finite at 1 of 100 states"), GOOD
    )
    assert found.worst == math.inf
    assert not found.agrees
    assert "not finite" in str(found)
    data = json.loads(
        found.to_json(), parse_constant=lambda name: pytest.fail(f"{name} is no JSON")
    )
    assert data["worst"] is None
    assert data["rows"][0]["worst"] is None
    assert data["agrees"] is False


def test_nothing_compared_is_no_agreement() -> None:
    found = verdict()
    assert not found.agrees
    assert "nothing was compared" in str(found)


def test_the_table_has_a_line_per_quantity_and_a_column_per_source() -> None:
    other = replace(GOOD, sources=("recursion", "Pinocchio"), worst=3e-15)
    found = verdict(GOOD, other, BAD)
    assert found.table == (
        ("difference from Pinocchio", "jets", "recursion"),
        ("mass matrix", "2.0e-16", "3.0e-15"),
        ("bias", "2.5e-01 !", ""),
    )
    lines = str(found).splitlines()
    assert lines[1].split() == ["difference", "from", "Pinocchio", "jets", "recursion"]
    assert lines[2].split() == ["mass", "matrix", "2.0e-16", "3.0e-15"]
    assert lines[3].split() == ["bias", "2.5e-01", "!"]
    mixed = verdict(GOOD, replace(GOOD, sources=("jets", "recursion")))
    assert mixed.table[0] == ("relative difference", "jets = Pinocchio", "jets = recursion")


def test_remarks_are_told_below() -> None:
    found = verdict(replace(GOOD, remark="up to a constant"))
    assert found.remarks == (
        "mass matrix, jets and Pinocchio: up to a constant",
        "left out: nothing",
    )


def test_json_holds_everything() -> None:
    data = json.loads(verdict(GOOD, BAD).to_json())
    assert data["mechanism"] == "p<b>"
    assert data["rows"][1] == {
        "quantity": "bias",
        "sources": ["jets", "Pinocchio"],
        "worst": 0.25,
        "agrees": False,
        "tolerance": 1e-9,
        "entry": [],
        "q": {"q": 0.1},
        "v": {"q'": -2.0},
        "t": 3.0,
        "remark": "",
    }
    assert (data["samples"], data["seed"], data["tolerance"]) == (100, 7, 1e-9)
    assert data["versions"] == {"numpy": "2.0"}
    assert data["notes"] == ["left out: nothing"]


def test_rounding_allows_more_where_it_explains_more_and_says_so() -> None:
    close = replace(GOOD, quantity="acceleration", worst=2e-8, rounding=5e-8)
    found = verdict(close)
    assert found.agrees
    assert found.summary.startswith("p<b>: agrees")
    assert found.remarks[0] == (
        "acceleration, jets and Pinocchio: rounding may make 5.0e-08, from the conditioning at "
        "q = 0.5, q' = 1.5, t = 0"
    )
    assert found.to_dict()["rows"][0]["tolerance"] == 5e-8
    far = verdict(replace(close, worst=6e-8))
    assert not far.agrees
    assert "6.0e-08 !" in str(far)


def test_html_escapes_what_users_named() -> None:
    html = verdict(GOOD)._repr_html_()
    assert "p&lt;b&gt;" in html
    assert "<b>" not in html
    assert html.count("<tr>") == 2


def test_it_is_frozen_and_survives_pickling() -> None:
    found = verdict(GOOD)
    assert pickle.loads(pickle.dumps(found)) == found
    with pytest.raises(AttributeError):
        found.seed = 3  # type: ignore[misc]  # that is the point


@pytest.mark.parametrize(
    ("worst", "head"),
    [(0.25, ": its M and bias differ by up to 25 %"), (math.inf, ""), (None, None), (1e-6, None)],
)
def test_an_engine_that_reads_otherwise_says_by_how_much_and_six_remarks(
    worst: float | None, head: str | None
) -> None:
    remarks = tuple(f"remark {k}" for k in range(8))
    reading = EngineReading("Engine 1", worst, remarks=remarks)
    data = reading.to_dict()
    assert data["worst"] == (worst if worst is not None and math.isfinite(worst) else None)
    assert data["differs"] == reading.differs == (head is not None)
    if head is None:
        assert not reading.sentences()
        return
    first = f"Engine 1 reads the file itself otherwise{head}"
    assert reading.sentences() == (first, *remarks[:6], "… and 2 remarks more in --json")
    assert replace(reading, remarks=remarks[:6]).sentences() == (first, *remarks[:6])


def test_a_change_that_was_not_weighed_has_no_weight_in_json() -> None:
    assert Change("link 'a'", "mass").to_dict()["weight"] is None
    assert Change("link 'a'", "mass", weight=0.5).to_dict()["weight"] == 0.5


@pytest.mark.parametrize(
    ("alike", "apart"),
    [
        ({"A": ("mecanique", "B"), "B": ("mecanique", "A"), "C": ()}, ("C",)),
        ({"A": ("B",), "B": ("A",)}, ("mecanique",)),
        ({"A": ("mecanique",), "B": ()}, ("B",)),
        ({"A": (), "B": ()}, ()),
        ({"A": ()}, ()),
        ({"A": ("B",), "B": ("A",), "C": ("mecanique",)}, ()),
    ],
)
def test_who_reads_otherwise_than_more_than_half_stands_apart(
    alike: dict[str, tuple[str, ...]], apart: tuple[str, ...]
) -> None:
    readings = [EngineReading(name, 0.0, alike=others) for name, others in alike.items()]
    readings.append(EngineReading("D", None))  # refused: it has no vote
    assert dissenters_among(readings) == apart


@pytest.mark.parametrize("ratio", [1.0, 1e6])
def test_what_moves_no_mass_is_told_from_what_moves_little(ratio: float) -> None:
    bodies = [mq.Body(name, mq.particle(m)) for name, m in (("a", ratio), ("b", 1 / ratio))]
    joints = (
        mq.Prismatic(f"on_{name}", "ground", name, axis=(1, 0, 0), coordinate=name)
        for name in ("a", "b", "c")
    )
    loose = mq.Mechanism("loose", (mq.Body("ground"), *bodies, mq.Body("c")), tuple(joints))
    found = mq.verify(loose)
    assert found.agrees
    assert found.remarks[-1].endswith("which nothing determines: c' moves no mass")


def test_ten_flaws_are_listed_and_the_others_counted() -> None:
    flaw = Finding("M203", "warning", "<text>", 7, "joint 'j'", "bad", "why", "mend it", "name")
    for count, last in (
        (10, "flaw in line 7"),
        (11, "… and 1 flaw more;"),
        (13, "… and 3 flaws more;"),
    ):
        lines = str(replace(verdict(GOOD), flaws=(flaw,) * count)).splitlines()
        assert sum("flaw in line 7" in line for line in lines) == 10
        assert last in lines[-1]

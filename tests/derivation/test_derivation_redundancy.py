"""Redundant constraints are named in the steps of a derivation, without the reference's help."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import pytest
from systems import derive_system

import mecanique as mq
from mecanique.derivation.numeric.constraints.redundancy import find_redundancy
from mecanique.derivation.symbolic import multipliers

START = {name: mq.textbook.entry(name).start for name in ("governor", "bricard_linkage")}


@pytest.mark.parametrize(
    "name",
    ["bricard_linkage", "four_bar_linkage", "governor", "rolling_disk", "two_wheeled_cart"],
)
def test_the_same_rows_are_redundant_as_by_the_reference(name: str) -> None:
    mechanism = mq.textbook.load(name)
    known = mq.degrees_of_freedom(mechanism, q=START.get(name)).redundant
    assert find_redundancy(mechanism).rows == known


def test_both_wheels_of_a_cart_keep_the_axle_from_sliding() -> None:
    """Friction along the axle has parts along x and y of the plane, so that four are open."""
    shared = tuple(f"{side}_contact: {axis}" for side in ("left", "right") for axis in "xy")
    assert find_redundancy(mq.textbook.load("two_wheeled_cart")).shared == shared


@pytest.mark.parametrize("scale", [1e-5, 1e-3, 1e5])
@pytest.mark.parametrize("name", ["four_bar_linkage", "two_wheeled_cart"])
def test_what_is_redundant_does_not_depend_on_the_unit_of_length(name: str, scale: float) -> None:
    mechanism = mq.textbook.load(name)
    parameters = tuple(
        replace(p, value=p.value * scale) if p.unit == "m" else p for p in mechanism.parameters
    )
    assert find_redundancy(replace(mechanism, parameters=parameters)) == find_redundancy(mechanism)


def test_a_folded_governor_is_no_reason_to_call_a_link_redundant() -> None:
    """Where the sleeve meets the pivot, both links ask for the same; elsewhere they do not."""
    governor = mq.textbook.load("governor")
    assert mq.degrees_of_freedom(governor, q={"s": 0.0}).redundant == ("link2: length",)
    assert find_redundancy(governor) == ((), ())


def test_the_steps_name_them() -> None:
    # across the plane of its motion a disk has no equation, which could be redundant
    assert "Redundant" not in derive_system("rolling_disk").text(steps=True)
    by_bodies = derive_system("two_wheeled_cart", method="newton_euler").text(steps=True)
    assert "right_contact: x and right_contact: y are undetermined individually" in " ".join(
        by_bodies.split()
    )
    work = derive_system("two_wheeled_cart", method="virtual_work").text(steps=True)
    assert "nothing more.\n" in work  # no force appears in it
    assert "Redundant" not in derive_system("four_bar_linkage").text(steps=True)


@pytest.mark.parametrize("of_work", [False, True])
@pytest.mark.parametrize(
    ("rows", "shared", "said"),
    [
        ((), (), ()),
        (
            ("a: x",),
            ("b: y",),
            ("a: x follows from", "it restrains", "The force of b: y is undetermined."),
        ),
        (
            ("a: x", "b: y", "c: rz"),
            ("b: y", "a: x"),
            (
                "a: x and b: y follow from",
                "they restrain",
                "The forces of b: y and a: x are undetermined individually;",
            ),
        ),
    ],
    ids=["none", "one", "two"],
)
def test_redundant_rows_are_told_alone_or_together(
    monkeypatch: pytest.MonkeyPatch,
    rows: tuple[str, ...],
    shared: tuple[str, ...],
    said: tuple[str, ...],
    *,
    of_work: bool,
) -> None:
    """Of rows that have an equation, which c: rz has not; in virtual work no force appears."""
    monkeypatch.setattr(multipliers, "find_redundancy", lambda _: (rows, shared))
    ties: Any = [SimpleNamespace(name=name) for name in ("a_x", "b_y")]
    mechanism = mq.textbook.load("four_bar_linkage")
    stages = multipliers.redundancy_stages(mechanism, ties, of_work=of_work)
    assert len(stages) == bool(rows)
    for stage in stages:
        follow, restrain, force = said
        assert follow in stage.explanation
        assert restrain in stage.explanation
        assert (force in stage.explanation) is not of_work
    assert not multipliers.redundancy_stages(mq.textbook.load("simple_pendulum"), ties)

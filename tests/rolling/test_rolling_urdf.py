"""Contacts are written as tags of our own, and read back."""

from __future__ import annotations

import pytest
from rolling_samples import bowl, sleigh, stone, turntable, wheel

from mecanique import Mechanism, Placement, Reference, UrdfError, lint, read_urdf, write_urdf
from mecanique.verification.states import random_states

ALL = [
    wheel(0.1, Placement((0, 0, 0.1), (0.2, 0.3, 0.1))),
    wheel(),
    turntable(),
    sleigh(),
    bowl(-2.0),
    stone(),
    wheel(friction=0.3),
]


@pytest.mark.parametrize(
    "mechanism",
    ALL,
    ids=["tilted", "wheel", "turntable", "sleigh", "dome", "ellipsoid", "friction"],
)
def test_contacts_are_read_as_they_were_written(mechanism: Mechanism) -> None:
    text = write_urdf(mechanism)
    read = read_urdf(text)
    assert write_urdf(read).count("<mecanique:") == text.count("<mecanique:") == 1
    for ours, theirs in zip(mechanism.contacts, read.contacts, strict=True):
        assert (ours.name, ours.body, ours.on) == (theirs.name, theirs.body, theirs.on)
        assert mechanism.evaluate_all(ours.scalars) == list(theirs.scalars)
        for name in ("axis", "along", "normal"):
            given, again = (getattr(each, name, None) or 0 for each in (ours, theirs))
            assert given == pytest.approx(again, rel=1e-12)


def test_what_is_read_moves_alike() -> None:
    mechanism = wheel(0.1, Placement((0, 0, 0.1), (0.2, 0.3, 0.1)))
    read = read_urdf(write_urdf(mechanism))
    states = random_states(mechanism, 3, 6, lot=8)
    found = Reference(read).acceleration(states.q, states.v)
    expected = Reference(mechanism).acceleration(states.q, states.v)
    assert found == pytest.approx(expected, rel=1e-12, abs=1e-12)


def test_others_are_noted_to_ignore_it() -> None:
    findings = lint(write_urdf(wheel()))
    assert "M610" in {finding.code for finding in findings}
    assert not [finding for finding in findings if finding.severity == "error"]


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('link="disk" on=', 'link="disc" on=', "'disc' is no link"),
        ('on="ground"', 'on="disk"', "both of its ends are on link 'disk'"),
        ('radius="0.5"', "", "has no radius"),
        ('axis="0 1 0"', 'axis="0 0 0"', "with a length for the axis of rolling 'rim'"),
        ('crown="0"', 'crown="0.7"', "a sharp edge, to the radius 0.5, a ball, got 0.7"),
    ],
)
def test_wrong_data_is_refused_with_its_place(old: str, new: str, message: str) -> None:
    text = write_urdf(wheel())
    assert old in text
    with pytest.raises(UrdfError, match=message):
        read_urdf(text.replace(old, new))

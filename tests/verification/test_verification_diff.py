"""Two descriptions compared as descriptions."""

from __future__ import annotations

import json
import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import mecanique as mq
from mecanique.cli import app
from mecanique.verification.diff import _pair_elements, _welds, vector_slip
from mecanique.verification.verdict import Change

ARM = """<robot name="arm">
<link name="base"/>
<link name="upper"><inertial><origin xyz="0.1 0.2 -0.3"/><mass value="2"/>
<inertia ixx="0.03" iyy="0.02" izz="0.04" ixy="0.001" ixz="0.002" iyz="0.003"/></inertial></link>
<link name="lower"><inertial><origin xyz="0 0 -0.2"/><mass value="1"/>
<inertia ixx="0.01" iyy="0.01" izz="0.005" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="tool"><inertial><origin xyz="0 0 0.1"/><mass value="0.5"/>
<inertia ixx="0.001" iyy="0.001" izz="0.001" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/>
<origin xyz="0.1 0.2 0.5" rpy="0.3 0.5 0.7"/><axis xyz="0 1 0"/>
<limit lower="-1" upper="1.5" effort="9" velocity="3"/></joint>
<joint name="elbow" type="revolute"><parent link="upper"/><child link="lower"/>
<origin xyz="0 0.05 -0.6"/><axis xyz="0 1 0"/>
<limit lower="-2" upper="2" effort="9" velocity="3"/></joint>
<joint name="flange" type="fixed"><parent link="lower"/><child link="tool"/>
<origin xyz="0 0 -0.4"/></joint>
</robot>"""


def changed(old: str, new: str) -> tuple[Change, ...]:
    assert old in ARM
    return mq.diff(ARM, ARM.replace(old, new)).changes


def test_the_same_written_another_way_is_the_same() -> None:
    found = mq.diff(ARM, ARM.replace('value="2"', 'value="2.000"').replace("1.5", "15e-1"))
    assert found.same
    assert found.summary == "arm and the other arm describe the same mechanism"


_INERTIA = 'ixx="0.03" iyy="0.02" izz="0.04" ixy="0.001" ixz="0.002" iyz="0.003"'
_ENTRIES = "ixx", "iyy", "izz", "ixy", "ixz", "iyz"


def _written(tensor: np.ndarray) -> str:
    entries = tensor[(0, 1, 2, 0, 0, 1), (0, 1, 2, 1, 2, 2)]
    return " ".join(f'{n}="{x:.9g}"' for n, x in zip(_ENTRIES, entries, strict=True))


TENSOR = np.array([[0.03, 0.001, 0.002], [0.001, 0.02, 0.003], [0.002, 0.003, 0.04]])
DIAGONAL = np.diag(np.diag(TENSOR))
C = np.array([0.1, 0.2, -0.3])
LEVER = 2 * (C @ C * np.eye(3) - np.outer(C, C))
TURN = np.array(mq.Placement(rpy=(0.2, 0.4, 0.1)).rotation, dtype=float)
REORDERED = "0.7 0.5 0.3"
MOVING = "0.556103377 0.160617815 0.8230825"
"""Rx(0.3) Ry(0.5) Rz(0.7) as turns about fixed axes."""

SLIPS = {
    "grams for kilograms": ('value="2"', 'value="2000"'),
    "a decimal point (×10)": ('value="2"', 'value="20"'),
    "pounds for kilograms": ('value="2"', 'value="4.40924524"'),
    "millimeters for meters": ('xyz="0.1 0.2 -0.3"', 'xyz="100 200 -300"'),
    "mirrored (y with the other sign)": ('xyz="0.1 0.2 -0.3"', 'xyz="0.1 -0.2 -0.3"'),
    "axes exchanged (y, x, z)": ('xyz="0.1 0.2 -0.3"', 'xyz="0.2 0.1 -0.3"'),
    "kg·mm² for kg·m²": (_INERTIA, _written(1e6 * TENSOR)),
    "about the link's origin instead of": (_INERTIA, _written(TENSOR + LEVER)),
    "products of inertia with the other": (_INERTIA, _written(2 * DIAGONAL - TENSOR)),
    "the same principal moments about": (_INERTIA, _written(TURN @ TENSOR @ TURN.T)),
    "products of inertia left out": (_INERTIA, _written(DIAGONAL)),
    "degrees for radians": ('rpy="0.3 0.5 0.7"', 'rpy="17.1887339 28.6478898 40.1070457"'),
    "a decimal point (×10) of iyy alone": (_INERTIA, _INERTIA.replace("0.02", "0.2", 1)),
    "rpy in the order r, y, p": ('rpy="0.3 0.5 0.7"', 'rpy="0.3 0.7 0.5"'),
    "turned about moving axes x, y, z": ('rpy="0.3 0.5 0.7"', f'rpy="{MOVING}"'),
    "rpy in the order y, p, r": ('rpy="0.3 0.5 0.7"', f'rpy="{REORDERED}"'),
    "the other sign": ('lower="-1" upper="1.5"', 'lower="1" upper="-1.5"'),
    "reversed": ('"0.3 0.5 0.7"/><axis xyz="0 1 0"/>', '"0.3 0.5 0.7"/><axis xyz="0 -1 0"/>'),
}  # fmt: skip


@pytest.mark.parametrize("slip", [name for name in SLIPS if name != "the other sign"])
def test_likely_slips_are_named(slip: str) -> None:
    (change,) = changed(*SLIPS[slip])
    assert change.slip.startswith(slip)
    assert change.where in ("link 'upper'", "joint 'shoulder'")
    assert change.weight >= 0


@pytest.mark.parametrize("place", range(3))
@pytest.mark.parametrize(
    ("factor", "words"),
    [
        (10.0, "a decimal point (×10) of {} alone"),
        (0.1, "a decimal point (÷10) of {} alone"),
        (1e3, "millimeters for meters of {} alone"),
        (1e-3, "meters for millimeters of {} alone"),
        (1e2, ""),
        (1e-2, ""),
    ],
)
def test_a_slip_in_one_number_of_a_position_is_named(factor: float, words: str, place: int) -> None:
    """Of a single number only what is common is told: a digit, or the unit."""
    before = np.array([0.1, 0.2, -0.3])
    after = before * np.where(np.arange(3) == place, factor, 1.0)
    assert vector_slip(before, after) == words.format("xyz"[place])


def test_limits_in_degrees() -> None:
    (change,) = changed('lower="-2" upper="2"', 'lower="-114.591559" upper="114.591559"')
    assert (change.what, change.slip) == ("limits", "degrees for radians")
    assert math.isnan(change.weight)


def test_weight_is_the_change_of_mass_matrix_and_bias() -> None:
    """One hinge: M = m l² grows by 10 % with the mass, and the bias m g l sin q as much."""
    text = """<robot name="r"><link name="a"/><link name="b"><inertial><origin xyz="0 0 -1"/>
    <mass value="1"/><inertia ixx="0" iyy="0" izz="0" ixy="0" ixz="0" iyz="0"/></inertial></link>
    <joint name="j" type="continuous"><parent link="a"/><child link="b"/><axis xyz="0 1 0"/></joint>
    </robot>"""
    (change,) = mq.diff(text, text.replace('value="1"', 'value="1.1"')).changes
    assert change.weight == pytest.approx(0.1 / 1.1, rel=1e-9)
    assert (change.before, change.after) == ("1", "1.1 kg (+10 %)")


def test_a_millionth_of_a_mass_is_listed_with_digits_that_show_it() -> None:
    """It was taken for links merged into their parents, which happened nowhere."""
    for value in (1, 2):
        text = ARM.replace(f'mass value="{value}"', f'mass value="{value * (1 + 1e-6)!r}"')
        (change,) = mq.diff(ARM, text).changes
        after = f"{value}.00000{value} kg (+0.0001 %)"
        assert (change.what, change.before, change.after) == ("mass", str(value), after)


def test_what_changes_the_equations_most_comes_first() -> None:
    heavier = ARM.replace('mass value="2"', 'mass value="2.1"')
    text = heavier.replace('mass value="1"', 'mass value="9"')
    weights = [change.weight for change in mq.diff(ARM, text).changes]
    assert len(weights) == 2
    assert weights == sorted(weights, reverse=True)
    assert weights[0] > weights[1]


HAND = ARM.replace('"tool"', '"hand"').replace('"flange"', '"wrist"')
"""The tool and its joint with other names."""


def test_a_link_is_known_by_its_numbers_where_its_joint_is_renamed_too() -> None:
    assert {str(change) for change in mq.diff(ARM, HAND).changes} == {
        "link 'tool': renamed 'tool' → 'hand'",
        "joint 'flange': renamed 'flange' → 'wrist'",
    }


def test_the_grounds_match_whatever_they_are_called() -> None:
    world = ARM.replace('"base"', '"world"')
    assert world != ARM
    assert [str(change) for change in mq.diff(ARM, world).changes] == [
        "link 'base': renamed 'base' → 'world'"
    ]


@pytest.mark.parametrize(
    ("own", "other"),
    [
        ('mass value="0.5"', 'mass value="0.50001"'),
        ('xyz="0 0 0.1"', 'xyz="0 0 0.10001"'),
        ('ixx="0.001"', 'ixx="0.0010001"'),
        ('xyz="0 0 -0.4"', 'xyz="0 0 -0.40001"'),
    ],
)
def test_a_link_with_another_number_is_another_link(own: str, other: str) -> None:
    assert HAND.count(own) == 1
    changes = [str(change) for change in mq.diff(ARM, HAND.replace(own, other)).changes]
    assert len(changes) == 4
    assert not any("renamed" in change for change in changes)


def test_renamed_added_and_merged() -> None:
    renamed = mq.diff(ARM, ARM.replace('"upper"', '"humerus"').replace('"elbow"', '"hinge"'))
    assert {str(change) for change in renamed.changes} == {
        "link 'upper': renamed 'upper' → 'humerus'",
        "joint 'elbow': renamed 'elbow' → 'hinge'",
    }
    # a tool of 0.5 kg, its center 0.3 m below the link's origin: 1 · (−0.2) + 0.5 · (−0.3)
    center = (-0.2 - 0.15) / 1.5
    moment = 0.01 + 0.001 + 1 * (0.2 + center) ** 2 + 0.5 * (0.3 + center) ** 2
    lower = ARM[ARM.index('<link name="lower">') : ARM.index("<joint")]
    merged = ARM.replace(lower, re.sub(r'<link name="tool">.*?</link>', "", lower, flags=re.DOTALL))
    merged = re.sub(r'<joint name="flange".*?</joint>', "", merged, flags=re.DOTALL)
    merged = merged.replace(
        'xyz="0 0 -0.2"/><mass value="1"', f'xyz="0 0 {center!r}"/><mass value="1.5"'
    )
    merged = merged.replace(
        '"0.01" iyy="0.01" izz="0.005"', f'"{moment!r}" iyy="{moment!r}" izz="0.006"'
    )
    found = [str(change) for change in mq.diff(ARM, merged).changes]
    assert found == [
        "link 'tool': merged into link 'lower', with the same mass and inertia in all",
        "joint 'flange': merged into link 'lower', with the same mass and inertia in all",
    ]
    back = [str(change) for change in mq.diff(merged, ARM).changes]
    assert (
        back[0] == "link 'tool': split off from link 'lower', with the same mass and inertia in all"
    )


def test_the_command_and_the_verdict_show_the_summary_first(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.urdf").write_text(ARM, encoding="utf-8")
    (tmp_path / "b.urdf").write_text(ARM.replace('value="2"', 'value="2000"'), encoding="utf-8")
    run = CliRunner().invoke(app, ["diff", "a.urdf", "b.urdf"])
    assert run.exit_code == 1
    assert run.stdout.startswith("arm and the other arm: 1 difference, 1 likely slip\n")
    assert "link 'upper': mass 2 → 2000 kg (+9.99e+04 %): grams for kilograms" in run.stdout
    assert CliRunner().invoke(app, ["diff", "a.urdf", "a.urdf"]).exit_code == 0
    shown = json.loads(CliRunner().invoke(app, ["diff", "a.urdf", "b.urdf", "--json"]).stdout)
    assert shown["changes"][0]["slip"] == "grams for kilograms"
    verdict = mq.verify(mq.read_urdf(ARM), samples=5, against=str(tmp_path / "b.urdf"))
    assert str(verdict).startswith("arm and the other arm: 1 difference, 1 likely slip\n")
    assert not verdict.agrees


GROUPS = ("forces", "loops", "contacts", "velocity_constraints", "elements")


@pytest.mark.parametrize("name", mq.textbook.names())
def test_every_element_that_is_left_out_is_told(name: str) -> None:
    mechanism = mq.textbook.load(name)
    assert mq.diff(mechanism, mechanism).same
    for group in GROUPS:
        elements = getattr(mechanism, group)
        if not elements or (group == "elements" and mechanism.coordinates.driven):
            continue
        bare = replace(mechanism, **{group: ()})  # type: ignore[arg-type]
        changes = mq.diff(mechanism, bare).changes
        assert {change.what for change in changes} <= {"removed", "damping"}
        assert len(changes) == len(elements)


def test_numbers_and_ends_of_elements_are_compared() -> None:
    blocks = mq.read_urdf(mq.write_urdf(mq.textbook.load("two_blocks")))
    spring, *rest = blocks.forces
    assert isinstance(spring, mq.Spring)
    stiff = replace(blocks, forces=(replace(spring, stiffness=2 * spring.stiffness), *rest))
    assert [str(change) for change in mq.diff(blocks, stiff).changes] == [
        "spring 'ground_block1_spring': stiffness 40 → 80"
    ]
    moved = replace(blocks, forces=(replace(spring, body_b="block2"), *rest))
    assert str(mq.diff(blocks, moved).changes[0]).endswith("body b block1 → block2")
    up = replace(blocks, gravity=(0.0, 0.0, 9.81))
    assert "gravity 0 0 -9.81 → 0 0 9.81 m/s²" in str(mq.diff(blocks, up).changes[0])


def test_elements_that_switch_are_compared() -> None:
    blocks = mq.textbook.load("two_blocks")
    joint = blocks.joints[0].name
    dry = replace(blocks, switching=(mq.Friction("dry", joint, 0.1, 9.81),))
    drier = replace(blocks, switching=(mq.Friction("dry", joint, 0.2, 9.81),))
    changes = [str(change) for change in mq.diff(dry, drier).changes]
    assert changes == ["friction 'dry': mu 0.1 → 0.2", "friction 'dry': mu static 0.1 → 0.2"]
    assert str(mq.diff(dry, blocks).changes[0]) == "friction 'dry': removed"
    bounded = replace(blocks, switching=(mq.Stop("dry", joint, 1.0),))
    assert {str(c) for c in mq.diff(dry, bounded).changes} == {
        "friction 'dry': removed",
        "stop 'dry': added",
    }


def test_another_coordinate_is_another_law_of_the_joint() -> None:
    absolute = mq.textbook.load("double_pendulum")
    q1, q2 = map(mq.coordinate, ("q1", "q2"))
    relative = replace(absolute, coordinates=mq.Coordinates(("q1", "q2"), {"theta2": q2}))
    (change,) = mq.diff(absolute, relative).changes
    assert (change.what, change.before, change.after) == (
        "law of its coordinate",
        str(absolute.coordinates.driven["theta2"]),
        "q2",
    )
    assert absolute.coordinates.driven["theta2"] == q2 - q1
    assert mq.diff(relative, relative).same


def test_another_kind_of_joint_is_told_before_anything_else_about_it() -> None:
    changes = changed(
        '<joint name="elbow" type="revolute">', '<joint name="elbow" type="prismatic">'
    )
    assert [str(change) for change in changes] == ["joint 'elbow': type revolute → prismatic"]


def test_elements_are_paired_by_name_then_by_kind_in_order() -> None:
    def rows(*names: str) -> list[mq.Spring | mq.Damper]:
        ends = ("ground", (0, 0, 0), "b", (0, 0, 0), 1.0)
        kinds: list[type[mq.Spring | mq.Damper]] = [
            mq.Damper if name.startswith("d") else mq.Spring for name in names
        ]
        return [kind(name, *ends) for kind, name in zip(kinds, names, strict=True)]

    pairs = _pair_elements(rows("a", "d1", "b", "c", "e"), rows("c", "x", "y", "d2", "d3"))
    assert [tuple(part and part.name for part in pair) for pair in pairs] == [
        *(("c", "c"), ("a", "x"), ("d1", "d2"), ("b", "y")),
        *(("e", None), (None, "d3")),
    ]


def test_what_is_welded_askew_has_the_poses_of_the_engine() -> None:
    """Of a chain of three, each turned and shifted against the one before."""
    turns = (0.3, -0.5, 0.8), (1.1, 0.2, -0.4), (-0.6, 0.9, 0.1)
    chain = mq.Mechanism(
        "chain",
        tuple(mq.Body(name, mq.ball(1.0, 0.1)) for name in ("ground", "a", "b", "c", "d")),
        (
            mq.Prismatic("slide", "ground", "a"),
            *(
                mq.Fixed(f"to {child}", parent, child, origin=mq.Placement((1, 2 * k, -1), turn))
                for k, (parent, child, turn) in enumerate(zip("abc", "bcd", turns, strict=True))
            ),
        ),
    )
    found = dict(_welds(chain, "a"))
    assert [*found] == ["a", "b", "c", "d"]
    for name, pose in found.items():
        expected = mq.Reference(chain).pose(name, [0.0])
        np.testing.assert_allclose(pose, expected, rtol=0, atol=1e-14)

"""Files with errors that no equation of motion needs are read, and their flaws are listed."""

from __future__ import annotations

import re

import numpy as np
import pytest

import mecanique as mq
from mecanique.urdf import read_urdf
from mecanique.urdf.lint import find_balances, lint, mend
from mecanique.urdf.lint.repair import nearest_inertia
from mecanique.verification.compare import compare

ARM = """<robot name="r">
<link name="base"/>
<link name="l"><inertial><origin xyz="0 0 -0.5"/><mass value="1"/>
<inertia ixx="0.02" iyy="0.02" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="j" type="revolute"><parent link="base"/><child link="l"/><axis xyz="0 1 0"/>
<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
</robot>"""

BOX = '<visual><geometry><box size="1 1 1"/></geometry>{}</visual></link>'
MESH = '<visual><geometry><mesh filename="{}"/></geometry></visual></link>'
MATERIAL = '<material name="m"><color rgba="1 0 0 1"/></material>'


def swap(old: str, new: str, text: str = ARM) -> str:
    assert old in text
    return text.replace(old, new)


FLAWED = {
    "mesh above the package": (swap("</inertial></link>", "</inertial>" + MESH.format("package://../l.stl")),
                               "M502", 4),
    "two materials": (swap("</inertial></link>", "</inertial>" + BOX.format(2 * MATERIAL)),
                      "M112", 4),
    "a scale of four": (
        swap("</inertial></link>", "</inertial>" + MESH.format('l.stl" scale="1 1 1 1')),
        "M104",
        4,
    ),
    "a material twice": (swap('name="r">', f'name="r">{2 * MATERIAL}'), "M106", 1),
    "lower above upper": (swap('lower="-1"', 'lower="2"'), "M306", 6),
    "negative effort": (swap('effort="1"', 'effort="-1"'), "M306", 6),
    "two limits": (swap("<limit", '<limit lower="0" upper="0" effort="0" velocity="0"/>\n<limit'),
                   "M112", 7),
    "empty name": (swap('name="r"', 'name=""'), "M105", 1),
    "no name": (swap(' name="r"', ""), "M101", 1),
    "axis of a fixed joint": (
        swap("</robot>", '<link name="f"/>\n<joint name="k" type="fixed"><parent link="l"/>'
             '<child link="f"/><axis/></joint></robot>'),
        "M103",
        8,
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", FLAWED)
def test_what_equations_do_without_is_read_and_listed(name: str) -> None:
    text, code, line = FLAWED[name]
    mechanism = read_urdf(text)
    assert mechanism.origin is not None
    assert [(f.code, f.line) for f in mechanism.origin.flaws] == [(code, line)]
    assert all(flaw.remedy for flaw in mechanism.origin.flaws)
    whole = read_urdf(ARM)
    state = {"j": 0.3}
    ours, theirs = mq.Reference(mechanism), mq.Reference(whole)
    assert ours.mass_matrix(state) == theirs.mass_matrix(state)
    assert ours.bias(state, [1.0]) == theirs.bias(state, [1.0])
    with pytest.raises(mq.UrdfError, match=mechanism.origin.flaws[0].message[:20]):
        read_urdf(text, strict=True)
    assert [f.code for f in lint(text) if f.severity == "error"] == [code]


def test_limits_that_no_position_obeys_are_none() -> None:
    joint = read_urdf(swap('lower="-1"', 'lower="2"')).joint("j")
    assert isinstance(joint, mq.Revolute)
    assert joint.limits == mq.Limits(-np.inf, np.inf, 1.0, 1.0)


def test_a_parent_world_that_is_no_link_is_the_inertial_frame() -> None:
    text = swap('<link name="base"/>\n', "", swap('parent link="base"', 'parent link="world"'))
    mechanism = read_urdf(text)
    assert mechanism.ground == "world"
    assert mechanism.origin is not None
    assert [flaw.code for flaw in mechanism.origin.flaws] == ["M107"]
    with pytest.raises(mq.UrdfError, match="parent 'earth' is no link"):
        read_urdf(text.replace('"world"', '"earth"'))


UNREAL = swap('ixx="0.02" iyy="0.02" izz="0.01"', 'ixx="2e-6" iyy="9e-7" izz="3e-6"')
NEGATIVE = swap('ixx="0.02" iyy="0.02"', 'ixx="0.02" iyy="-0.3"')


@pytest.mark.parametrize("text", [UNREAL, NEGATIVE])
def test_an_inertia_of_no_real_body_is_verified_and_told(text: str) -> None:
    verdict = mq.verify(read_urdf(text), samples=5)
    assert verdict.agrees
    assert "; 1 flaw in its description" in verdict.summary
    (flaw,) = verdict.flaws
    assert (flaw.line, flaw.where) == (4, "link 'l'")
    assert f"flaw in line 4: link 'l': {flaw.message}. {flaw.remedy}" in str(verdict)
    assert verdict.to_dict()["flaws"][0]["code"] == flaw.code


def test_negative_kinetic_energy_is_not_integrated() -> None:
    """M = −0.3 + 1 · 0.5² is negative: of a body that falls away from its rest."""
    with pytest.raises(mq.IntegrationError, match=r"definite at t = 0 s.*inertia of 'l'"):
        mq.simulate(read_urdf(NEGATIVE), duration=0.1)
    assert mq.simulate(read_urdf(UNREAL), q={"j": 0.5}, duration=0.1).t[-1] == 0.1


def test_mended_inertia_is_the_nearest_of_a_real_body() -> None:
    """On a face of the cone each moment changes by a third of what the sum lacks."""
    assert nearest_inertia((2e-6, 9e-7, 3e-6, 0, 0, 0)) == pytest.approx(
        (2e-6 + 1e-7 / 3, 9e-7 + 1e-7 / 3, 3e-6 - 1e-7 / 3, 0, 0, 0), abs=1e-20
    )
    assert nearest_inertia((-1, -1, -1, 0, 0, 0)) == pytest.approx([0] * 6, rel=1e-12)
    rng = np.random.default_rng(0)
    for _ in range(20):
        given = rng.normal(size=6)
        mended = np.array(nearest_inertia(given.tolist()), dtype=float)
        weight = np.array([1, 1, 1, 2, 2, 2])
        best = np.sum(weight * (mended - given) ** 2)
        for scale in (1e-3, 1e-1, 1):
            # a real body: its covariance is positive, I = tr(Σ) 1 − Σ
            root = np.linalg.cholesky(_covariance(mended) + 1e-9 * np.eye(3))
            root = root + scale * rng.normal(size=(3, 3))
            other = np.trace(root @ root.T) * np.eye(3) - root @ root.T
            entries = other[(0, 1, 2, 0, 0, 1), (0, 1, 2, 1, 2, 2)]
            assert np.sum(weight * (entries - given) ** 2) > best


def _covariance(inertia: np.ndarray) -> np.ndarray:
    ixx, iyy, izz, ixy, ixz, iyz = inertia
    tensor = np.array([[ixx, ixy, ixz], [ixy, iyy, iyz], [ixz, iyz, izz]])
    covariance: np.ndarray = np.trace(tensor) / 2 * np.eye(3) - tensor
    return covariance


@pytest.mark.parametrize("text", [UNREAL, NEGATIVE])
def test_balance_mends_what_fix_alone_leaves(text: str) -> None:
    assert mend(text) == text
    mended = mend(text, balance=True)
    assert not [f for f in lint(mended) if f.severity == "error"]
    (change,) = find_balances(text)
    assert str(change).startswith("line 4: link 'l': ixx ")
    assert find_balances(mended) == ()
    assert mend(mended, balance=True) == mended


def test_joints_that_move_no_mass_are_left_out_by_name() -> None:
    more = (
        '<link name="tip"/><joint name="k" type="continuous"><parent link="l"/>'
        '<child link="tip"/><axis xyz="0 0 1"/></joint></robot>'
    )
    verdict = mq.verify(read_urdf(swap("</robot>", more)), samples=5)
    assert verdict.agrees
    compared = {row.quantity for row in verdict.rows}
    assert {"mass matrix", "bias", "inverse dynamics", "kinetic energy"} <= compared
    assert not {"acceleration", "reactions"} & compared
    assert "accelerations and reactions, which nothing determines: k' moves no mass" in str(verdict)


def test_a_robot_without_any_mass_has_no_equations() -> None:
    text = ARM[: ARM.index("<inertial>")] + ARM[ARM.index("</inertial>") + len("</inertial>") :]
    verdict = mq.verify(read_urdf(text), samples=5)
    assert verdict.agrees
    assert [row.quantity for row in verdict.rows] == ["poses", "Jacobians"]
    with pytest.raises(mq.EngineError, match="nothing that moves has mass, so it has geometry but"):
        compare(read_urdf(text), 5, 0)


def test_a_body_without_inertia_about_its_only_axis_has_mass_all_the_same() -> None:
    """What is said is true: the mass is there, and resists nothing."""
    text = re.sub(
        r"<inertia [^>]*/>", '<inertia ixx="0" iyy="0" izz="0" ixy="0" ixz="0" iyz="0"/>', ARM
    )
    text = re.sub(r"(<inertial>\s*)(<origin [^>]*/>)?", r"\1", text)
    mechanism = read_urdf(text)
    assert mechanism.body("l").mass == read_urdf(ARM).body("l").mass > 0
    message = (
        "its bodies have mass, but none resists a change of .*: centers of mass lie on the axes"
    )
    with pytest.raises(mq.EngineError, match=message):
        mq.verify(mechanism, samples=5)
    with pytest.raises(mq.DerivationError, match="give what it moves mass or inertia"):
        mq.derive(mechanism).acceleration([0.1], [0.2])


def test_an_inertial_without_inertia_is_a_point() -> None:
    text = re.sub(r"<inertia [^>]*/>", "", ARM)
    mechanism = read_urdf(text)
    assert mechanism.origin is not None
    assert [flaw.code for flaw in mechanism.origin.flaws] == ["M103"]
    assert not any(mechanism.body("l").inertia)
    assert mechanism.body("l").mass == read_urdf(ARM).body("l").mass
    assert mq.verify(mechanism, samples=2).agrees
    with pytest.raises(mq.UrdfError, match="no <inertia>"):
        read_urdf(text, strict=True)


@pytest.mark.engine
def test_pinocchio_takes_an_inertial_without_inertia_for_a_point() -> None:
    mechanism = read_urdf(re.sub(r"<inertia [^>]*/>", "", ARM))
    assert not mq.verify(mechanism, samples=2).readings[0].differs

"""What engines make of the file itself."""

from __future__ import annotations

import os
import re
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
import pytest
from original_samples import ARM, MOVING, pair
from reading_faults import blame, misread, name_dissenters
from scipy.spatial.transform import Rotation

import mecanique as mq
from mecanique.model.mechanism.origin import Origin
from mecanique.reference.originals.original import ByJoint, Original
from mecanique.urdf import read_urdf
from mecanique.verification import engines
from mecanique.verification.engines import read_by
from mecanique.verification.verdict import EngineReading


def reading(text: str, engine: str = "pinocchio") -> EngineReading:
    (found,) = read_by(read_urdf(text), (engine,), 0)
    return found


@pytest.mark.parametrize(
    "engine", [pytest.param("pinocchio", marks=pytest.mark.engine), "mujoco", "drake"]
)
def test_engines_read_a_sound_file_alike(engine: str) -> None:
    if engine != "pinocchio":
        pytest.importorskip({"drake": "pydrake"}.get(engine, engine))
    found = reading(ARM, engine)
    assert found.worst is not None
    assert found.worst < 1e-12
    assert not found.sentences()


@pytest.mark.engine
@pytest.mark.parametrize(
    ("old", "new", "read", "trap", "said"),
    [
        (
            'value="0.5"',
            'value="0.5 "',
            "0 kg·m²",
            "line 5: link 'k': value of <mass> is '0.5 '",
            "mass [0.5 ] is not a float",
        ),
        (
            'ixy="0.001" ixz="0" iyz="0"',
            'ixy="0.001" ixz="0" iyz="0\n"',
            "0.02 kg·m²",
            "line 6: link 'k': iyz of <inertia>",
            "element iyz is not",
        ),
        (
            'xyz="0 0.1 -0.2"',
            'xyz="0\t0.1 -0.2"',
            "0 kg·m²",
            "line 5: link 'k': xyz of <origin>",
            "[0\t0.1]",
        ),
    ],
)
def test_a_dropped_inertial_does_not_agree(
    old: str, new: str, read: str, trap: str, said: str
) -> None:
    """M of the outer joint is m |a × c|² + aᵀ I a = 0.02 + 0.0136."""
    assert old in ARM
    verdict = mq.verify(read_urdf(ARM.replace(old, new, 1)), samples=3)
    (found,) = verdict.readings
    assert found.differs
    assert not verdict.agrees
    assert "DISAGREES" in verdict.summary
    assert "Pinocchio 4" in verdict.summary
    text = str(verdict)
    assert f"link 'k' at joint 'i': {read} instead of 0.0336" in text
    assert trap in text
    assert said in text
    assert verdict.to_dict()["readings"][0]["differs"] is True


@pytest.mark.engine
def test_other_engines_read_the_file_besides_pinocchio() -> None:
    """MuJoCo reads a number with a blank behind it, Pinocchio does not."""
    pytest.importorskip("mujoco")
    text = ARM.replace('value="0.5"', 'value="0.5 "', 1)
    verdict = mq.verify(read_urdf(text), samples=3, engines=("mujoco",))
    pinocchio, mujoco = verdict.readings
    assert pinocchio.differs
    assert not mujoco.differs
    assert not verdict.agrees


@pytest.mark.engine
def test_a_refusal_is_told_and_equations_still_agree() -> None:
    text = ARM.replace('effort="1"', 'effort="-1"')
    verdict = mq.verify(read_urdf(text), samples=3)
    assert verdict.agrees
    assert "Pinocchio" in verdict.summary
    assert "refuses the file itself" in verdict.summary
    assert "min_effort are greater than max_effort" in str(verdict)


@pytest.mark.parametrize(("sign", "alike"), [(1.0, True), (-1.0, False)])
def test_springs_and_dampers_of_an_engine_are_taken_off_its_bias(
    sign: float, alike: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """An engine that adds Q = −k q − c q' to a hinge with m l² and m g l sin q."""
    m, l, k, c, g = 2.0, 0.7, 3.0, 0.4, 9.81
    arm = mq.Mechanism(
        "arm",
        (mq.Body("ground"), mq.Body("arm", mq.particle(m).at((0, 0, -l)))),
        (mq.Revolute("hinge", "ground", "arm", axis=(0, 1, 0)),),
        gravity=(0, 0, -g),
    )
    held = (mq.JointSpring("spring", "hinge", k), mq.JointDamper("damper", "hinge", c))

    def answer(_text: bytes, _gravity: object, q: ByJoint, v: ByJoint) -> Original:
        angle, rate = (np.array(x["hinge"])[:, None] for x in (q, v))
        mass = np.full((len(angle), 1, 1), m * l**2)
        passive = -sign * (k * angle + c * rate)
        return Original(("hinge",), mass, m * g * l * np.sin(angle), (), passive)

    engine = engines.Engine("Closed form", "numpy", answer)
    monkeypatch.setattr(engines, "ENGINES", {"closed": engine})
    origin = Origin(None, mq.write_urdf(arm).encode())
    (found,) = engines.read_text_by(arm, origin, ["closed"], 0, 4, held)
    assert found.worst is not None
    assert (found.worst < 1e-12) == alike


@pytest.mark.parametrize("sprung", [False, True])
def test_dampers_of_a_urdf_are_compared_unless_what_engines_leave_out_acts_beside_them(
    sprung: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """An engine that doubles a damper; springs stand in a tag that it passes over."""
    m, l, c, g = 2.0, 0.7, 0.4, 9.81
    springs = (mq.JointSpring("spring", "hinge", 3.0),) if sprung else ()
    arm = mq.Mechanism(
        "arm",
        (mq.Body("ground"), mq.Body("arm", mq.particle(m).at((0, 0, -l)))),
        (mq.Revolute("hinge", "ground", "arm", axis=(0, 1, 0)),),
        gravity=(0, 0, -g),
        forces=(mq.JointDamper("damper", "hinge", c), *springs),
    )

    def answer(_text: bytes, _gravity: object, q: ByJoint, v: ByJoint) -> Original:
        angle, rate = (np.array(x["hinge"])[:, None] for x in (q, v))
        mass = np.full((len(angle), 1, 1), m * l**2)
        return Original(("hinge",), mass, m * g * l * np.sin(angle), (), -2 * c * rate)

    engine = engines.Engine("Closed form", "numpy", answer)
    monkeypatch.setattr(engines, "ENGINES", {"closed": engine})
    found = reading(mq.write_urdf(arm), "closed")
    assert found.worst is not None
    assert found.differs == (not sprung)


def test_drake_and_mujoco_on_an_inertia_of_no_real_body() -> None:
    pytest.importorskip("mujoco")
    text = ARM.replace(
        'ixx="0.02" iyy="0.02" izz="0.01" ixy="0"', 'ixx="9" iyy="1" izz="1" ixy="0"'
    )
    found = reading(text, "mujoco")
    assert "inertia must satisfy A + B >= C" in found.refused
    assert any("line 4: link 'l': its principal moments" in remark for remark in found.remarks)
    pytest.importorskip("pydrake")
    found = reading(text, "drake")
    assert found.differs
    assert any("Drake said" in remark for remark in found.remarks)


def test_an_engine_that_is_not_installed_or_known(monkeypatch: pytest.MonkeyPatch) -> None:
    from mecanique.verification import engines

    drake = replace(engines.ENGINES["drake"], package="no-such-package")
    monkeypatch.setitem(engines.ENGINES, "drake", drake)
    found = reading(ARM, "drake")
    said = "Drake did not read the file: it is not installed"
    assert found.sentences() == (f"{said} (pip install no-such-package)",)
    assert not found.refused
    verdict = mq.verify(read_urdf(ARM), samples=3, engines=("drake",))
    assert verdict.agrees
    assert verdict.summary.endswith(f"; {said}")
    with pytest.raises(mq.UnknownNameError, match="bullet"):
        reading(ARM, "bullet")


def test_a_mechanism_from_no_file_has_no_readings() -> None:
    assert mq.verify(mq.textbook.load("cart_pole"), samples=3).readings == ()


@pytest.mark.engine
@pytest.mark.parametrize(
    ("fault", "culprit", "root"),
    [
        ("mass in grams", "mecanique", "fixed"),
        ("place mirrored", "pinocchio", "fixed"),
        ("axis turned", "mujoco", "fixed"),
        ("moment doubled", "pinocchio", "fixed"),
        ("mass of another link", "mecanique", "floating"),
        ("moment lost", "mujoco", "floating"),
        ("angles in degrees", "pinocchio", "floating"),
    ],
)
def test_of_three_sources_the_one_that_misreads_is_named(
    fault: str, culprit: str, root: Literal["fixed", "floating"]
) -> None:
    pytest.importorskip("mujoco")
    _, blamed, readings = blame(culprit, 0, fault, ("pinocchio", "mujoco"), 3, root)
    assert blamed == (culprit,)
    right = [r for r in readings if not r.engine.lower().startswith(culprit)]
    assert all(r.alike for r in right)


@pytest.mark.engine
def test_the_verdict_names_who_stands_alone() -> None:
    pytest.importorskip("mujoco")
    text = ARM.replace('value="0.5"', 'value="0.5 "', 1)
    verdict = mq.verify(read_urdf(text), samples=3, engines=("mujoco",))
    (dissenter,) = verdict.dissenters
    assert dissenter.startswith("Pinocchio")
    assert f"{dissenter} stands alone: mecanique and MuJoCo" in str(verdict)
    assert mq.verify(read_urdf(text), samples=3).dissenters == ()  # two sources have no majority


@pytest.mark.engine
def test_the_verdict_names_who_reads_alike() -> None:
    pytest.importorskip("mujoco")
    alike = r"mecanique, Pinocchio [\d.]+ and MuJoCo [\d.]+ read the file itself alike"
    plain = read_urdf(ARM.replace("<mimic", "<ignored"))
    assert re.search(alike, str(mq.verify(plain, samples=3, engines=("mujoco",))))
    assert "alike" not in str(mq.verify(plain, samples=3))


MJCF = """<mujoco model="m"><compiler settotalmass="3"/>
<option gravity="0 0 -3"/>
<worldbody><body name="b"><joint name="a" axis="0 1 0" armature="0.1"/>
<geom type="box" size="0.1 0.2 0.3" pos="0.1 0 0"/></body></worldbody></mujoco>"""


@pytest.mark.engine
def test_engines_read_mjcf_themselves_and_lines_they_leave_out_are_named() -> None:
    pytest.importorskip("mujoco")
    verdict = mq.verify(mq.read(MJCF), samples=3, engines=("mujoco", "pinocchio"))
    mujoco, pinocchio = verdict.readings
    assert mujoco.worst is not None
    assert mujoco.worst < 1e-12
    assert pinocchio.differs
    assert "line 1: Pinocchio leaves out settotalmass=… of <compiler>" in pinocchio.remarks
    assert "line 2: Pinocchio leaves out gravity=… of <option>" in pinocchio.remarks
    assert mq.verify(mq.read(MJCF), samples=3).readings == ()


TWO = """<mujoco model="m"><option viscosity="1"/><worldbody>
<body name="a"><joint name="a" axis="0 1 0"/><geom size="0.1" pos="0.1 0 0"/></body>
<body name="b"><joint name="b" axis="1 0 0"/><geom size="0.1" pos="0 0 0.3"/></body></worldbody>
{}</mujoco>"""


def test_forces_on_joints_that_follow_others_are_compared_where_those_lead_them() -> None:
    pytest.importorskip("mujoco")
    text = TWO.format(
        '<equality><joint joint1="a" joint2="b" polycoef="0.1 0.5 0.2"/></equality><tendon><fixed '
        'damping="3"><joint joint="a" coef="1"/><joint joint="b" coef="2"/></fixed></tendon>'
    )
    (mujoco,) = mq.verify(mq.read(text), samples=3, engines=("mujoco",)).readings
    assert mujoco.worst is not None
    assert mujoco.worst < 1e-12


def test_a_tendons_armature_is_read_as_mujoco_counts_it_on_separate_branches() -> None:
    pytest.importorskip("mujoco")
    text = TWO.format(
        '<tendon><fixed armature="2"><joint joint="a" coef="1"/><joint joint="b" coef="1"/></fixed>'
        "</tendon>"
    )
    mechanism = mq.read(text)
    verdict = mq.verify(mechanism, samples=3, engines=("mujoco",))
    assert verdict.agrees, str(verdict)
    assert "armature of tendons that couples joints on separate branches (1)" in mechanism.about


def test_engines_that_read_no_sdf_say_so() -> None:
    text = '<sdf version="1.9"><model name="m"><link name="a"/><joint name="q" type="universal">'
    text += (
        "<parent>world</parent><child>a</child><axis><xyz>0 1 0</xyz><dynamics><damping>0.3"
        "</damping></dynamics></axis><axis2><xyz>1 0 0</xyz></axis2></joint></model></sdf>"
    )
    # Pinocchio is not asked where it is not installed
    verdict = mq.verify(mq.read(text), samples=3, engines=("mujoco", "pinocchio", "drake"))
    readings = {r.engine.split()[0]: r for r in verdict.readings if not r.missing}
    refused = {
        "MuJoCo": "it has no reader of SDF",
        "Pinocchio": "its packages have no reader of SDF",
        "Drake": "",
    }
    assert readings
    assert {name: r.refused for name, r in readings.items()} == {n: refused[n] for n in readings}
    if "Drake" in readings:
        worst = readings["Drake"].worst
        assert worst is not None
        assert worst < 1e-12


def test_pinocchio_is_asked_where_it_is_there(monkeypatch: pytest.MonkeyPatch) -> None:
    for there in (True, False):
        monkeypatch.setattr(
            "mecanique.verification.engines.has_pinocchio", lambda there=there: there
        )
        titles = [engine.title for engine in engines._choose(("pinocchio", "mujoco"))]
        assert titles == (["Pinocchio", "MuJoCo"] if there else ["MuJoCo"])


def test_a_file_is_read_again_with_the_folders_of_its_models(tmp_path: Path) -> None:
    (tmp_path / "models" / "inner").mkdir(parents=True)
    inner = "<sdf version='1.9'><model name='inner'><link name='b'/></model></sdf>"
    (tmp_path / "models" / "inner" / "inner.sdf").write_text(inner, encoding="utf-8")
    include = "<include><uri>model://inner/inner.sdf</uri></include>"
    outer = f"<sdf version='1.9'><model name='m'>{include}</model></sdf>"
    (tmp_path / "outer.sdf").write_text(outer, encoding="utf-8")
    mechanism = mq.read(tmp_path / "outer.sdf", package_path=tmp_path / "models")
    assert mechanism.origin is not None
    assert engines.read_as_engines(mechanism, mechanism.origin).nv == 6
    with engines._beside(mechanism.origin):  # Drake seeks them by this variable
        assert os.environ["ROS_PACKAGE_PATH"].startswith(str(tmp_path / "models"))


@pytest.mark.engine
def test_joints_that_engines_read_otherwise_are_named() -> None:
    """Pinocchio takes every plane for that of x and y, and loses free bodies after the first."""
    (slanted,) = read_by(pair("planar"), ("pinocchio",), 0)
    assert slanted.differs
    assert any("line 3: joint 'j': the normal of its plane is" in said for said in slanted.remarks)
    (lost,) = read_by(mq.read(MOVING), ("pinocchio",), 0)
    assert lost.remarks[0].endswith("has no joint 'd_free'")


def test_passive_forces_are_compared() -> None:
    pytest.importorskip("mujoco")
    read = engines.ENGINES["mujoco"].read
    damped = MOVING.replace('damping="0.2"', 'damping="0.3"').encode()
    other = replace(engines.ENGINES["mujoco"], read=lambda _, *given: read(damped, *given))
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(engines.ENGINES, "mujoco", other)
        (found,) = read_by(mq.read(MOVING), ("mujoco",), 0)
    assert found.differs


def test_a_joint_that_an_engine_has_more_is_named() -> None:
    pytest.importorskip("mujoco")
    more = MOVING.replace(
        "</worldbody>", '<body><freejoint name="n"/><geom size="1"/></body></worldbody>'
    )
    read = engines.ENGINES["mujoco"].read
    other = replace(engines.ENGINES["mujoco"], read=lambda _, *given: read(more.encode(), *given))
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(engines.ENGINES, "mujoco", other)
        (found,) = read_by(mq.read(MOVING), ("mujoco",), 0)
    assert found.remarks[0].endswith("has a joint 'n' more")


@pytest.mark.parametrize("culprit", ["mecanique", "mujoco", "drake"])
@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('size=".1 .2 .3" pos="0.1 0 0"', 'size=".1 .2 .3" pos="0 0.1 0"'),
        ('euler="0 20 0"', 'euler="20 0 0"'),
        ('damping="0.2"', 'damping="0.02"'),
        ('size=".1 .2 .3" pos="0 0.1 0"', 'size=".1 .3 .2" pos="0 0.1 0"'),
    ],
)
def test_who_misreads_bodies_that_move_freely_is_named(old: str, new: str, culprit: str) -> None:
    pytest.importorskip("mujoco")
    pytest.importorskip("pydrake")
    wrong = MOVING.replace(old, new)
    assert wrong != MOVING
    with misread(culprit, MOVING, wrong, "fixed") as mechanism:
        readings = read_by(mechanism, ("mujoco", "drake"), 0)
    assert name_dissenters(readings) == (culprit,)


def test_a_free_body_on_what_is_welded_is_placed_in_the_world() -> None:
    """As the poses of all bodies say, welded twice askew; their angles are no product's order."""
    seats = mq.Placement((1, 2, 3), (0.3, -0.5, 0.8)), mq.Placement((-1, 0.5, 2), (1.1, 0.2, -0.4))
    free = mq.Floating("free", "b", "c", origin=mq.Placement((0.2, 0, 0.7), (-0.6, 0.9, 0.1)))
    mechanism = mq.Mechanism(
        "welded",
        tuple(mq.Body(name, mq.ball(1.0, 0.1)) for name in ("ground", "a", "b", "c")),
        (
            mq.Fixed("one", "ground", "a", origin=seats[0]),
            mq.Fixed("other", "a", "b", origin=seats[1]),
            free,
        ),
    )
    places = np.random.default_rng(2).normal(size=(3, 7))
    places[:, 3:] /= np.linalg.norm(places[:, 3:], axis=1, keepdims=True)
    found = engines._in_world(mechanism, free, places)
    for place, seen in zip(places, found, strict=True):
        pose = mq.Reference(mechanism).pose("c", place)
        np.testing.assert_allclose(seen[:3], pose[:3, 3], rtol=0, atol=1e-14)
        turn = Rotation.from_quat(seen[3:]).as_matrix()
        np.testing.assert_allclose(turn, pose[:3, :3], rtol=0, atol=1e-14)


def test_of_links_whose_inertia_differs_the_outermost_is_named() -> None:
    """All that carry it differ with it."""
    tree = read_urdf(ARM.replace('<mimic joint="j"/>', ""))
    mass = np.array([np.diag([3.0, 0.5])])
    for wrong, names in (([4.0, 0.7], ["k"]), ([4.0, 0.5], ["l"]), ([3.0, 0.5], [])):
        others = np.array([np.diag(wrong)])
        found = [*engines._places(tree, tree.joints, mass, others)]
        assert [line.split("'")[1] for line in found] == names


def test_what_rotors_add_is_taken_from_their_own_joints() -> None:
    """Of a ball, a hinge with a rotor and a slide."""
    nothing: Any = None
    v = {"ball": np.zeros((1, 3)), "hinge": np.zeros((1, 1)), "slide": np.zeros((1, 1))}
    asked = engines._Asked(nothing, nothing, nothing, {}, {"hinge": 0.3}, {}, v, nothing)
    mass = np.random.default_rng(0).normal(size=(1, 5, 5))
    found = asked.without_rotors(Original(("ball", "hinge", "slide"), mass, mass[:, 0], ()))
    np.testing.assert_array_equal(found.mass[0], mass[0] - np.diag([0, 0, 0, 0.3, 0]))

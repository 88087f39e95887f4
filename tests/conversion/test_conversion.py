"""Conversions are proved: round trips, what is lost, and results that are wrong."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import mecanique as mq
from mecanique import conversion as room
from mecanique.cli import app
from mecanique.formats.mjcf import write_mjcf
from mecanique.formats.scope import SCOPES, Form, list_losses
from mecanique.model.bodies.body import Shape
from mecanique.model.constraints.loops import Kind
from mecanique.model.expression import coordinate
from mecanique.reference.engine.package import has_pinocchio
from mecanique.verification.engines import ENGINES
from mecanique.verification.verdict import EngineReading

ARM = """<sdf version="1.9"><model name="m"><link name="a"><pose>0 0 1 0.1 0.2 0.3</pose></link>
<link name="b"><pose>0.5 0.1 1 0.4 0 0.2</pose></link>
<joint name="q" type="revolute"><pose>0 0.1 -0.2 0.3 0 0</pose><parent>world</parent>
<child>a</child><axis><xyz>0 1 0</xyz><dynamics><damping>0.3</damping></dynamics></axis></joint>
<joint name="r" type="prismatic"><parent>a</parent><child>b</child><axis><xyz>1 1 0</xyz>
</axis></joint></model></sdf>"""


@pytest.mark.parametrize("form", ["MJCF", "SDF"])
@pytest.mark.parametrize("name", ["panda", "ur5_robot", "solo12", "double_pendulum"])
def test_urdf_to_another_format_and_back_is_the_same_robot(name: str, form: Form) -> None:
    robot = name in mq.robots()
    mechanism = mq.read(mq.robot(name)) if robot else mq.textbook.load(name)
    out = mq.convert(mechanism, form, states=20)
    assert out.proved, str(out)
    if form == "MJCF":
        assert any(reading.engine.startswith("MuJoCo") for reading in out.readings)
        unstated = r"limits of velocity of \d+ joints: MJCF has none|\d+ meshes that show bodies"
        assert all(re.match(unstated, line) for line in out.lost)
    else:
        assert out.lost == ()
    back = mq.convert(mq.read(out.text), "URDF", states=20)
    assert max(out.worst, back.worst) <= 1e-12, str(back)
    assert mq.verify(mechanism, against=mq.read_urdf(back.text), samples=5).agrees


@pytest.mark.parametrize("form", SCOPES)
def test_sdf_becomes_any_format(form: Form) -> None:
    conversion = mq.convert(mq.read(ARM), form)
    assert conversion.proved, str(conversion)
    assert conversion.worst <= 1e-12


def _box(name: str, mass: float = 2.0) -> mq.Body:
    return mq.Body(name, mq.box(mass, (0.1, 0.2, 0.3)))


def _chain(kind: str) -> mq.Mechanism:
    """Two boxes, joined by a joint of a kind and a hinge with spring, damper, rotor and limits."""
    place = mq.Placement((0.1, 0.2, 0.3), (0.4, 0.5, 0.6))
    ends = ("first", "earth", "a")
    joints: dict[str, mq.Joint] = {
        "screw": mq.Helical(*ends, origin=place, axis=(0, 0.6, 0.8), pitch=0.07),
        "universal": mq.Universal(*ends, origin=place),
        "ball": mq.Spherical(*ends, origin=place),
        "free": mq.Floating(*ends),
        "planar": mq.Planar(*ends, origin=place),
        "slide": mq.Prismatic(*ends, origin=place, axis=(0, 0.6, 0.8)),
    }
    limits = mq.Limits(-1.0, 2.0, effort=5.0)
    hinge = mq.Revolute("q", "tool", "b", origin=place, axis=(1, 0, 0), limits=limits, armature=0.3)
    fixed = mq.Fixed("mount", "a", "tool", origin=place)
    bodies = (mq.Body("earth"), _box("a"), mq.Body("tool"), _box("b", 3.0))
    forces = (mq.JointSpring("k", "q", 3.0, 0.4), mq.JointDamper("c", "q", 0.5))
    return mq.Mechanism(
        "chain",
        bodies,
        (joints[kind], fixed, hinge),
        forces=forces,
        gravity=(1, 0, -3),
        ground="earth",
    )


@pytest.mark.parametrize("kind", ["screw", "universal", "ball", "free", "slide"])
@pytest.mark.parametrize("form", SCOPES)
def test_every_joint_is_written_with_what_acts_in_it(kind: str, form: Form) -> None:
    mechanism = _chain(kind)
    conversion = mq.convert(mechanism, form, states=20)
    ball = "joint first: a ball, in a tag that Drake reads and other engines do not"
    assert conversion.lost == ((ball,) if (kind, form) == ("ball", "URDF") else ())
    assert conversion.worst <= 1e-12, str(conversion)
    result = mq.read(conversion.text)
    hinge = next(joint for joint in result.joints if joint.name == "q")
    assert isinstance(hinge, mq.Revolute)
    assert (hinge.armature, hinge.limits) == (0.3, mq.Limits(-1.0, 2.0, effort=5.0))
    # MuJoCo, asked where Pinocchio is not installed, takes no link without mass from a URDF
    massless = kind in ("screw", "universal") and form == "URDF"
    assert conversion.proved == (has_pinocchio() or not massless), str(conversion)


def test_sdf_states_loops_where_all_coordinates_are_zero() -> None:
    closed = mq.Loop.hinge("pin", "world", (0.3, 0.2, 1.3), "b", (0, 0, 0), (0, 0, 1), (0, 0, 1))
    mechanism = mq.read(ARM)
    place = np.linalg.inv(mq.Reference(mechanism).pose("b", [0.0, 0.0]))
    point = place @ [0.3, 0.2, 1.3, 1.0]
    axis = place[:3, :3] @ [0.0, 0.0, 1.0]
    closed = mq.Loop.hinge(
        "pin", "world", (0.3, 0.2, 1.3), "b", tuple(point[:3]), (0, 0, 1), tuple(axis)
    )
    conversion = mq.convert(replace(mechanism, loops=(closed,)), "SDF", states=20)
    assert conversion.proved, str(conversion)
    assert conversion.lost == ()
    (loop,) = mq.read(conversion.text).loops
    assert (loop.kind, loop.bodies) == ("hinge", ("world", "b"))
    ball = mq.Loop.ball("far", "world", (0.3, 0.2, 1.3), "b", (0, 0, 0))
    rod = mq.Loop.distance("rod", "world", (0, 0, 0), "b", (0, 0, 0), 1.0)
    conversion = mq.convert(replace(mechanism, loops=(ball, rod)), "SDF", states=5)
    assert conversion.lost == (
        "loop far: it is open where SDF states it, at coordinates of zero",
        "loop rod: SDF has none of the kind 'distance'",
    )


@pytest.mark.parametrize("form", ["URDF", "SDF", "MJCF"])
def test_a_joint_that_is_held_is_a_weld(form: Form) -> None:
    rod = '<geom type="capsule" size="0.1" fromto="0 0 0 0.2 0 -1"/>'
    hinge = '<joint name="{0}" axis="{1}" ref="20" stiffness="{2}"/>'
    inner = f'<body name="c" pos="0 0 -1">{hinge.format("s", "1 0 0", 3)}{rod}</body>'
    slide = f'<joint name="r" type="slide" axis="0 3 4" ref="0.1" damping="1"/>{rod}'
    middle = f'<body name="b" pos="0 0 -1">{hinge.format("h", "0 1 1", 2)}{slide}{inner}</body>'
    body = f'<body name="a">{hinge.format("q", "0 1 0", 0)}{rod}{middle}</body>'
    held = '<joint joint1="h" polycoef="0.3"/><joint joint1="r" polycoef="-0.2"/>'
    text = f"<mujoco><worldbody>{body}</worldbody><equality>{held}</equality></mujoco>"
    mechanism = mq.read(text)
    out = mq.convert(mechanism, form, states=20)
    assert out.proved, str(out)
    told = "the constant coordinates of 2 joints: welds in their place"
    assert (told in out.lost) == (form != "MJCF")
    result, q, v = mq.read(out.text), np.array([0.4, -0.7]), np.array([0.3, 0.9])
    ours, theirs = mq.Reference(mechanism), mq.Reference(result)
    assert ours.acceleration(q, v) == pytest.approx(theirs.acceleration(q, v), rel=1e-9)


def test_a_share_of_the_weight_may_be_taken_off_a_body() -> None:
    mechanism = _chain("slide")
    center = mechanism.bodies[1].center
    lift = mq.Force("lift", "a", center, (-1.0, 0.0, 3.0))  # half of its weight
    lifted = replace(mechanism, forces=(*mechanism.forces, lift))
    assert mq.convert(lifted, "URDF", states=5).lost == (
        "load lift: no such force is written to URDF",
    )
    assert mq.convert(lifted, "SDF", states=5).lost == (
        "load lift: no such force is written to SDF",
    )
    conversion = mq.convert(lifted, "MJCF", states=5)
    assert conversion.proved, str(conversion)
    assert 'gravcomp="0.5"' in conversion.text
    whole = mq.Force("lift", "a", center, (-2.0, 0.0, 6.0))
    conversion = mq.convert(replace(mechanism, forces=(whole,)), "SDF", states=5)
    assert conversion.lost == ()
    assert conversion.worst <= 1e-12


@pytest.mark.parametrize("form", ["MJCF", "SDF"])
def test_moving_bodies_without_mass_get_a_little(form: Form) -> None:
    mechanism = _chain("slide")
    bodies = (mechanism.bodies[0], mq.Body("a"), *mechanism.bodies[2:])
    conversion = mq.convert(replace(mechanism, bodies=bodies), form, states=5)
    said = f"1 body without mass: {form} has none, each has 2e-15 kg and kg·m² more"
    assert conversion.lost == (said,)
    assert conversion.proved, str(conversion)
    assert conversion.worst <= 1e-12


def test_planar_joints_are_not_stated_in_sdf() -> None:
    conversion = mq.convert(_chain("planar"), "SDF", states=5)
    assert conversion.lost == ("joint first: SDF has none of the kind 'Planar'",)


@pytest.mark.parametrize("form", ["MJCF", "SDF"])
@pytest.mark.parametrize(("mass", "most"), [(1.0, 0.9), (1.0, -0.1), (0.0, 0.9)])
def test_what_no_real_body_has_is_converted_and_told(form: Form, mass: float, most: float) -> None:
    inertia = f'<inertia ixx="0.1" iyy="0.1" izz="{most}" ixy="0" ixz="0" iyz="0"/>'
    mechanism = mq.read_urdf(
        f'<robot name="r"><link name="base"/><link name="arm"><inertial><mass value="{mass}"/>'
        f'{inertia}</inertial></link><joint name="j" type="continuous"><parent link="base"/>'
        '<child link="arm"/><axis xyz="0 0 1"/></joint></robot>'
    )
    conversion = mq.convert(mechanism, form, states=5)
    said = f"body arm: no real body has its inertia, and engines of {form} refuse it"
    assert said in conversion.lost
    light = f"1 body without mass: {form} has none, each has 2e-15 kg and kg·m² more"
    assert (light in conversion.lost) == (mass == 0)


def test_names_of_models_in_a_world_are_one_name_in_sdf() -> None:
    two = "".join(
        f'<model name="{name}">{ARM.split(">", 2)[2].split("</model>")[0]}</model>'
        for name in ("m", "n")
    )
    free = '<model name="f"><link name="c"/></model>'
    world = f'<sdf version="1.9"><world name="w">{two}{free}</world></sdf>'
    conversion = mq.convert(mq.read(world), "SDF", states=5)
    assert "::" not in conversion.text
    assert conversion.proved, str(conversion)
    assert conversion.worst <= 1e-12
    assert {"m__q", "n__r"} <= {joint.name for joint in mq.read(conversion.text).joints}


def test_links_called_as_joints_get_other_names_in_sdf() -> None:
    mechanism = _chain("slide")
    a, tool = (replace(joint, name=joint.child) for joint in mechanism.joints[:2])
    whole = replace(mechanism, joints=(a, tool, *mechanism.joints[2:]))
    conversion = mq.convert(whole, "SDF", states=5)
    assert conversion.proved, str(conversion)
    assert {joint.name for joint in mq.read(conversion.text).joints} >= {"a", "q"}


def test_a_fixed_body_without_inertia_is_written_to_mjcf() -> None:
    mechanism = _chain("slide")
    bodies = list(mechanism.bodies)
    bodies[2] = mq.Body("tool", mq.particle(0.1))
    conversion = mq.convert(replace(mechanism, bodies=tuple(bodies)), "MJCF", states=5)
    assert conversion.proved, str(conversion)


def test_joints_with_empty_bodies_between_them_are_one_body_of_mjcf() -> None:
    text = (
        '<mujoco><worldbody><body name="b" pos="0.1 0 1" euler="10 20 30"><joint name="q" '
        'axis="0 1 1" pos="0.1 0 0" stiffness="3" springref="20" ref="10"/><joint name="s" '
        'type="slide" axis="1 1 1" ref="0.1"/><joint name="r" axis="1 0 1" pos="0 0 0.3"/>'
        '<geom size="0.1" pos="0 0 -1"/></body></worldbody></mujoco>'
    )
    conversion = mq.convert(mq.read(text), "MJCF", states=5)
    assert conversion.text.count("<body ") == 1
    assert conversion.proved, str(conversion)
    conversion = mq.convert(mq.read(text), "URDF", states=5)
    assert conversion.worst <= 1e-12
    # by Pinocchio, as MuJoCo refuses empty links
    assert conversion.proved == has_pinocchio()


@pytest.mark.parametrize("form", ["MJCF", "SDF"])
def test_what_shows_a_body_is_written(form: Form) -> None:
    looks = (
        mq.Visual(mq.Box((0.1, 0.2, 0.3)), mq.Placement((0.1, 0, 0), (0.1, 0.2, 0.3))),
        mq.Visual(mq.Cylinder(0.1, 0.4)),
        mq.Visual(mq.Sphere(0.2)),
    )
    mechanism = _chain("slide")
    shape = Shape(2.0, (0.1, 0.0, 0.0), (0.02, 0.03, 0.04, 0.0, 0.0, 0.0), looks)
    a = mq.Body("a", shape)
    bodies = (mechanism.bodies[0], a, *mechanism.bodies[2:])
    conversion = mq.convert(replace(mechanism, bodies=bodies), form, states=5)
    assert conversion.worst <= 1e-12
    shown = next(b for b in mq.read(conversion.text).bodies if b.name == "a").visuals
    assert [visual.geometry for visual in shown] == [visual.geometry for visual in looks]
    assert shown[0].placement.rpy == pytest.approx((0.1, 0.2, 0.3), abs=1e-15)


def test_a_tendon_along_joints_is_written_with_its_rotor() -> None:
    text = (
        '<mujoco><worldbody><body><joint name="q" axis="0 1 0"/><geom size="0.1" pos="1 0 0"/>'
        '<body pos="1 0 0"><joint name="s" type="slide"/><geom size="0.1"/></body></body>'
        '</worldbody><tendon><fixed name="f" stiffness="3" damping="0.2" armature="0.4" '
        'springlength="0.1"><joint joint="q" coef="2"/><joint joint="s" coef="-0.5"/></fixed>'
        "{}</tendon></mujoco>"
    )
    mechanism = mq.read(text.format(""))
    conversion = mq.convert(mechanism, "MJCF", states=5)
    assert conversion.lost == ()
    assert conversion.proved, str(conversion)
    assert conversion.worst <= 1e-12
    bare = mq.read(text.format("").replace("<tendon>", "<!--").replace("</tendon>", "-->"))
    for form in ("URDF", "SDF"):
        conversion = mq.convert(mechanism, form, states=5)
        assert conversion.lost == (f"tendon f: {form} states none of its kind",)
        assert conversion.worst <= 1e-12
        assert mq.verify(bare, against=mq.read(conversion.text), samples=5).agrees


def test_limits_that_differ_are_not_proved(monkeypatch: pytest.MonkeyPatch) -> None:
    def write_wrongly(mechanism: mq.Mechanism) -> str:
        return write_mjcf(mechanism).replace('range="-1 2"', 'range="-1 2.5"')

    monkeypatch.setitem(room._WRITERS, "MJCF", write_wrongly)
    conversion = mq.convert(_chain("slide"), "MJCF", states=5)
    assert conversion.worst == pytest.approx(0.25, rel=1e-12)
    assert not conversion.proved


def test_an_engines_springs_are_compared(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("mujoco")
    from mecanique.reference.originals import mujoco

    read = mujoco.read

    def read_without_springs(text: bytes, *given: object) -> object:
        return read(text.replace(b"stiffness=", b"group=").replace(b'group="3"', b""), *given)  # type: ignore[arg-type]

    engine = replace(ENGINES["mujoco"], read=read_without_springs)  # type: ignore[arg-type]
    monkeypatch.setitem(ENGINES, "mujoco", engine)
    conversion = mq.convert(_chain("slide"), "MJCF", states=5)
    (reading,) = conversion.readings
    assert reading.differs
    assert not conversion.proved


def test_springs_loops_and_mimics_are_written() -> None:
    mechanism = mq.read(ARM)
    point = (0.1, 0.2, 0.3)
    spring = mq.Spring("s", "world", point, "b", point, 30.0, 0.2)
    coil = mq.JointSpring("k", "q", 3.0, 0.4)
    ball = mq.Loop.ball("c", "world", point, "b", point)
    whole = replace(mechanism, forces=(*mechanism.forces, spring, coil), loops=(ball,))
    conversion = mq.convert(whole, "MJCF")
    assert conversion.proved, str(conversion)
    (loop,) = mq.read(conversion.text).loops
    assert (loop.kind, loop.bodies) == ("ball", ("world", "b"))
    driven = mq.Coordinates((), (("r", 0.5 + 2 * mq.coordinate("q")),))
    follows = mq.convert(replace(mechanism, coordinates=driven), "MJCF")
    assert follows.proved, str(follows)
    assert mq.read(follows.text).nv == 1


def test_a_result_that_is_not_read_again_is_told_from_the_source() -> None:
    stiff = replace(mq.read(ARM), forces=(mq.JointDamper("d", "q", 5e80),))
    said = "what was written is not read as URDF, so nothing is proved; .*damping of <dynamics>"
    with pytest.raises(mq.InputError, match=said):
        mq.convert(stiff, "URDF")


def test_what_is_lost_is_listed() -> None:
    conversion = mq.convert(mq.textbook.load("cart_pole"), "MJCF", states=5)
    thin = "1 body without inertia about an axis: MuJoCo refuses them, each has 2e-15 kg·m² more"
    assert conversion.lost == ("load push: no such force is written to MJCF", thin)
    assert "MJCF cannot express: load push" in str(conversion)
    assert conversion.proved, str(conversion)


@pytest.mark.parametrize("name", ["simple_pendulum", "double_pendulum", "furuta_pendulum"])
def test_thin_rods_and_particles_are_written_so_that_mujoco_takes_them(name: str) -> None:
    pytest.importorskip("mujoco")
    conversion = mq.convert(mq.textbook.load(name), "MJCF", states=5)
    (reading,) = conversion.readings
    assert not reading.refused
    assert conversion.proved, str(conversion)


def test_a_wrong_result_is_not_proved(monkeypatch: pytest.MonkeyPatch) -> None:
    def write_wrongly(mechanism: mq.Mechanism) -> str:
        return write_mjcf(mechanism).replace('mass="1"', 'mass="1.000001"')

    monkeypatch.setitem(room._WRITERS, "MJCF", write_wrongly)
    conversion = mq.convert(mq.read(ARM), "MJCF")
    assert not conversion.proved
    assert "The MJCF differs from the source" in str(conversion)


def test_an_engine_that_reads_otherwise_is_named_beside_the_verdict() -> None:
    conversion = mq.convert(mq.textbook.load("rigid_bar_pendulum"), "URDF", states=5)
    otherwise = replace(conversion, readings=(EngineReading("MuJoCo 4.0.0", 9.1e-4),))
    assert not otherwise.proved
    assert str(otherwise).splitlines()[-1] == (
        "The URDF says the same as the source: largest relative difference 0.0e+00 at 5 states; "
        "not proved: read otherwise by MuJoCo 4.0.0."
    )


def test_an_engine_that_refuses_the_result_is_not_said_to_be_missing() -> None:
    pytest.importorskip("mujoco")
    mechanism = _chain("slide")
    flat = Shape(2.0, (0.0, 0.0, 0.0), (0.1, 0.1, 0.9, 0.0, 0.0, 0.0))
    bodies = (mechanism.bodies[0], mq.Body("a", flat, as_given=True), *mechanism.bodies[2:])
    conversion = mq.convert(replace(mechanism, bodies=bodies), "MJCF", states=3)
    assert "refuses the file itself" in str(conversion)
    assert "No engine" not in str(conversion)
    assert not conversion.proved


@pytest.mark.parametrize("form", SCOPES)
def test_without_an_engine_of_the_format_nothing_is_proved(
    form: Form, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(room, "find_spec", lambda _: None)
    conversion = mq.convert(mq.textbook.load("rigid_bar_pendulum"), form, states=5)
    assert conversion.worst < 1e-12
    assert not conversion.proved
    assert not conversion.differs
    assert str(conversion).endswith(
        f"; not proved: no engine of {form} itself is installed, mecanique alone read the result."
    )
    file = tmp_path / f"result{SCOPES[form].suffixes[0]}"
    run = CliRunner().invoke(app, ["convert", "rigid_bar_pendulum", "-o", str(file)])
    assert (run.exit_code, "not proved: no engine" in run.stdout) == (0, True)
    assert replace(conversion, worst=1e-3).differs


@pytest.mark.engine
def test_one_engine_that_reads_the_result_alike_is_enough() -> None:
    pytest.importorskip("mujoco")
    conversion = mq.convert(mq.textbook.load("rigid_bar_pendulum"), "URDF", states=3)
    assert [bool(reading.refused) for reading in conversion.readings] == [False, True]
    assert "MuJoCo" in str(conversion)
    assert "refuses the file itself" in str(conversion)
    assert "not proved" not in str(conversion)
    assert conversion.proved


def test_the_command_writes_and_judges(tmp_path: Path) -> None:
    source, result = tmp_path / "arm.sdf", tmp_path / "arm.xml"
    source.write_text(ARM, encoding="utf-8")
    run = CliRunner().invoke(app, ["convert", str(source), "-o", str(result)])
    assert run.exit_code == 0, run.output
    assert "The MJCF says the same as the source" in run.stdout
    assert mq.read(result).nv == 2
    refused = CliRunner().invoke(app, ["convert", str(source), "-o", str(tmp_path / "arm.usd")])
    assert refused.exit_code == 2
    assert "expected a file ending in .urdf, .xml, .mjcf, .sdf, got 'arm.usd'" in refused.stderr
    with pytest.raises(mq.InputError, match="expected one of 'URDF', 'MJCF', 'SDF' for the format"):
        mq.convert(mq.read(ARM), "USD")  # type: ignore[arg-type]
    with pytest.raises(mq.InputError, match="expected a number of states from 1, got 0"):
        mq.convert(mq.read(ARM), "URDF", states=0)


@pytest.mark.parametrize("form", ["URDF", "MJCF", "SDF"])
def test_loops_are_compared_in_their_order_whatever_their_names(form: Form) -> None:
    """URDF names a loop by its bodies, so that "second" comes before "first"."""
    arm = '<body name="{}" pos="{} 0 1"><joint axis="0 1 0"/><geom size="0.1" pos="0 0 {}"/></body>'
    arms = "".join(
        arm.format(name, k, 0.3 + 0.1 * k) for k, name in enumerate(("z", "y", "b", "a"))
    )
    ties = (
        '<connect name="first" body1="z" body2="y" anchor="0.5 0 0"/>'
        '<connect name="second" body1="b" body2="a" anchor="0.4 0 0.1"/>'
    )
    text = f"<mujoco><worldbody>{arms}</worldbody><equality>{ties}</equality></mujoco>"
    conversion = mq.convert(mq.read(text), form, states=5)
    assert conversion.proved, str(conversion)


@pytest.mark.parametrize("form", ["URDF", "MJCF", "SDF"])
@pytest.mark.parametrize("tie", ["connect", "weld"])
def test_a_loop_may_end_at_the_ground(form: Form, tie: str) -> None:
    """A joint of SDF has no world for its child."""
    link = '<body name="{}" pos="{} 0 {}"><joint axis="0 1 0"/><geom size="0.1" pos="0.4 0 0.1"/>'
    chain = link.format("a", 0, 1) + link.format("b", 1, 0) + link.format("c", 0, 1)
    text = f"<mujoco><worldbody>{chain}</body></body></body></worldbody><equality>"
    text += f'<{tie} body1="c" anchor="0.1 0 0.1"/></equality></mujoco>'
    conversion = mq.convert(mq.read(text), form, states=5)
    assert conversion.proved, str(conversion)
    assert not conversion.lost


@pytest.mark.parametrize(
    ("kind", "form"), [("ball", "URDF"), ("ball", "MJCF"), ("distance", "URDF")]
)
def test_frames_of_loops_may_be_turned_about_what_turns_freely(kind: Kind, form: Form) -> None:
    """The result may state other axes of the same joint."""
    four_bar = mq.textbook.load("four_bar_linkage")
    (loop,) = four_bar.loops
    length = 1.5 if kind == "distance" else 0.0
    turned = replace(loop.frame_a, rpy=(0.3, 0.2, 0.4))
    tilted = replace(loop, kind=kind, length=length, frame_a=turned)
    assert mq.convert(replace(four_bar, loops=(tilted,)), form, states=3).worst < 1e-12


def test_a_length_that_differs_is_not_proved(monkeypatch: pytest.MonkeyPatch) -> None:
    four_bar = mq.textbook.load("four_bar_linkage")
    right, wrong = (
        replace(
            four_bar,
            loops=(mq.Loop.distance("bar", "crank", (1, 0, 0), "ground", (0, 0, 2), length),),
        )
        for length in (1.5, 1.6)
    )
    written = mq.write_urdf(wrong)
    monkeypatch.setitem(room._WRITERS, "URDF", lambda _: written)
    assert mq.convert(right, "URDF", states=3).worst > 1e-3


@pytest.mark.parametrize("form", ["MJCF", "SDF"])
@pytest.mark.parametrize("welded", [False, True])
@pytest.mark.parametrize("xyz", [(0.0, 0.0, 0.0), (1.0, 2.0, 3.0)])
def test_a_body_free_above_what_is_welded_is_free_in_the_world(
    form: Form, welded: bool, xyz: tuple[float, float, float]
) -> None:
    """Both formats count from the world; MuJoCo refuses a free joint inside of another body."""
    place = mq.Placement(xyz, xyz)
    world, top = mq.Body("world"), mq.Body("top", mq.box(2.0, (0.1, 0.2, 0.3)))
    free = mq.Floating("top", "world", "top", origin=place)  # called as its link
    spinning = mq.Mechanism("spinning", (world, top), (free,), ground="world")
    if welded:
        weld = mq.Fixed("weld", "world", "base", origin=place)
        joints = weld, mq.Floating("top", "base", "top")
        spinning = replace(spinning, bodies=(world, mq.Body("base"), top), joints=joints)
    conversion = mq.convert(spinning, form, states=5)
    counted = ("joint top: its coordinates count from the world's frame",)
    assert conversion.lost == (counted if any(xyz) else ())
    assert conversion.proved


@pytest.mark.parametrize("form", ["MJCF", "SDF"])
def test_a_body_free_above_what_moves_is_free_in_the_world(form: Form) -> None:
    """The same bodies in other coordinates; by a force in these it cannot be said."""
    cart, bird = (mq.Body(name, mq.box(2.0, (0.1, 0.2, 0.3))) for name in ("cart", "bird"))
    slide = mq.Prismatic("slide", "world", "cart", axis=(1, 0, 0))
    fly = mq.Floating("fly", "cart", "bird", origin=mq.Placement((0.0, 0.0, 0.4)))
    flight = mq.Mechanism("flight", (mq.Body("world"), cart, bird), (slide, fly), ground="world")
    conversion = mq.convert(flight, form, states=5)
    assert conversion.lost == ("joint fly: its coordinates count from the world's frame",)
    assert conversion.proved
    lift = mq.Force("lift", "bird", (0.0, 0.0, 0.0), (0.0, 0.0, -coordinate(fly.coordinates[2])))
    bound = replace(flight, forces=(lift,))
    assert "joint fly: free joints start at the world's frame" in list_losses(bound, form)

"""A description at rest: where its links stand, where their mass is, what is wrong with it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from viewing_browser import Visit

import mecanique as mq
from mecanique.viewing.live.view import scene_at_rest
from mecanique.viewing.scene.inspection import Inspection, inspection_of
from mecanique.viewing.scene.scene import Scene

ARM = """<robot name="arm">
  <link name="base"/>
  <link name="upper"><inertial><origin xyz="0 0 0.5"/><mass value="2"/>
    <inertia ixx="0.2" iyy="0.2" izz="0.05" ixy="0" ixz="0" iyz="0"/></inertial>
    <visual><origin xyz="0 0 0.5"/><geometry><box size="0.1 0.1 1"/></geometry></visual></link>
  <link name="lower"><inertial><origin xyz="0 0 0.2"/><mass value="1"/>
    <inertia ixx="0.01" iyy="0.01" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial>
    <visual><origin xyz="0 0 0.2"/><geometry><cylinder radius="0.05" length="0.4"/></geometry>
    </visual></link>
  <link name="finger"><inertial><mass value="0.1"/>
    <inertia ixx="1e-4" iyy="1e-4" izz="1e-4" ixy="0" ixz="0" iyz="0"/></inertial>
    <visual><geometry><sphere radius="0.04"/></geometry></visual></link>
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/>
    <origin xyz="0 0 0.3" rpy="0.2 0 0.4"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="2" effort="9" velocity="9"/></joint>
  <joint name="elbow" type="continuous"><parent link="upper"/><child link="lower"/>
    <origin xyz="0 0 1"/><axis xyz="0.6 0.8 0"/></joint>
  <joint name="slide" type="prismatic"><parent link="lower"/><child link="finger"/>
    <origin xyz="0 0 0.4"/><axis xyz="0 0 1"/>
    <mimic joint="elbow" multiplier="0.1" offset="0.05"/>
    <limit lower="0" upper="1" effort="9" velocity="9"/></joint>
</robot>
"""

HEAVY = """<link name="base"><inertial><mass value="3"/>
    <inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link>"""
SOUND = ARM.replace('izz="0.1"', 'izz="0.01"').replace('<link name="base"/>', HEAVY)


@pytest.fixture(scope="module")
def arm() -> mq.Mechanism:
    return mq.read_urdf(ARM)


def looked_into(mechanism: mq.Mechanism) -> Inspection:
    return inspection_of(mechanism, mq.lint(ARM))


def scene(mechanism: mq.Mechanism) -> Scene:
    return scene_at_rest(mechanism, looked_into(mechanism))


def poses_of(mechanism: mq.Mechanism, q: Any) -> np.ndarray:
    """Poses by the reference."""
    motion = mq.simulate(mechanism, q=q, duration=1e-6)
    return np.asarray(motion.poses()[0])


@pytest.mark.parametrize("root", ["fixed", "floating"])
def test_sliders_put_the_links_where_the_reference_has_them(root: Any) -> None:
    mechanism = mq.read_urdf(SOUND, root=root)
    inspection = inspection_of(mechanism, ())
    assert [slider.name for slider in inspection.sliders] == ["shoulder", "elbow"]
    values = {"shoulder": 0.7, "elbow": -1.3}
    expected = poses_of(mechanism, values)
    assert inspection.poses(list(values.values())) == pytest.approx(expected, abs=1e-6)
    start = inspection_of(mechanism, (), mechanism.position(values))
    assert start.poses() == pytest.approx(expected, abs=1e-6)


def test_a_free_body_stands_where_it_is_put() -> None:
    mechanism = mq.read_urdf(SOUND, root="floating")
    q = mechanism.position({"root_joint_x": 1.0, "root_joint_qz": 0.6, "root_joint_qw": 0.8})
    expected = poses_of(mechanism, q)
    assert inspection_of(mechanism, (), q).poses() == pytest.approx(expected, abs=1e-6)


def test_sliders_keep_to_the_limits(arm: mq.Mechanism) -> None:
    shoulder, elbow = looked_into(arm).sliders
    assert (shoulder.low, shoulder.high, shoulder.limited) == (-1, 2, True)
    assert (elbow.low, elbow.high, elbow.limited) == (-np.pi, np.pi, False)


def test_ellipsoids_have_mass_and_inertia_of_the_link(arm: mq.Mechanism) -> None:
    upper = looked_into(arm).links[1]
    a, b, c = np.square(upper.radii)
    moments = upper.mass / 5 * np.diag([b + c, a + c, a + b])
    axes = np.array(upper.axes)
    assert np.linalg.det(axes) == pytest.approx(1, rel=1e-6)
    assert axes @ moments @ axes.T == pytest.approx(np.diag([0.2, 0.2, 0.05]), rel=1e-6)
    assert upper.center == (0, 0, 0.5)


def test_findings_point_at_their_links(arm: mq.Mechanism) -> None:
    notes = {note.finding.code: note for note in looked_into(arm).notes}
    lower = [body.name for body in arm.bodies].index("lower")
    assert notes["M203"].bodies == (lower,)
    assert notes["M203"].suspicious
    assert not any(note.suspicious for note in notes.values() if note.finding.severity == "info")
    found = replace(notes["M203"].finding, message="as joint 'slide' has it", where="link 'lower'")
    (note,) = inspection_of(arm, [found]).notes
    assert [arm.bodies[k].name for k in note.bodies] == ["lower", "finger"]


def test_only_mechanisms_are_looked_into() -> None:
    with pytest.raises(mq.InputError, match="expected a Mechanism, got str"):
        mq.inspect("robot.urdf")  # type: ignore[arg-type]


def test_the_page_bends_the_robot_and_colors_what_is_wrong(
    arm: mq.Mechanism, show: Callable[..., Visit]
) -> None:
    inspection = looked_into(arm)
    seen = show(scene(arm))
    names = "[...document.querySelectorAll('[role=tab]:not([hidden])')].map(t => t.textContent)"
    assert seen.js(names) == ["Findings", "Joints", "URDF"]
    assert "M203" in seen.js("document.getElementById('findings').textContent")
    for k, value in enumerate((1.5, -0.9)):
        move = "([k, x]) => { const s = document.querySelector(`[data-joint='${k}']`);"
        seen.js(f"{move} s.value = x; s.oninput(); }}", [k, value])
    expected = inspection.poses([1.5, -0.9])
    seen.settle()
    for k in range(len(arm.bodies)):
        assert seen.body(k)[:3] == pytest.approx(expected[k, :3, 3], abs=1e-6)
    outputs = "[...document.querySelectorAll('#joints output')].map(o => o.textContent)"
    assert seen.js(outputs) == ["85.9°", "-51.6°"]
    seen.js("document.getElementById('joints-back').click()")
    seen.settle()
    for k, pose in enumerate(inspection.poses()):
        assert seen.body(k)[:3] == pytest.approx(pose[:3, 3], abs=1e-6)

    # what is wrong is red, what is pointed at is bright, and back
    color = "k => mecanique.inspection.anatomy.paints[k][0].paint.color.getHex()"
    plain, lower = seen.js(color, 1), seen.js(color, 2)
    assert plain != lower
    button = "document.querySelector('#findings [data-bodies]')"
    seen.js(f"{button}.click()")
    assert seen.js(color, 2) != lower
    seen.js(f"{button}.click()")
    assert seen.js(color, 2) == lower
    switch = (
        "text => [...document.querySelectorAll('#show-menu label')]"
        ".find(l => l.textContent === text).querySelector('input').click()"
    )
    seen.js(switch, "Suspicious links in color")
    assert seen.js(color, 2) == plain

    # inside of the links
    parts = "['centers', 'ellipsoids', 'axes'].map(n => mecanique.inspection.anatomy[n])"
    visible = f"{parts}.map(all => all.filter(p => p && p.visible).length)"
    assert seen.js(visible) == [0, 0, 0]
    for text in ("Centers of mass", "Inertia ellipsoids", "Joint axes"):
        seen.js(switch, text)
    assert seen.js(visible) == [3, 3, 3]
    scale = "mecanique.inspection.anatomy.ellipsoids[1].scale.toArray()"
    assert seen.js(scale) == pytest.approx(inspection.links[1].radii, rel=1e-6)
    seen.clean()

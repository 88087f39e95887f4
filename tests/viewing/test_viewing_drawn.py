"""What a page draws of bodies and joints: rings and cones, feet of pins, lines of attraction."""

from __future__ import annotations

import numpy as np
import pytest
import umsgpack

import mecanique as mq
from mecanique.viewing.page.page import draw_bodies
from mecanique.viewing.scene.drawn import bodies_of, marks_of, spans_of
from mecanique.viewing.scene.scene import SceneBody


def profile(body: SceneBody, shape: int = 0) -> np.ndarray:
    """The distance from the axis and the height of a round solid's corners, shape (n, 2)."""
    command = umsgpack.unpackb(draw_bodies([body])[shape])
    (geometry,) = command["object"]["geometries"]
    assert geometry["type"] == "LatheGeometry"
    return np.array([[point["x"], point["y"]] for point in geometry["points"]])


def drawn(name: str, body: str) -> SceneBody:
    return next(b for b in bodies_of(mq.textbook.load(name)) if b.name == body)


def test_a_ring_is_open_and_a_disk_is_not() -> None:
    outer = drawn("gyroscope", "outer")
    radius = mq.textbook.load("gyroscope").values["r1"]
    ring = profile(outer)
    assert ring[:, 0].max() == pytest.approx(radius, rel=1e-12)
    assert ring[:, 0].min() > 0.8 * radius
    np.testing.assert_array_equal(ring[0], ring[-1])
    assert profile(drawn("gyroscope", "rotor"))[:, 0].min() == 0.0


def test_a_cone_reaches_from_its_base_to_its_apex() -> None:
    top = drawn("heavy_top", "top")
    values = mq.textbook.load("heavy_top").values
    corners = profile(top)
    flat, ones = np.zeros(len(corners)), np.ones(len(corners))
    places = top.shapes[0].pose @ [flat, corners[:, 0], corners[:, 1], ones]
    apex, rim = places[2].argmin(), places[1].argmax()
    np.testing.assert_allclose(places[:3, apex], 0.0, rtol=0, atol=1e-12)
    np.testing.assert_allclose(places[1:3, rim], [values["r"], values["h"]], rtol=1e-12, atol=0)


@pytest.mark.parametrize(
    ("name", "q", "foot"),
    [
        ("rigid_bar_pendulum", {"q": 0.5}, 1.0),  # hangs
        ("rigid_bar_pendulum", {"q": 2.5}, -1.0),
        ("four_bar_linkage", {"phi": 1.0}, -1.0),  # stands
        ("kepler_orbit", {"r": 1.0}, 0.0),  # the sun is drawn there
    ],
)
def test_a_pin_on_the_bare_ground_has_a_foot_away_from_what_it_carries(
    name: str, q: dict[str, float], foot: float
) -> None:
    mechanism = mq.textbook.load(name)
    poses = np.asarray(mq.Reference(mechanism).poses(mq.assemble(mechanism, q)))
    mark = marks_of(mechanism, poses)[0]
    assert (mark.foot[-1] if mark.foot else 0.0) == foot
    if mark.foot:
        seat = mechanism.evaluate_all(mechanism.joints[0].origin.xyz)
        assert mark.foot[:3] == pytest.approx(seat, abs=1e-12)


def test_pins_that_close_loops_are_marked_where_they_join() -> None:
    """The coupler of a four-bar meets its rocker at c (cos psi, sin psi) from the rocker's pin."""
    mechanism = mq.textbook.load("four_bar_linkage")
    q = mq.assemble(mechanism, {"phi": 1.0})
    poses = np.asarray(mq.Reference(mechanism).poses(q))
    mark = next(mark for mark in marks_of(mechanism, poses) if mark.name == "C")
    assert (mark.kind, mark.foot) == ("revolute", ())
    pose = poses[[body.name for body in mechanism.bodies].index(mark.body)]
    psi = dict(zip(mechanism.coordinates, q, strict=True))["psi"]
    c, d = mechanism.values["c"], mechanism.values["d"]
    joined = (d + c * np.cos(psi), 0.0, c * np.sin(psi))
    assert (pose @ (*mark.point, 1.0))[:3] == pytest.approx(joined, abs=1e-12)
    assert np.abs(pose[:3, :3] @ mark.axis) == pytest.approx((0, 1, 0), abs=1e-12)


def test_springs_stand_on_the_bare_ground_behind_their_ends() -> None:
    """One holds its bar from above, the other from below; a drawn base needs no foot."""
    mechanism = mq.textbook.load("bars_and_springs")
    poses = np.asarray(mq.Reference(mechanism).poses(mq.assemble(mechanism, {"q": 0.0})))
    feet = {mark.name: mark.foot for mark in marks_of(mechanism, poses) if "foot" in mark.name}
    assert [*feet] == ["foot of spring_B", "foot of spring_F"]
    assert feet["foot of spring_B"][3:] == pytest.approx((0, 0, 1), abs=1e-12)
    assert feet["foot of spring_F"][3:] == pytest.approx((0, 0, -1), abs=1e-12)
    shaken = mq.textbook.load("base_excited_mass")
    poses = np.asarray(mq.Reference(shaken).poses([0.1]))
    assert not any("foot" in mark.name for mark in marks_of(shaken, poses))


def test_what_is_attracted_has_a_line_and_no_rod() -> None:
    assert [span.kind for span in spans_of(mq.textbook.load("kepler_orbit"))] == ["pull"]
    # the slide of an elastic pendulum is shown by its spring alone
    kinds = [span.kind for span in spans_of(mq.textbook.load("elastic_pendulum"))]
    assert kinds == ["spring"]

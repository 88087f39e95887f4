"""What a mapping leaves out is the same at every door, and named where there is no answer."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import mecanique as mq
from mecanique.model.states import States, explain_defaults, seated_velocities

RODS = mq.textbook.load("double_pendulum")
GIVEN = {"q1": 0.4}
FULL = [0.4, 0.0]

DOORS: dict[str, Callable[[Any, Any], Any]] = {
    "simulate": lambda q, v: mq.simulate(RODS, q=q, v=v, duration=0.1, method="dop853").q,
    "simulate_many": lambda q, v: mq.simulate_many(RODS, q=q, v=v, duration=0.1).q[:],
    "acceleration": lambda q, v: mq.Reference(RODS).acceleration(q, v),
    "derived acceleration": lambda q, v: mq.derive(RODS).acceleration(q, v),
    "inverse dynamics": lambda q, v: mq.Reference(RODS).inverse_dynamics(q, v, v),
    "energy": lambda q, v: mq.Reference(RODS).energy(q, v).total,
    "pose": lambda q, v: mq.Reference(RODS).pose("rod2", q),
    "linearize": lambda q, v: mq.linearize(RODS, q, v=v).K,
    "equilibria": lambda q, v: np.array([each.q for each in mq.equilibria(RODS, [q])]),
    "assemble": lambda q, v: mq.assemble(RODS, q),
}


@pytest.mark.parametrize("door", DOORS)
def test_what_is_left_out_is_zero_at_every_door(door: str) -> None:
    ask = DOORS[door]
    by_name, in_order = ask(GIVEN, {"q2": 0.5}), ask(FULL, [0.0, 0.5])
    assert np.array_equal(by_name, in_order)


def test_a_picture_takes_the_same(tmp_path: Path) -> None:
    positions: tuple[Any, ...] = (GIVEN, FULL)
    for k, q in enumerate(positions):
        mq.picture(RODS, path=tmp_path / f"{k}.svg", q=q)
    assert (tmp_path / "0.svg").read_text(encoding="utf-8") == (tmp_path / "1.svg").read_text(
        encoding="utf-8"
    )


def test_quaternions_are_unturned_and_limited_coordinates_within_their_limits() -> None:
    body = mq.textbook.load("free_rigid_body")
    assert body.position({"x": 2.0}).tolist() == [2, 0, 0, 0, 0, 0, 1]
    assert np.array_equal(body.position({}), body.neutral())


def test_what_was_not_given_is_named_where_there_is_no_answer() -> None:
    mechanism = mq.textbook.load("elastic_pendulum")
    named = r"finite; r = 0 was not given"
    with pytest.raises(mq.IntegrationError, match=named):
        mq.simulate(mechanism, q={"theta": 1.0}, duration=0.1)
    with pytest.raises(mq.IntegrationError, match="r = 0, theta = 0 were not given"):
        mq.simulate(mechanism, duration=0.1)
    with pytest.raises(mq.IntegrationError, match=r"every force is finite$"):
        mq.simulate(mechanism, q=[0.0, 1.0], duration=0.1)


def test_followers_count_for_what_they_follow() -> None:
    mechanism = mq.textbook.load("atwood_machine")
    (leader,) = mechanism.coordinates
    for follower in mechanism.coordinates.driven:
        assert explain_defaults(mechanism, {follower: 0.1}) == ""
    assert explain_defaults(mechanism, {leader: 0.1}) == ""
    assert explain_defaults(mechanism, [0.1]) == ""
    assert explain_defaults(mechanism, None) == f"; {leader} = 0 was not given"


@pytest.mark.parametrize(("slope", "offset"), [(3.0, 0.5), (-0.25, 0.0), (0.7, -2.0)])
def test_what_follows_gives_what_it_follows(slope: float, offset: float) -> None:
    """b = s a + c, from which a = (b − c) / s and a' = b' / s."""
    parts = mq.Parameter("s", slope), mq.Parameter("c", offset)
    rod = mq.rod(1.0, 1.0)
    follower = mq.Mechanism(
        "follower",
        (mq.Body("ground"), mq.Body("first", rod), mq.Body("second", rod)),
        (
            mq.Revolute("one", "ground", "first", axis=(0, 1, 0), coordinate="a"),
            mq.Revolute("two", "first", "second", axis=(0, 1, 0), coordinate="b"),
        ),
        parameters=parts,
        coordinates=mq.Coordinates(("a",), {"b": parts[0] * mq.coordinate("a") + parts[1]}),
    )
    a = np.array([0.4, -1.3])
    np.testing.assert_allclose(
        follower.position({"b": slope * 0.4 + offset}), [0.4], rtol=1e-14, atol=0
    )
    given: Any = {"b": slope * a + offset}
    many = follower.position(given, many=True)
    np.testing.assert_allclose(many, a[:, None], rtol=1e-14, atol=0)
    np.testing.assert_allclose(follower.velocity({"b'": slope * 0.4}), [0.4], rtol=1e-14, atol=0)
    np.testing.assert_allclose(
        follower.acceleration({"b''": slope * 0.4}), [0.4], rtol=1e-14, atol=0
    )


def test_coefficients_are_lengths_where_friction_of_a_named_force_may_turn() -> None:
    by_force, by_name = (
        mq.Friction("dry", "axle", 0.1, 20.0),
        mq.Friction("dry", "axle", 0.1, "wall"),
    )
    units = [{its.name: its.units for its in dry.stated} for dry in (by_force, by_name)]
    assert (units[0]["mu"], units[0]["mu static"]) == (("1",), ("1",))
    assert (units[1]["mu"], units[1]["mu static"]) == (("1", "m"), ("1", "m"))
    assert units[0]["load"] == ("N", "N·m")
    assert units[0]["speed"] == units[1]["speed"] == ("m/s", "rad/s")


def test_a_torque_on_a_screw_by_its_name_is_the_moment_about_its_axis() -> None:
    press = mq.textbook.load("screw_press")
    assert seated_velocities(press) == {"theta'", "slip'"}
    efforts = States.of(press, [0.1], tau={"thread": 2.0, "bearing": -3.0}).efforts
    assert efforts is not None
    assert efforts.names == ("theta'", "theta_travel'", "slip'")
    assert efforts.values.tolist() == [[2.0, 0.0, -3.0]]


def test_a_screw_is_renamed_by_its_angle() -> None:
    hinge = mq.Revolute("hinge", "ground", "arm")
    assert hinge.renamed(("angle",)).coordinates == ("angle",)
    thread = mq.textbook.load("screw_press").joint("thread")
    assert isinstance(thread, mq.Helical)
    assert thread.renamed(("way", "angle")).coordinates == ("angle_travel", "angle")

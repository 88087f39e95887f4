"""Linearizing without a state looks for an equilibrium, and says which one was chosen."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest

import mecanique as mq
from mecanique.model.expression import Scalar
from mecanique.motion.linear import equilibria


@pytest.mark.parametrize(
    ("name", "place"),
    [
        ("two_link_arm", {"q1": -pi / 2, "q2": 0.0}),
        ("slider_crank", {"theta": -pi / 2}),
        ("chained_four_bars", {f"theta{k}": -pi / 2 for k in range(3)}),
    ],
)
def test_the_lowest_stable_equilibrium_is_found_from_random_starts(
    name: str, place: dict[str, float]
) -> None:
    linear = mq.linearize(mq.textbook.load(name))
    assert linear.at_equilibrium
    assert linear.stable
    assert "random starts lead to, the stable one with the least potential energy" in linear.chosen
    assert linear.chosen in str(linear)
    found = dict(zip(linear.mechanism.coordinates, linear.q, strict=True))
    assert {key: found[key] for key in place} == pytest.approx(place, abs=1e-8)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["four_bar_linkage", "governor"])
def test_no_equilibrium_lies_lower(name: str) -> None:
    mechanism = mq.textbook.load(name)
    linear = mq.linearize(mechanism)
    reference = mq.Reference(mechanism)
    lowest = min(reference.energy(e.q).potential for e in mq.equilibria(mechanism, 20) if e.stable)
    assert reference.energy(linear.q).potential == pytest.approx(lowest, abs=1e-9)


def test_starts_that_go_to_and_fro_are_given_up(monkeypatch: pytest.MonkeyPatch) -> None:
    """A third of 51 starts took a hundred steps each; the positions of rest come in pairs."""
    steps = 0
    take = equilibria._step

    def count(slope: np.ndarray, value: np.ndarray, longest: float) -> np.ndarray:
        nonlocal steps
        steps += 1
        return take(slope, value, longest)

    monkeypatch.setattr(equilibria, "_step", count)
    rest = mq.equilibria(mq.textbook.load("four_bar_linkage"))
    assert [e.stable for e in rest] == [True, False, True, False]
    # the linkage and its mirror image in the line of the pins
    np.testing.assert_allclose(rest[3].q, -rest[0].q, rtol=0, atol=1e-9)
    np.testing.assert_allclose(rest[2].q, -rest[1].q, rtol=0, atol=1e-9)
    assert steps < 600


def test_the_neutral_position_comes_first() -> None:
    linear = mq.linearize(mq.textbook.load("double_pendulum"))
    assert linear.chosen == "the equilibrium that Newton's method reaches from the neutral position"
    assert not linear.q.any()
    near = mq.linearize(mq.textbook.load("double_pendulum"), near={"q1": 3.0, "q2": 3.0})
    assert near.chosen == "the equilibrium that Newton's method reaches from the start given"
    assert not mq.linearize(mq.textbook.load("double_pendulum"), near.q).chosen


@pytest.mark.parametrize("name", ["heavy_top", "spherical_pendulum"])
def test_an_equilibrium_where_coordinates_fall_in_line_is_refused(name: str) -> None:
    with pytest.raises(mq.InputError, match=r"moves no mass at .*; choose other coordinates"):
        mq.linearize(mq.textbook.load(name))
    assert mq.equilibria(mq.textbook.load(name), 20) == ()


@pytest.mark.parametrize("name", ["free_particle", "kepler_orbit", "atwood_machine"])
def test_what_nothing_balances_is_refused_with_a_remedy(name: str) -> None:
    remedy = r"say where: linearize\(mechanism, near=.*any state: linearize\(mechanism, at="
    with pytest.raises(mq.InputError, match=f"no equilibrium of '{name}' was found.*{remedy}"):
        mq.linearize(mq.textbook.load(name))


def test_a_family_of_equilibria_is_one() -> None:
    """A linkage on a turntable rests at any angle of the table."""
    bodies = (
        mq.Body("ground"),
        mq.Body("table", mq.disk(5.0, 1.0)),
        mq.Body("a", mq.rod(1.0, 0.5, (0, 0, -1))),
        mq.Body("b", mq.rod(1.0, 0.5, (0, 0, -1))),
    )
    joints = (
        mq.Revolute("axle", "ground", "table", axis=(0, 0, 1), coordinate="psi"),
        mq.Revolute("A", "table", "a", axis=(0, -1, 0), coordinate="p"),
        mq.Revolute(
            "B", "table", "b", axis=(0, -1, 0), origin=mq.Placement((0.2, 0, 0)), coordinate="r"
        ),
    )
    coupler = mq.Loop.distance("coupler", "a", (0, 0, -0.5), "b", (0, 0, -0.5), 0.2)
    gravity = (0, 0, -9.81)
    mechanism = mq.Mechanism("turntable", bodies, joints, loops=(coupler,), gravity=gravity)
    start = [{"psi": psi, "p": 0.1, "r": 0.1} for psi in (0.0, 1.0, 2.0)]
    assert len(mq.equilibria(mechanism, start)) == 1


def test_equilibria_of_a_family_are_called_so() -> None:
    cart = mq.linearize(mq.textbook.load("cart_pole"))
    assert cart.chosen.endswith("; it is one of a family, with any value of x")
    alone = mq.linearize(mq.textbook.load("rigid_bar_pendulum"))
    assert "family" not in alone.chosen
    weightless = mq.linearize(mq.textbook.load("n_link_pendulum", n=6, g=0.0))
    assert weightless.chosen.endswith("with any value of q1, q2, q3, q4 and 2 more")


def test_a_coin_rests_upright_anywhere() -> None:
    """Nothing resists its place, its heading and its turn; it falls to either side."""
    coin = mq.textbook.load("rolling_coin")
    (upright,) = mq.equilibria(coin, 6)
    assert upright.family == ("x", "y", "yaw", "spin")
    place = dict(zip(coin.coordinates, upright.q, strict=True))
    assert place["lean"] == pytest.approx(0.0, abs=1e-9)
    assert place["z"] == pytest.approx(coin.values["r"], rel=1e-12)
    assert not upright.stable
    # about its rim: m r² (1 + 1/4) lean'' = m g r lean
    growth = upright.linearization.eigenvalues.real.max()
    assert growth == pytest.approx((4 * 9.81 / (5 * coin.values["r"])) ** 0.5, rel=1e-9)
    assert "it is one of a family, with any value of x, y, yaw, spin" in str(upright)


def test_a_ball_rests_in_a_bowl_however_it_is_turned() -> None:
    """It rolls to and fro with 5 g / (7 (R - r)) (Lamb, Higher Mechanics, 1920, art. 76)."""
    bowl = mq.textbook.load("ball_in_a_bowl")
    bottom, top = mq.equilibria(bowl, 4)
    s = bowl.values
    swing = (5 * 9.81 / (7 * (s["R"] - s["r"]))) ** 0.5
    frequencies = bottom.linearization.frequencies
    np.testing.assert_allclose(frequencies, [0, swing, swing], rtol=0, atol=1e-8)
    assert bottom.family == tuple(f"turns of ball about {axis}" for axis in "xyz")
    assert (bottom.stable, top.stable) == (True, False)


def test_a_family_along_a_curve_is_one() -> None:
    """A bead on a level ring rests anywhere; in an upright one at two places, tied or not."""
    bodies = (mq.Body("ground"), mq.Body("cross"), mq.Body("bead", mq.particle(1.0)))
    joints = (
        mq.Prismatic("along", "ground", "cross", axis=(1, 0, 0), coordinate="x"),
        mq.Prismatic("up", "cross", "bead", axis=(0, 0, 1), coordinate="z"),
    )
    wire = (mq.Loop.distance("wire", "ground", (0, 0, 0), "bead", (0, 0, 0), 0.5),)
    level = mq.Mechanism("ring", bodies, joints, loops=wire, gravity=(0, 0, 0))
    (anywhere,) = mq.equilibria(level, [{"x": 0.5}, {"x": 0.3, "z": 0.4}, {"x": -0.3, "z": -0.4}])
    assert anywhere.family == ("x and z together",)
    upright = mq.Mechanism("ring", bodies, joints, loops=wire, gravity=(0, 0, -9.81))
    low, high = mq.equilibria(upright, [{"x": 0.5, "z": 0.1}, {"x": 0.3, "z": -0.4}, {"z": 0.5}])
    assert (low.family, high.family) == ((), ())
    assert low.linearization.frequencies == pytest.approx([(9.81 / 0.5) ** 0.5], rel=1e-9)


def tied_blocks(rate: Scalar) -> mq.Mechanism:
    """Three blocks on springs with (1 + sin z) x' + y' equal to a rate."""
    names = ("x", "y", "z")
    slides = tuple(
        mq.Prismatic(name, "ground", f"block {name}", axis=(1.0, 0.0, 0.0), coordinate=name)
        for name in names
    )
    row = (("x", 1.0 + mq.sin(mq.coordinate("z"))), ("y", 1.0))
    return mq.Mechanism(
        "tied blocks",
        (mq.Body("ground"), *(mq.Body(f"block {k}", mq.particle(1.0)) for k in names)),
        slides,
        tuple(mq.JointSpring(f"spring {k}", k, 5.0) for k in names),
        velocity_constraints=(mq.VelocityConstraint("tie", row, rate),),
    )


def test_what_a_constraint_moves_does_not_rest() -> None:
    """A rate 0.2 sin(t) is zero at t = 0 but accelerates the blocks; 0.2 cos(t) moves them."""
    assert mq.equilibria(tied_blocks(0.0), 5)
    assert not mq.equilibria(tied_blocks(0.2 * mq.sin(mq.time())), 5)
    assert not mq.equilibria(tied_blocks(0.2 * mq.cos(mq.time())), 5)

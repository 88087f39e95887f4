"""Bounds of rounding in closed form: what is summed, what is solved for, and along the links."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import mecanique as mq
from mecanique.derivation.numeric.constraints.rows import Held
from mecanique.model.states import States
from mecanique.verification.rounding import (
    entry_rounding,
    in_independent_coordinates,
    measure_noise,
    rounding,
)
from mecanique.verification.rows import evaluate
from mecanique.verification.states import random_states

Array = Any

EPSILON = 2.0**-52
UNIT, ENTRY = 8 * EPSILON, 64 * EPSILON


def bead_on_a_turning_rod(mass: float = 2.0) -> mq.Mechanism:
    """A bead that slides along a rod without mass, which turns in a level plane."""
    return mq.Mechanism(
        "bead",
        (mq.Body("ground"), mq.Body("rod"), mq.Body("bead", mq.particle(mass))),
        (
            mq.Revolute("pin", "ground", "rod", axis=(0, 0, 1), coordinate="theta"),
            mq.Prismatic("slide", "rod", "bead", axis=(1, 0, 0), coordinate="r"),
        ),
        forces=(mq.JointForce("push", "slide", 3.0), mq.JointForce("drive", "pin", -5.0)),
        gravity=(0, 0, -9.81),
    )


def test_bounds_of_a_tree_follow_from_its_mass_matrix_in_closed_form() -> None:
    """M = diag(m r², m): s = (r_max/r, 1), and M⁻¹ scaled is one."""
    m, bead = 2.0, bead_on_a_turning_rod(2.0)
    states = random_states(bead, 6, 0)
    values = evaluate(mq.derive(bead), states)
    bounds = rounding(bead, states, values)

    r, (spin, speed), a = np.abs(states.q[:, 1]), states.v.T, np.abs(states.a)
    s = np.stack([r.max() / r, np.ones(6)], axis=1)
    length = np.linalg.norm(s, axis=1)

    def size(f: Array) -> Array:
        """Norm of f_i / d_i, and the typical one of f_i over the largest d_i."""
        d = np.sqrt(m) * np.stack([r, np.ones(6)], axis=1)
        typical = np.sqrt(np.mean(np.sum((f / d.max(axis=0)) ** 2, axis=1)))
        return np.linalg.norm(f / d, axis=1) + typical

    bias = np.stack([2 * m * states.q[:, 1] * speed * spin, -m * states.q[:, 1] * spin**2], axis=1)
    forces = np.tile([-5.0, 3.0], (6, 1))
    pushed = size(bias) + size(forces)
    moved = np.sqrt(m) * (r.max() * a[:, 0] + a[:, 1])
    solved = np.abs((forces - bias) / (m * np.stack([r**2, np.ones(6)], axis=1)))
    flung = np.sqrt(m) * (r.max() * solved[:, 0] + solved[:, 1])
    expected = {
        "mass matrix": length**2,
        "bias": length * size(bias),
        "gravity": np.zeros(6),
        "forces": length * size(forces),
        "inverse dynamics": length * (moved + pushed),
        "acceleration": length * (flung + pushed),
        # δa in the norm of the kinetic energy: sᵀ M⁻¹ s
        "reactions": np.sqrt(m * length**2) * (flung + pushed),
    }
    assert bounds.keys() == expected.keys()
    for quantity, bound in expected.items():
        np.testing.assert_allclose(
            bounds[quantity], UNIT * np.sqrt(2) * bound, rtol=1e-9, atol=1e-25, err_msg=quantity
        )


def expected_of_loops(
    mechanism: mq.Mechanism, states: States, values: Mapping[str, Array]
) -> Array:
    """‖δa‖ for u = 1, by the inverse of the whole matrix of a and λ: |A⁻¹| (|δA| |x| + |δb|)."""
    held = Held(mechanism).at(states)
    d = np.sqrt(np.diagonal(values["mass matrix"], axis1=1, axis2=2))
    largest, n = d.max(axis=0), mechanism.nv
    usual = np.linalg.norm(held.jacobian, axis=2).max(axis=0)

    def size(f: Array) -> Array:
        typical = np.sqrt(np.mean(np.sum((f / largest) ** 2, axis=1)))
        return np.linalg.norm(f / d, axis=1) + typical

    beta_bias, beta_forces = size(values["bias"]), size(values["forces"])
    bounds = []
    for k in range(len(states)):
        s = largest / d[k]
        J = held.jacobian[k] / d[k]
        raw, gamma = np.linalg.norm(held.jacobian[k], axis=1), held.gamma[k]
        acting = raw > 0  # in a plane, rows across it are zero
        J, raw, gamma, most = J[acting], raw[acting], gamma[acting], usual[acting]
        rows = np.linalg.norm(J, axis=1)
        J, gamma = J / rows[:, None], gamma / rows
        M = values["mass matrix"][k] / np.outer(d[k], d[k])
        whole = np.block([[M, -J.T], [J, np.zeros((len(J), len(J)))]])
        inverse = np.linalg.pinv(whole, rcond=1e-9)
        right = np.concatenate([(values["forces"][k] - values["bias"][k]) / d[k], -gamma])
        a, multipliers = np.split(inverse @ right, [n])
        by_force, by_drift = inverse[:n, :n], inverse[:n, n:]
        norm, pinv = np.linalg.norm(J, 2), np.linalg.norm(np.linalg.pinv(J, rcond=1e-9), 2)
        in_rows = norm * (most / raw).max()
        # velocities are known to u ‖J‖ ‖J⁺‖, and bias and γ are quadratic in them
        quadratic = 1 + 2 * in_rows * pinv
        moved = s @ np.abs(a)
        pushed = moved + beta_forces[k] + quadratic * beta_bias[k]
        pushed += in_rows * np.linalg.norm(multipliers)
        drifted = in_rows * moved + quadratic * np.linalg.norm(gamma)
        bounds.append(
            np.linalg.norm(np.abs(by_force) @ s) * pushed + np.linalg.norm(by_drift, 2) * drifted
        )
    return np.array(bounds)


def closed_by_a_hinge() -> mq.Mechanism:
    """A four-bar linkage, closed by five equations in space, of which two are independent."""
    linkage = mq.textbook.load("four_bar_linkage")
    (loop,) = linkage.loops
    ends = (loop.body_a, loop.frame_a.xyz, loop.body_b, loop.frame_b.xyz)
    return replace(linkage, loops=(mq.Loop.hinge("hinge", *ends, (0, 1, 0)),))


@pytest.mark.parametrize("name", ["four_bar_linkage", "governor", "closed by a hinge"])
def test_the_bound_of_loops_is_that_of_the_whole_matrix_of_accelerations_and_multipliers(
    name: str,
) -> None:
    mechanism = closed_by_a_hinge() if " " in name else mq.textbook.load(name)
    states = random_states(mechanism, 5, 0)
    values = evaluate(mq.derive(mechanism), states)
    bound = rounding(mechanism, states, values)["acceleration"]
    # elimination repeats the same errors, which add up like their number
    expected = UNIT * mechanism.nv * expected_of_loops(mechanism, states, values)
    np.testing.assert_allclose(bound, expected, rtol=1e-6, atol=0)


def arm(lengths: tuple[float, ...], masses: tuple[float, ...], spring: float = 0.0) -> mq.Mechanism:
    """Particles at the ends of rods without mass, hinged one to the other about y."""
    bodies, joints, last, place = [mq.Body("ground")], list[mq.Joint](), "ground", (0.0, 0.0, 0.0)
    for k, (length, mass) in enumerate(zip(lengths, masses, strict=True)):
        bodies.append(mq.Body(f"b{k}", mq.particle(mass).at((length, 0, 0))))
        hinge = mq.Revolute(f"h{k}", last, f"b{k}", axis=(0, 1, 0), origin=mq.Placement(place))
        joints.append(hinge)
        last, place = f"b{k}", (length, 0.0, 0.0)
    return mq.Mechanism("arm", tuple(bodies), tuple(joints), gravity=(0, 0, -9.81))


def test_what_an_arm_sums_is_what_it_is_where_it_is_stretched() -> None:
    """All terms of M, gravity, energy and momentum have one sign there, and none is larger."""
    mechanism = arm((0.5, 0.3, 0.7), (2.0, 1.0, 3.0))
    states = random_states(mechanism, 4, 0)
    bounds = entry_rounding(mechanism, states)
    stretched = replace(states, q=np.zeros((4, 3)), v=np.abs(states.v))
    largest = evaluate(mq.derive(mechanism), stretched)
    for quantity in ("mass matrix", "gravity"):
        np.testing.assert_allclose(
            bounds[quantity], ENTRY * np.abs(largest[quantity]), rtol=1e-12, atol=0
        )
    # Σ m v² has no half in it; a momentum is as uncertain in each direction
    np.testing.assert_allclose(
        bounds["kinetic energy"], ENTRY * 2 * largest["kinetic energy"], rtol=1e-12, atol=0
    )
    np.testing.assert_allclose(
        bounds["momentum"],
        np.tile(ENTRY * np.abs(largest["momentum"][:, 2:]), (1, 3)),
        rtol=1e-12,
        atol=0,
    )


def test_what_a_moving_arm_sums_in_closed_form() -> None:
    """Of the particles at the ends: levers times weight and α, ω² of all links before, and m v²."""
    lengths, masses = np.array([0.5, 0.3, 0.7]), np.array([2.0, 1.0, 3.0])
    mechanism = arm(tuple(lengths), tuple(masses))
    states = random_states(mechanism, 4, 0)
    bounds = entry_rounding(mechanism, states)
    spin = np.cumsum(np.abs(states.v), axis=1)
    # each particle's speed, and its acceleration: weight, ω² along each rod and the axes' turns
    speed = np.cumsum(spin * lengths, axis=1)
    pull = 9.81 + np.cumsum(2 * spin**2 * lengths, axis=1)
    for joint in range(3):
        lever = np.cumsum(np.where(np.arange(3) >= joint, lengths, 0.0))
        own = np.arange(3) >= joint
        expected = (masses * (lever * pull + speed**2))[:, own].sum(axis=1)
        np.testing.assert_allclose(bounds["bias"][:, joint], ENTRY * expected, rtol=1e-12, atol=0)
    # about the center of mass, which lies within the same reach: twice the way to the last hinge
    way = np.cumsum(lengths) - lengths
    angular = (masses * (2 * way + lengths) * speed).sum(axis=1)
    np.testing.assert_allclose(
        bounds["angular momentum"], ENTRY * np.tile(angular[:, None], 3), rtol=1e-12, atol=0
    )


def test_what_a_telescope_sums_in_closed_form() -> None:
    """A hinge, a slide and a hinge with a particle: r θ'², and 2 θ' r' of Coriolis.

    A second particle, on the first hinge, does not feel the others.
    """
    l, m, near, other = 0.4, 2.0, 0.2, 5.0
    mechanism = mq.Mechanism(
        "telescope",
        (
            mq.Body("ground"),
            mq.Body("a", mq.particle(other).at((near, 0, 0))),
            mq.Body("b"),
            mq.Body("c", mq.particle(m).at((l, 0, 0))),
        ),
        (
            mq.Revolute("turn", "ground", "a", axis=(0, 1, 0)),
            mq.Prismatic("slide", "a", "b", axis=(1, 0, 0), origin=mq.Placement((0.3, 0, 0))),
            mq.Revolute("wrist", "b", "c", axis=(0, 1, 0)),
        ),
        gravity=(0, 0, -9.81),
    )
    states = random_states(mechanism, 4, 0)
    r, (turn, slide, wrist) = 0.3 + np.abs(states.q[:, 1]), np.abs(states.v.T)
    spin = turn + wrist
    speed = turn * r + slide + spin * l
    pull = 9.81 + 2 * turn**2 * r + 2 * turn * slide + 2 * spin**2 * l
    lever = np.stack([r + l, np.ones(4), np.full(4, l)], axis=1)
    bounds = entry_rounding(mechanism, states)
    expected = m * lever[:, :, None] * lever[:, None, :]
    expected[:, 0, 0] += other * near**2
    np.testing.assert_allclose(bounds["mass matrix"], ENTRY * expected, rtol=1e-12, atol=0)
    weight = 9.81 * (m * lever + np.array([other * near, 0, 0]))
    np.testing.assert_allclose(bounds["gravity"], ENTRY * weight, rtol=1e-12, atol=0)
    energy = m * speed**2 + other * (near * turn) ** 2
    np.testing.assert_allclose(bounds["kinetic energy"], ENTRY * energy, rtol=1e-12, atol=0)
    # a velocity's direction turns with the links: by its speed, that of a slide by the spin
    turned = np.stack([speed, spin, speed], axis=1)
    bias = m * (lever * pull[:, None] + turned * speed[:, None])
    bias[:, 0] += other * near * (9.81 + 2 * turn**2 * near) + other * (near * turn) ** 2
    np.testing.assert_allclose(bounds["bias"], ENTRY * bias, rtol=1e-12, atol=0)


def test_a_body_sums_its_mass_times_the_square_of_the_distance_from_its_joint() -> None:
    """∫ r² dm, of which a moment of inertia about any axis is a part; free, |x| comes before."""
    m, center, sides = 3.0, np.array([0.1, -0.2, 0.4]), np.array([0.3, 0.5, 0.7])
    body = mq.Body("body", mq.box(m, tuple(sides)).at(tuple(center)))
    polar = m * (center @ center + sides @ sides / 12)
    hinge = mq.Revolute(
        "hinge", "ground", "body", axis=(0.6, 0, 0.8), origin=mq.Placement((1, 2, 3))
    )
    hung = mq.Mechanism("hung", (mq.Body("ground"), body), (hinge,))
    bound = entry_rounding(hung, random_states(hung, 2, 0))["mass matrix"]
    np.testing.assert_allclose(bound, np.full((2, 1, 1), ENTRY * polar), rtol=1e-12, atol=0)

    joint = mq.Floating("free", "ground", "body", origin=mq.Placement((1, 2, 2)))
    free = mq.Mechanism("free", (mq.Body("ground"), body), (joint,), gravity=(0, 0, -9.81))
    states = random_states(free, 3, 0)
    bounds = entry_rounding(free, states)
    root, size = np.sqrt(m), np.sqrt(polar)
    B = np.repeat([root, size], 3)
    np.testing.assert_allclose(
        bounds["mass matrix"], np.tile(ENTRY * np.outer(B, B), (3, 1, 1)), rtol=1e-12, atol=0
    )
    way = 3 + np.linalg.norm(states.q[:, :3], axis=1)
    slide, turn = np.abs(states.v[:, :3]).sum(axis=1), np.abs(states.v[:, 3:]).sum(axis=1)
    speed = root * slide + size * turn
    expected = (2 * root * way + size) * speed
    np.testing.assert_allclose(
        bounds["angular momentum"], ENTRY * np.tile(expected[:, None], 3), rtol=1e-12, atol=0
    )
    # weight, ω × v of the velocity in the body's axes, and ω² with the axes' turns
    pull = root * (9.81 + turn * slide) + 2 * size * turn**2
    turned = np.repeat(np.stack([root * turn, speed], axis=1), 3, axis=1)
    bias = B * pull[:, None] + turned * speed[:, None]
    np.testing.assert_allclose(bounds["bias"], ENTRY * bias, rtol=1e-12, atol=0)


def test_the_energy_of_a_rotor_is_rounded_as_well() -> None:
    """A light particle in a heavy drive: I θ'², beside which m l² θ'² is nothing."""
    drive = mq.Revolute("pin", "ground", "bob", axis=(0, 1, 0), coordinate="theta", armature=7.0)
    bob = mq.Body("bob", mq.particle(1e-9).at((0.3, 0, 0)))
    mechanism = mq.Mechanism("drive", (mq.Body("ground"), bob), (drive,))
    states = random_states(mechanism, 3, 0)
    energy = (7.0 + 1e-9 * 0.09) * states.v[:, 0] ** 2
    bounds = entry_rounding(mechanism, states)
    np.testing.assert_allclose(bounds["kinetic energy"], ENTRY * energy, rtol=1e-12, atol=0)


def test_angles_of_many_turns_are_as_uncertain_as_they_are_large() -> None:
    mechanism = arm((0.5, 0.3), (2.0, 1.0))
    states = random_states(mechanism, 3, 0)
    q = states.q.copy()
    q[1, 1], q[2] = -20 * np.pi, (6 * np.pi, 1.0)
    usual, many = (entry_rounding(mechanism, replace(states, q=x)) for x in (0 * q, q))
    for quantity, bound in usual.items():
        factor = np.array([1.0, 10.0, 3.0]).reshape(-1, *[1] * (bound.ndim - 1))
        np.testing.assert_allclose(many[quantity], factor * bound, rtol=1e-12, atol=0)


def driven_block(law: Any, m: float) -> mq.Mechanism:
    """A block that a law of p, q and t moves along an arm which turns by theta."""
    return mq.Mechanism(
        "driven",
        (mq.Body("ground"), mq.Body("arm"), mq.Body("block", mq.particle(m))),
        (
            mq.Revolute("turn", "ground", "arm", axis=(0, 1, 0), coordinate="theta"),
            mq.Prismatic("slide", "arm", "block", axis=(1, 0, 0), coordinate="x"),
        ),
        coordinates=mq.Coordinates(("theta", "p", "q"), {"x": law}),
        gravity=(0, 0, -9.81),
    )


P, Q = mq.coordinate("p"), mq.coordinate("q")


def test_a_driven_joint_is_as_certain_as_its_formula() -> None:
    """x = p q² sin 3t: |x| + |∂x/∂t t| + |∂x/∂p p| + |∂x/∂q q|, and so its slopes."""
    m = 2.0
    mechanism = driven_block(P * Q**2 * mq.sin(3 * mq.time()), m)
    states = random_states(mechanism, 4, 0)
    bounds = entry_rounding(mechanism, states)
    p, q, t = np.abs(states.q[:, 1]), np.abs(states.q[:, 2]), states.t
    sine, cosine = np.abs(np.sin(3 * t)), np.abs(np.cos(3 * t))
    x, by_p, by_q = p * q**2, q**2, 2 * p * q
    size = x * sine + 3 * x * cosine * t + 3 * x * sine
    along_p = by_p * sine + 3 * by_p * cosine * t + 2 * by_p * sine
    along_q = by_q * sine + 3 * by_q * cosine * t + 2 * by_q * sine
    B = np.stack([size, along_p, along_q], axis=1)
    expected = m * B[:, :, None] * B[:, None, :]
    np.testing.assert_allclose(bounds["mass matrix"], ENTRY * expected, rtol=1e-12, atol=0)
    np.testing.assert_allclose(bounds["gravity"], ENTRY * m * 9.81 * B, rtol=1e-12, atol=0)
    assert bounds.keys() == {"mass matrix", "gravity"}


@pytest.mark.parametrize("sense", [1, -1])
def test_what_cancels_in_a_formula_is_as_uncertain_as_what_adds_up(sense: int) -> None:
    """x = p ± q p + t: |x| + |p (1 ± q)| + |q p| + |t|, and slopes 1 ± q and p with theirs."""
    m = 2.0
    mechanism = driven_block(P + sense * Q * P + mq.time(), m)
    states = random_states(mechanism, 6, 1)
    p, q, t = states.q[:, 1], states.q[:, 2], states.t
    by_p = np.abs(1 + sense * q)
    size = np.abs(p + sense * q * p + t) + np.abs(p) * by_p + np.abs(q * p) + np.abs(t)
    B = np.stack([size, by_p + np.abs(q), 2 * np.abs(p)], axis=1)
    found = entry_rounding(mechanism, states)["mass matrix"]
    expected = ENTRY * m * B[:, :, None] * B[:, None, :]
    np.testing.assert_allclose(found, expected, rtol=1e-12, atol=0)


@pytest.mark.parametrize(
    ("law", "linear"),
    [
        (lambda q, t: 3 * q, True),
        (lambda q, t: q / 2 + 1, True),
        (lambda q, t: q + t, False),
        (lambda q, t: q * t, False),
        (lambda q, t: q**2, False),
    ],
)
def test_bias_energy_and_momenta_are_bounded_where_the_map_is_linear_and_at_rest(
    law: Callable[[Any, Any], Any], linear: bool
) -> None:
    mechanism = mq.Mechanism(
        "slider",
        (mq.Body("ground"), mq.Body("block", mq.particle(2.0))),
        (mq.Prismatic("x", "ground", "block", axis=(1, 0, 0)),),
        coordinates=mq.Coordinates(("q",), {"x": law(mq.Parameter("q", 0.0), mq.time())}),
    )
    bounds = entry_rounding(mechanism, random_states(mechanism, 3, 0))
    assert ("bias" in bounds) == linear
    assert ("kinetic energy" in bounds) == linear


def test_independent_coordinates_are_as_uncertain_as_their_choice_is_irregular() -> None:
    """The inverse of the block enters twice in each of eight steps, down to a billionth."""
    bounds = {name: np.array([1e-15, 2e-15]) for name in ("acceleration", "bias")}
    found = in_independent_coordinates(bounds, np.array([0.5, 0.0]))
    np.testing.assert_allclose(found["acceleration"], [32e-15, 16e3], rtol=1e-12, atol=0)
    np.testing.assert_array_equal(found["bias"], bounds["bias"])


def noise_of(gain: float, opening: float = 0.0, size: float = 50.0) -> tuple[Any, Array]:
    """Noise of answers that shift by a gain times the shift of q, and q; of a mass of 4 kg."""
    slider = mq.Mechanism(
        "slider",
        (mq.Body("ground"), mq.Body("block", mq.particle(4.0))),
        (mq.Prismatic("x", "ground", "block", axis=(1, 0, 0)),),
    )
    states = random_states(slider, 20, 0)

    def ask(near: States) -> dict[str, Array]:
        shifted = size * (1 + gain * (near.q - states.q))
        return {"bias": 2 * shifted, "acceleration": shifted / 2, "gravity": np.ones((20, 1))}

    noise = measure_noise(ask, np.full((20, 1, 1), 4.0), states, np.full(20, opening))
    return noise, np.abs(states.q[:, 0])


@pytest.mark.parametrize("opening", [0.0, 2e-16, 1e-14])
def test_noise_is_eight_times_what_answers_differ_by_beside_a_state(opening: float) -> None:
    """Four ε of each position and what loops are open, to either side, of five answers."""
    gain, size = 1e6, 50.0
    noise, q = noise_of(gain, opening, size)
    most = 2 * size * gain * (4 * EPSILON * q + opening)
    for quantity in ("bias", "acceleration"):  # both scaled by the root of the mass to one
        part = noise[quantity] / (8 * most)
        assert (part < 1).all()
        # of four differences from the first the largest is seldom small
        assert part.max() > 0.8
        assert np.median(part) > 0.4
    np.testing.assert_array_equal(noise["gravity"], 0)


def test_noise_above_a_hundred_thousandth_of_an_answer_excuses_nothing() -> None:
    for gain, kept in ((1e8, True), (1e12, False)):
        noise, _ = noise_of(gain, 1e-14)
        assert (noise["bias"] > 0).all() == kept
        assert (noise["bias"] > 0).any() == kept
    noise, _ = noise_of(1e9, 1e-14, 50.0)
    excused = noise["bias"][noise["bias"] > 0] / 50
    assert 0 < len(excused) < 20
    assert 0.7e-5 * 8 < excused.max() <= 1e-5 * 8 * 1.001


@pytest.mark.parametrize("name", ["bead", "four_bar_linkage"])
@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_a_state_without_numbers_changes_no_bound_elsewhere(name: str, bad: float) -> None:
    mechanism = bead_on_a_turning_rod() if name == "bead" else mq.textbook.load(name)
    states = random_states(mechanism, 5, 0)
    values = evaluate(mq.derive(mechanism), states)
    values = {quantity: np.concatenate([x, x[:1]]) for quantity, x in values.items()}
    alone = {quantity: x[:5] for quantity, x in values.items()}
    for quantity in ("bias", "gravity", "forces", "acceleration"):
        values[quantity][5] = bad
    six = states.at(np.array([0, 1, 2, 3, 4, 0]))
    with np.errstate(invalid="ignore"):
        bounds = rounding(mechanism, six, values)
    for quantity, bound in rounding(mechanism, states, alone).items():
        np.testing.assert_allclose(bounds[quantity][:5], bound, rtol=1e-12, atol=0)
        assert not np.isnan(bounds[quantity]).any()


def test_accelerations_have_no_bound_where_nothing_determines_them() -> None:
    """A hinge on the axis of another: M has no inverse."""
    body = mq.Body("body", mq.box(2.0, (0.1, 0.2, 0.3)))
    joints = (
        mq.Revolute("a", "ground", "ring", axis=(0, 0, 1)),
        mq.Revolute("b", "ring", "body", axis=(0, 0, 1)),
    )
    mechanism = mq.Mechanism("coaxial", (mq.Body("ground"), mq.Body("ring"), body), joints)
    states = States.of(mechanism, np.zeros((2, 2)), np.ones((2, 2)), np.zeros(2), np.ones((2, 2)))
    values = evaluate(mq.derive(mechanism), states, accelerations=False)
    bounds = rounding(mechanism, states, values | {"acceleration": np.ones((2, 2))})
    assert (bounds["acceleration"] == np.inf).all()
    assert (bounds["reactions"] == np.inf).all()
    assert np.isfinite(bounds["bias"]).all()
    assert rounding(mechanism, states, {"bias": values["bias"]}) == {}

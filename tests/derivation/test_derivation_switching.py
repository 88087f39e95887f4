"""What a mode holds, what an impact changes and what each element has left, by hand."""

from __future__ import annotations

from itertools import combinations_with_replacement
from typing import Any

import numpy as np
import pytest
from numpy.linalg import solve
from sympy import Symbol, prod

import mecanique as mq
from mecanique.derivation.mechanics.letters import Letters
from mecanique.derivation.mechanics.switching import (
    BACKWARD,
    CLOSED,
    FORWARD,
    SLIPS,
    STICKS,
    ElementRows,
    ModeProblem,
    Terms,
    accelerate,
    bounce,
    close_contacts,
    find_inside,
    hold,
    joint_terms,
    list_elements,
    list_holding_margins,
    list_present_margins,
    name_mode,
    solve_held,
)
from mecanique.derivation.printing.writers import Text
from mecanique.derivation.switching import _Cosines
from mecanique.derivation.tolerances import CLOSED_GAP
from mecanique.program.evaluation import evaluate
from mecanique.program.traced import values_of

MASS, G, MU, MU_0 = 2.0, 9.81, 0.3, 0.4
FLOOR = mq.Contact("floor", "puck", mu=MU)
LOAD = np.array([5.0, -3.0, -MASS * G])
"""On a puck with the velocities x', y', z' over a floor."""


def puck(velocity: tuple[float, float, float], gap: float = 0.0) -> Terms:
    """The terms of a puck over a floor: rows normal, x and y."""
    J = np.array([[0.0, 0, 1], [1, 0, 0], [0, 1, 0]])
    return Terms(
        mass=MASS * np.eye(3),
        load=LOAD,
        jacobian=J,
        gamma=np.array([0.5, -0.2, 0.1]),
        gaps=np.array([gap, 0.0, 0.0]),
        rates=J @ velocity,
        drift=np.zeros(3),
        kinetic=np.array([MU]),
        static=np.array([MU_0]),
    )


def floor(*tangents: int, **given: Any) -> tuple[ElementRows, ...]:
    return (ElementRows(FLOOR, 0, tangents, pressing=0, **given),)


def answer(terms: Terms, elements: Any, mode: Any, problem: ModeProblem) -> Any:
    def by_mass(columns: np.ndarray) -> np.ndarray:
        return solve(terms.mass, columns)

    def by_rows(J: Any, yielding: Any, free: Any, wanted: Any) -> Any:
        return solve(J @ yielding, wanted - free)

    held = hold(terms, elements, mode, problem)
    solution = solve_held(terms, held, problem, by_mass, by_rows)
    assert solution is not None
    return solution


def test_an_open_contact_leaves_the_puck_to_its_load() -> None:
    terms, elements = puck((1, 0, 0), 0.2), floor(1, 2)
    a, forces = answer(terms, elements, name_mode(elements, {}), accelerate(terms, elements))
    np.testing.assert_allclose(a, LOAD / MASS, rtol=1e-14, atol=0)
    assert not forces.any()
    margins = list_present_margins(terms, elements, name_mode(elements, {}), forces, np.hypot)
    assert margins == [(0.2, 1.0)]


def test_a_puck_that_sticks_has_the_accelerations_of_its_rows() -> None:
    terms, elements = puck((0, 0, 0)), floor(1, 2)
    mode = name_mode(elements, {"floor": STICKS})
    a, forces = answer(terms, elements, mode, accelerate(terms, elements))
    np.testing.assert_allclose(a, [0.2, -0.1, -0.5], rtol=1e-14, atol=0)
    expected = MASS * a - LOAD
    np.testing.assert_allclose(forces, expected[[2, 0, 1]], rtol=1e-14, atol=0)
    ((press, reserve),) = list_present_margins(terms, elements, mode, forces, np.hypot)
    assert press == pytest.approx(MASS * (G - 0.5), rel=1e-14)
    assert reserve == pytest.approx(MU_0 * press - np.hypot(*expected[:2]), rel=1e-14)


@pytest.mark.parametrize("direction", [(1.0,), (-1.0,), (0.6, -0.8)])
def test_friction_of_a_puck_that_slips_is_against_its_slip(direction: tuple[float, ...]) -> None:
    terms = puck((3.0 * direction[0], 3.0 * (*direction, 0.0)[1], 0.0))
    elements = floor(*range(1, 1 + len(direction)))
    state = SLIPS if direction[1:] else FORWARD if direction[0] > 0 else BACKWARD
    mode = name_mode(elements, {"floor": state}, direction)
    a, forces = answer(terms, elements, mode, accelerate(terms, elements))
    N = MASS * (G - 0.5)
    friction = np.array([-MU * N * part for part in (*direction, 0.0)[:2]])
    np.testing.assert_allclose(a, [*(LOAD[:2] + friction) / MASS, -0.5], rtol=1e-14, atol=0)
    np.testing.assert_allclose(forces, [N, *friction], rtol=1e-14, atol=1e-15)
    ((press, speed),) = list_present_margins(terms, elements, mode, forces, np.hypot)
    assert (press, speed) == pytest.approx((N, 3.0), rel=1e-14)


def test_what_a_latch_holds_is_left_before_it_opens() -> None:
    terms, elements = puck((0, 0, 0)), floor(holds=4.0)
    mode = name_mode(elements, {"floor": CLOSED})
    a, forces = answer(terms, elements, mode, accelerate(terms, elements))
    np.testing.assert_allclose(a, [*LOAD[:2] / MASS, -0.5], rtol=1e-14, atol=0)
    ((press, reserve),) = list_present_margins(terms, elements, mode, forces, np.hypot)
    assert press == pytest.approx(MASS * (G - 0.5) + 4.0, rel=1e-14)
    assert reserve == 1.0


def test_an_elastic_floor_presses_by_how_far_it_is_pressed_in() -> None:
    terms, elements = puck((2.0, 0, 0), -0.01), floor(1, stiffness=3000.0)
    mode = name_mode(elements, {"floor": FORWARD})
    a, forces = answer(terms, elements, mode, accelerate(terms, elements))
    expected = [(5.0 - MU * 30.0) / MASS, -1.5, 30.0 / MASS - G]
    np.testing.assert_allclose(a, expected, rtol=1e-14, atol=0)
    np.testing.assert_allclose(forces, [30.0, -MU * 30.0, 0.0], rtol=1e-14, atol=0)
    # it opens where the gap does, however it is closed
    ((left, speed),) = list_present_margins(terms, elements, mode, forces, np.hypot)
    assert (left, speed) == (0.01, 1.0)
    ((gap, _),) = list_present_margins(terms, elements, name_mode(elements, {}), forces, np.hypot)
    assert gap == -0.01


def test_a_stated_friction_needs_no_normal_force() -> None:
    """Its coefficients are forces: 0.3 N while it slips, 0.4 N before it does."""
    dry = mq.Friction("dry", "slide", 0.3, 1.0, mu_static=0.4)
    elements = (ElementRows(dry, None, (1,)),)
    terms = puck((-2.0, 0, 0))
    mode = name_mode(elements, {"dry": BACKWARD})
    a, forces = answer(terms, elements, mode, accelerate(terms, elements))
    np.testing.assert_allclose(a, (LOAD + np.array([MU, 0, 0])) / MASS, rtol=1e-14, atol=0)
    np.testing.assert_allclose(forces, [0, MU, 0], rtol=1e-14, atol=0)
    assert list_present_margins(terms, elements, mode, forces, np.hypot) == [(1.0, 2.0)]
    mode = name_mode(elements, {"dry": STICKS})
    a, forces = answer(terms, elements, mode, accelerate(terms, elements))
    ((_, reserve),) = list_present_margins(terms, elements, mode, forces, abs)
    assert reserve == pytest.approx(MU_0 - abs(MASS * 0.2 - 5.0), rel=1e-14)


@pytest.mark.parametrize("restitution", [0.0, 0.5, 1.0])
def test_an_impact_turns_the_rate_of_the_gap_around(restitution: float) -> None:
    """By Newton's law; friction that slips takes μ of the normal impulse, what sticks all slip."""
    terms, elements = puck((6.0, 0, -2.0)), floor(1, restitution=restitution)

    def solve_state(terms: Terms, state: str, problem: ModeProblem) -> Any:
        return answer(terms, elements, name_mode(elements, {"floor": state}), problem)

    change, impulses = bounce(terms, elements, ("floor", FORWARD), solve_state)
    P = MASS * 2.0 * (1 + restitution)
    np.testing.assert_allclose(impulses, [P, -MU * P, 0], rtol=1e-14, atol=0)
    expected = [-MU * P / MASS, 0, 2.0 * (1 + restitution)]
    np.testing.assert_allclose(change, expected, rtol=1e-14, atol=0)
    change, impulses = bounce(terms, elements, ("floor", STICKS), solve_state)
    np.testing.assert_allclose(change, [-6.0, 0, 2.0 * (1 + restitution)], rtol=1e-14, atol=0)
    np.testing.assert_allclose(impulses, [P, -12.0, 0], rtol=1e-14, atol=0)


@pytest.mark.parametrize("restitution", [0.0, 0.5])
def test_an_impact_by_poisson_gives_a_part_of_the_impulse_back(restitution: float) -> None:
    """Friction is μ of the impulse given back, too; by Routh's diagram the puck slips on."""
    bouncing = mq.Contact("floor", "puck", mu=MU, law="poisson")
    elements = (ElementRows(bouncing, 0, (1,), pressing=0, restitution=restitution),)

    def solve_state(terms: Terms, state: str, problem: ModeProblem) -> Any:
        return answer(terms, elements, name_mode(elements, {"floor": state}), problem)

    terms, pressed = puck((6.0, 0, -2.0)), 2.0 * MASS
    back, friction = restitution * pressed, MU * restitution * pressed
    for state, along in (
        (STICKS, -6.0 * MASS),
        (FORWARD, -MU * pressed - friction),
        ("", -MU * pressed - friction),
    ):
        change, impulses = bounce(terms, elements, ("floor", state), solve_state)
        np.testing.assert_allclose(impulses, [pressed + back, along, 0], rtol=1e-14, atol=1e-14)
        expected = [along / MASS, 0, (pressed + back) / MASS]
        np.testing.assert_allclose(change, expected, rtol=1e-14, atol=1e-14)


@pytest.mark.parametrize("foot", [0.0, 0.6, -0.6, 2.0])
def test_a_side_with_ends_carries_between_them(foot: float) -> None:
    """Near an end what is left is the distance from it; beyond, a contact is open."""
    elements, half = floor(1, length=3.0), 1.5
    assert find_inside(floor(1), {}, np.zeros(3)) == [1.0]
    (left,) = find_inside(elements, {"floor": foot}, np.zeros(3))
    inside = (half + foot) * (half - foot) / (2 * half)
    assert left == pytest.approx(inside, rel=1e-14)
    for gap in (-1.0, 0.1, 1.0):
        terms = puck((3.0, 0, 0), gap)._replace(inside=np.array([left]))
        margins = list_present_margins(terms, elements, name_mode(elements, {}), None, abs)
        assert margins == [(pytest.approx(max(gap, -inside), rel=1e-13), 1.0)]
    mode, weight = name_mode(elements, {"floor": FORWARD}), np.abs(LOAD).sum()
    for press in (0.1, 50.0):
        forces = np.array([press, 0, 0])
        margins = list_present_margins(terms, elements, mode, forces, abs)
        assert margins == [(pytest.approx(min(press, weight / 3 * inside), rel=1e-13), 3.0)]


@pytest.mark.parametrize("gap", [-0.7, -0.2, 0.0, 0.4])
def test_at_an_edge_a_side_carries_only_what_is_not_in_front_of_the_other(gap: float) -> None:
    """What is left is the smaller of the distances from the end and behind the other side."""
    elements, half, foot = floor(1, length=3.0, edges=(2,)), 1.5, 0.6
    (left,) = find_inside(elements, {"floor": foot}, np.array([0.0, 9.0, gap]))
    inside = (half + foot) * (half - foot) / (2 * half)
    assert left == pytest.approx(min(inside, -gap), rel=1e-8, abs=1e-8)


@pytest.mark.parametrize("tiny", [-2.0, -0.5, 0.5, 2.0])
def test_what_touches_the_other_side_of_an_edge_is_not_behind_it(tiny: float) -> None:
    """Within the gap that counts as closed it rests on the other side, not on this one."""
    elements = floor(1, length=3.0, edges=(2,))
    (left,) = find_inside(elements, {"floor": 0.6}, np.array([0, 9, tiny * CLOSED_GAP * 3.0]))
    assert (left > 0) == (tiny < -1)


def test_a_coordinate_that_sticks_does_not_creep_by_the_rounding_of_forces() -> None:
    """A row of one coordinate is kept exactly; in others the forces decide."""
    elements = floor(1)
    terms = puck((0, 0, 0))._replace(jacobian=np.array([[0.6, 0, 0.8], [0, 4.0, 0], [1, 1, 0]]))
    mode, off = name_mode(elements, {"floor": STICKS}), np.array([1e-3, 2e-3])
    problem = accelerate(terms, elements)
    held = hold(terms, elements, mode, problem)
    solution = solve_held(
        terms, held, problem, lambda columns: columns / MASS, lambda J, y, free, wanted: off
    )
    assert solution is not None
    a, forces = solution
    assert forces.tolist() == [1e-3, 2e-3, 0.0]
    x, _, z = (LOAD + off @ terms.jacobian[:2]) / MASS
    assert a.tolist() == pytest.approx([x, 0.2 / 4.0, z], rel=1e-14)


def test_what_is_held_at_many_states_is_what_is_held_at_each() -> None:
    random, elements = np.random.default_rng(4), floor(1, 2)
    terms = [
        puck((1, 2, 0))._replace(jacobian=random.normal(size=(3, 3)), kinetic=random.random(1))
        for _ in range(4)
    ]
    together = Terms(*map(np.stack, zip(*terms, strict=True)))
    for state in elements[0].states:
        mode = name_mode(elements, {"floor": state}, (0.6, -0.8))
        held = hold(together, elements, mode, accelerate(together, elements))
        for k, single in enumerate(terms):
            alone = hold(single, elements, mode, accelerate(single, elements))
            assert alone.rows == held.rows
            for ours, theirs in zip(alone[1:], held[1:], strict=True):
                np.testing.assert_allclose(ours, theirs[k], rtol=1e-14, atol=0)


def test_a_contact_rubs_along_the_rows_in_which_something_moves() -> None:
    bodies = mq.Body("ground"), mq.Body("puck", mq.particle(1.0))
    joints = (mq.Floating("free", "ground", "puck"),)
    rows = ["other", *(f"floor: {row}" for row in ("normal", "x", "y"))]
    smooth = mq.Contact("floor", "puck", restitution=0.25, length=2.0)
    for contact, idle, expected in (
        (FLOOR, (), (1, 2, 3)),
        (FLOOR, (3,), (1, 2)),
        (FLOOR, (2, 3), (1,)),
        (smooth, (), (1,)),
    ):
        mechanism = mq.Mechanism("puck", bodies, joints, switching=(contact,))
        (element,) = list_elements(mechanism, rows, mechanism.evaluate, idle)
        assert (element.rows, element.pressing) == (expected, 1)
    assert (element.restitution, element.length, element.states) == (0.25, 2.0, ("open", "closed"))


def test_what_rolls_and_cords_hold_as_long_as_they_press() -> None:
    """A wheel with friction may slip or lift off, one without only lift off, a cord go slack."""
    bodies = mq.Body("ground"), *(mq.Body(name, mq.particle(1.0)) for name in "ab")
    joints = tuple(mq.Floating(f"free_{name}", "ground", name) for name in "ab")
    mu = mq.Parameter("mu", 0.3)
    wheels = tuple(
        mq.Rolling(name, body, 0.1, axis=(0, 1, 0), friction=friction)
        for name, body, friction in (("rough", "a", mu), ("ideal", "b", None))
    )
    pair = mq.Mechanism("pair", bodies, joints, contacts=wheels, parameters=(mu,))
    rows = [f"{name}: {row}" for name in ("rough", "ideal") for row in ("normal", "x", "y")]
    forces = dict(zip(rows, [10.0, 1.5, -2.0, 4.0, 3.0, 1.0], strict=True))
    margins = list_holding_margins(pair, forces, pair.evaluate, np.hypot)
    assert margins == pytest.approx([10.0, 3.0 - 2.5, 4.0], rel=1e-14)
    machine = mq.textbook.load("atwood_machine")
    tensions = {"cord_1": 7.0, "cord_2": -1.0}
    assert list_holding_margins(machine, tensions, machine.evaluate, np.hypot) == [7.0, -1.0]


def slider(*elements: Any, driven: dict[str, Any] | None = None) -> mq.Mechanism:
    bodies = mq.Body("ground"), mq.Body("a", mq.particle(1.0)), mq.Body("b", mq.particle(1.0))
    slides = tuple(
        mq.Prismatic(f"slide_{body}", "ground", body, axis=(1, 0, 0), coordinate=q)
        for body, q in (("a", "x"), ("b", "y"))
    )
    coordinates = mq.Coordinates(("x",) if driven else (), driven or {})
    return mq.Mechanism("slider", bodies, slides, coordinates=coordinates, switching=elements)


def numbers(mechanism: mq.Mechanism, q: list[float], v: list[float], t: float) -> dict[str, Any]:
    """Return the terms of elements in joints as numbers, by name."""
    letters = Letters(close_contacts(mechanism))
    terms = joint_terms(mechanism, letters)
    at = dict(zip([*mechanism.coordinates, *mechanism.velocities, "t"], [*q, *v, t], strict=True))
    inputs = {name: at.get(name, 0.0) for _, _, name in letters.tape.operations if name}
    result = {}
    for name in ("jacobian", "gamma", "gaps", "rates", "drift", "kinetic", "static"):
        array = getattr(terms, name)
        flat = evaluate(letters.tape, values_of(array.ravel()), inputs, 1)[0]
        result[name] = flat.reshape(array.shape)
    return result


def test_rows_of_joints_are_gaps_and_ways_with_their_rates() -> None:
    """A stop above, one below, a belt, and a cord between both slides over a drum."""
    elements = (
        mq.Stop("above", "slide_a", at=0.5),
        mq.Stop("below", "slide_b", at=-0.25, side=-1),
        mq.Friction("belt", "slide_b", 0.3, 10.0, mu_static=0.4, speed=0.7),
        mq.Capstan("cord", "slide_a", "slide_b", length=2.0, wrap=1.0, mu=0.2),
    )
    found = numbers(slider(*elements), [0.1, 0.3], [1.0, -2.0], 0.0)
    np.testing.assert_allclose(found["gaps"], [0.4, 0.55, 0, 1.6, 0], rtol=1e-14, atol=0)
    jacobian = np.array([[-1, 0], [0, 1], [0, 1], [-1, -1], [0.5, -0.5]])
    np.testing.assert_allclose(found["jacobian"], jacobian, rtol=1e-14, atol=0)
    np.testing.assert_allclose(found["rates"], [-1, -2, -2.7, 1, 1.5], rtol=1e-14, atol=0)
    np.testing.assert_allclose(found["drift"], [0, 0, -0.7, 0, 0], rtol=1e-14, atol=0)
    assert not found["gamma"].any()
    drum = 2 * np.tanh(0.1)
    np.testing.assert_allclose(found["kinetic"], [0, 0, 3, drum], rtol=1e-14, atol=0)
    np.testing.assert_allclose(found["static"], [0, 0, 4, drum], rtol=1e-14, atol=0)
    rows = list_elements(slider(*elements), ["one", "two"], float)
    assert [element.rows for element in rows] == [(2,), (3,), (4,), (5, 6)]
    assert [element.struck for element in rows] == [True, True, False, True]
    assert [element.pressing for element in rows] == [None, None, None, 5]
    assert [element.states for element in rows] == [e.states for e in elements]


def test_a_joint_that_the_map_drives_moves_its_stop() -> None:
    """y = x²/2 + sin 3t: J = x, its rate has the drift 3 cos 3t, and γ = x'² − 9 sin 3t."""
    driven = {"y": mq.coordinate("x") ** 2 / 2 + mq.sin(3 * mq.time())}
    found = numbers(slider(mq.Stop("s", "slide_b", at=1.0), driven=driven), [0.4], [2.0], 0.6)
    wave, slope = np.sin(1.8), 3 * np.cos(1.8)
    np.testing.assert_allclose(found["gaps"], [1 - 0.08 - wave], rtol=1e-14, atol=0)
    np.testing.assert_allclose(found["jacobian"], [[-0.4]], rtol=1e-14, atol=0)
    np.testing.assert_allclose(found["rates"], [-0.8 - slope], rtol=1e-14, atol=0)
    np.testing.assert_allclose(found["drift"], [-slope], rtol=1e-14, atol=0)
    np.testing.assert_allclose(found["gamma"], [-4.0 + 9 * wave], rtol=1e-14, atol=0)


def push_on(W: Any, rates: Any, mu: float, rise: float, impulse: float = np.inf) -> Any:
    """Follow an impact in a plane step by step; W[i, j] is rate i that impulse j changes.

    The normal impulse grows until the normal rate is `rise`, or the impulse is as given. Friction
    is μ times it against slip; once that has stopped, what holds it, or on the cone's nearer side.
    """
    u, p = np.array(rates), np.zeros(2)
    for _ in range(2):
        friction = -mu * np.sign(u[1]) if u[1] else np.clip(-W[1, 0] / W[1, 1], -mu, mu)
        unit = np.array([1.0, friction])
        slope = W @ unit
        size = impulse - p[0] if np.isfinite(impulse) else (rise - u[0]) / slope[0]
        stop = -u[1] / slope[1] if u[1] * slope[1] < 0 else np.inf
        assert min(slope[0], size) > 0, "nothing jams"
        p += min(size, stop) * unit
        u += min(size, stop) * slope
        if size <= stop:
            return p
        u[1] = 0.0
    raise AssertionError("slip stops once")


@pytest.mark.parametrize("size", [1.0, 1e7, 1e-7])
@pytest.mark.parametrize("law", ["newton", "poisson"])
def test_an_impact_goes_through_the_phases_of_its_friction(law: Any, size: float) -> None:
    """Slip that lasts, stops and sticks, or stops and turns around, whatever is coupled.

    One in ten begins without slip; masses are of any size.
    """
    random = np.random.default_rng(12)
    contact = mq.Contact("floor", "puck", mu=MU, law=law)
    seen = set()
    for case in range(60):
        e, root = random.uniform(0, 1), random.normal(size=(3, 3))
        elements = (ElementRows(contact, 0, (1,), pressing=0, restitution=e),)
        speeds = (random.uniform(-3, 3) * (case % 10 > 0), 0.0, random.uniform(-2, -1))
        terms = puck(speeds)._replace(mass=size * (root @ root.T + 1.5 * np.eye(3)))
        J = terms.jacobian[:2]
        W = J @ solve(terms.mass, J.T)
        if law == "newton":
            expected = push_on(W, terms.rates[:2], MU, -e * terms.rates[0])
        else:
            pressed = push_on(W, terms.rates[:2], MU, 0.0)[0]
            expected = push_on(W, terms.rates[:2], MU, 0.0, (1 + e) * pressed)
        change, impulses = bounce(terms, elements, ("floor", ""), alone(elements))
        near = 1e-11 * size
        np.testing.assert_allclose(impulses[:2], expected, rtol=1e-11, atol=near)
        np.testing.assert_allclose(terms.mass @ change, J.T @ expected, rtol=1e-11, atol=near)
        slip = terms.rates[1] + W[1] @ expected
        still = abs(slip) < 1e-12
        seen.add("sticks" if still else "slips on" if slip * terms.rates[1] > 0 else "turns around")
    assert seen == {"sticks", "slips on", "turns around"}


def alone(elements: Any) -> Any:
    """Return what solves a state of a floor."""

    def solve_state(terms: Terms, state: str, problem: ModeProblem) -> Any:
        return answer(terms, elements, name_mode(elements, {"floor": state}), problem)

    return solve_state


@pytest.mark.parametrize("law", ["newton", "poisson"])
def test_what_does_not_approach_has_no_impact(law: Any) -> None:
    contact = mq.Contact("floor", "puck", mu=MU, law=law)
    elements = (ElementRows(contact, 0, (1,), pressing=0, restitution=0.6),)
    for rise in (0.0, 1.5):
        change, impulses = bounce(puck((2.0, 0, rise)), elements, ("floor", ""), alone(elements))
        assert not change.any()
        assert not impulses.any()


@pytest.mark.parametrize(("leads", "parts"), [(2.0, True), (-2.0, True), (5.0, False)])
def test_what_friction_jams_stays_and_does_not_part(leads: float, parts: bool) -> None:
    """Of one motion v with the slip k v: beyond μ |k| = 1 what sticks may not move at all."""
    elements = floor(1, restitution=0.5)
    terms = puck((0, 0, 0))._replace(
        mass=np.array([[MASS]]),
        load=np.zeros(1),
        jacobian=np.array([[1.0], [leads], [0.0]]),
        rates=np.array([-1.0, -leads, 0.0]),
    )

    # what sticks has two rows for one motion
    def by_rows(J: Any, yielding: Any, free: Any, wanted: Any) -> Any:
        return np.linalg.lstsq(J @ yielding, wanted - free, rcond=None)[0]

    def solve_state(terms: Terms, state: str, problem: ModeProblem) -> Any:
        held = hold(terms, elements, name_mode(elements, {"floor": state}), problem)
        return solve_held(terms, held, problem, lambda columns: columns / MASS, by_rows)

    change, impulses = bounce(terms, elements, ("floor", ""), solve_state)
    np.testing.assert_allclose(change, [1.5 if parts else 1.0], rtol=1e-12, atol=0)
    assert impulses[0] + leads * impulses[1] == pytest.approx(MASS * change[0], rel=1e-12)
    assert abs(impulses[1]) <= MU * impulses[0] * (1 + 1e-12)


@pytest.mark.parametrize("law", ["newton", "poisson"])
@pytest.mark.parametrize("state", ["", STICKS, FORWARD])
def test_impacts_of_many_states_are_those_of_each(law: Any, state: str) -> None:
    random = np.random.default_rng(5)
    contact = mq.Contact("floor", "puck", mu=MU, law=law)
    elements = (ElementRows(contact, 0, (1,), pressing=0, restitution=0.4),)
    single = [
        puck(tuple(random.uniform(-3, -1, 3)))._replace(
            mass=np.diag(random.uniform(1, 2, 3)), jacobian=random.normal(size=(3, 3))
        )
        for _ in range(5)
    ]

    def solve_each(terms: Terms, state: str, problem: ModeProblem) -> Any:
        solved = []
        for k in range(len(terms.load)):
            given = {row: np.broadcast_to(x, 5)[k] for row, x in problem.given.items()}
            each = ModeProblem(problem.load[k], problem.wanted[k], given, problem.sticking[k], [0])
            here = Terms(*(part[k] if len(part) else part for part in terms))
            solved.append(alone(elements)(here, state, each))
        return tuple(map(np.array, zip(*solved, strict=True)))

    together = Terms(*(np.array(part) for part in zip(*single, strict=True)))
    found = bounce(together, elements, ("floor", state), solve_each)
    for k, terms in enumerate(single):
        expected = bounce(terms, elements, ("floor", state), alone(elements))
        for ours, theirs in zip(found, expected, strict=True):
            np.testing.assert_allclose(ours[k], theirs, rtol=1e-12, atol=1e-13)


@pytest.mark.parametrize("tilt", [0.0, 0.4, -2.0])
@pytest.mark.parametrize("end", [1, -1])
def test_two_sides_meet_in_an_edge_where_one_falls_off_behind_the_other(
    tilt: float, end: int
) -> None:
    """What touches a corner that juts out may be on either side; in a hollow it touches both."""
    bodies = mq.Body("ground"), mq.Body("ball", mq.ball(1.0, 0.1))
    joints = (mq.Planar("free", "ground", "ball", axis=(0, -1, 0)),)

    def turn(angle: float, x: float, z: float) -> np.ndarray:
        """Return (x, 0, z), turned about y."""
        c, s = np.cos(angle), np.sin(angle)
        return np.array([c * x + s * z, 0.0, c * z - s * x])

    for fall in (-2.0, -1.0, -0.3, 0.3, 1.0, 2.0):
        corner = turn(tilt, end * 1.5, 0.0)
        next_angle = tilt + end * fall  # turned by `fall` downwards, outwards from the corner
        middle = corner + turn(next_angle, end * 1.0, 0.0)
        first = mq.Contact("first", "ball", mu=MU, length=3.0, plane=mq.Placement(rpy=(0, tilt, 0)))
        place = mq.Placement(tuple(middle.tolist()), (0, next_angle, 0))
        second = mq.Contact("second", "ball", mu=MU, length=2.0, plane=place)
        mechanism = mq.Mechanism("corner", bodies, joints, switching=(first, second))
        rows = [f"{name}: {row}" for name in ("first", "second") for row in ("normal", "x", "y")]
        found = list_elements(mechanism, rows, mechanism.evaluate)
        expected = [(3,), (0,)] if fall > 0 else [(), ()]
        assert [element.edges for element in found] == expected, fall


def test_a_cord_over_a_drum_sticks_by_the_ratio_of_its_tensions() -> None:
    modes = mq.derive_modes(mq.textbook.load("capstan"))
    assert "sticks if |log(m_1/m_2)| ≤ phi mu" in modes["sticks"].conditions
    assert modes["slips +"].write(Text())[0] == (
        "x'' = g (m_1 - m_2 exp(phi mu))/(m_1 + m_2 exp(phi mu))"
    )


def test_corners_that_slip_alike_are_never_in_different_states() -> None:
    """They were given conditions that exclude each other, as x' > 0 and x' < 0."""
    never = ("never, as left and right slip alike",)
    for mode in mq.derive_modes(mq.textbook.load("rocking_block")).modes:
        both = set(mode.states.values())
        assert (mode.conditions == never) == (len(both) == 2 and "open" not in both)


@pytest.mark.parametrize("degree", [1, 2, 3, 4, 5])
def test_products_of_components_of_a_quaternion_are_sums_of_cosines(degree: int) -> None:
    """4 x w = A_32 − A_23 and its like, of any degree: an odd one leaves a component."""
    free = mq.Spherical("s", "ground", "ball")
    pair = mq.Body("ground"), mq.Body("ball", mq.ball(1.0, 0.1))
    cosines = _Cosines(mq.Mechanism("ball", pair, (free,)))
    letters = [Symbol(name) for name in free.quaternion or ()]
    turn = np.random.default_rng(degree).normal(size=4)
    at = dict(zip(letters, (turn / np.linalg.norm(turn)).tolist(), strict=True))
    values = at | {name: float(formula.subs(at)) for name, formula in cosines.meanings.items()}
    for chosen in combinations_with_replacement(letters, degree):
        written = cosines.write(prod(chosen))
        assert len(written.free_symbols & {*letters}) <= degree % 2
        assert float(written.subs(values)) == pytest.approx(float(prod(chosen).subs(at)), abs=1e-14)


def test_cosines_are_reduced_to_those_of_the_vertical() -> None:
    """By columns of unit length that are perpendicular, and A_33 = A_11 A_22 − A_12 A_21."""
    pair = mq.Body("ground"), mq.Body("ball", mq.ball(1.0, 0.1))
    cosines = _Cosines(mq.Mechanism("ball", pair, (mq.Spherical("s", "ground", "ball"),)))
    A = {f"{i}{k}": Symbol(f"A_s_{i}{k}") for i in (1, 2, 3) for k in (1, 2, 3)}
    for i, k in ((1, 2), (2, 3), (3, 1)):
        column = [A[f"{row}{i}"] for row in (1, 2, 3)]
        other = [A[f"{row}{k}"] for row in (1, 2, 3)]
        assert cosines.reduce(column[0] ** 2 + column[1] ** 2 + column[2] ** 2) == 1
        product = column[0] * other[0] + column[1] * other[1]
        assert (cosines.reduce(product) + column[2] * other[2]).expand() == 0
        across = column[0] * other[1] - column[1] * other[0]
        assert cosines.reduce(across) == A[f"3{6 - i - k}"]

"""Verdicts on mechanisms with elements that switch: every mode, against the engine."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

import mecanique as mq
from mecanique.derivation import switching
from mecanique.derivation.mechanics.switching import Terms
from mecanique.reference.engine.package import engine_name
from mecanique.verification import modes
from mecanique.verification.states import random_states
from mecanique.verification.verdict import Row

m, g, mu, alpha, r = (
    mq.Parameter("m", 1.3, "kg"),
    mq.Parameter("g", 9.81, "m/s²"),
    mq.Parameter("mu", 0.2),
    mq.Parameter("alpha", 0.3, "rad"),
    mq.Parameter("r", 0.1, "m"),
)
INCLINED = (g * mq.sin(alpha), 0, -g * mq.cos(alpha))


def slider(*elements: mq.Friction | mq.Stop) -> mq.Mechanism:
    """Return a block on an incline, with a spring to its origin."""
    return mq.Mechanism(
        "slider",
        (mq.Body("ground"), mq.Body("block", mq.box(m, (0.1, 0.1, 0.1)))),
        (mq.Prismatic("slide", "ground", "block", axis=(1, 0, 0), coordinate="x"),),
        parameters=(m, g, mu, alpha, r),
        gravity=INCLINED,
        forces=(mq.JointSpring("spring", "slide", 100.0),),
        switching=elements,
    )


def flat(shape: mq.Shape, **contact: object) -> mq.Mechanism:
    """Return a body in the plane x, z on an incline."""
    return mq.Mechanism(
        "flat",
        (mq.Body("ground"), mq.Body("body", shape)),
        (mq.Planar("plane", "ground", "body", axis=(0, -1, 0), names=("x", "z", "th")),),
        parameters=(m, g, mu, alpha, r),
        gravity=INCLINED,
        switching=(mq.Contact("floor", "body", **contact),),  # type: ignore[arg-type]
    )


def shaken() -> mq.Mechanism:
    """Return a mass on a base that time moves, with friction in both slides."""
    smooth = mq.textbook.load("base_excited_mass")
    names = [joint.name for joint in smooth.joints]
    dry = tuple(mq.Friction(f"dry in {name}", name, 0.1, 2.0) for name in names)
    return replace(smooth, switching=dry)


def rolling() -> mq.Mechanism:
    """Return a ball with resistance to rolling: a couple of r/10 times the normal force."""
    bodies = (
        *(mq.Body(name, mq.massless()) for name in ("carriage", "lift")),
        mq.Body("body", mq.ball(m, r)),
    )
    joints = (
        mq.Prismatic("along", "ground", "carriage", axis=(1, 0, 0), coordinate="x"),
        mq.Prismatic("up", "carriage", "lift", axis=(0, 0, 1), coordinate="z"),
        mq.Revolute("spin", "lift", "body", axis=(0, -1, 0), coordinate="th"),
    )
    return mq.Mechanism(
        "wheel",
        (mq.Body("ground"), *bodies),
        joints,
        parameters=(m, g, mu, alpha, r),
        gravity=INCLINED,
        switching=(
            mq.Contact("floor", "body", radius=r, mu=mu),
            mq.Friction("rolls", "spin", r / 10, load="floor"),
        ),
    )


SYSTEMS = {
    "block": slider(mq.Friction("dry", "slide", mu, m * g * mq.cos(alpha))),
    "belt": slider(mq.Friction("belt", "slide", mu, m * g, speed=0.4)),
    "stop": slider(mq.Stop("stop", "slide", 1.0)),
    "elastic stop": slider(mq.Stop("stop", "slide", 1.0, stiffness=50.0)),
    "stop and friction": slider(
        mq.Friction("dry", "slide", mu, 3.0), mq.Stop("stop", "slide", 1.0)
    ),
    "ball": flat(mq.ball(m, r), radius=r, mu=mu),
    "rod": flat(mq.rod(m, 2.0), mu=mu),
    "smooth corner": flat(mq.box(m, (0.1, 0.1, 0.4)), center=(0.05, 0.0, 0.2)),
    "shaken": shaken(),
    "capstan": mq.textbook.load("capstan"),
    "rolling resistance": rolling(),
    "latch": slider(mq.Stop("latch", "slide", 1.0, holds=2.0)),
}


@pytest.mark.parametrize("system", SYSTEMS)
def test_every_mode_agrees_with_the_engine(system: str) -> None:
    verdict = mq.verify(SYSTEMS[system], samples=20)
    assert verdict.agrees, str(verdict)
    of_modes = [row for row in verdict.rows if "impact" not in row.sources[0]]
    assert {row.quantity for row in of_modes} == {"acceleration", "forces of elements"}
    left_out = sum("rigid bodies do not determine" in note for note in verdict.notes)
    assert len(of_modes) == 2 * (len(mq.derive_modes(SYSTEMS[system]).modes) - left_out)
    struck = [
        element.name
        for element in SYSTEMS[system].switching
        if "open" in element.states and getattr(element, "stiffness", None) is None
    ]
    assert {row.sources[0] for row in verdict.rows if row not in of_modes} == {
        f"impact of {name}" for name in struck
    }


def table() -> mq.Mechanism:
    """Return a ball in space on a rough floor."""
    bodies = mq.Body("ground"), mq.Body("ball", mq.ball(m, r))
    cloth = mq.Contact("cloth", "ball", radius=r, mu=mu, restitution=0.3)
    joint = mq.Floating("free", "ground", "ball")
    return mq.Mechanism("table", bodies, (joint,), parameters=(m, r, mu), switching=(cloth,))


@pytest.mark.parametrize("most", [0, 16])
def test_slip_along_two_directions_is_compared_in_letters_and_in_numbers(
    most: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(modes, "IN_LETTERS", most)
    verdict = mq.verify(table(), samples=10)
    assert verdict.agrees, str(verdict)
    compared = {"open", "sticks", "slips"} if most else {"3 modes"}
    assert {row.sources[0] for row in verdict.rows} == {*compared, "impact of cloth"}
    assert {row.quantity for row in verdict.rows if "impact" in row.sources[0]} == {
        "acceleration",
        "forces of elements",
        "momentum about contacts",
    }


def test_a_row_of_contact_that_is_wrong_is_seen_in_modes_and_impacts(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    right: Callable[[modes._Bench], Terms] = vars(modes._Bench)["ours"].func

    def tilt(bench: modes._Bench) -> Terms:
        terms = right(bench)
        (cloth,) = bench.elements
        terms.jacobian[:, cloth.normal] *= 1.001
        return terms

    monkeypatch.setattr(modes._Bench, "ours", property(tilt))
    monkeypatch.setattr(modes, "IN_LETTERS", 0)
    verdict = mq.verify(table(), samples=5)
    assert {row.sources[0] for row in verdict.rows if not row.agrees} == {
        "3 modes",
        "impact of cloth",
    }


def test_an_impact_that_changes_momentum_about_the_contact_is_seen(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    right: Callable[[modes._Bench], Terms] = vars(modes._Bench)["ours"].func

    def shift(bench: modes._Bench) -> Terms:
        terms = right(bench)
        (cloth,) = bench.elements
        terms.jacobian[:, cloth.tangents[0], 5] += 0.01
        return terms

    monkeypatch.setattr(modes._Bench, "ours", property(shift))
    verdict = mq.verify(table(), samples=5)
    wrong = {row.quantity for row in verdict.rows if not row.agrees}
    assert "momentum about contacts" in wrong


def test_impacts_on_a_plate_that_moves_by_itself_have_its_speed() -> None:
    """Our gap's rate lacked that of the plate, and the verdict said that both disagree."""
    plate = mq.Prismatic("lift", "ground", "plate", axis=(0, 0, 1), coordinate="s")
    mechanism = mq.Mechanism(
        "shaken",
        (
            mq.Body("ground"),
            mq.Body("plate", mq.box(1.0, (0.1, 0.1, 0.1))),
            mq.Body("p", mq.particle(1.0)),
        ),
        (plate, mq.Prismatic("fall", "ground", "p", axis=(0, 0, 1), coordinate="z")),
        coordinates=mq.Coordinates(("z",), {"s": 0.05 * mq.sin(20 * mq.time())}),
        switching=(mq.Contact("floor", "p", on="plate", restitution=0.5),),
    )
    verdict = mq.verify(mechanism, samples=5)
    assert verdict.agrees, str(verdict)
    assert "impact of floor" in str(verdict)


def test_too_many_modes_are_refused() -> None:
    dry = tuple(mq.Friction(f"f{k}", "slide", mu, 1.0) for k in range(8))
    with pytest.raises(mq.DerivationError, match="has 6561 modes, more than 4096; expected fewer"):
        mq.verify(slider(*dry), samples=1)


def test_a_law_of_friction_that_is_wrong_is_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    right = switching._find_load
    monkeypatch.setattr(switching, "_find_load", lambda element: 1.01 * right(element))
    verdict = mq.verify(SYSTEMS["ball"], samples=5)
    assert not verdict.agrees
    wrong = {row.sources[0] for row in verdict.rows if not row.agrees}
    assert wrong == {"slips +", "slips -"}


def test_a_mode_that_rigid_bodies_do_not_determine_is_told() -> None:
    verdict = mq.verify(SYSTEMS["stop and friction"], samples=5)
    assert "dry sticks, stop closed: not compared, rigid bodies do not determine" in str(verdict)


def test_what_no_verdict_treats_is_refused() -> None:
    block = SYSTEMS["block"]
    with pytest.raises(mq.InputError, match="'dry': its modes are compared with Pinocchio"):
        mq.verify(block, against=block)


def test_rates_of_a_driven_joint_are_those_of_its_formula_on_both_sides() -> None:
    """x = cos θ/2 + sin(2 t)/10, against a belt of 0.4 m/s and before a stop at 1 m."""
    theta, t = mq.Parameter("theta", 0.0), mq.time()
    base = mq.Mechanism(
        "crank",
        (mq.Body("ground"), mq.Body("block", mq.particle(2.0))),
        (mq.Prismatic("slide", "ground", "block", axis=(1, 0, 0), coordinate="x"),),
        coordinates=mq.Coordinates(("theta",), {"x": mq.cos(theta) / 2 + mq.sin(2 * t) / 10}),
    )
    dry, stop = mq.Friction("belt", "slide", 0.2, 3.0, speed=0.4), mq.Stop("stop", "slide", 1.0)
    whole = replace(base, switching=(dry, stop))
    states = random_states(base, 5, 0)
    q, v, t = states.q[:, 0], states.v[:, 0], states.t
    slope, drift = -np.sin(q) / 2, np.cos(2 * t) / 5
    bend = -np.cos(q) / 2 * v**2 - 0.4 * np.sin(2 * t)
    gap = 1 - np.cos(q) / 2 - np.sin(2 * t) / 10
    bench = modes._Bench(whole, states, 1e-9)
    expected = {
        "mass": 2 * slope[:, None, None] ** 2,
        "load": (-2 * slope * bend)[:, None],
        "jacobian": np.stack([slope, -slope], axis=1)[:, :, None],
        "gamma": np.stack([bend, -bend], axis=1),
        "gaps": np.stack([0 * gap, gap], axis=1),
        "drift": np.stack([drift - 0.4, -drift], axis=1),
        "rates": np.stack([slope * v + drift - 0.4, -slope * v - drift], axis=1),
    }
    for terms in (bench.theirs, bench.ours):
        for name, values in expected.items():
            np.testing.assert_allclose(getattr(terms, name), values, rtol=1e-11, atol=1e-14)
    # gap and rate of the normal force, and the slip of the friction
    measured = modes.measure_elements(whole, states)
    columns = [expected["rates"][:, 0], gap, expected["rates"][:, 1]]
    np.testing.assert_allclose(measured, np.stack(columns, axis=1), rtol=1e-11, atol=1e-14)


def test_the_place_along_a_side_is_the_same_on_both_sides_of_the_wall() -> None:
    """Of a wheel on a tilted side of a body that turns; (a² − s²)/(2 a) at s, with a = 0.35."""
    side = mq.Placement((0.1, 0, 0.2), (0, 0.3, 0))
    wheel = mq.Contact("rim", "b", (0, 0, 0.1), 0.05, (0, 1, 0), "a", side, length=0.7)
    bodies = (
        mq.Body("ground"),
        mq.Body("a", mq.box(1.0, (0.3, 0.2, 0.1))),
        mq.Body("b", mq.ball(1.0, 0.1)),
    )
    joints = (
        mq.Revolute("turn", "ground", "a", axis=(0, -1, 0)),
        mq.Planar("plane", "ground", "b", axis=(0, -1, 0), names=("x", "z", "th")),
    )
    pair = mq.Mechanism("pair", bodies, joints, switching=(wheel,))
    states = random_states(replace(pair, switching=()), 7, 0)
    *_, inside = modes.measure_elements(pair, states).T
    turn, x, z, th = states.q.T
    tilt = turn - 0.3
    at = np.array([x - 0.1 * np.sin(th), z + 0.1 * np.cos(th)])
    at -= np.array(
        [0.1 * np.cos(turn) - 0.2 * np.sin(turn), 0.1 * np.sin(turn) + 0.2 * np.cos(turn)]
    )
    foot = at[0] * np.cos(tilt) + at[1] * np.sin(tilt)
    np.testing.assert_allclose(inside, (0.35**2 - foot**2) / 0.7, rtol=0, atol=1e-13)
    code = mq.generate(mq.derive_modes(pair), "python", samples=4)
    assert code.verdict is not None
    assert code.verdict.worst["elements"] < 1e-13


def thrown(e: float) -> mq.Mechanism:
    """A particle in a plane above a rough floor, with another contact far to the side."""
    bodies = mq.Body("ground"), mq.Body("carriage"), mq.Body("body", mq.particle(1.3))
    joints = (
        mq.Prismatic("along", "ground", "carriage", axis=(1, 0, 0), coordinate="x"),
        mq.Prismatic("up", "carriage", "body", axis=(0, 0, 1), coordinate="z"),
    )
    floor = mq.Contact("floor", "body", mu=0.2, restitution=e)
    stop = mq.Stop("stop", "along", 5.0)
    gravity = (3.0, 0, -9.0)
    return mq.Mechanism("thrown", bodies, joints, gravity=gravity, switching=(floor, stop))


@pytest.mark.parametrize("bowl", [2.0, -2.0])
def test_modes_on_a_round_that_are_not_written_out_are_compared_in_numbers(bowl: float) -> None:
    system = flat(mq.ball(m, r), radius=r, mu=mu, bowl=bowl)
    with pytest.raises(mq.DerivationError, match="not written out"):
        mq.derive_modes(system)
    verdict = mq.verify(system, samples=5)
    assert verdict.agrees, str(verdict)
    assert {row.sources[0] for row in verdict.rows} == {"4 modes", "impact of floor"}


@pytest.mark.parametrize(
    ("state", "a", "forces"),
    [
        ("open", (3.0, -9.0), (0.0, 0.0)),
        ("sticks", (0.0, 0.0), (1.3 * 9, -1.3 * 3)),
        ("slips +", (3 - 0.2 * 9, 0.0), (1.3 * 9, -0.2 * 1.3 * 9)),
        ("slips -", (3 + 0.2 * 9, 0.0), (1.3 * 9, 0.2 * 1.3 * 9)),
    ],
)
def test_a_mode_of_a_particle_on_a_rough_floor_has_its_closed_form(
    state: str, a: tuple[float, float], forces: tuple[float, float]
) -> None:
    mechanism = thrown(0.5)
    states = random_states(replace(mechanism, switching=()), 3, 0)
    solution, rounding = modes.solve_mode(mechanism, {"floor": state, "stop": "open"}, states)
    expected = np.tile([*a, *forces, 0.0], (3, 1))
    np.testing.assert_allclose(solution, expected, rtol=0, atol=1e-12)
    # ε times the condition number, which is that of a few ones
    size = np.linalg.norm(expected, axis=1)
    assert (rounding >= 1e-15 * size * (1 - 1e-9)).all()
    assert (rounding < 1e-14 * size).all()


@pytest.mark.parametrize(("state", "rub"), [("slips +", -0.2), ("slips -", 0.2)])
def test_an_impact_on_a_rough_floor_has_its_closed_form(state: str, rub: float) -> None:
    """v_z⁺ = −e v_z with the impulse m (1 + e) |v_z|, a fifth of it along the floor."""
    e, mechanism = 0.5, thrown(0.5)
    states = random_states(replace(mechanism, switching=()), 3, 0)
    solution, _ = modes.solve_mode(mechanism, {"floor": state}, states, struck=True)
    vx, vz = states.v.T
    push = -1.3 * (1 + e) * vz
    expected = np.stack([vx + rub * push / 1.3, -e * vz, push, rub * push], axis=1)
    np.testing.assert_allclose(solution, expected, rtol=0, atol=1e-12)


def test_rounding_of_the_momentum_about_a_contact_grows_with_the_condition_number() -> None:
    mechanism = thrown(0.5)
    bench = modes._Bench(mechanism, random_states(replace(mechanism, switching=()), 3, 0), 1e-9)
    solution, _ = bench.solve({"floor": "slips +"}, bench.ours, struck=True)
    for condition in (1.0, 1e6):
        (row,) = bench._conserve(solution, np.full(3, condition), bench.elements[0])
        assert row.rounding == pytest.approx(modes.EPSILON * condition, rel=1e-12, abs=0)


def test_how_many_modes_rigid_bodies_do_not_determine_is_told() -> None:
    """One of three frictions and a stop holds the one slide: 2³ + 3 · 2² + 2³ of 54 modes."""
    dry = tuple(mq.Friction(f"f{k}", "slide", mu, 1.0) for k in range(3))
    verdict = mq.verify(slider(*dry, mq.Stop("stop", "slide", 1.0)), samples=2)
    assert verdict.agrees, str(verdict)
    assert verdict.notes == ("26 modes not compared, rigid bodies do not determine their forces",)
    assert {row.sources[0] for row in verdict.rows} == {"28 modes", "impact of stop"}


def test_condition_numbers_do_not_depend_on_units() -> None:
    random = np.random.default_rng(0)
    rows, columns = 10 ** random.uniform(-6, 6, (2, 3))
    even = np.array([[1.0, 0.5, 0.0], [0.5, 1.0, 0.2], [0.0, 0.2, 1.0]])
    systems = np.stack([np.diag([1e8, 1.0, 1e-8]), rows[:, None] * np.eye(3) * columns, even])
    expected = [1.0, 1.0, np.linalg.cond(even)]
    np.testing.assert_allclose(modes._condition(systems), expected, rtol=1e-9, atol=0)


def test_the_worst_row_of_a_quantity_uses_up_most_of_what_is_allowed() -> None:
    rows = [
        Row(quantity, ("", ""), worst, (), (), 0.0, rounding=bound)
        for quantity, worst, bound in (
            ("a", 1e-8, 1e-7),
            ("a", 5e-10, 0),
            ("a", 4e-10, 0),
            ("b", 1, 0),
        )
    ]
    found = modes._find_worst(rows, "here")
    assert [(row.quantity, row.worst) for row in found] == [("a", 5e-10), ("b", 1)]
    assert all(row.sources == ("here", engine_name()) for row in found)


def test_the_condition_of_a_system_does_not_depend_on_units() -> None:
    """Rows and columns in other units leave it as it is; that of a rotation is one."""
    random = np.random.default_rng(5)
    turns = np.linalg.qr(random.normal(size=(6, 4, 4)))[0]
    usual = modes._condition(turns)
    assert (usual >= 1.0).all()
    assert (usual < 20.0).all()
    np.testing.assert_allclose(modes._condition(1e9 * turns), usual, rtol=1e-12, atol=0)
    rows, columns = 10.0 ** random.uniform(-6, 6, (2, 6, 4))
    scaled = modes._condition(rows[:, :, None] * turns)
    np.testing.assert_allclose(scaled, usual, rtol=1e-9, atol=0)
    assert (modes._condition(rows[:, :, None] * turns * columns[:, None, :]) < 1e3).all()


def test_a_mode_that_is_too_long_in_letters_is_compared_in_numbers() -> None:
    system = SYSTEMS["stop and friction"]
    bench = modes._Bench(system, random_states(replace(system, switching=()), 5, 0), 1e-9)
    first, *others = mq.derive_modes(system).modes
    rows, notes = bench.compare_letters([replace(first, unsolved=("0",)), *others])
    by_number = bench.compare_numbers([first.states])[0]
    by_letters, remarks = bench.compare_letters(others)
    assert by_number
    assert [str(row) for row in rows] == [str(row) for row in (*by_number, *by_letters)]
    assert notes == remarks

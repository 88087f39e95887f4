"""Entries are judged by the terms that they sum: no false alarm, and light parts are seen."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from verification_injections import with_body

import mecanique as mq
from mecanique.reference import Reference
from mecanique.verification import Verdict
from mecanique.verification.compare import ask, derive_all, derive_quickly, judge
from mecanique.verification.rounding import ENTRY, entry_rounding
from mecanique.verification.rows import evaluate
from mecanique.verification.states import random_states

KINDS = (mq.Spherical, mq.Universal, mq.Floating, mq.Planar)


def wild_tree(seed: int, links: int = 8) -> mq.Mechanism:
    """Return links of all kinds, from 1 mm and 0.1 g to 10 m and 100 kg, far from their joints."""
    rng = np.random.default_rng(seed)
    bodies, joints = [mq.Body("ground")], list[mq.Joint]()
    for k in range(links):
        length, mass = 10 ** rng.uniform(-3, 1), 10 ** rng.uniform(-4, 2)
        x, y, z = (float(c) for c in length * rng.normal(size=3))
        box = mq.box(mass, tuple(length * rng.uniform(0.1, 1, 3))).at((x, y, z))
        parent = bodies[rng.integers(max(0, k - 3), k + 1)].name
        bodies.append(mq.Body(f"b{k}", box))
        place = tuple(10 ** rng.uniform(-2, 1) * rng.normal(size=3))
        origin = mq.Placement(place, tuple(rng.uniform(-3, 3, 3)))
        axis = tuple(rng.normal(size=3))
        name, kind = f"j{k}", rng.integers(6)
        if kind < len(KINDS):
            joints.append(KINDS[kind](name, parent, f"b{k}", origin=origin))
        elif kind == len(KINDS):
            joints.append(mq.Revolute(name, parent, f"b{k}", axis=axis, origin=origin))
        else:
            joints.append(mq.Prismatic(name, parent, f"b{k}", axis=axis, origin=origin))
    return mq.Mechanism(f"tree {seed}", tuple(bodies), tuple(joints))


def verdict_on(ours: mq.Mechanism, engine: mq.Mechanism, tolerance: float | None = None) -> Verdict:
    """Return the verdict on a derivation of one mechanism beside the engine's of another."""
    states = random_states(engine, 5, 0)
    answers = ask(derive_quickly(ours), Reference(engine), engine, states, reactions=False)
    return judge(engine, answers, states, 0, tolerance)


@pytest.mark.parametrize("seed", range(4))
def test_all_forms_agree_within_the_bound_in_trees_of_all_sizes(seed: int) -> None:
    tree = wild_tree(seed)
    states = random_states(tree, 5, seed)
    bound, engine = entry_rounding(tree, states), evaluate(Reference(tree), states)
    assert bound.keys() == {
        "mass matrix", "bias", "gravity", "kinetic energy", "momentum", "angular momentum"
    }  # fmt: skip
    for name, form in derive_all(tree).forms.items():
        ours = evaluate(form, states)
        for quantity in bound.keys() & ours.keys():
            off = np.abs(ours[quantity] - engine[quantity])
            assert (off <= bound[quantity]).all(), (name, quantity)


def arm_with_sensor(mass: float) -> mq.Mechanism:
    """Return two heavy links, with a light sensor fixed to the second."""
    heavy = mq.rod(10.0, 1.0, direction=(1, 0, 0))
    ball = mq.ball(mass, 0.01)
    return mq.Mechanism(
        "arm",
        (mq.Body("ground"), mq.Body("upper", heavy), mq.Body("lower", heavy), mq.Body("eye", ball)),
        (
            mq.Revolute("shoulder", "ground", "upper", axis=(0, -1, 0)),
            mq.Revolute("elbow", "upper", "lower", axis=(0, 0, 1), origin=mq.Placement((1, 0, 0))),
            mq.Fixed("mount", "lower", "eye", origin=mq.Placement((0.5, 0, 0.1))),
        ),
    )


def with_error(mechanism: mq.Mechanism, mass: float) -> mq.Mechanism:
    return with_body(mechanism, "eye", mass, np.zeros(3), 4e-5 * mass * np.eye(3))


def test_a_millionth_of_a_light_sensor_is_found_by_default() -> None:
    mass = 1e-4
    arm = arm_with_sensor(mass)
    assert verdict_on(with_error(arm, mass), arm).agrees
    wrong = with_error(arm, mass * (1 + 1e-6))
    verdict = verdict_on(wrong, arm)
    assert not verdict.agrees
    (row,) = (r for r in verdict.rows if r.quantity == "mass matrix" and r.sources[0] == "jets")
    assert row.entry == ("elbow'", "elbow'")
    assert row.worst == pytest.approx(0.25 * 1e-10 / (10 / 3), rel=0.01, abs=0)
    assert "worst in entry (elbow', elbow')" in str(verdict)
    assert verdict_on(wrong, arm, tolerance=1e-9).agrees


def test_an_axis_next_to_a_coordinate_axis_is_read_as_the_engine_reads_it() -> None:
    # as in models of iCub written by a CAD program: Pinocchio takes it for the x axis
    arm = arm_with_sensor(1.0)
    shoulder = mq.Revolute("shoulder", "ground", "upper", axis=(1.0, 5e-13, 0.0))
    assert mq.verify(replace(arm, joints=(shoulder, *arm.joints[1:])), samples=10).agrees


def test_what_is_below_rounding_is_not_found_and_the_verdict_has_the_bound() -> None:
    mass = 1e-9
    arm = arm_with_sensor(mass)
    verdict = verdict_on(with_error(arm, mass * (1 + 1e-6)), arm)
    assert verdict.agrees
    (row,) = (r for r in verdict.rows if r.quantity == "mass matrix" and r.sources[0] == "jets")
    assert ENTRY <= row.rounding < 10 * ENTRY
    assert row.rounding > 0.25 * 1e-15 / (10 / 3)
    assert row.tolerance == 0.0
    assert "judged entry by entry, each within what rounding may make of its terms" in str(verdict)


def test_far_from_the_origin_the_bound_on_the_turn_grows_only_where_it_must() -> None:
    body = mq.Body("body", mq.box(2.0, (1, 2, 3)))
    joint = mq.Revolute("hinge", "ground", "body", origin=mq.Placement((1e6, 0, 0)))
    far = mq.Mechanism("far", (mq.Body("ground"), body), (joint,))
    near = replace(far, joints=(replace(joint, origin=mq.Placement()),))
    states = random_states(far, 2, 0)
    bounds = [entry_rounding(one, states) for one in (near, far)]
    np.testing.assert_allclose(
        bounds[0]["mass matrix"], bounds[1]["mass matrix"], rtol=1e-14, atol=0
    )
    assert (bounds[1]["angular momentum"] > 1e5 * bounds[0]["angular momentum"]).all()


def test_a_map_is_as_certain_as_what_goes_into_it() -> None:
    q = mq.Parameter("q", 0.0)
    slider = mq.Mechanism(
        "slider",
        (mq.Body("ground"), mq.Body("block", mq.particle(2.0))),
        (mq.Prismatic("x", "ground", "block", axis=(1, 0, 0)),),
        coordinates=mq.Coordinates(("q",), {"x": mq.sin(q)}),
    )
    states = random_states(slider, 3, 0)
    bound, c, s = entry_rounding(slider, states), *np.abs((np.cos(states.q), np.sin(states.q)))
    # M = 2 cos² q, and cos q is uncertain by sin q times the error of q
    expected = ENTRY * 2 * (c + s * np.abs(states.q)) ** 2
    np.testing.assert_allclose(bound["mass matrix"][:, 0], expected, rtol=1e-12, atol=0)
    assert "bias" not in bound


def test_balances_of_a_rolling_stone_are_as_exact_as_the_other_forms() -> None:
    # solved but once, forces and accelerations of different sizes lose them six digits
    verdict = mq.verify(mq.textbook.load("rattleback"), samples=20, seed=2)
    solved = {"acceleration", "reactions", "contact forces"}
    rows = [r for r in verdict.rows if r.sources[0] == "Newton-Euler" and r.quantity in solved]
    assert len(rows) == len(solved)
    assert max(row.worst for row in rows) < 5e-12

"""Newton and Euler, and virtual work: Lagrange's equations, the chapter's reactions."""

from __future__ import annotations

import pickle
import re
import sys
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from itertools import count

import numpy as np
import pytest
from derivation_samples import SAMPLES, sample, states
from systems import FREE, derive_system

import mecanique as mq
from mecanique import textbook
from mecanique.derivation import derive
from mecanique.derivation.numeric.dynamics import Latest
from mecanique.derivation.numeric.newton_euler import Balances
from mecanique.derivation.numeric.recursion import Recursion
from mecanique.derivation.numeric.virtual_work import NumericVirtualWork
from mecanique.derivation.scalars.elementary import cos, sin
from mecanique.derivation.scalars.evaluation import Evaluation
from mecanique.derivation.symbolic.lagrange import Lagrange
from mecanique.derivation.symbolic.newton_euler import NewtonEuler
from mecanique.derivation.symbolic.symbols import Algebra
from mecanique.derivation.symbolic.virtual_work import VirtualWork, distribution_of
from mecanique.errors import DerivationError
from mecanique.model import (
    Body,
    JointForce,
    Loop,
    Mechanism,
    Parameter,
    Placement,
    Prismatic,
    Revolute,
    particle,
    rod,
)
from mecanique.model.states import States
from mecanique.verification.states import random_states

READ = (
    "rigid_bar_pendulum",
    "two_blocks",
    "double_pendulum",
    "cart_pole",
    "gyroscope",
    "rotating_plate",
    "dumbbell",
)
QUANTITIES = (
    "mass_matrix",
    "bias",
    "forces",
    "gravity",
    "acceleration",
    "inverse_dynamics",
    "energy",
    "momentum",
)


@cache
def mechanism_of(name: str) -> Mechanism:
    return sample(name) if name in SAMPLES else textbook.load(name)


def some_states(name: str, n: int = 4) -> States:
    if name in SAMPLES:
        return states(sample(name), n)
    drawn = random_states(mechanism_of(name), n, 0)
    return States.of(mechanism_of(name), drawn.q, drawn.v, drawn.t)


@pytest.mark.parametrize("name", [*SAMPLES, *FREE])
@pytest.mark.parametrize("method", [Balances, NumericVirtualWork])
def test_the_methods_give_the_numbers_of_lagrange(
    name: str, method: Callable[[Mechanism], Balances | NumericVirtualWork]
) -> None:
    mechanism, some = mechanism_of(name), some_states(name)
    ours, lagrange = method(mechanism), Recursion(mechanism)
    a = np.random.default_rng(1).normal(size=some.v.shape)
    scale = max(1.0, float(np.abs(lagrange.mass_matrix(some)).max()))
    for quantity in QUANTITIES:
        more = (a,) if quantity == "inverse_dynamics" else ()
        x, y = getattr(ours, quantity)(some, *more), getattr(lagrange, quantity)(some, *more)
        for one, other in zip(np.atleast_1d(x), np.atleast_1d(y), strict=True):
            assert np.abs(one - other).max() <= 1e-12 * max(scale, np.abs(other).max()), quantity


@pytest.mark.parametrize("name", [*FREE, "planar", "rheonomic", "functions"])
@pytest.mark.parametrize("method", [NewtonEuler, VirtualWork])
def test_the_methods_give_the_series_of_lagrange(
    name: str, method: Callable[[Mechanism, Algebra], NewtonEuler | VirtualWork]
) -> None:
    """Not at some states only: the difference is zero as an element of the ring."""
    mechanism = mechanism_of(name)
    algebra = Algebra(mechanism)
    lagrange, ours = (
        Lagrange(mechanism, algebra).derivation(),
        method(mechanism, algebra).derivation(),
    )
    for x, y in zip(lagrange.rows, ours.rows, strict=True):
        assert (x - y).vanishes()


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("bars_and_springs", ["length of spring_B [m]", "length of spring_F [m]"]),
        ("coupled_pendulums", ["length of the spring [m]"]),
        ("squeezer", ["length of the spring [m]"]),
        ("two_blocks", ["the length of spring1", "the length of spring2"]),
        ("base_excited_mass", ["the length of the spring"]),
        ("kepler_orbit", ["the length of the attraction"]),
    ],
)
@pytest.mark.parametrize("method", ["lagrange", "newton_euler", "virtual_work"])
def test_each_method_names_distances_or_takes_their_signs_for_granted(
    name: str, words: list[str], method: str
) -> None:
    """A damper contains the square of its length alone, whose sign does not matter."""
    told = derive_system(name, method).derivation
    subjects = [assumption.subject for assumption in told.assumptions]
    assert [*told.lengths.values(), *dict.fromkeys(subjects)] == words


def test_reactions_of_the_rod_pendulum_are_the_chapters() -> None:
    """Fundamentals of Dynamics, eqs. 1.14, 1.23, 1.24."""
    equations = derive_system("rigid_bar_pendulum", "newton_euler")
    ring = equations.derivation.algebra.ring
    m, length, g, q, v, a = (ring[name] for name in ("m", "l", "g", "q", "q'", "q''"))
    assert dict(equations.derivation.reactions) == {
        "R_pin_n": m * g * cos(q) + m * length * v**2 / 2,
        "R_pin_t": m * g * sin(q) + m * length * a / 2,
    }
    text = equations.text(steps=True)
    assert not any(name in text for name in ("R_pin_k", "M_pin_n", "M_pin_t"))
    assert "-m l q'^2/2 = m g cos(q) - R_pin_n" in text
    assert "m l^2 q''/3 = -m g l sin(q)/2" in text


@pytest.mark.parametrize(
    "name", ["rigid_bar_pendulum", "double_pendulum", "cart_pole", "rheonomic", "bars_and_springs"]
)
def test_closed_reactions_are_the_numeric_ones(name: str) -> None:
    mechanism, some = mechanism_of(name), some_states(name)
    by_hand = NewtonEuler(mechanism)
    balances = Balances(mechanism)
    a = balances.acceleration(some)
    values = some.values | dict(zip(by_hand.algebra.accelerations, a.T, strict=True))
    numeric = balances.reactions(some)
    evaluated = Evaluation(by_hand.algebra.ring, values)
    for cut in by_hand.cuts.bodies:
        found = by_hand.balances.demands[cut.body]
        for vector, expected in zip(
            (found.force, found.moment), numeric[cut.joint.name], strict=True
        ):
            got = np.stack([np.broadcast_to(evaluated(c), (len(some),)) for c in vector], axis=1)
            np.testing.assert_allclose(
                got, expected, rtol=0, atol=1e-11 * max(1.0, np.abs(expected).max())
            )


def test_a_large_system_gives_the_same_by_elimination(monkeypatch: pytest.MonkeyPatch) -> None:
    mechanism, some = mechanism_of("everything"), some_states("everything")
    whole, reactions = Balances(mechanism).acceleration(some), Balances(mechanism).reactions(some)
    monkeypatch.setattr(sys.modules["mecanique.derivation.numeric.newton_euler"], "_DENSE", 1)
    np.testing.assert_allclose(Balances(mechanism).acceleration(some), whole, rtol=1e-11, atol=0)
    for name, (force, moment) in Balances(mechanism).reactions(some).items():
        np.testing.assert_allclose(force, reactions[name].force, rtol=0, atol=1e-11)
        np.testing.assert_allclose(moment, reactions[name].moment, rtol=0, atol=1e-11)


def test_inertia_forces_of_a_rod_are_triangular_and_act_at_two_thirds() -> None:
    """Fundamentals of Dynamics, eqs. 1.23-1.25."""
    work = VirtualWork(textbook.load("rigid_bar_pendulum"))
    ring = work.algebra.ring
    spread = distribution_of(work.cuts, work.cuts.bodies[0])
    assert spread is not None
    m, length, v, a, s = (ring[name] for name in ("m", "l", "q'", "q''", "s"))
    assert [*spread.density][:2] == [m * s * v**2 / length, -m * s * a / length]
    assert spread.resultant[:2] == (m * length * v**2 / 2, -m * length * a / 2)
    assert spread.point == (None, 2 * length / 3, None)  # along the rod it has no moment


def test_a_rod_that_also_slides_has_no_single_point_for_its_inertia_forces() -> None:
    work = VirtualWork(textbook.load("double_pendulum"))
    upper, lower = (distribution_of(work.cuts, cut) for cut in work.cuts.bodies)
    assert upper is not None
    assert lower is not None
    assert upper.point[0] == 2 * work.algebra.ring["l1"] / 3
    assert lower.point == (None, None, None)


def test_a_disk_has_no_distribution_along_a_line() -> None:
    work = VirtualWork(textbook.load("compound_pendulum"))
    assert distribution_of(work.cuts, work.cuts.bodies[0]) is None


@pytest.mark.parametrize(
    "name", ["double_pendulum", "cart_pole", "rotating_plate", "spherical_pendulum"]
)
def test_reactions_do_no_virtual_work(name: str) -> None:
    equations = derive_system(name, "virtual_work")
    (stage,) = [
        stage for stage in equations.steps if stage.title == "Virtual work of the reactions"
    ]
    assert "The reactions do no work." in stage.explanation
    assert not stage.results


def test_reactions_on_a_body_that_turns_freely_do_no_virtual_work() -> None:
    """Both bodies have their vectors in the axes of the box, which are not the world's."""
    box, arm = mq.box(2.0, (0.3, 0.2, 0.1)), mq.rod(1.0, 0.4, direction=(1, 0, 0))
    free = mq.Mechanism(
        "box with an arm",
        (mq.Body("ground"), mq.Body("box", box), mq.Body("arm", arm)),
        (
            mq.Floating("free", "ground", "box"),
            mq.Revolute(
                "pin", "box", "arm", origin=mq.Placement((0.15, 0.1, 0.05)), axis=(0, 1, 0)
            ),
        ),
    )
    (stage,) = [
        stage
        for stage in derive(free, method="virtual_work").steps
        if stage.title == "Virtual work of the reactions"
    ]
    assert not stage.results


def test_what_guides_coordinates_does_no_work_in_all() -> None:
    work = VirtualWork(replace(textbook.load("bars_and_springs_small"), elements=()))
    (line,) = work.balances.sum_guides()
    ring = work.algebra.ring
    assert line.left == (ring["C_A"] + ring["C_D"]) / (4 * ring["l"])


@pytest.mark.parametrize("method", ["newton_euler", "virtual_work"])
@pytest.mark.parametrize("name", READ)
def test_every_derivation_can_be_read_with_its_symbols_defined(name: str, method: str) -> None:
    equations = derive_system(name, method)
    text = equations.text(steps=True)
    assert "Equations of motion" in text
    assert equations.latex(steps=True).count("{") == equations.latex(steps=True).count("}")
    assert equations.mathml(steps=True).count("<math") > len(equations.steps)
    listed = text.split("Symbols", 1)[1].split("\n\n")[0]
    words = {word.rstrip(",") for word in listed.split()}
    assert words.issuperset(equations.derivation.unknowns.keys() - {"s"})


def test_methods_without_reactions_and_loops_are_refused() -> None:
    pendulum = textbook.load("rigid_bar_pendulum")
    with pytest.raises(DerivationError, match=r"'lagrange' shows no reactions.*newton_euler"):
        derive(pendulum).reactions({"q": 0.1}, None)
    m = Parameter("m", 1.0, "kg")
    looped = Mechanism(
        "looped",
        (Body("ground"), Body("a", rod(m, 1.0))),
        (Revolute("pin", "ground", "a", axis=(0, -1, 0)),),
        loops=(Loop.pin("end", "ground", (0, 0, -1), "a", (0, 0, -1)),),
        parameters=(m,),
    )
    equations = derive(looped, "newton_euler")
    with pytest.raises(DerivationError, match="'looped' has loops"):
        equations.reactions({"pin": 0.0}, None)


def test_a_drive_beside_the_origin_leaves_its_slide_without_a_moment() -> None:
    sledge = Mechanism(
        "sledge",
        (Body("ground"), Body("sledge", particle(2.0))),
        (Prismatic("rail", "ground", "sledge", axis=(1, 0, 0), origin=Placement((0.3, 0.4, 0.5))),),
        forces=(JointForce("drive", "rail", 5.0),),
        gravity=(0, 0, -9.81),
    )
    found = derive(sledge, "newton_euler").reactions({"rail": 0.7}, None)["rail"]
    np.testing.assert_allclose(found.force, [0, 0, 2 * 9.81], rtol=0, atol=1e-12)
    np.testing.assert_allclose(found.moment, 0, rtol=0, atol=1e-12)


def test_reactions_come_for_one_state_and_for_many() -> None:
    equations = derive_system("rigid_bar_pendulum", "newton_euler")
    one = equations.reactions({"q": 0.0}, {"q": 2.0})["pin"]
    np.testing.assert_allclose(one.force, [0, 0, 9.81 + 2.0], rtol=0, atol=1e-13)
    many = equations.reactions(np.array([[0.0], [0.1]]), np.array([[2.0], [0.0]]))["pin"]
    assert many.force.shape == (2, 3)
    np.testing.assert_allclose(many.force[0], one.force, rtol=1e-14, atol=0)


@pytest.mark.parametrize("method", ["lagrange", "newton_euler", "virtual_work"])
def test_what_is_kept_of_the_last_states_does_not_outlive_them(method: str) -> None:
    """A caller may fill the same array anew; the answers are those of its present numbers."""
    mechanism = mq.textbook.load("double_pendulum")
    equations = mq.derive(mechanism, method=method)
    q, v = np.array([[0.1, 0.2]]), np.array([[0.3, -0.4]])
    before = equations.bias(q, v)
    q[:] = [0.7, -0.5]
    after = equations.bias(q, v)
    fresh = mq.derive(mechanism, method=method).bias(q.copy(), v)
    np.testing.assert_allclose(after, fresh, rtol=1e-14, atol=1e-14)
    q[:] = [0.1, 0.2]
    np.testing.assert_allclose(equations.bias(q, v), before, rtol=1e-14, atol=1e-14)
    kinetic, _ = equations.energy(q, v)
    faster, _ = equations.energy(q, 2 * v)
    np.testing.assert_allclose(faster, 4 * kinetic, rtol=1e-13, atol=0)


def test_what_is_kept_of_the_last_states_answers_for_equal_ones_alone() -> None:
    numbers = count(1)
    latest = Latest(lambda _: next(numbers))
    pendulum = mq.textbook.load("double_pendulum")
    some = random_states(pendulum, 3, 0)
    assert [latest.at(some), latest.at(replace(some, q=some.q.copy()))] == [1, 1]
    heavier = replace(pendulum, gravity=(0.0, 0.0, -20.0))
    others = [replace(some, **{name: getattr(some, name) + 0.1}) for name in ("q", "v", "t")]
    for number, other in enumerate([replace(some, mechanism=heavier), *others], 2):
        assert [latest.at(other), latest.at(other)] == [number, number]


def test_what_is_kept_of_the_last_states_is_not_pickled() -> None:
    mechanism = mq.textbook.load("double_pendulum")
    latest = Latest(len)
    assert latest.at(random_states(mechanism, 100, 0)) == 100
    assert len(pickle.dumps(latest)) < 200
    assert pickle.loads(pickle.dumps(latest)).at(random_states(mechanism, 3, 0)) == 3


@pytest.mark.parametrize(
    ("name", "acting"),
    [
        (
            "double_atwood_machine",
            {
                "weight1": "its weight and T_cord",
                "the pulley": "the reaction in the hook, T_cord and T_second",
                "weight2": "its weight and T_second",
                "weight3": "its weight and T_second",
            },
        ),
        (
            "planetary_gear",
            {
                "the sun": "the reaction in the sun axle, the drive, F_inner and N_inner",
                "the arm": (
                    "the reaction in the arm axle and the opposite of the reaction in the planet "
                    "pin"
                ),
                "the ring": "the reaction in the ring axle, the brake, F_outer and N_outer",
                "the planet": (
                    "the reaction in the planet pin, its weight, F_inner, N_inner, F_outer and "
                    "N_outer"
                ),
            },
        ),
    ],
)
def test_each_body_cut_free_names_what_acts_on_it(name: str, acting: dict[str, str]) -> None:
    text = " ".join(derive_system(name, "newton_euler").text(steps=True).split())
    assert dict(re.findall(r"Cut free, ([\w ]+) is acted on by ([^.]*)\.", text)) == acting


@pytest.mark.parametrize("factor", [1e-3, -1.0, 1e3])
@pytest.mark.parametrize("method", ["lagrange", "newton_euler", "virtual_work"])
def test_a_sleigh_is_driven_sideways_whatever_its_constraint_is_multiplied_by(
    method: str, factor: float
) -> None:
    """With n = (sin θ, −cos θ), e ahead and v·n = s t: e·a = 0 and n·a = s − u θ', as e' = −θ' n.

    The second row, the first again, changes nothing.
    """
    theta, s = mq.coordinate("theta"), 0.7
    edges = (
        mq.VelocityConstraint(
            name,
            {"x": scale * mq.sin(theta), "y": -scale * mq.cos(theta)},
            scale * s * mq.time(),
        )
        for name, scale in (("edge", factor), ("again", 3.0))
    )
    sleigh = Mechanism(
        "sleigh",
        (Body("ground"), Body("sleigh", mq.box(2.0, (1, 0.4, 0.1)))),
        (mq.Planar("plane", "ground", "sleigh", names=("x", "y", "theta")),),
        gravity=(0, 0, 0),
        velocity_constraints=tuple(edges),
    )
    turn, ahead, spin, t = 0.4, 0.9, 1.3, 2.0
    e, n = (
        np.array([np.cos(turn), np.sin(turn), 0.0]),
        np.array([np.sin(turn), -np.cos(turn), 0.0]),
    )
    v = ahead * e + s * t * n + [0.0, 0.0, spin]
    found = derive(sleigh, method).acceleration([0.2, -0.3, turn], v, t)
    np.testing.assert_allclose(found, (s - ahead * spin) * n, rtol=0, atol=1e-12)

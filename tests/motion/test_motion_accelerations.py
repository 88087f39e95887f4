from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import mecanique as mq
from mecanique.model.states import States
from mecanique.motion.analysis.audit import momentum_balances
from mecanique.motion.analysis.energies import balance_energy
from mecanique.motion.compile import derive
from mecanique.motion.compile.along import StateLaw
from mecanique.motion.compile.cache import compile_once
from mecanique.motion.compile.program import RatesProgram
from mecanique.motion.record.curve import Curve
from mecanique.motion.record.quadrature import integral
from mecanique.motion.record.rates import Rates
from mecanique.motion.trajectory import at_steps
from mecanique.reference import Reference


def linkage() -> mq.Motion:
    """A motion with more samples than the reference is asked at one by one."""
    system = mq.textbook.entry("four_bar_linkage")
    mechanism = mq.textbook.load("four_bar_linkage")
    q, v = system.start, system.start_velocity
    return mq.simulate(mechanism, q=q, v=v, duration=0.5, samples=500)


def count_answers(monkeypatch: pytest.MonkeyPatch, name: str) -> list[int]:
    """Count the states in which the reference is asked for something."""
    asked: list[int] = []
    answer = getattr(Reference, name)

    def ask(self: Reference, q: np.ndarray, *rest: Any) -> Any:
        asked.append(len(q))
        return answer(self, q, *rest)

    monkeypatch.setattr(Reference, name, ask)
    return asked


def test_programs_answer_as_the_reference(monkeypatch: pytest.MonkeyPatch) -> None:
    """The reference is asked in 24 of 500 states, where it took half a millisecond each."""
    motion = linkage()
    right = motion.reference.acceleration(motion.q, motion.v, motion.t)
    forces = motion.reference.reactions(motion.q, motion.v, motion.t)
    asked = count_answers(monkeypatch, "reactions")
    np.testing.assert_allclose(motion.a, right, rtol=0, atol=1e-11 * np.abs(right).max())
    largest = max(np.abs(wrench.force).max() for wrench in forces.values())
    for name, wrench in forces.items():
        found = motion.reactions(name)
        np.testing.assert_allclose(found.force, wrench.force, rtol=0, atol=1e-11 * largest)
        np.testing.assert_allclose(found.moment, wrench.moment, rtol=0, atol=1e-11 * largest)
        assert (found.undetermined, found.parent) == (wrench.undetermined, wrench.parent)
        turned = found.in_axes("child").force
        same = wrench.in_axes("child").force
        np.testing.assert_allclose(turned, same, rtol=0, atol=1e-11 * largest)
    assert asked == [24]


def test_a_program_that_disagrees_along_the_motion_is_not_asked() -> None:
    motion = linkage()
    code = compile_once(motion.mechanism)
    program = code.along()
    assert isinstance(program, RatesProgram)
    wrong = program.tape.multiply(program.rates[-1], 1.0 + 1e-6)
    code._along[""] = replace(program, rates=(*program.rates[:-1], wrong))
    states = States.of(motion.mechanism, motion.q, motion.v, motion.t)
    np.testing.assert_array_equal(motion.a, motion.reference.quick_accelerations(states))
    assert motion.audit().ok


@pytest.mark.parametrize("name", ["kepler_orbit", "foucault_pendulum", "base_excited_mass"])
def test_energies_and_poses_of_many_samples_are_the_references(name: str) -> None:
    system = mq.textbook.entry(name)
    motion = mq.simulate(
        mq.textbook.load(name),
        q=system.start,
        v=system.start_velocity,
        duration=2.0,
        samples=3000,
    )
    energy, right = motion.energy(), motion.reference.energy(motion.q, motion.v, motion.t)
    for found, part in ((energy.kinetic, right.kinetic), (energy.potential, right.potential)):
        np.testing.assert_allclose(found, part, rtol=0, atol=1e-12 * np.abs(right.total).max())
    poses = motion.reference.poses(motion.q, motion.t)
    np.testing.assert_allclose(motion.poses(), poses, rtol=0, atol=1e-12 * np.abs(poses).max())


def steps(count: int) -> Curve:
    """A motion q = t, v = 1 over 1 s."""
    t = np.linspace(0.0, 1.0, count)
    ones = np.ones((count, 1))
    mechanism = mq.textbook.load("simple_pendulum")
    return Curve(t, t[:, None], ones, 0 * ones, np.array([0]), Rates.of(mechanism))


def test_long_steps_are_halved_until_the_integrand_is_resolved() -> None:
    times = np.linspace(0.0, 1.0, 23)
    asked = []

    def wave(t: np.ndarray, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        asked.append(len(t))
        wave: np.ndarray = np.cos(60 * q)
        return wave

    found = integral(steps(6), wave, times)
    np.testing.assert_allclose(found[:, 0], np.sin(60 * times) / 60, rtol=0, atol=1e-9)
    assert asked[0] < sum(asked) < 2000


def test_rounding_is_not_taken_for_what_is_to_be_resolved() -> None:
    random, asked = np.random.default_rng(1), []

    def noise(t: np.ndarray, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        asked.append(len(t))
        return random.normal(size=(len(t), 1))

    integral(steps(50), noise, np.array([1.0]))
    assert sum(asked) < 4 * asked[0]


def test_what_is_negligible_is_not_resolved() -> None:
    asked = []

    def wave(t: np.ndarray, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        asked.append(len(t))
        return np.hstack([np.ones_like(q), 1e-2 * np.cos(60 * q)])

    integral(steps(6), wave, np.array([1.0]), negligible=np.array([0.0, 0.1]))
    assert len(asked) == 1
    integral(steps(6), wave, np.array([1.0]), negligible=np.array([0.0, 1e-9]))
    assert len(asked) > 2


@pytest.mark.parametrize("known", [True, False])
def test_sums_that_the_reference_does_not_uphold_are_not_used(
    known: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    motion = roll("double_pendulum", 1.0, 2500)
    written = derive.energies_of

    def slip_off(mechanism: mq.Mechanism) -> RatesProgram:
        program = written(mechanism)
        wrong = program.tape.multiply(program.rates[0], 1.0 + 1e-9)
        if not known:
            wrong = program.tape.call("log", program.tape.multiply(wrong, -1.0))
        return replace(program, rates=(wrong, *program.rates[1:]))

    monkeypatch.setattr(derive, "energies_of", slip_off)
    energy = motion.energy()
    found = energy.kinetic, energy.gravity, energy.springs
    np.testing.assert_array_equal(found, motion.reference.energy(motion.q, motion.v, motion.t))


def roll(name: str, duration: float, samples: int) -> mq.Motion:
    """Return a motion of a system of the catalogue from its own start."""
    system, mechanism = mq.textbook.entry(name), mq.textbook.load(name)
    q, v = system.start, system.start_velocity
    return mq.simulate(mechanism, q=q, v=v, duration=duration, samples=samples)


@pytest.mark.parametrize("name", ["kepler_orbit", "four_bar_linkage", "rolling_coin"])
def test_points_and_velocities_of_many_samples_are_the_references(name: str) -> None:
    motion = roll(name, 1.0, 2500)
    body, some = motion.mechanism.bodies[-1].name, slice(None, None, 40)
    t, q, v, a = motion.t[some], motion.q[some], motion.v[some], motion.a[some]
    right = motion.reference.point(body, (0.1, -0.2, 0.3), q, v, a, t)
    for part, expected in zip(motion.point(body, (0.1, -0.2, 0.3)), right, strict=True):
        size = np.abs(expected).max()
        np.testing.assert_allclose(part[some], expected, rtol=0, atol=1e-12 * size)
    twist = motion.reference.velocity(body, q, v, t)
    for part, expected in zip(motion.velocity(body), twist, strict=True):
        np.testing.assert_allclose(part[some], expected, rtol=0, atol=1e-12 * np.abs(v).max())


@pytest.mark.parametrize("name", ["rolling_coin", "chaplygin_sleigh", "whipple_bicycle"])
def test_reactions_of_many_samples_are_the_references_where_it_rolls(name: str) -> None:
    motion = roll(name, 0.5, 500)
    right = motion.reference.reactions(motion.q, motion.v, motion.t)
    largest = max(np.abs(wrench.force).max() for wrench in right.values())
    for joint, wrench in right.items():
        told = motion.reactions(joint)
        np.testing.assert_allclose(told.force, wrench.force, rtol=0, atol=1e-10 * largest)
        np.testing.assert_allclose(told.moment, wrench.moment, rtol=0, atol=1e-10 * largest)


def test_tensions_of_many_samples_are_the_references() -> None:
    motion = roll("swinging_atwood_machine", 0.5, 500)
    right = motion.reference.guide_forces(motion.q, motion.v, motion.t)
    for name, tension in motion.guide_forces().items():
        np.testing.assert_allclose(tension, right[name], rtol=1e-10, atol=0)


def test_forces_that_elements_share_stay_undetermined() -> None:
    motion = roll("two_wheeled_cart", 0.5, 500)
    multipliers = StateLaw(motion.mechanism, motion.reference).multipliers(
        motion.t, motion.q, motion.v
    )
    unknown = {name for name, values in multipliers.items() if np.isnan(values).all()}
    assert unknown == {"left_contact: y", "right_contact: y"}


@pytest.mark.parametrize(
    ("name", "duration", "samples"),
    [("four_bar_linkage", 60.0, 4000), ("rolling_coin", 30.0, 4000), ("kepler_orbit", 600.0, 2)],
)
def test_questions_ask_the_reference_in_a_bounded_number_of_states(
    name: str, duration: float, samples: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """However long a motion is: an audit took six states of each step, a point each sample."""
    motion = roll(name, duration, samples)
    body, joint = motion.mechanism.bodies[-1].name, motion.mechanism.joints[0].name
    asked: list[int] = []
    answer = Reference._answer

    def ask(self: Reference, states: States, *rest: Any, **named: Any) -> Any:
        asked.append(len(states.q))
        return answer(self, states, *rest, **named)

    monkeypatch.setattr(Reference, "_answer", ask)
    questions: dict[str, Callable[[], object]] = {
        "point": lambda: motion.point(body),
        "velocity": lambda: motion.velocity(body),
        "poses": motion.poses,
        "energy": motion.energy,
        "reactions": lambda: motion.reactions(joint),
        "audit": motion.audit,
        "summary": motion.summary,
    }
    most = {}
    for question, ask_it in questions.items():
        asked.clear()
        ask_it()
        most[question] = sum(asked)
    assert most.pop("audit") <= 8000
    assert max(most.values()) <= 1000, most


def test_the_momentum_of_a_long_motion_is_balanced_in_stretches() -> None:
    """Five of 67 steps, and found broken in each if the mechanism is another."""
    motion = roll("double_pendulum", 60.0, 2)
    assert motion.statistics.steps > 2000
    balances = momentum_balances(at_steps(motion))
    assert all(len(balance.t) == 340 for balance in balances)
    assert all((np.linalg.norm(b.residual, axis=1) < 1e-8 * b.size).all() for b in balances)
    heavier = replace(motion, mechanism=mq.textbook.load("double_pendulum", m1=2.0))
    broken = momentum_balances(at_steps(heavier))[0]
    relative = np.linalg.norm(broken.residual, axis=1) / broken.size
    assert (relative.reshape(5, -1).max(axis=1) > 1e-3).all()
    whole = momentum_balances(at_steps(motion), whole=True)[0]
    assert len(whole.t) == len(at_steps(motion).t)
    assert (np.linalg.norm(whole.residual, axis=1) < 1e-8 * whole.size).all()


def test_the_work_on_a_long_motion_is_balanced_in_stretches() -> None:
    """Of a driven pivot; whole if asked, and if nothing but weight and springs does work."""
    motion = roll("kapitza_pendulum", 4.0, 2)
    assert motion.statistics.steps > 1500
    seen = at_steps(motion)
    parts = balance_energy(seen)
    assert [len(energy.t) for energy in parts] == [41] * 5
    (whole,) = balance_energy(seen, whole=True)
    for energy in (*parts, whole):
        assert np.abs(energy.balance).max() < 1e-9 * whole.scale
    assert (parts[0].t[0], parts[-1].t[-1]) == (0.0, 4.0)
    assert "of work since" not in motion.summary()
    assert "in 5 stretches" in motion.summary()
    slower = replace(seen, mechanism=mq.textbook.load("kapitza_pendulum", A=0.019))
    assert all(np.abs(e.balance).max() > 1e-4 * whole.scale for e in balance_energy(slower))
    assert len(balance_energy(at_steps(roll("double_pendulum", 60.0, 2)))) == 1

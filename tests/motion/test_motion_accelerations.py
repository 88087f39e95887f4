from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import mecanique as mq
from mecanique.model.states import States
from mecanique.motion.analysis.momentum import momenta_along
from mecanique.motion.compile.cache import compile_once
from mecanique.motion.compile.program import RatesProgram
from mecanique.motion.record.curve import Curve
from mecanique.motion.record.quadrature import integral
from mecanique.motion.record.rates import Rates
from mecanique.reference import Reference
from mecanique.reference.engine.answers import Energy, Momentum


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
    program = code.accelerations
    assert isinstance(program, RatesProgram)
    wrong = program.tape.multiply(program.rates[-1], 1.0 + 1e-6)
    code.__dict__["accelerations"] = replace(program, rates=(*program.rates[:-1], wrong))
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


@pytest.mark.parametrize("slip", [1e-9, float("nan")])
def test_sums_that_the_reference_does_not_uphold_are_not_used(
    slip: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    system = mq.textbook.entry("double_pendulum")
    motion = mq.simulate(mq.textbook.load("double_pendulum"), q=system.start, duration=1.0)
    state = motion.curve(motion.t)
    reference, states = motion.reference, (state.q, state.v, motion.t)
    energies, momenta = reference.quick_energies(*states), reference.quick_momenta(*states)
    wrong_energies = Energy(*((1.0 + slip) * part for part in energies))
    wrong_momenta = Momentum(*((1.0 + slip) * part for part in momenta))
    monkeypatch.setattr(Reference, "quick_energies", lambda *_: wrong_energies)
    monkeypatch.setattr(Reference, "quick_momenta", lambda *_: wrong_momenta)
    energy = motion.energy()
    found = energy.kinetic, energy.gravity, energy.springs
    np.testing.assert_array_equal(found, reference.energy(*states))
    right = reference.momentum(motion.q, motion.v, motion.t)
    np.testing.assert_array_equal(momenta_along(motion), np.hstack(right))

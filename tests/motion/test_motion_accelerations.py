from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import mecanique as mq
from mecanique.motion.analysis.momentum import AccelerationLaw, momenta_along
from mecanique.motion.compile.cache import compile_once
from mecanique.motion.compile.program import RatesProgram
from mecanique.motion.record.curve import Curve
from mecanique.motion.record.quadrature import integral
from mecanique.motion.record.rates import Rates
from mecanique.reference import Reference
from mecanique.reference.engine.answers import Energy, Momentum


def linkage() -> mq.Motion:
    """A motion that is integrated with equations derived in-house."""
    system = mq.textbook.entry("four_bar_linkage")
    mechanism = mq.textbook.load("four_bar_linkage")
    compile_once(mechanism).program(Reference.of(mechanism))
    return mq.simulate(mechanism, q=system.start, v=system.start_velocity, duration=0.5)


def test_the_program_answers_as_the_reference() -> None:
    motion = linkage()
    t, q, v = motion.t, motion.q, motion.v
    quick = AccelerationLaw(motion.mechanism, motion.reference)
    found, sure = quick._by_program(t, q, v)
    assert sure.all()
    right = motion.reference.acceleration(q, v, t)
    np.testing.assert_allclose(found, right, rtol=0, atol=1e-9 * np.abs(right).max())


def test_a_program_that_disagrees_along_the_motion_is_not_asked() -> None:
    motion = linkage()
    code = compile_once(motion.mechanism)
    program = code.known
    assert isinstance(program, RatesProgram)
    wrong = program.tape.multiply(program.rates[-1], 1.0 + 1e-6)
    code._program = replace(program, rates=(*program.rates[:-1], wrong))
    quick = AccelerationLaw(motion.mechanism, motion.reference)
    assert not quick._by_program(motion.t, motion.q, motion.v)[1].any()
    assert motion.audit().ok


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

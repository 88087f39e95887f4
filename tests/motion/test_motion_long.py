"""Long motions to tight tolerances: the errors of many steps, and rounding of late times."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import mecanique as mq
from mecanique.motion.analysis.extremes import find_bounds, find_maxima
from mecanique.motion.analysis.trust import estimate_errors
from mecanique.motion.compile.heyoka import is_installed
from mecanique.motion.output import report
from mecanique.motion.output.report import say_uncertain
from mecanique.motion.record.curve import Curve
from mecanique.motion.record.rates import Rates

ADDED = "because the errors of so many add up"


def drift(motion: mq.Motion) -> float:
    total = motion.energy().total
    return float(np.abs(total / total[0] - 1).max())


@pytest.mark.parametrize("method", ["dop853", "closed_form"])
def test_a_long_motion_to_a_tight_tolerance_keeps_its_energy(method: str) -> None:
    mechanism = mq.textbook.load("rigid_bar_pendulum")
    motion = mq.simulate(mechanism, q=[2.0], duration=340.0, rtol=1e-12, method=method, fps=5)
    assert ADDED in motion.method
    assert motion.statistics.rtol == 1e-12
    assert drift(motion) < 5e-12  # without it, 3e-11


def test_many_steps_on_loops_add_up_less() -> None:
    """A tenth of the tolerance a step is not enough where there are more than 10,000 of them."""
    linkage, start = (
        mq.textbook.load("four_bar_linkage"),
        mq.textbook.entry("four_bar_linkage").start,
    )

    def swing(duration: float, rtol: float) -> mq.Motion:
        return mq.simulate(linkage, q=start, duration=duration, rtol=rtol, method="compiled", fps=1)

    motion = swing(600.0, 1e-10)
    assert "steps to 3.5e-12, because the errors of so many add up" in motion.method
    energy = motion.energy()
    error = np.abs(energy.total - energy.total[0]).max() / energy.kinetic.max()
    assert error < 5e-10  # without it, 8e-10
    assert ADDED not in swing(100.0, 1e-10).method
    assert ADDED not in swing(300.0, 1e-9).method


@pytest.mark.parametrize(("duration", "rtol"), [(340.0, 1e-10), (20.0, 1e-12)])
def test_shorter_motions_and_looser_tolerances_cost_no_more(duration: float, rtol: float) -> None:
    mechanism = mq.textbook.load("rigid_bar_pendulum")
    motion = mq.simulate(mechanism, q=[2.0], duration=duration, rtol=rtol, method="dop853", fps=5)
    assert ADDED not in motion.method


def test_few_steps_are_refused() -> None:
    mechanism = mq.textbook.load("rigid_bar_pendulum")
    motion = mq.simulate(mechanism, q=[2.0], duration=20.0, rtol=1e-10, method="dop853", samples=2)
    refused = motion.statistics.evaluations / 12 - motion.statistics.steps
    assert refused < 0.12 * motion.statistics.steps  # a quarter without damping of the step control


def test_states_between_late_steps_are_as_accurate_as_the_steps() -> None:
    mechanism = mq.textbook.load("rigid_bar_pendulum")
    motion = mq.simulate(
        mechanism, q=[2.0], t0=1e4, duration=10.0, rtol=1e-13, method="dop853", samples=2
    )
    times = np.linspace(1e4, 1e4 + 10, 2000)[1:]
    total = motion.energy(times).total
    assert np.abs(total / total[0] - 1).max() < 3e-11  # the times themselves are rounded to 2e-12 s


def test_steps_without_length_are_no_intervals() -> None:
    t = np.array([0.0, 0.1, 0.2, 0.3, 0.3, 0.3])
    x = np.ones((6, 1)) * np.arange(6)[:, None]
    curve = Curve(t, x, 0 * x, 0 * x, np.array([0, 4]), Rates(((0,), (0,)), (), ()))
    assert curve.intervals.tolist() == [0, 1, 2]
    assert np.isfinite(curve(np.linspace(0, 0.3, 7)).q).all()
    still = Curve(t[3:], x[3:], 0 * x[3:], 0 * x[3:], np.array([0, 1]), Rates(((0,), (0,)), (), ()))
    assert still(0.3).q.tolist() == [5.0]


def test_what_is_asked_of_a_long_motion_costs_less_than_the_motion(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Its forces without potential were asked of the reference at six places of every step."""
    orbit = mq.textbook.load("kepler_orbit")
    motion = mq.simulate(orbit, q={"r": 1.0}, v={"phi": 2.5}, duration=300.0)
    asked = 0
    forces = mq.Reference.forces

    def count(reference: mq.Reference, q: np.ndarray, v: np.ndarray, t: np.ndarray) -> np.ndarray:
        nonlocal asked
        asked += len(q)
        return np.asarray(forces(reference, q, v, t))

    monkeypatch.setattr(mq.Reference, "forces", count)
    assert "balance within" in motion.summary()
    energy = motion.energy()
    assert abs(energy.balance).max() < 1e-8 * energy.scale
    assert asked < motion.statistics.evaluations / 100


def test_least_and_largest_values_are_of_the_motion_not_of_its_samples() -> None:
    pendulum = mq.textbook.load("rigid_bar_pendulum")
    motion = mq.simulate(pendulum, q={"q": 1.0}, duration=4.0, samples=[0.0, 0.1])
    assert "q [rad]: -1 … 1, at the end" in motion.summary()
    dense = mq.simulate(pendulum, q={"q": 1.0}, duration=4.0, samples=4001)
    assert motion.audit().speed == pytest.approx(dense.audit().speed, rel=1e-9)


def read_end(motion: mq.Motion, name: str) -> tuple[float, float]:
    """Return the value at the end and its error, as a summary states them; no error is NaN."""
    (line,) = [line for line in motion.summary().splitlines() if line.strip().startswith(name)]
    value, _, error = line.partition("at the end ")[2].partition(" ± ")
    return float(value), float(error or "nan")


def test_a_summary_says_that_a_chaotic_motion_is_no_prediction() -> None:
    pendulum = mq.textbook.load("double_pendulum")
    start = {"q1": 2.0, "q2": 2.5}
    motion, other = (
        mq.simulate(pendulum, q=start, duration=60.0, samples=2, rtol=rtol)
        for rtol in (1e-10, 1e-13)
    )
    value, error = read_end(motion, "q1 [rad]")
    assert abs(motion["q1"][-1] - other["q1"][-1]) > 1.0
    assert error > 1.0
    assert value == pytest.approx(motion["q1"][-1], abs=error)
    assert np.isnan(read_end(mq.simulate(pendulum, q=start, duration=1.0), "q1 [rad]")[1])


@pytest.mark.parametrize("name", ["rigid_bar_pendulum", "four_bar_linkage", "cart_pole"])
def test_errors_that_a_summary_states_bound_those_of_the_motion(name: str) -> None:
    mechanism = mq.textbook.load(name)
    start = dict(zip(mechanism.coordinates, [1.0] * mechanism.nq, strict=True))
    motion, finer = (
        mq.simulate(mechanism, q=start, duration=100.0, samples=50, rtol=rtol)
        for rtol in (1e-9, 1e-13)
    )
    actual = np.hstack([motion.q - finer.q, motion.v - finer.v])
    stated = estimate_errors(motion)
    ratio = np.abs(actual).max(axis=0) / stated
    assert (ratio > 0.02).all()
    assert (ratio < 1.0).all()


def test_numbers_are_written_to_the_digits_that_their_errors_leave() -> None:
    written = [say_uncertain(1234.56789, error) for error in (0.0, 0.0123, 70.0, 1e5, np.inf)]
    assert written == [
        "1234.56789",
        "1234.568 ± 0.01",
        "1.23e+03 ± 7e+01",
        "1e+03 ± 1e+05",
        "1234.56789",
    ]


@pytest.mark.parametrize("duration", [2000.0, 1e4])
def test_an_orbit_by_default_is_where_kepler_puts_it(duration: float) -> None:
    """Kepler's equation, e = 0.6; errors of single steps had added up to 0.03 rad in 1e4 s."""
    orbit, e = mq.textbook.load("kepler_orbit"), 0.6
    mu = orbit.values["mu"]
    motion = mq.simulate(
        orbit, q={"r": 1.0}, v={"phi": (mu * (1 + e)) ** 0.5}, duration=duration, samples=2
    )
    assert ADDED in motion.method
    mean = (mu * (1 - e) ** 3) ** 0.5 * duration
    anomaly = mean
    for _ in range(50):
        anomaly -= (anomaly - e * np.sin(anomaly) - mean) / (1 - e * np.cos(anomaly))
    half = np.sqrt((1 + e) / (1 - e)) * np.tan(anomaly / 2)
    turns = np.round((mean - 2 * np.arctan(half)) / (2 * np.pi))
    true = 2 * np.arctan(half) + 2 * np.pi * turns
    assert motion["phi"][-1] == pytest.approx(true, abs=5e-6), "as many digits as are printed"
    printed, error = read_end(motion, "phi [rad]")
    # of two errors of rounding, which decides in 1e4 s, the difference may be the smaller
    assert abs(motion["phi"][-1] - true) < 3 * error < 6e-5
    assert printed == pytest.approx(motion["phi"][-1], abs=error)
    assert len(motion.curve.t) < 3.1 * motion.statistics.steps, "no finer than was asked for"


@pytest.mark.skipif(not is_installed(), reason="heyoka is not installed")
def test_a_summary_of_a_long_series_needs_no_curve_through_all_of_it() -> None:
    """Extremes of Kepler's orbit with e = 0.6 from the samples about them: 1 … 4, μ = 10."""
    orbit = mq.textbook.load("kepler_orbit")
    motion = mq.simulate(
        orbit, q={"r": 1.0}, v={"phi": 4.0}, duration=200.0, fps=120.0, method="taylor"
    )
    bounds = find_bounds(motion)
    assert "curve" not in vars(motion)
    # the errors of its steps add up to 2e-7, those between steps to 5e-8
    known = [4.0, 4.0, 1.5, -1.0, -0.25, 1.5]
    np.testing.assert_allclose(bounds[[1, 2, 3, 5, 6, 7]], known, rtol=0, atol=5e-7)
    motion.summary()
    assert "curve" not in vars(motion)
    whole = find_maxima(motion.curve, lambda t, q, v: np.hstack([q, v, -q, -v])).values
    np.testing.assert_allclose(bounds, whole, rtol=0, atol=1e-7)


def test_a_summary_says_why_errors_are_not_known(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(report, "LONG", 1)
    pendulum = mq.simulate(mq.textbook.load("rigid_bar_pendulum"), q=[2.0], duration=1.0)
    assert "not known" not in pendulum.summary()
    assert " ± " in pendulum.summary()
    pendulum.save(tmp_path / "run.npz")
    unknown = "errors of these values are not known: "
    stored = mq.Motion.load(tmp_path / "run.npz").summary()
    assert unknown + "the motion was read from a file, without the events" in stored
    dry = mq.simulate(mq.textbook.load("stick_slip"), q=[0.1], duration=0.5)
    assert unknown + "motions with corners are integrated once" in dry.summary()
    monkeypatch.setattr(report, "LONG", 1200)
    assert "not known" not in dry.summary()

"""Every maximum that is told of a motion is the motion's, however it was sampled."""

from __future__ import annotations

import numpy as np
import pytest

import mecanique as mq
from mecanique.motion.analysis.extremes import find_bounds, find_exceeded, find_maxima


def told(name: str, duration: float, samples: int) -> dict[str, float]:
    """Return the maxima that are told of a motion with so many samples."""
    mechanism, system = mq.textbook.load(name), mq.textbook.entry(name)
    q, v = system.start, system.start_velocity
    motion = mq.simulate(mechanism, q=q, v=v, duration=duration, samples=samples)
    audit = motion.audit(refine=not mechanism.constrained)
    told = {"speed": audit.speed}
    if audit.trust is not None:
        told |= {"error": audit.trust.error, "until": audit.trust.until}
    told |= {f"friction at {need.contact}": need.coefficient for need in audit.friction}
    for row in audit.rows:
        told |= {row.name: row.residual, f"{row.name}, relative": row.relative}
    told |= {f"bound {k}": bound for k, bound in enumerate(find_bounds(motion))}
    told |= {f"limit of {passed.joint}": passed.value for passed in find_exceeded(motion)}
    if not mechanism.constrained:
        check = mq.inertial_check(mechanism, motion, 0.8)
        told["force"] = check.force
        for changed in check.rows:
            told |= {changed.name: changed.size, f"change of {changed.name}": changed.change}
    return told


@pytest.mark.parametrize(
    ("name", "duration"),
    [
        ("rolling_coin", 1.0),
        ("double_pendulum", 2.0),
        ("four_bar_linkage", 2.0),
        ("kapitza_pendulum", 1.0),
    ],
)
def test_maxima_do_not_depend_on_the_samples(name: str, duration: float) -> None:
    few, many = (told(name, duration, samples) for samples in (3, 1000))
    # gaps of loops are rounding, which no maximum of a curve is
    assert few == pytest.approx(many, rel=1e-6, abs=1e-13, nan_ok=True)


def test_the_peaks_of_several_quantities_are_found_together() -> None:
    """Of q = 0.3 cos(ω t) and its rate, at their own times, in one search of seven rounds."""
    slide = mq.Mechanism(
        "slide",
        (mq.Body("ground"), mq.Body("block", mq.particle(2.0))),
        (mq.Prismatic("guide", "ground", "block", axis=(1, 0, 0), coordinate="x"),),
        forces=(mq.JointSpring("spring", "guide", 18.0),),
    )
    motion = mq.simulate(slide, q={"x": 0.3}, duration=3.0, samples=2)
    asked = []

    def measure(t: np.ndarray, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        asked.append(len(t))
        return np.hstack([q, -q, v])

    most = find_maxima(motion.curve, measure)
    np.testing.assert_allclose(most.values, [0.3, 0.3, 0.9], rtol=1e-9, atol=0)
    np.testing.assert_allclose(most.times[1:], [np.pi / 3, np.pi / 2], rtol=1e-4, atol=0)
    assert len(asked) == 8


def test_a_coin_needs_the_same_friction_however_it_was_sampled() -> None:
    """As its multipliers at 2,001 times have it; three samples tell 1.5 % too little."""
    coin = mq.textbook.load("rolling_coin")
    q, v = {"lean": 0.6, "z": 0.5 * np.cos(0.6)}, {"yaw": 0.5, "spin": -5.0}
    dense, *motions = (
        mq.simulate(coin, q=q, v=v, duration=1.0, samples=samples)
        for samples in (20_001, 3, 10, 100, 1000)
    )
    forces = dense.reference.multipliers(dense.q[::10], dense.v[::10], dense.t[::10])
    normal, along, across = forces.values()
    truth = (np.hypot(along, across) / normal).max()
    needs = [motion.audit().friction[0].coefficient for motion in motions]
    np.testing.assert_allclose(needs, truth, rtol=1e-6, atol=0)
    sampled = np.interp(motions[1].t, dense.t[::10], np.hypot(along, across) / normal).max()
    assert sampled < 0.99 * truth, "its samples would tell too little"


def test_the_energy_balance_of_a_summary_is_of_the_motion() -> None:
    pendulum = mq.textbook.load("double_pendulum")
    few, many = (
        mq.simulate(pendulum, q={"q1": 2.0, "q2": 1.5}, duration=4.0, samples=samples)
        for samples in (3, 1000)
    )
    told = [m.summary().partition("balance within")[2].splitlines()[0] for m in (few, many)]
    assert told[0] == told[1]
    assert 0.0 < float(told[0].split()[0]) < 1e-8

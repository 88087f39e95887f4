from __future__ import annotations

import gc
import pickle
import sys
import weakref
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import mecanique as mq
from mecanique.motion.compile.cache import compile_once
from mecanique.motion.compile.costs import estimate_series
from mecanique.motion.compile.heyoka import is_installed
from mecanique.motion.trajectory import settle

needs_heyoka = pytest.mark.skipif(not is_installed(), reason="heyoka is not installed")
METHODS = ["closed_form", pytest.param("taylor", marks=needs_heyoka)]
STARTS: dict[str, dict[str, float]] = {
    "rigid_bar_pendulum": {"q": 2.0},
    "double_pendulum": {"q1": 0.9, "q2": 1.4},
    "elastic_pendulum": {},
    "heavy_top": {},
    "free_rigid_body": {},
}


def start_of(name: str) -> dict[str, Any]:
    mechanism = mq.textbook.load(name)
    q = STARTS[name] or mq.textbook.entry(name).start
    return {
        "q": {k: x for k, x in q.items() if k in mechanism.coordinates.names},
        "v": {k: x for k, x in q.items() if k in mechanism.velocities},
    }


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("name", sorted(STARTS))
def test_compiled_motions_are_those_of_the_reference(name: str, method: str) -> None:
    mechanism, start = mq.textbook.load(name), start_of(name)
    motion = mq.simulate(mechanism, **start, duration=3.0, rtol=1e-12, method=method)
    expected = mq.simulate(mechanism, **start, duration=3.0, rtol=1e-13, method="dop853")
    assert np.array_equal(motion.t, expected.t)
    np.testing.assert_allclose(motion.q, expected.q, rtol=0, atol=1e-9)
    np.testing.assert_allclose(motion.v, expected.v, rtol=0, atol=1e-9)
    between = np.linspace(0.0, 3.0, 97)
    np.testing.assert_allclose(motion(between).q, expected(between).q, rtol=0, atol=1e-9)
    np.testing.assert_allclose(motion(between).v, expected(between).v, rtol=0, atol=1e-9)
    assert "closed form" in motion.method


@needs_heyoka
@pytest.mark.parametrize("samples", [2, [0.5, 1.25], [0.0, 2.0], [0.25]])
def test_samples_are_where_they_are_asked_for(samples: Any) -> None:
    mechanism = mq.textbook.load("rigid_bar_pendulum")
    motion = mq.simulate(mechanism, q=[1.0], duration=2.0, t0=0.0, samples=samples, method="taylor")
    expected = mq.simulate(mechanism, q=[1.0], duration=2.0, samples=samples, method="dop853")
    assert motion.t.tolist() == expected.t.tolist()
    np.testing.assert_allclose(motion.q, expected.q, rtol=0, atol=1e-9)
    assert motion.curve.t[-1] == 2.0


@needs_heyoka
def test_time_in_the_equations_is_kept() -> None:
    mechanism = mq.textbook.load("kapitza_pendulum")
    options: dict[str, Any] = {"q": [0.3], "t0": 0.7, "duration": 0.5, "samples": 9}
    motion = mq.simulate(mechanism, method="taylor", rtol=1e-12, **options)
    expected = mq.simulate(mechanism, method="dop853", rtol=1e-13, **options)
    np.testing.assert_allclose(motion.q, expected.q, rtol=0, atol=1e-11)


@needs_heyoka
def test_the_energy_of_a_pendulum_keeps_to_machine_precision() -> None:
    mechanism = mq.textbook.load("rigid_bar_pendulum")
    motion = mq.simulate(
        mechanism, q=[2.0], duration=200.0, rtol=1e-12, method="taylor", samples=400
    )
    reference = mq.Reference(mechanism)
    energies = np.array(
        [reference.energy(q, v).total for q, v in zip(motion.q, motion.v, strict=True)]
    )
    assert np.abs(energies / energies[0] - 1).max() < 1e-12


@needs_heyoka
def test_a_compiled_motion_is_kept_like_any_other(tmp_path: Path) -> None:
    mechanism = mq.textbook.load("double_pendulum")
    motion = mq.simulate(mechanism, q={"q1": 0.9, "q2": 1.4}, duration=2.0, method="taylor")
    motion.save(tmp_path / "motion.npz")
    for again in (mq.Motion.load(tmp_path / "motion.npz"), pickle.loads(pickle.dumps(motion))):
        assert np.array_equal(again.q, motion.q)
        t = np.linspace(0.0, 2.0, 31)
        np.testing.assert_allclose(again(t).q, motion(t).q, rtol=0, atol=1e-12)
        np.testing.assert_allclose(again(t).v, motion(t).v, rtol=0, atol=1e-11)
        assert again.curve.series is None
    # between its steps the motion itself is that of the integrator's series, which stay here
    assert motion.curve.series is not None
    assert len(settle(motion).t) > len(motion.curve.t) == motion.statistics.steps + 1
    assert motion.audit().rows


@needs_heyoka
def test_what_stops_a_compiled_motion_is_said_and_what_is_done_is_kept() -> None:
    mechanism = mq.textbook.load("rigid_bar_pendulum")
    with pytest.raises(
        mq.IntegrationError,
        match=r"more than 10 steps at t = .*; raise max_steps.*the error's \.motion",
    ) as info:
        mq.simulate(mechanism, q=[1.0], duration=10.0, method="taylor", max_steps=10)
    motion = info.value.motion
    assert info.value.time is not None
    assert 0.3 < info.value.time < 5.0
    assert motion.t[-1] <= info.value.time
    assert motion.curve.t[-1] == info.value.time

    def stop(fraction: float) -> None:
        raise KeyboardInterrupt

    with pytest.raises(mq.IntegrationError, match="interrupted at t = ") as info:
        mq.simulate(mechanism, q=[1.0], duration=10.0, method="taylor", progress=stop)
    assert isinstance(info.value.__cause__, KeyboardInterrupt)


@needs_heyoka
@pytest.mark.parametrize(
    ("name", "options", "message"),
    [
        ("n_link_pendulum", {}, "expected at most 8 velocities for a closed form, got 9"),
        (
            "rigid_bar_pendulum",
            {"events": [mq.Event("low", mq.coordinate("q"))]},
            r"watches for no events, got 'low'; expected another method: 'closed_form', or 'auto'",
        ),
    ],
)
def test_refusals(name: str, options: dict[str, Any], message: str) -> None:
    mechanism = mq.textbook.load(name, **({"n": 9} if name == "n_link_pendulum" else {}))
    with pytest.raises(mq.MecaniqueError, match=message):
        mq.simulate(mechanism, method="taylor", **options)


def test_without_heyoka_the_method_says_how_to_get_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("mecanique.motion.compile.heyoka.is_installed", lambda: False)
    with pytest.raises(
        mq.InputError,
        match=r"needs heyoka, which is not installed: pip install 'mecanique\[fast\]'",
    ):
        mq.simulate(mq.textbook.load("rigid_bar_pendulum"), method="taylor")


CHAOTIC: dict[str, Any] = {"q": {"q1": 2.0, "q2": 2.4}, "duration": 20.0}


def test_auto_gives_the_same_numbers_whatever_ran_before() -> None:
    mechanism = mq.textbook.load("double_pendulum")
    first = mq.simulate(mechanism, **CHAOTIC)
    for method in ("closed_form", *(["taylor"] if is_installed() else [])):
        mq.simulate(mechanism, q=CHAOTIC["q"], duration=60.0, method=method)
    for again in (mechanism, mechanism.replace()):
        then = mq.simulate(again, **CHAOTIC)
        assert then.method == first.method
        assert np.array_equal(then.q, first.q)


@needs_heyoka
def test_series_chosen_by_auto_give_the_same_numbers_too(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("mecanique.motion.simulation.choice.PAYOFF", 0.0)
    monkeypatch.setattr("mecanique.motion.simulation.choice.STEPS", 20)
    monkeypatch.setattr("mecanique.motion.compile.cache.OPTIMIZED", 300)
    mechanism = mq.textbook.load("double_pendulum")
    first = mq.simulate(mechanism, **CHAOTIC)
    assert first.method.startswith("taylor")
    for _ in range(3):
        mq.simulate(mechanism, **CHAOTIC, method="taylor")
    assert compile_once(mechanism).is_optimized(1e-10)
    then = mq.simulate(mechanism, **CHAOTIC)
    assert then.method == first.method
    assert np.array_equal(then.q, first.q)
    assert np.array_equal(then(7.77).q, first(7.77).q)


def test_auto_compiles_when_it_pays(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("mecanique.motion.simulation.choice.is_installed", lambda: False)
    monkeypatch.setattr("mecanique.motion.simulation.choice.PAYOFF", 0.0)
    monkeypatch.setattr("mecanique.motion.simulation.choice.STEPS", 20)
    mechanism = mq.textbook.load("double_pendulum")
    motion = mq.simulate(mechanism, q={"q1": 0.9}, duration=5.0)
    assert "on the closed form" in motion.method
    expected = mq.simulate(mechanism, q={"q1": 0.9}, duration=5.0, method="dop853")
    np.testing.assert_allclose(motion.q, expected.q, rtol=0, atol=1e-10)


@needs_heyoka
def test_auto_takes_taylor_series_for_a_long_motion(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("mecanique.motion.simulation.choice.PAYOFF", 0.0)
    monkeypatch.setattr("mecanique.motion.simulation.choice.STEPS", 20)
    mechanism = mq.textbook.load("rigid_bar_pendulum")
    motion = mq.simulate(mechanism, q=[1.0], duration=5.0)
    assert motion.method.startswith("taylor")
    assert "long enough to pay for compiling" in motion.method


def test_auto_stays_with_the_reference_where_there_is_no_closed_form(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("mecanique.motion.simulation.choice.PAYOFF", 0.0)
    monkeypatch.setattr("mecanique.motion.simulation.choice.STEPS", 20)
    mechanism = mq.textbook.load("n_link_pendulum", n=9)
    motion = mq.simulate(mechanism, q=np.full(9, 0.1), duration=2.0)
    assert "closed form" not in motion.method
    assert not compile_once(mechanism).possible


def test_what_is_compiled_goes_with_its_mechanism() -> None:
    mechanism = mq.textbook.load("rigid_bar_pendulum")
    assert compile_once(mechanism) is compile_once(mechanism)
    assert compile_once(mechanism) is not compile_once(mechanism.replace(l=3.0))
    reference = mq.Reference(mechanism)
    rhs, y = compile_once(mechanism).rhs(reference), np.array([0.3, 0.1])
    np.testing.assert_allclose(rhs(0.0, y), reference.rhs()(0.0, y), rtol=1e-14, atol=0)
    assert mq.simulate(mechanism, q=[0.3], duration=0.1, method="closed_form").t[-1] == 0.1
    alive = weakref.ref(mechanism)
    del mechanism, reference, rhs
    gc.collect()
    assert alive() is None


def test_the_estimate_of_building_does_not_depend_on_what_ran_before(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setitem(sys.modules, "heyoka", sys)
    imported = estimate_series(100)
    monkeypatch.delitem(sys.modules, "heyoka")
    assert estimate_series(100) == imported
    assert estimate_series(1000) > estimate_series(100)


@needs_heyoka
def test_a_state_that_is_not_finite_ends_a_compiled_motion() -> None:
    x = mq.coordinate("x")
    mechanism = mq.Mechanism(
        "falling into the sun",
        (mq.Body("ground"), mq.Body("stone", mq.particle(1.0))),
        (mq.Prismatic("ray", "ground", "stone", axis=(1, 0, 0), coordinate="x"),),
        forces=(mq.JointForce("pull", "ray", -1 / x**2),),
    )
    with pytest.raises(mq.IntegrationError, match=r"step size collapsed at t = 1\.1") as info:
        mq.simulate(mechanism, q=[1.0], duration=5.0, method="taylor")
    assert info.value.time == pytest.approx(np.pi / np.sqrt(8), abs=1e-6)  # free fall to the center
    assert np.isfinite(info.value.motion.q).all()


def driven(signal: Any) -> mq.Mechanism:
    return mq.Mechanism(
        "driven",
        (mq.Body("ground"), mq.Body("block", mq.particle(1.0))),
        (mq.Prismatic("rail", "ground", "block", axis=(1, 0, 0), coordinate="x"),),
        forces=(mq.JointForce("drive", "rail", mq.coordinate("F")),),
        inputs=(mq.Input("F", signal),),
    )


@needs_heyoka
@pytest.mark.parametrize(
    "signal", [np.cos, mq.Record(np.array([0.0, 1.0, 2.0]), np.array([0.0, 1.0, 0.0]))]
)
def test_an_input_that_is_no_formula_is_refused_and_avoided(
    signal: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    mechanism = driven(signal)
    with pytest.raises(
        mq.DerivationError,
        match="input F is a function or a record; write it as an expression in t",
    ):
        mq.simulate(mechanism, duration=2.0, method="taylor")
    monkeypatch.setattr("mecanique.motion.simulation.choice.PAYOFF", 0.0)
    monkeypatch.setattr("mecanique.motion.simulation.choice.STEPS", 3)
    motion = mq.simulate(mechanism, duration=2.0)
    assert motion.method.startswith("dop853")
    exact = 1 - np.cos(2.0) if signal is np.cos else 1.0
    assert motion["x"][-1] == pytest.approx(exact, abs=1e-8)


@needs_heyoka
def test_auto_leaves_events_to_what_watches_for_them() -> None:
    mechanism = mq.textbook.load("rigid_bar_pendulum")
    mq.simulate(mechanism, q=[1.0], duration=0.1, method="taylor")
    motion = mq.simulate(
        mechanism, q=[1.0], duration=3.0, events=[mq.Event("low", mq.coordinate("q"))]
    )
    assert not motion.method.startswith("taylor")
    assert len(motion.events) == 3


@needs_heyoka
def test_code_is_optimized_when_that_pays(monkeypatch: pytest.MonkeyPatch) -> None:
    mechanism = mq.textbook.load("double_pendulum")
    code = compile_once(mechanism)
    first = mq.simulate(mechanism, q={"q1": 0.9}, duration=5.0, method="taylor")
    assert not code.is_optimized(1e-10)
    monkeypatch.setattr("mecanique.motion.compile.cache.OPTIMIZED", first.statistics.steps)
    then = mq.simulate(mechanism, q={"q1": 0.9}, duration=5.0, method="taylor")
    assert code.is_optimized(1e-10)
    assert not code.is_optimized(1e-8)
    np.testing.assert_allclose(then.q, first.q, rtol=0, atol=1e-11)


@needs_heyoka
def test_code_is_optimized_within_a_long_motion(monkeypatch: pytest.MonkeyPatch) -> None:
    mechanism = mq.textbook.load("rigid_bar_pendulum")
    expected = mq.simulate(mechanism, q=[1.0], duration=10.0, method="taylor")
    again = mechanism.replace()
    monkeypatch.setattr("mecanique.motion.compile.cache.OPTIMIZED", 40)
    monkeypatch.setattr("mecanique.motion.simulation.integrators.taylor.AT_ONCE", 30)
    motion = mq.simulate(again, q=[1.0], duration=10.0, method="taylor")
    assert compile_once(again).is_optimized(1e-10)
    assert motion.statistics.steps == pytest.approx(
        expected.statistics.steps, abs=15
    )  # some are cut by looking on
    np.testing.assert_allclose(motion.q, expected.q, rtol=0, atol=1e-10)
    np.testing.assert_allclose(motion(7.77).q, expected(7.77).q, rtol=0, atol=1e-12)

from __future__ import annotations

import os
import pickle
import signal
from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.linalg import eigh, expm
from scipy.special import ellipj, ellipk

import mecanique as mq
from mecanique.motion.compile.heyoka import is_installed
from mecanique.motion.simulation.integrators.methods import METHODS

G = 9.81


def pendulum_solution(
    t: np.ndarray, start: float = 2.0, length: float = 1.0
) -> tuple[np.ndarray, np.ndarray]:
    """Angle and rate of the rod pendulum released at rest: q = 2 asin(k sn(K − ω t, k))."""
    omega, k = np.sqrt(3 * G / (2 * length)), np.sin(start / 2)
    sn, cn, _, _ = ellipj(ellipk(k**2) - omega * t, k**2)
    return 2 * np.arcsin(k * sn), -2 * k * omega * cn


def blocks_solution(mechanism: mq.Mechanism, start: np.ndarray, t: np.ndarray) -> np.ndarray:
    """The two blocks under F0 cos(W t), released at rest, by their modes."""
    p = mechanism.values
    M = np.diag([p["m1"], p["m2"]])
    K = np.array([[p["k1"] + p["k2"], -p["k2"]], [-p["k2"], p["k2"]]])
    forced = np.linalg.solve(K - p["W"] ** 2 * M, [0.0, p["F0"]])
    squares, modes = eigh(K, M)
    amplitudes = modes.T @ M @ (start - forced)
    free = (modes * amplitudes) @ np.cos(np.sqrt(squares)[:, None] * t)
    return np.asarray((forced[:, None] * np.cos(p["W"] * t) + free).T)


def sliding(
    *forces: mq.AnyForce,
    inputs: tuple[mq.Input, ...] = (),
    parameters: tuple[mq.Parameter, ...] = (),
) -> mq.Mechanism:
    """A particle of 1 kg on a line."""
    return mq.Mechanism(
        "slider",
        (mq.Body("ground"), mq.Body("block", mq.particle(1.0))),
        (mq.Prismatic("slide", "ground", "block", axis=(1, 0, 0), coordinate="x"),),
        forces=forces,
        inputs=inputs,
        parameters=parameters,
    )


@pytest.fixture(scope="module")
def swing() -> mq.Motion:
    return mq.simulate(mq.textbook.load("rigid_bar_pendulum"), q={"q": 2.0}, duration=10.0)


def test_pendulum_follows_the_elliptic_functions(swing: mq.Motion) -> None:
    q, v = pendulum_solution(swing.t)
    np.testing.assert_allclose(swing["q"], q, rtol=0, atol=2e-9)
    np.testing.assert_allclose(swing["q'"], v, rtol=0, atol=8e-9)
    np.testing.assert_allclose(swing["q''"], -1.5 * G * np.sin(q), rtol=0, atol=3e-8)


@pytest.mark.parametrize("rtol", [1e-4, 1e-6, 1e-8, 1e-10, 1e-12])
def test_the_error_follows_the_tolerance_also_between_the_samples(rtol: float) -> None:
    motion = mq.simulate(
        mq.textbook.load("rigid_bar_pendulum"), q=[2.0], duration=3.0, rtol=rtol, fps=5
    )
    t = np.linspace(0, 3, 1777)
    state = motion(t)
    q, v = pendulum_solution(t)
    at_steps = np.abs(motion.curve.v[:, 0] - pendulum_solution(motion.curve.t)[1]).max()
    assert np.abs(state.q[:, 0] - q).max() < 40 * rtol
    assert np.abs(state.v[:, 0] - v).max() < max(3 * at_steps, 40 * rtol)


def test_two_blocks_under_a_harmonic_force_are_the_closed_form() -> None:
    mechanism = mq.textbook.load("two_blocks")
    motion = mq.simulate(mechanism, q=[0.2, -0.1], duration=10.0)
    np.testing.assert_allclose(
        motion.q, blocks_solution(mechanism, np.array([0.2, -0.1]), motion.t), rtol=0, atol=5e-10
    )


@pytest.mark.parametrize("method", [*METHODS, "auto"])
def test_every_method_gives_the_same_motion(method: str) -> None:
    mechanism = mq.textbook.load("cart_pole")
    exact = mq.simulate(mechanism, q={"q": 1.0}, v={"x": 0.3}, duration=1.0, rtol=1e-12)
    motion = mq.simulate(
        mechanism, q={"q": 1.0}, v={"x": 0.3}, duration=1.0, rtol=1e-7, method=method
    )
    np.testing.assert_allclose(motion.q, exact.q, rtol=0, atol=1e-4)
    np.testing.assert_allclose(motion.v, exact.v, rtol=0, atol=3e-4)
    assert (method if method != "auto" else "dop853") in motion.method


def test_stiff_equations_are_found_and_said() -> None:
    mechanism = sliding(
        mq.JointSpring("spring", "slide", 1.0), mq.JointDamper("damper", "slide", 1e5)
    )
    motion = mq.simulate(mechanism, q=[1.0], duration=10.0, rtol=1e-8)
    assert "radau" in motion.method
    assert "stiff" in motion.method
    slow = -1 / (5e4 + np.sqrt(2.5e9 - 1))
    np.testing.assert_allclose(motion["x"][1:], np.exp(slow * motion.t[1:]), rtol=0, atol=1e-8)
    assert motion.audit().ok
    with pytest.raises(mq.IntegrationError, match="too stiff for dop853"):
        mq.simulate(mechanism, q=[1.0], duration=10.0, rtol=1e-8, method="dop853")


def test_the_samples_end_at_the_end(swing: mq.Motion) -> None:
    assert len(swing) == 601
    assert swing.t[-1] == 10.0
    odd = mq.simulate(swing.mechanism, q=[0.1], duration=0.99, fps=50, t0=3.0)
    assert odd.t[0] == 3.0
    assert odd.t[-1] == 3.99
    np.testing.assert_allclose(np.diff(odd.t)[:-1], 0.02, rtol=1e-12, atol=0)
    assert np.diff(odd.t)[-1] <= 0.02 + 1e-12
    assert (
        mq.simulate(swing.mechanism, duration=1.0, samples=7).t.tolist()
        == np.linspace(0, 1, 7).tolist()
    )
    assert mq.simulate(swing.mechanism, duration=1.0, samples=[0.25, 0.5]).t.tolist() == [0.25, 0.5]


def test_time_enters_the_equations_from_t0() -> None:
    force = mq.Force("push", "block", (0, 0, 0), (2 * mq.time(), 0, 0))
    motion = mq.simulate(sliding(force), duration=2.0, t0=1.0)
    np.testing.assert_allclose(motion["x'"], motion.t**2 - 1, rtol=0, atol=1e-12)


def test_quaternions_keep_their_length_and_the_torque_free_top_its_momentum() -> None:
    mechanism = mq.textbook.load("free_rigid_body")
    v = {name: 1.0 + 0.7 * k for k, name in enumerate(mechanism.velocities)}
    motion = mq.simulate(mechanism, v=v, duration=20.0, rtol=1e-9)
    quaternion = motion.q[:, 3:]
    np.testing.assert_allclose(np.linalg.norm(quaternion, axis=1), 1.0, rtol=0, atol=1e-14)
    momentum = motion.reference.momentum(motion.q, motion.v, motion.t).angular_about_center
    np.testing.assert_allclose(
        momentum, np.broadcast_to(momentum[0], momentum.shape), rtol=2e-7, atol=0
    )
    # between the steps q̇ and v belong together
    t = np.linspace(0.001, 19.99, 333)
    state, h = motion(t), 1e-5
    rate = (motion(t + h).q - motion(t - h).q) / (2 * h)
    np.testing.assert_allclose(rate, motion.reference.rates(state.q, state.v), rtol=0, atol=1e-6)


def test_a_sampled_input_is_followed_kink_by_kink() -> None:
    times, values = [0.0, 1.0, 2.0, 3.0], [0.0, 1.0, -1.0, 0.0]
    F = mq.Input("F", mq.Record(np.array(times), np.array(values)), "N")
    motion = mq.simulate(
        sliding(mq.Force("push", "block", (0, 0, 0), (F, 0, 0)), inputs=(F,)), duration=4.0, fps=100
    )
    force = np.interp(motion.t, times, values)
    impulse = np.concatenate([[0], np.cumsum((force[1:] + force[:-1]) / 2 * np.diff(motion.t))])
    np.testing.assert_allclose(motion["x'"], impulse, rtol=0, atol=1e-13)
    assert {1.0, 2.0, 3.0} <= set(motion.curve.t[motion.curve.breaks].tolist())


def test_a_short_pulse_of_an_input_function_is_not_stepped_over() -> None:
    F = mq.Input("F", lambda t: 1.0 if 7.0 < t < 7.5 else 0.0, "N")
    motion = mq.simulate(
        sliding(mq.Force("push", "block", (0, 0, 0), (F, 0, 0)), inputs=(F,)),
        duration=10.0,
        rtol=1e-8,
    )
    assert motion["x'"][-1] == pytest.approx(0.5, abs=1e-6)


def test_progress_is_reported() -> None:
    reported: list[float] = []
    mq.simulate(
        mq.textbook.load("rigid_bar_pendulum"), q=[2.0], duration=10.0, progress=reported.append
    )
    assert reported == sorted(reported)
    assert reported[-1] == 1.0
    assert 50 < len(reported) < 120


@pytest.mark.parametrize("method", ["dop853", *(["taylor"] if is_installed() else [])])
@pytest.mark.parametrize("when", [0.5, 1.0])
def test_what_progress_raises_loses_nothing(method: str, when: float) -> None:
    def stop(fraction: float) -> None:
        if fraction >= when:
            raise RuntimeError("enough")

    with pytest.raises(mq.IntegrationError, match=r"enough.*in the error's \.motion") as caught:
        mq.simulate(
            mq.textbook.load("rigid_bar_pendulum"),
            q=[2.0],
            duration=10.0,
            method=method,
            progress=stop,
        )
    assert isinstance(caught.value.__cause__, RuntimeError)
    motion = caught.value.motion
    assert motion is not None
    # a Taylor series of ten seconds is reported of at its end only
    assert motion.t[-1] == 10.0 if when == 1.0 or method == "taylor" else 5.0 < motion.t[-1] < 6.0


@pytest.fixture
def interruptible() -> Iterator[None]:
    """Let Ctrl-C work here, also where the tests run in the background."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def test_interrupting_keeps_what_is_done(interruptible: None) -> None:
    def press(fraction: float) -> None:
        if 0.5 < fraction < 1:
            os.kill(os.getpid(), signal.SIGINT)

    before = signal.getsignal(signal.SIGINT)
    with pytest.raises(
        mq.IntegrationError, match=r"interrupted at t = 5\.\d+ s, q = .*\.motion"
    ) as caught:
        mq.simulate(mq.textbook.load("rigid_bar_pendulum"), q=[2.0], duration=10.0, progress=press)
    assert signal.getsignal(signal.SIGINT) is before
    motion = caught.value.motion
    assert 5 < motion.t[-1] < 6
    assert motion.t[-1] == caught.value.time
    np.testing.assert_allclose(motion["q"], pendulum_solution(motion.t)[0], rtol=0, atol=2e-9)


def test_an_interrupt_raised_by_a_callback_does_not_break_the_integrator() -> None:
    def press(fraction: float) -> None:
        if fraction > 0.5:
            raise KeyboardInterrupt

    with pytest.raises(mq.IntegrationError, match="interrupted") as caught:
        mq.simulate(mq.textbook.load("rigid_bar_pendulum"), q=[2.0], duration=10.0, progress=press)
    assert caught.value.motion.t[-1] > 5


@pytest.mark.parametrize("method", ["dop853", "lsoda", "radau", "bdf"])
def test_what_progress_raises_keeps_the_motion_until_then(method: str) -> None:
    def stop(done: float) -> None:
        if done > 0.5:
            raise ValueError("enough")

    mechanism = mq.textbook.load("rigid_bar_pendulum")
    with pytest.raises(mq.IntegrationError, match="progress raised ValueError") as caught:
        mq.simulate(mechanism, q=[1.0], duration=2.0, rtol=1e-6, method=method, progress=stop)
    assert caught.value.motion is not None
    assert caught.value.motion.t[-1] == caught.value.time
    assert caught.value.motion.t[-1] > 1.0
    assert isinstance(caught.value.__cause__, ValueError)


@pytest.mark.parametrize("method", [*METHODS, "auto"])
def test_what_an_input_raises_is_reported_with_time_and_state(method: str) -> None:
    def signal_(t: float) -> float:
        return 1.0 if t < 2 else 1 / 0

    F = mq.Input("F", signal_, "N")
    mechanism = sliding(mq.Force("push", "block", (0, 0, 0), (F, 0, 0)), inputs=(F,))
    with pytest.raises(
        mq.IntegrationError, match=r"failed at t = .* s, x = .*division by zero"
    ) as caught:
        mq.simulate(mechanism, duration=4.0, method=method, rtol=1e-6)
    assert isinstance(caught.value.__cause__, ZeroDivisionError)
    assert caught.value.motion.t[-1] == pytest.approx(2.0, abs=0.2)
    assert caught.value.state.shape == (2,)


def test_a_start_that_fails_is_reported_at_its_time() -> None:
    mechanism = mq.textbook.load("cart_pole")
    force = replace(mechanism.inputs[0], signal=lambda t: 1.0 / (t - 3.0))
    with pytest.raises(mq.IntegrationError, match="failed: float division") as caught:
        mq.simulate(replace(mechanism, inputs=(force,)), t0=3.0, duration=1.0)
    assert caught.value.time == 3.0
    assert caught.value.motion is None


def test_a_collapsing_step_is_reported() -> None:
    x = mq.coordinate("x")
    mechanism = sliding(mq.Force("pull", "block", (0, 0, 0), (-1 / x**3, 0, 0)))
    with pytest.raises(
        mq.IntegrationError, match=r"step size collapsed at t = (0\.9\d*|1) s, x = "
    ) as caught:
        mq.simulate(mechanism, q=[1.0], duration=5.0)
    # x² = 1 − t² reaches zero at t = 1
    assert caught.value.time == pytest.approx(1.0, abs=1e-3)
    with pytest.raises(mq.MecaniqueError, match=r"finite|singular|zero"):
        mq.simulate(mechanism, q=[0.0], duration=5.0)


def test_too_many_steps_are_reported() -> None:
    with pytest.raises(
        mq.IntegrationError, match=r"more than 20 steps at t = .*max_steps"
    ) as caught:
        mq.simulate(mq.textbook.load("rigid_bar_pendulum"), q=[2.0], max_steps=20)
    assert len(caught.value.motion.curve.t) > 15


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"duration": 0.0}, "expected a positive duration"),
        ({"duration": -1.0}, "expected a positive duration"),
        ({"duration": float("nan")}, "expected a finite number for the duration"),
        ({"duration": "long"}, "expected a finite number for the duration, got 'long'"),
        ({"rtol": 0.0}, "rtol in 1e-14…0.1, got 0"),
        ({"rtol": 1.0}, "rtol in 1e-14…0.1, got 1"),
        ({"atol": 0.0}, "positive absolute tolerance"),
        ({"fps": 0}, "positive number of samples per second"),
        ({"fps": 1e9}, "fewer than 100,000,000 samples"),
        ({"samples": 1}, "at least 2 samples"),
        ({"samples": "many"}, "a number of samples or their times, got 'many'"),
        ({"samples": [1.0, 0.5]}, "increasing finite sample times"),
        ({"samples": [1.0, 11.0]}, "sample times in 0…10 s"),
        ({"max_step": 0.0}, "positive longest step"),
        ({"max_steps": 0}, "at least 1 for max_steps"),
        ({"q": {"theta": 1.0}}, "unknown coordinate 'theta'; known: q"),
        ({"q": [1.0, 2.0]}, r"expected shape \(1,\) for the coordinate values"),
        ({"v": [float("inf")]}, "expected finite velocity values"),
        ({"method": "dop54"}, "unknown method 'dop54'; did you mean 'dop853'"),
        ({"events": ["q"]}, "expected events of type Event, got 'q'"),
        ({"t0": 1e20}, "not lost beside the start time"),
    ],
)
def test_bad_arguments_are_refused_by_name(arguments: dict[str, object], message: str) -> None:
    with pytest.raises(mq.InputError, match=message):
        mq.simulate(mq.textbook.load("rigid_bar_pendulum"), **arguments)  # type: ignore[arg-type]  # bad on purpose


def test_the_motion_answers_by_name_and_by_time(swing: mq.Motion) -> None:
    assert swing.names == ("q", "q'", "q''")
    with pytest.raises(
        mq.UnknownNameError, match="unknown coordinate, velocity or acceleration 'p'"
    ):
        swing["p"]
    state = swing(1.2345)
    assert state.t == 1.2345
    assert state.q.shape == (1,)
    assert swing([0.0, 1.0]).q.shape == (2, 1)
    with pytest.raises(mq.InputError, match=r"expected times within the motion, 0…10 s, got 10\.5"):
        swing(10.5)
    with pytest.raises(mq.InputError, match="expected times"):
        swing("now")  # type: ignore[arg-type]  # bad on purpose
    assert not swing.q.flags.writeable


def test_poses_points_and_reactions_follow_the_closed_forms(swing: mq.Motion) -> None:
    q, v, a = swing["q"], swing["q'"], swing["q''"]
    e_n = np.stack([np.sin(q), 0 * q, -np.cos(q)], axis=1)
    e_t = np.stack([np.cos(q), 0 * q, np.sin(q)], axis=1)
    assert swing.poses().shape == (601, 2, 4, 4)
    assert swing.poses(1.0).shape == (2, 4, 4)
    np.testing.assert_allclose(swing.poses()[:, 1, :3, :3] @ [0, 0, -1], e_n, rtol=0, atol=1e-14)
    tip = swing.point("rod", (0, 0, -1))
    np.testing.assert_allclose(tip.position, e_n, rtol=0, atol=1e-14)
    np.testing.assert_allclose(tip.velocity, v[:, None] * e_t, rtol=0, atol=1e-13)
    np.testing.assert_allclose(
        tip.acceleration, a[:, None] * e_t - (v**2)[:, None] * e_n, rtol=0, atol=1e-12
    )
    # chapter 1, eqs. 1.14: R_n = m g cos q + m l q'²/2 against e_n, R_t = m g sin q + m l q''/2
    # along e_t
    force = swing.reactions("pin").force
    np.testing.assert_allclose(
        -(force * e_n).sum(axis=1), G * np.cos(q) + v**2 / 2, rtol=0, atol=1e-12
    )
    np.testing.assert_allclose((force * e_t).sum(axis=1), G * np.sin(q) + a / 2, rtol=0, atol=1e-12)
    np.testing.assert_allclose(
        swing.reactions("pin", [0.0, 1.0]).force[0], force[0], rtol=1e-14, atol=0
    )
    with pytest.raises(mq.UnknownNameError, match="unknown joint, loop or contact 'hinge'; "):
        swing.reactions("hinge")
    with pytest.raises(mq.UnknownNameError, match="unknown body 'bob'"):
        swing.point("bob")


def test_the_summary_says_what_happened(swing: mq.Motion) -> None:
    text = swing.summary()
    assert "rigid_bar_pendulum: t = 0…10 s, 601 samples" in text
    assert "dop853" in text
    assert "q [rad]" in text
    assert "balance within" in text
    assert repr(swing) == "<Motion of 'rigid_bar_pendulum': 601 samples, t = 0…10 s>"


def test_a_motion_can_be_pickled(swing: mq.Motion) -> None:
    copy = pickle.loads(pickle.dumps(swing))
    np.testing.assert_array_equal(copy.q, swing.q)
    np.testing.assert_array_equal(copy.a, swing.a)
    np.testing.assert_array_equal(copy(3.3).q, swing(3.3).q)


def test_rounding_of_late_times_does_not_spoil_what_lies_between_the_steps() -> None:
    motion = mq.simulate(
        mq.textbook.load("rigid_bar_pendulum"), q=[2.0], duration=100.0, t0=2000.0, rtol=1e-13
    )
    energy = motion["q'"] ** 2 / 6 - G / 2 * np.cos(motion["q"])
    assert np.ptp(energy) < 1e-9


def test_what_cannot_move_is_refused() -> None:
    mechanism = mq.Mechanism(
        "welded",
        (mq.Body("ground"), mq.Body("block", mq.particle(1.0))),
        (mq.Fixed("weld", "ground", "block"),),
    )
    with pytest.raises(
        mq.InputError, match="'welded' has no coordinate, so nothing in it can be set in motion"
    ):
        mq.simulate(mechanism)


def test_an_oscillator_follows_a_sampled_force_exactly() -> None:
    t = np.linspace(0.0, 4.0, 201)
    values = 3 * np.sin(5 * t) + np.random.default_rng(0).normal(size=t.size)
    m, k = mq.Parameter("m", 1.0, "kg"), mq.Parameter("k", 100.0, "N/m")
    load = mq.Input("F", mq.Record(t, values), "N")
    mechanism = mq.Mechanism(
        "oscillator",
        (mq.Body("ground"), mq.Body("block", mq.box(m, (0.1, 0.1, 0.1)))),
        (mq.Prismatic("slide", "ground", "block", axis=(1, 0, 0), coordinate="x"),),
        forces=(
            mq.JointSpring("spring", "slide", k),
            mq.Force("push", "block", (0, 0, 0), (load, 0, 0)),
        ),
        parameters=(m, k),
        inputs=(load,),
    )
    motion = mq.simulate(mechanism, duration=4.0, rtol=1e-10, samples=t)
    # x'' + 100 x = F, F linear between samples: the matrix exponential of (x, x', F, F') is exact
    state = np.zeros(2)
    expected = [state]
    step = t[1] - t[0]
    flow = expm(step * np.array([[0, 1, 0, 0], [-100.0, 0, 1, 0], [0, 0, 0, 1], [0, 0, 0, 0]]))
    for before, after in pairwise(values):
        state = (flow @ np.array([*state, before, (after - before) / step]))[:2]
        expected.append(state)
    np.testing.assert_allclose(
        np.column_stack([motion["x"], motion["x'"]]), expected, rtol=0, atol=1e-10
    )

"""Code of mechanisms that switch: every mode and impact, against Pinocchio and closed forms."""

from __future__ import annotations

import shutil
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import mecanique as mq
from mecanique.verification import modes

G = 9.81
COMPILER = pytest.mark.skipif(shutil.which("cc") is None, reason="needs a C compiler")


@pytest.mark.parametrize("target", ["c", "javascript", "python", "jax", "casadi"])
def test_every_mode_and_impact_is_written_and_agrees(target: str) -> None:
    tool = {"c": "cc", "javascript": "node"}.get(target)
    if tool is not None and shutil.which(tool) is None:
        pytest.skip(f"needs {tool}")
    if tool is None and target != "python":
        pytest.importorskip(target)
    code = mq.generate(mq.derive_modes(mq.textbook.load("billiard_ball")), target, samples=20)
    assert code.verdict is not None
    assert max(code.verdict.worst.values()) < 1e-13
    assert list(code.verdict.worst) == [
        "elements",
        "mode_open",
        "mode_sticks",
        "mode_slips_plus",
        "mode_slips_minus",
        "impact_cloth_sticks",
        "impact_cloth_slips_plus",
        "impact_cloth_slips_minus",
    ]


@COMPILER
def test_modes_of_several_elements_and_other_parameters() -> None:
    block = mq.Mechanism(
        "slider",
        (mq.Body("ground"), mq.Body("block", mq.box(2.0, (0.1, 0.1, 0.1)))),
        (mq.Prismatic("slide", "ground", "block", axis=(1, 0, 0), coordinate="x"),),
        parameters=(mq.Parameter("k", 50.0, "N/m"), mq.Parameter("e", 0.5, "1")),
        switching=(
            mq.Friction("dry", "slide", 0.1, 20.0, speed=0.3),
            mq.Stop("buffer", "slide", at=0.5, stiffness=mq.Parameter("k", 50.0, "N/m")),
            mq.Stop("wall", "slide", at=0.7, restitution=mq.Parameter("e", 0.5, "1")),
        ),
    )
    made = mq.generate(mq.derive_modes(block), "c", samples=20).compile()
    q, v = [0.6], [1.5]
    names = "mode_dry_slips_plus_buffer_closed_wall_open"
    # −μ N − k (x − 0.5), by the mass; then the three forces
    given = {"k": 80.0, "e": 0.25}
    np.testing.assert_allclose(
        getattr(made, names)(0.0, q, v, given), [-5.0, -2.0, 8.0, 0.0], rtol=1e-14, atol=0
    )
    np.testing.assert_allclose(
        made.impact_wall_closed(0.0, q, v, given), [-0.375, 3.75], rtol=1e-14, atol=0
    )
    # slip; gap and its rate, twice
    np.testing.assert_allclose(
        made.elements(0.0, q, v, given), [1.2, -0.1, -1.5, 0.1, -1.5], rtol=1e-14, atol=0
    )


@COMPILER
def test_a_loop_over_the_code_moves_as_simulate_does() -> None:
    """Stick and slip on a belt, by the functions of the two modes and an event of each."""
    belt = mq.textbook.load("stick_slip")
    made = mq.generate(mq.derive_modes(belt), "c", samples=5).compile()
    motion = mq.simulate(belt, v={"x": 0.1}, duration=3.0, rtol=1e-12)

    def sticks(t: float, y: np.ndarray) -> float:
        return 0.4 * G - abs(float(made.mode_sticks(t, y[:1], y[1:])[1]))

    def slips(t: float, y: np.ndarray) -> float:
        # from the start on its slip is away from zero
        return float(made.elements(t, y[:1], y[1:])[0]) if y[0] < 0.0196 else -1.0

    t, y, stick, times = 0.0, np.array([0.0, 0.1]), True, []
    while t < 3.0:
        mode = made.mode_sticks if stick else made.mode_slips_minus
        event = sticks if stick else slips
        event.terminal = True  # type: ignore[attr-defined]

        def rates(t: float, y: np.ndarray, mode: object = mode) -> list[float]:
            return [y[1], float(mode(t, y[:1], y[1:])[0])]  # type: ignore[operator]

        done = solve_ivp(rates, (t, 3.0), y, events=event, rtol=1e-12, atol=1e-14, method="DOP853")
        t, y = float(done.t[-1]), done.y[:, -1]
        if done.status == 1:
            times.append(t)
            stick = not stick
    np.testing.assert_allclose(times, [event.t for event in motion.events], rtol=0, atol=1e-9)
    assert y[0] == pytest.approx(motion["x"][-1], abs=1e-9)


def test_a_ball_that_strikes_keeps_its_momentum_about_the_contact() -> None:
    ball = mq.textbook.load("billiard_ball")
    code = mq.generate(mq.derive_modes(ball), "python", samples=5)
    namespace: dict[str, object] = {}
    exec(code.files["billiard_ball.py"], namespace)
    q, v = np.array([[0.0, 0.03, 0.0]]), np.array([[3.0, -2.0, 0.0]])
    struck = namespace["impact_cloth_slips_plus"](0.0, q, v)  # type: ignore[operator]
    after = np.asarray(struck).reshape(-1)
    # μ N = 0.2 m 2 to the left; turns about −y roll it back
    np.testing.assert_allclose(after[:3], [2.6, 0.0, -0.4 / (0.4 * 0.03)], rtol=1e-13, atol=1e-14)
    np.testing.assert_allclose(after[3:], [0.34, -0.068], rtol=1e-13, atol=0)


def test_what_no_code_can_hold_is_refused() -> None:
    with pytest.raises(mq.InputError, match="an FMU holds one mode, and cannot tell which follows"):
        mq.generate(mq.derive_modes(mq.textbook.load("clutch")), "fmu")
    smooth = mq.textbook.load("base_excited_mass")
    dry = replace(smooth, switching=(mq.Friction("dry", smooth.joints[0].name, 0.1, 2.0),))
    with pytest.raises(mq.DerivationError, match="is moved by time; code of modes is not written"):
        mq.generate(mq.derive_modes(dry))


def test_code_that_differs_from_pinocchio_is_not_handed_out(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    from mecanique.generation import verdict as cases

    def shift(*given: object, **named: object) -> object:
        solved, rounding = modes.solve_mode(*given, **named)  # type: ignore[arg-type]
        return solved * (1 + 1e-9), rounding

    monkeypatch.setattr(cases, "solve_mode", shift)
    with pytest.raises(mq.DerivationError, match="and the reference disagree: mode_sticks differs"):
        mq.generate(mq.derive_modes(mq.textbook.load("dry_oscillator")), "python", samples=5)

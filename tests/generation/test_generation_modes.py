"""Code of mechanisms that switch: every mode and impact, against Pinocchio and closed forms."""

from __future__ import annotations

import shutil
from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import mecanique as mq
from mecanique.derivation.mechanics.letters import Letters
from mecanique.derivation.mechanics.switching import (
    Terms,
    accelerate,
    close_contacts,
    name_mode,
)
from mecanique.generation.mechanics import switching
from mecanique.generation.mechanics.constrained import inputs_at
from mecanique.generation.mechanics.switching import SwitchingEquations
from mecanique.program.evaluation import evaluate
from mecanique.program.solving import eliminate
from mecanique.program.traced import trace, values_of
from mecanique.verification import modes
from mecanique.verification.states import random_states

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
        "impact_cloth",
    ]


def test_slip_in_a_plane_has_the_root_of_the_sum_of_squares_for_its_length() -> None:
    ball = mq.textbook.load("billiard_ball")
    letters = Letters(close_contacts(ball))
    equations = SwitchingEquations(ball, letters, lambda _: False)
    parts = [trace(letters.tape, letters.tape.input(name)) for name in "ab"]
    values = values_of([equations.length(parts[0]), equations.length(*parts)])
    (lengths,) = evaluate(letters.tape, values, {"a": -3.0, "b": 4.0}, 1)
    np.testing.assert_allclose(lengths, [3.0, 5.0], rtol=1e-15, atol=0)


def block() -> mq.Mechanism:
    """A block on a spring, with friction against a belt and a wall to stop it."""
    return mq.Mechanism(
        "block",
        (mq.Body("ground"), mq.Body("block", mq.box(2.0, (0.1, 0.1, 0.1)))),
        (mq.Prismatic("slide", "ground", "block", axis=(0.6, 0, 0.8), coordinate="x"),),
        forces=(mq.JointSpring("spring", "slide", 80.0),),
        switching=(
            mq.Friction("dry", "slide", 0.1, 20.0, speed=0.3, mu_static=0.15),
            mq.Stop("wall", "slide", at=0.7, restitution=0.5),
        ),
        gravity=(0, 0, -G),
    )


def rolled() -> mq.Mechanism:
    """A ball in space on cloth, thrown by a force."""
    return mq.Mechanism(
        "rolled",
        (mq.Body("ground"), mq.Body("ball", mq.ball(0.2, 0.03))),
        (mq.Floating("free", "ground", "ball"),),
        forces=(mq.Force("push", "ball", (0, 0, 0.01), (0.3, -0.4, 0.5)),),
        switching=(mq.Contact("cloth", "ball", radius=0.03, mu=0.2, mu_static=0.3),),
        gravity=(0, 0, -G),
    )


@pytest.mark.parametrize("mechanism", [block(), rolled()], ids=lambda mechanism: mechanism.name)
def test_terms_and_modes_on_a_tape_are_those_of_the_engine(mechanism: mq.Mechanism) -> None:
    states = random_states(replace(mechanism, switching=()), 1, 3)
    bench = modes._Bench(mechanism, states, 1e-9)
    letters = Letters(close_contacts(mechanism))
    equations = SwitchingEquations(mechanism, letters, lambda _: False)
    inputs = inputs_at(letters, states)

    def numbers(scalars: Any) -> np.ndarray:
        values = values_of(list(np.ravel(scalars)))
        return np.asarray(evaluate(letters.tape, values, inputs, 1)[0])

    for field in Terms._fields:
        expected = getattr(bench.theirs, field)[0]
        if field == "drift":  # of joints alone
            expected = expected[len(equations.contacts) :]
        np.testing.assert_allclose(
            numbers(getattr(equations.terms, field)),
            np.ravel(expected),
            rtol=0,
            atol=1e-12 * float(np.abs(expected).max(initial=1.0)),
            err_msg=field,
        )
    drive = accelerate(equations.terms, equations.elements)
    told = 0
    for chosen in product(*(element.states for element in mechanism.switching)):
        named = dict(zip((e.name for e in mechanism.switching), chosen, strict=True))
        expected, condition = bench.solve(named, bench.theirs)
        if condition[0] > 1e8:
            continue  # rigid bodies do not determine its forces
        mode = name_mode(equations.elements, named)
        a, forces = equations.solve(mode, drive)
        rows = [row for element in equations.elements for row in element.rows]
        solved = numbers([*a, *forces[rows]])
        size = float(np.abs(expected).max())
        np.testing.assert_allclose(
            solved, expected[0], rtol=0, atol=1e-11 * size, err_msg=str(mode)
        )
        told += 1
    assert told >= 3


@pytest.mark.parametrize("size", [1, 2, 3, 5])
def test_elimination_solves_any_regular_system(size: int) -> None:
    random = np.random.default_rng(size)
    A, b = random.normal(size=(size, size)) + 4 * np.eye(size), random.normal(size=size)
    expected = np.linalg.solve(A, b)
    np.testing.assert_allclose(eliminate(A.tolist(), b.tolist()), expected, rtol=0, atol=1e-12)


def test_rows_without_slip_are_solved_as_a_symmetric_system(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Where one slides, its friction acts along other rows, and the system is not symmetric."""
    mechanism = rolled()
    equations = SwitchingEquations(mechanism, Letters(close_contacts(mechanism)), lambda _: False)
    drive = accelerate(equations.terms, equations.elements)
    eliminated: list[int] = []

    def watch(system: Any, right: Any) -> Any:
        eliminated.append(len(system))
        return eliminate(system, right)

    monkeypatch.setattr(switching, "eliminate", watch)
    for state, sizes in (("sticks", []), ("slips", [1])):
        mode = name_mode(equations.elements, {"cloth": state}, (0.6, 0.8))
        equations.solve(mode, drive)
        assert eliminated == sizes, state


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
        made.impact_wall(0.0, q, v, given), [-0.375, 3.75], rtol=1e-14, atol=0
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
    struck = namespace["impact_cloth"](0.0, q, v)  # type: ignore[operator]
    after = np.asarray(struck).reshape(-1)
    # μ N = 0.2 m 2 to the left; turns about −y roll it back
    np.testing.assert_allclose(after[:3], [2.6, 0.0, -0.4 / (0.4 * 0.03)], rtol=1e-13, atol=1e-14)
    np.testing.assert_allclose(after[3:], [0.34, -0.068], rtol=1e-13, atol=0)


def test_modes_too_long_to_be_read_are_written_in_steps() -> None:
    crank = mq.textbook.load("clearance_slider_crank")
    names = [element.name for element in crank.switching]
    touching = dict(zip(names, ("slips +", "open", "open", "open"), strict=True))
    code = mq.generate(mq.derive_modes(crank, only=[touching]), "python", samples=5)
    assert code.verdict is not None
    (name,) = (name for name in code.verdict.worst if name.startswith("mode_"))
    assert name.startswith("mode_upper_left_slips_plus")


def test_what_no_code_can_hold_is_refused() -> None:
    ball = mq.textbook.load("bouncing_ball")
    steps = tuple(mq.Stop(f"s{k}", ball.joints[0].name, at=-1.0 - k, side=-1) for k in range(7))
    with pytest.raises(mq.DerivationError, match=r"has 7 elements that switch, .* at most 6"):
        mq.generate(mq.derive_modes(replace(ball, switching=steps), most=128), "fmu")
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

"""A mechanism against another description, functions of a user, and samples from a file."""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

import mecanique as mq
from mecanique.cli import app
from mecanique.errors import InputError, UnknownNameError
from mecanique.model.coordinates import Coordinates
from mecanique.verification.foreign import Functions

PENDULUM = "rigid_bar_pendulum"
FUNCTIONS: dict[str, Callable[..., Any]] = {
    "M": lambda q: np.array([[1 / 3]]),
    "C": lambda q, v: np.zeros((1, 1)),
    "g": lambda q: 9.81 / 2 * np.sin(q),
}


@pytest.fixture(autouse=True)
def _elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def test_another_file_of_the_same_robot_agrees() -> None:
    mechanism = mq.textbook.load("cart_pole")
    mq.write_urdf(mechanism, "same.urdf")
    verdict = mq.verify(mq.read_urdf(Path("same.urdf")), 10, against="same.urdf")
    assert verdict.agrees
    assert verdict.worst < 1e-13
    other = mq.verify(mechanism, 10, against="same.urdf")
    assert other.agrees
    matched = "the coordinates have different names and are matched in their order"
    assert matched in other.notes
    free, stone = (
        mq.Mechanism(
            "stone",
            (mq.Body("ground"), mq.Body("stone", mq.box(2.0, (1, 2, 3)))),
            (mq.Floating(name, "ground", "stone"),),
        )
        for name in ("free", "thrown")
    )
    verdict = mq.verify(free, 5, against=stone)
    assert verdict.agrees
    assert matched in verdict.notes


@pytest.mark.parametrize(("name", "said"), [("cart_pole", "other cart_pole"), ("mine", "mine")])
def test_two_mechanisms_of_one_name_are_told_apart(name: str, said: str) -> None:
    cart = mq.textbook.load("cart_pole")
    row, *_ = mq.verify(cart, 2, against=replace(cart, name=name)).rows
    assert row.sources == ("recursion", said)


def test_coordinates_are_matched_by_name() -> None:
    mechanism = mq.read_urdf(mq.robot("panda"))
    turned = replace(
        mechanism,
        coordinates=Coordinates(tuple(mechanism.coordinates)[::-1], mechanism.coordinates.map),
    )
    assert tuple(turned.coordinates) != tuple(mechanism.coordinates)
    assert mq.verify(mechanism, 5, against=turned).agrees


def test_different_coordinates_are_refused_by_name() -> None:
    one, two = mq.textbook.load(PENDULUM), mq.textbook.load("cart_pole")
    with pytest.raises(
        InputError, match="expected 1 coordinate as in 'rigid_bar_pendulum', got 2 in 'cart_pole'"
    ):
        mq.verify(one, 5, against=two)


def test_own_functions_agree_or_are_explained() -> None:
    mechanism = mq.textbook.load(PENDULUM)
    verdict = mq.verify(mechanism, 20, against=FUNCTIONS)
    assert verdict.agrees
    assert {row.quantity for row in verdict.rows} == {"mass matrix", "bias", "gravity"}
    wrong = {**FUNCTIONS, "M": lambda q: [[1 / 12]]}
    verdict = mq.verify(mechanism, 20, against=wrong)
    assert verdict.causes[0].kind == "parallel axis"
    assert "missing" in verdict.causes[0].text
    armed = {**FUNCTIONS, "M": lambda q: 1 / 3 + 0.2}
    (armature, *_) = mq.verify(mechanism, 20, against=armed).causes
    assert (armature.kind, armature.text) == (
        "armature",
        "armature of joint 'pin': 0.2 kg·m² instead of 0",
    )


def test_bad_functions_are_told() -> None:
    mechanism = mq.textbook.load(PENDULUM)
    with pytest.raises(InputError, match=r"expected shape \(1,\) from gravity, got \(2,\) at"):
        mq.verify(mechanism, 3, against={"g": lambda q: [1.0, 2.0]})
    with pytest.raises(InputError, match=r"gravity\(\[.*\]\) raised ZeroDivisionError"):
        mq.verify(mechanism, 3, against={"g": lambda q: 1 / 0})
    with pytest.raises(InputError, match=r"gravity\(\[.*\]\) raised SystemExit: 0"):
        mq.verify(mechanism, 3, against={"g": lambda q: sys.exit(0)})
    with pytest.raises(UnknownNameError, match="unknown function 'K'"):
        mq.verify(mechanism, 3, against={"K": lambda q: q})
    with pytest.raises(InputError, match="expected gravity besides coriolis"):
        mq.verify(mechanism, 3, against={"C": lambda q, v: v})
    with pytest.raises(
        InputError, match="expected at least one of the functions mass_matrix, bias"
    ):
        mq.verify(mechanism, 3, against={})


@pytest.mark.parametrize("light", ["first", "second"])
def test_a_slip_that_makes_the_mass_matrix_singular_is_named(light: str) -> None:
    m, l = mq.Parameter("m", 1.0), mq.Parameter("l", 1.0)
    arm = mq.Body("arm", mq.rod(m, l, direction=(0, 0, -1)))
    nothing = mq.Body("arm")
    whole, empty = (
        mq.Mechanism(
            "arm",
            (mq.Body("ground"), body),
            (mq.Revolute("pin", "ground", "arm", axis=(0, -1, 0), coordinate="q"),),
            parameters=(m, l),
        )
        for body in (arm, nothing)
    )
    first, second = (empty, whole) if light == "first" else (whole, empty)
    verdict = mq.verify(first, 5, against=second)
    assert not verdict.agrees
    assert "acceleration" not in {row.quantity for row in verdict.rows}
    assert "left out: accelerations, as a mass matrix of 'arm' is singular" in verdict.notes
    assert verdict.difference is not None
    assert "link 'arm': mass" in str(verdict)
    assert mq.verify(empty, 5, against=empty).agrees


@pytest.mark.parametrize("code", ["raise SystemExit(0)", "def M(q):\n    raise SystemExit(0)"])
def test_a_file_that_exits_does_not_pass_for_agreement(code: str) -> None:
    Path("exits.py").write_text(code, encoding="utf-8")
    result = CliRunner().invoke(app, ["verify", PENDULUM, "--against", "exits.py"])
    assert result.exit_code == 2
    assert "raised SystemExit: 0" in result.output


def test_samples_of_a_free_motion_agree() -> None:
    mechanism = mq.textbook.load("cart_pole")
    motion = mq.simulate(mechanism, q={"q": 1.0}, duration=1.0)
    motion.to_csv("free.csv")
    verdict = mq.verify(mechanism, against="free.csv")
    assert verdict.agrees
    assert verdict.summary.startswith(f"cart_pole: agrees at {len(motion.t)} states of free.csv")


def test_samples_tell_friction_and_damping() -> None:
    mechanism = mq.textbook.load("two_link_arm", b=0.0)
    rng = np.random.default_rng(0)
    q, v, a = rng.normal(size=(3, 60, 2))
    equations = mq.derive(mechanism)
    for extra, kind in ((0.3 * np.sign(v), "friction"), (0.3 * v, "damping")):
        tau = equations.inverse_dynamics(q, v, a)
        tau[:, 1] += extra[:, 1]
        names = [
            *mechanism.coordinates,
            *mechanism.velocities,
            *(f"{name}'" for name in mechanism.velocities),
        ]
        names += [f"tau_{name}" for name in mechanism.coordinates]
        table = np.hstack([q, v, a, tau])
        np.savetxt(
            "samples.csv", table, delimiter=",", header=",".join(names), comments="", fmt="%.17g"
        )
        verdict = mq.verify(mechanism, against="samples.csv")
        assert not verdict.agrees
        joints = [joint.name for joint in mechanism.joints]
        assert (verdict.causes[0].kind, verdict.causes[0].where) == (kind, f"joint {joints[1]!r}")
        assert "0.3" in verdict.causes[0].text


def test_noise_is_lived_with() -> None:
    mechanism = mq.textbook.load(PENDULUM)
    rng = np.random.default_rng(0)
    noisy = {**FUNCTIONS, "g": lambda q: -FUNCTIONS["g"](q) + 1e-4 * rng.normal(size=1)}
    del noisy["M"], noisy["C"]
    verdict = mq.verify(mechanism, 30, against=noisy)
    assert verdict.causes[0].kind == "gravity sign"
    assert mq.verify(
        mechanism, 30, against={"g": lambda q: FUNCTIONS["g"](q) + 1e-6}, tolerance=1e-3
    ).agrees


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "cannot be read"),
        ("q,q'\n0,0\n", "expected a column \"q''\", got q, q'"),
        ("q,q',q''\n", "expected at least one line of numbers"),
        ("q,q',q''\n0,0\n", "bad.csv:2: expected 3 numbers, got 2"),
        ("q,q',q''\n0,0,0\n0,nan,0\n", "bad.csv:3: expected finite numbers for the velocities"),
        ("q,q',q'',t\n0,0,0,soon\n", "bad.csv:2: expected finite numbers for the t"),
    ],
)
def test_bad_files_are_told(text: str, said: str) -> None:
    Path("bad.csv").write_text(text, encoding="utf-8")
    with pytest.raises(InputError) as caught:
        mq.verify(mq.textbook.load(PENDULUM), against="bad.csv")
    assert said in str(caught.value)


def test_the_command_line_takes_files_functions_and_names() -> None:
    Path("mine.py").write_text("def M(q):\n    return [[1/3]]\n", encoding="utf-8")
    Path("wrong.py").write_text("def M(q):\n    return [[1/12]]\n", encoding="utf-8")
    Path("empty.py").write_text("x = 1\n", encoding="utf-8")
    Path("broken.py").write_text("1/0\n", encoding="utf-8")
    mq.simulate(mq.textbook.load(PENDULUM), q={"q": 1.0}, duration=0.2).to_csv("free.csv")

    def ends(*words: str) -> tuple[int, str]:
        result = CliRunner().invoke(app, ["verify", PENDULUM, "--samples", "5", *words])
        return result.exit_code, result.output

    for other in ("mine.py", "free.csv", PENDULUM):
        assert ends("--against", other)[0] == 0
    code, text = ends("--against", "wrong.py")
    assert code == 1
    assert "likely cause 1: inertia of link 'rod': about the center of mass" in text
    assert "(parallel-axis term missing)" in text
    assert ends("--against", "empty.py")[1].startswith("error: expected functions among M, C, g")
    assert ends("--against", "broken.py")[1].startswith("error: broken.py raised ZeroDivisionError")
    assert ends("--against", "none.py")[0] == ends("--against", "none.csv")[0] == 2
    assert CliRunner().invoke(app, ["verify", "--all", "--against", "mine.py"]).exit_code == 2


def test_a_state_is_given_also_where_a_function_may_do_without() -> None:
    mechanism = mq.textbook.load("double_pendulum")
    reference = mq.Reference(mechanism)
    given: dict[str, Callable[..., Any]] = {"M": reference.mass_matrix, "bias": reference.bias}
    assert mq.verify(mechanism, 5, against=given).agrees


@pytest.mark.parametrize("put_into_T", [False, True])
@pytest.mark.parametrize("m", [2.0, 2e-6, 2e6])
def test_a_constraint_put_into_T_is_told_from_the_right_equations(
    put_into_T: bool, m: float
) -> None:
    """Of a sleigh by x' and θ': right u' = a θ'² and I_A θ'' = −m a u θ' with u = x' / cos θ.

    Wrong: Lagrange's operator on T = ½ m u² + ½ I_A θ'².
    """
    a, theta = 0.3, mq.coordinate("theta")
    edge = mq.VelocityConstraint("edge", {"x": mq.sin(theta), "y": -mq.cos(theta)})
    sleigh = mq.Mechanism(
        "sleigh",
        (mq.Body("ground"), mq.Body("sleigh", mq.box(m, (1, 0.4, 0.1)).at((a, 0, 0)))),
        (mq.Planar("plane", "ground", "sleigh", names=("x", "y", "theta")),),
        velocity_constraints=(edge,),
    )
    I_A = m * (1 + 0.4**2) / 12 + m * a**2

    def mass_matrix(q: np.ndarray) -> np.ndarray:
        return np.diag([m / np.cos(q[2]) ** 2, I_A])

    def bias(q: np.ndarray, v: np.ndarray) -> np.ndarray:
        (c, tangent), (x, _, w) = (np.cos(q[2]), np.tan(q[2])), v
        wrong = np.array([2 * x * w, -(x**2)]) * m * tangent / c**2
        a_x, a_theta = a * w**2 * c - x * tangent * w, -m * a * x / c * w / I_A
        return np.asarray(wrong if put_into_T else -mass_matrix(q) @ [a_x, a_theta])

    functions = Functions(mass_matrix, bias, by=("x", "theta"))
    verdict = mq.verify(sleigh, 4, 0, against=functions)  # where cos θ > 0.8
    assert verdict.agrees != put_into_T
    assert [cause.kind for cause in verdict.causes] == ["constraint put into T"] * put_into_T
    for cause in verdict.causes:  # relative to the bias, whatever the mass
        assert 1.0 < cause.before < 2.0
        assert cause.after < 1e-12

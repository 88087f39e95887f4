"""All lines of a derivation hold together: what they define, what they balance, what they give.

The mechanisms are small, so that each is derived in a moment, and nothing in them is a unit, zero
or symmetric.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from itertools import chain
from typing import Any

import numpy as np
import pytest
from derivation_reading import residual, value_of_text

import mecanique as mq
from mecanique.derivation.numeric.constraints.rows import Held
from mecanique.derivation.printing.writers import Text
from mecanique.derivation.scalars.evaluation import Evaluation
from mecanique.derivation.symbolic.result import INTEGRALS
from mecanique.derivation.symbolic.symbols import coordinate_of
from mecanique.model.states import States

METHODS = ("lagrange", "newton_euler", "virtual_work")
NOT_OF_ANY_STATE = {"Small motions", "Steady rotation", "Steady vibration"}
WORDS = {"sin", "cos", "tan", "sqrt", "exp", "log", "asin", "acos", "atan", "tanh", "abs", "sign"}
q, s = mq.coordinate("q"), mq.coordinate("s")
m, l, J = mq.Parameter("m", 1.3, "kg"), mq.Parameter("l", 0.7, "m"), mq.Parameter("J", 0.2, "kg·m²")
PLATE = mq.Shape(m, (0.15, 0.1, -l), (J, 1.5 * J, 2 * J, 0, 0.03, 0))
FALL = (0.4, 0.0, -9.81)


SHAPES = {
    "b": (PLATE,),
    "p": (mq.particle(m).at((0.1, 0, -l)),),
    "c": (mq.particle(m).at((0, 0, -l)),),
}


def build(name: str, *joints: mq.Joint, **parts: Any) -> mq.Mechanism:
    """Return a mechanism of plates b1 …, particles p1 …, c1 … and bodies without mass."""
    names = [joint.child for joint in joints]
    bodies = [mq.Body(name, *SHAPES.get(name[0], ())) for name in names]
    return mq.Mechanism(
        name,
        (mq.Body("ground"), *bodies),
        joints,
        parameters=(m, l, J),
        **({"gravity": FALL} | parts),
    )


def hinge(parent: str, child: str, name: str, **given: Any) -> mq.Revolute:
    return mq.Revolute(f"pin_{name}", parent, child, coordinate=name, **given)


def slide(parent: str, child: str, name: str, **given: Any) -> mq.Prismatic:
    return mq.Prismatic(f"rail_{name}", parent, child, coordinate=name, **given)


ROD = 0.5
DOWN, ASIDE = (0.0, -1.0, 0.0), mq.Placement((0.2, 0.3, -0.4))
CART = slide("ground", "b1", "x", axis=(1, 0, 0))
PIN = hinge("b1", "b2", "theta", axis=DOWN, origin=ASIDE)
MECHANISMS = (
    build(
        "cart and arm",
        CART,
        PIN,
        forces=(
            mq.JointDamper("grease", "pin_theta", 0.4),
            mq.JointSpring("winding", "pin_theta", 3.0, 0.2),
            mq.Force("push", "b2", (0, 0.1, -l), (1.5, 0.2, 0.3), axes="b2"),
            mq.Torque("twist", "b1", (0.2, 0.7, 0.4)),
        ),
    ),
    build(
        "in space",
        hinge("ground", "b1", "q", axis=(0, 0, 1)),
        hinge("b1", "b2", "theta", axis=(1, 0, 0), origin=ASIDE),
        forces=(mq.Force("push", "b2", (0, 0.1, -l), (1.5, 0.2, 0.3)),),
    ),
    build(
        "arm on a slide",
        hinge("ground", "b1", "q", axis=DOWN, origin=ASIDE),
        slide("b1", "b2", "x", axis=(0, 0, -1), origin=ASIDE),
        forces=(mq.Spring("spring", "ground", (0, 0, 1), "b1", (0, 0, -l), 4.0, 0.3),),
    ),
    build(
        "rotors",
        slide("ground", "b1", "x", axis=(1, 0, 0), armature=0.3),
        hinge("b1", "b2", "theta", axis=DOWN, origin=ASIDE, armature=0.05),
    ),
    build(
        "Cardan joint",
        mq.Universal("cardan", "ground", "b1", names=("q", "theta"), origin=ASIDE),
    ),
    build(
        "two arms on a frame",
        mq.Fixed("weld", "ground", "b1", origin=mq.Placement((0.1, 0, 0.6))),
        hinge("b1", "p2", "theta", axis=DOWN, origin=ASIDE),
        hinge("b1", "b3", "psi", axis=DOWN, origin=mq.Placement((-0.3, 0, 0.2))),
        forces=(mq.Torque("twist", "b3", (0.2, 0.7, 0.4)),),
    ),
    build(
        "plate",
        mq.Planar("floor", "ground", "b1", axis=(0, -1, 0), names=("x", "z", "theta")),
        hinge("b1", "p2", "psi", axis=DOWN, origin=ASIDE),
        gravity=(0, 0, 0),
    ),
    build(
        "ball",
        mq.Spherical("socket", "ground", "b1", origin=ASIDE),
        forces=(mq.Torque("twist", "b1", (0.2, 0.7, 0.4)),),
    ),
    build(
        "belt",
        hinge("ground", "b1", "q", axis=(0, 1, 0), armature=0.02),
        hinge("ground", "b2", "theta", axis=(0, 1, 0), origin=mq.Placement((0.5, 0, 0.3))),
        coordinates=mq.Coordinates(("q",), {"theta": 1.5 * q}),
        elements=(
            mq.Belt("belt", (mq.Pulley("b1", 0.3), mq.Pulley("b2", 0.2)), 50.0, normal=DOWN),
        ),
        gravity=(0, 0, 0),
    ),
    build(
        "rod",
        hinge("ground", "b1", "q", axis=DOWN),
        hinge("ground", "b2", "theta", axis=DOWN, origin=mq.Placement((0.5, 0, 0.3))),
        loops=(mq.Loop.distance("rod", "b1", (0, 0, -0.6), "b2", (0.1, 0, -0.4), ROD),),
        forces=(mq.JointDamper("grease", "pin_theta", 0.4),),
        gravity=(0, 0, -9.81),
    ),
    build(
        "slider",
        hinge("ground", "b1", "q", axis=DOWN),
        slide("ground", "b2", "x", axis=(1, 0, 0)),
        loops=(mq.Loop.pin("pin", "b1", (0, 0, -0.6), "b2", (0.1, 0, 0)),),
        gravity=(0, 0, 0),
    ),
    build(
        "gear",
        hinge("ground", "b1", "q", axis=DOWN, armature=0.02),
        hinge("ground", "b2", "theta", axis=DOWN, origin=mq.Placement((0.5, 0, 0))),
        coordinates=mq.Coordinates(("q",), {"theta": -1.5 * q}),
        elements=(mq.Gear("mesh", "pin_q", "pin_theta", 0.3, other_radius=0.2),),
        forces=(mq.JointForce("motor", "pin_q", 3.0),),
    ),
    build(
        "wheel",
        slide("ground", "hub", "x", axis=(1, 0, 0)),
        slide("hub", "axle", "z", axis=(0, 0, 1)),
        hinge("axle", "b1", "theta", axis=(0, 1, 0)),
        contacts=(mq.Rolling("contact", "b1", 0.4, axis=(0, 1, 0)),),
    ),
    build(
        "blade",
        slide("ground", "hub", "x", axis=(1, 0, 0)),
        slide("hub", "axle", "y", axis=(0, 1, 0)),
        hinge("axle", "b1", "theta", axis=(0, 0, 1)),
        contacts=(mq.Blade("blade", "b1"),),
    ),
    build(
        "guided",
        slide("ground", "b1", "x", axis=(1, 0, 0)),
        slide("ground", "b2", "z", axis=(0, 0, 1)),
        coordinates=mq.Coordinates(("s",), {"x": 2 * s, "z": s**2}),
    ),
    build(
        "loads",
        slide("ground", "p1", "x", axis=(1, 0, 0)),
        slide("p1", "p2", "z", axis=(0, 0, 1), origin=ASIDE),
        forces=(
            mq.Damper("damper", "ground", (0, 0, 1), "p2", (0.1, 0, 0.2), 0.7),
            mq.Spring("band", "p1", (0.5, 0, 0.1), "p2", (0, 0, 0.3), 4.0),
            mq.Potential("well", "rail_x", 3 * mq.coordinate("x") ** 4),
            mq.JointForce("drag", "rail_z", -(mq.velocity("z") ** 3)),
            mq.Force("wind", "p1", (0, 0, 0), (mq.coordinate("u") * mq.time(), 0.2, 0.3)),
        ),
        inputs=(mq.Input("u", 0.4 * mq.sin(3 * mq.time())),),
    ),
    build(
        "conical pendulum",
        mq.Universal("swing", "ground", "c1", names=("q", "theta")),
        gravity=(0, 0, -9.81),
    ),
    build(
        "flying",
        mq.Floating("flight", "ground", "b1", origin=ASIDE),
        gravity=(0, 0, -9.81),
    ),
    build(
        "turned steadily",
        hinge("ground", "frame", "q", axis=(0, 0, 1)),
        hinge("frame", "b1", "theta", axis=DOWN, origin=ASIDE),
        coordinates=mq.Coordinates((), {"q": 1.4 * mq.time()}),
        gravity=(0, 0, -9.81),
    ),
    build(
        "turned and driven",
        hinge("ground", "frame", "q", axis=(0, 0, 1)),
        hinge("frame", "b1", "theta", axis=DOWN, origin=ASIDE),
        coordinates=mq.Coordinates((), {"q": 1.4 * mq.time()}),
        forces=(mq.JointForce("motor", "pin_theta", 0.8),),
        gravity=(0, 0, -9.81),
    ),
    build(
        "led in time",
        slide("ground", "frame", "x", axis=(1, 0, 0)),
        hinge("frame", "b1", "theta", axis=DOWN, origin=ASIDE),
        coordinates=mq.Coordinates((), {"x": 0.3 * mq.sin(2 * mq.time())}),
    ),
)
SAMPLES = {mechanism.name: mechanism for mechanism in MECHANISMS}


def lines_of(equations: mq.Equations) -> Iterator[str]:
    """Yield the equations of all steps that are true of any motion."""
    title = ""
    for line in equations.text(steps=True).splitlines():
        if heading := re.fullmatch(r"\d+\. (.*)", line):
            title = heading[1]
        stated = line.startswith("     ") and " = " in line and "∂" not in line
        if stated and title not in NOT_OF_ANY_STATE:
            yield line.strip()


def letters_in(text: str) -> set[str]:
    """Return the letters of a printed formula, without functions and numbers."""
    names = re.findall(r"\d[\d.]*(?:e[+-]?\d+)?|([^\W\d]\w*'*)", text)
    return {*names} - WORDS - {""}


def state_of(mechanism: mq.Mechanism) -> tuple[States, np.ndarray]:
    """Return a state and a displacement that the constraints allow; any without constraints."""
    random = np.random.default_rng(8)
    q = mechanism.position(None)
    q = q + random.uniform(0.3, 0.9, len(q)) * (q == 0)
    v, shift = random.uniform(1, 2, (2, mechanism.nv))
    if mechanism.constrained:
        held = Held(mechanism)
        for _ in range(8):
            rows = held.at(States.of(mechanism, q, v, 0.6))
            back = np.linalg.pinv(rows.jacobian[0])
            q = q - back @ rows.residual[0]
        v = v - back @ rows.rates[0]
        shift = shift - back @ rows.jacobian[0] @ shift
    return States.of(mechanism, q, v, 0.6), shift


def spread(values: dict[str, Any], unknown: list[str]) -> dict[str, Any]:
    """Return values with the unknown ones all zero, then one after the other 1."""
    units = np.eye(len(unknown) + 1)[:, 1:]
    return values | dict(zip(unknown, units.T, strict=True))


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("name", SAMPLES)
def test_all_lines_of_a_derivation_are_true_of_a_motion(name: str, method: str) -> None:
    mechanism = SAMPLES[name]
    states, shift = state_of(mechanism)
    equations = mq.derive(mechanism, method)
    algebra = equations.derivation.algebra
    values: dict[str, Any] = {name: float(np.ravel(x)[0]) for name, x in states.values.items()}
    a = equations.acceleration(states.q[0], states.v[0], 0.6)
    values |= dict(zip(algebra.accelerations, a.tolist(), strict=True))
    coordinates = [coordinate_of(v) for v in mechanism.velocities]
    values |= {f"δ{q}": step for q, step in zip(coordinates, shift.tolist(), strict=True)}
    value = Evaluation(algebra.ring, values)
    waiting = [*lines_of(equations)]
    letters = letters_in(" ".join(waiting))
    roots = {algebra.ring.generators[index].name for index in algebra.ring.atoms} & letters
    values |= {name: float(value(algebra.ring[name])) for name in roots}
    before: list[str] = []
    while waiting != before:
        before, waiting = waiting, []
        for line in before:
            left, right = line.split(" = ")
            if letters_in(left) == {left} - {*values} and letters_in(right) <= {*values}:
                values[left] = value_of_text(right, values)
            else:
                waiting.append(line)
    unknown = sorted(letters_in(" ".join(waiting)) - {*values})
    given = spread(values, unknown)
    rows = np.array([np.broadcast_to(residual(line, given), len(unknown) + 1) for line in waiting])
    slopes, rest = rows[:, 1:] - rows[:, :1], rows[:, 0]
    solved = np.linalg.lstsq(slopes, -rest, rcond=None)[0]
    off = slopes @ solved + rest
    for line, error in zip(waiting, off, strict=True):
        assert error == pytest.approx(0, abs=1e-10), line
    if name == "rod":  # what an equation lists as Q beside its inertia is the rest of it
        moved = values["J_"] * a[0] + values["C"] * states.v[0, 0] ** 2
        assert values["Q_q"] == pytest.approx(moved, rel=1e-11)
    for integral in chain(*(x.results for x in equations.steps if x.title in INTEGRALS)):
        assert value(integral.right.ddt()) == pytest.approx(0, abs=1e-10), integral
    works = [values.get(f"δW_{q}", 0.0) for q in coordinates]
    assert sum(works) == pytest.approx(0, abs=1e-10)


def test_steps_say_what_there_is() -> None:
    def said(name: str, method: str) -> dict[str, str]:
        return {step.title: step.explanation for step in mq.derive(SAMPLES[name], method).steps}

    assert "J_ collects what multiplies q'', the inertia" in " ".join(
        mq.derive(SAMPLES["rod"]).text(steps=True).split()
    )  # as J has another meaning there
    summed = "Sum of the virtual work"
    assert said("guided", "virtual_work")[summed].endswith(
        "As δs is arbitrary, its coefficient is zero."
    )
    assert said("cart and arm", "virtual_work")[summed].endswith(
        "As δx and δtheta are arbitrary, each coefficient is zero."
    )
    assert "the constraint forces between bodies do none" in said("blade", "virtual_work")[summed]
    ball = said("ball", "lagrange")
    for axis in "xyz":
        assert ball[f"Operator for socket_w{axis}"].startswith(
            f"The operator for socket_w{axis}, which is not the rate of a coordinate:"
        )
    arm = said("cart and arm", "lagrange")
    assert arm["Operator for theta"].startswith("Lagrange's operator takes the momentum")


@pytest.mark.parametrize(
    ("name", "listed"),
    [
        ("led in time", ["T"]),
        ("blade", ["T"]),
        ("rotors", ["T_b1", "T_b2", "T_rail_x", "T_pin_theta", "T"]),
    ],
)
def test_the_kinetic_energy_of_a_single_body_is_listed_once(name: str, listed: list[str]) -> None:
    steps = {step.title: step for step in mq.derive(SAMPLES[name]).steps}
    lines = [line.write(Text()).partition(" = ")[0] for line in steps["Kinetic energy"].results]
    assert lines == listed


@pytest.mark.parametrize(
    ("name", "letters"),
    [("in space", {"E"}), ("Cardan joint", {"E"}), ("turned and driven", {"h"}), ("guided", {"E"})],
)
def test_what_stays_constant_is_listed(name: str, letters: set[str]) -> None:
    steps = [step for step in mq.derive(SAMPLES[name]).steps if step.title in INTEGRALS]
    found = {line.write(Text()).partition(" = ")[0] for step in steps for line in step.results}
    assert found == letters


CENTER = "both about its center of mass."
PLANE = "x and z are the axes of the world; forces are positive along them, moments about "
OWN = "are the axes of b1; moments are taken about them."


@pytest.mark.parametrize(
    ("name", "said"),
    [
        (
            "cart and arm",
            {
                "b1: forces": (
                    "b1 is acted on by the reaction in rail_x, its weight, the grease, the "
                    "winding, the twist and the opposite of the reaction in the pin theta. "
                    f"{PLANE}-y."
                ),
                "b1: moments": "The moments are in balance, all about its center of mass.",
                "b2: forces": "the pin theta, its weight, the grease, the winding and the push.",
                "b2: moments": f"the resultant moment, {CENTER}",
            },
        ),
        (
            "arm on a slide",
            {
                "b1: forces": f"the opposite of the reaction in rail_x. {PLANE}-y.",
                "b1: moments": "both about the joint pin_q, a fixed point. About it the moments",
                "b2: forces": "x and z are the axes of b2; forces are positive along them, moments",
                "b2: moments": CENTER,
            },
        ),
        (
            "two arms on a frame",
            {
                "b1: forces": (
                    "b1 is acted on by the reaction in the weld, its weight, the opposite of the "
                    "reaction in the pin theta and the opposite of the reaction in the pin psi."
                ),
                "b1: moments": "in balance, all about the joint weld, a fixed point.",
                "p2: forces": "p2 is acted on by the reaction in the pin theta and its weight.",
                "b3: forces": "the reaction in the pin psi, its weight and the twist.",
            },
        ),
        ("belt", {"b2: forces": f"in the pin theta, T_belt_1 and T_belt_2. {PLANE}y."}),
        ("gear", {"b1: forces": f"its weight, the motor, F_mesh and N_mesh. {PLANE}-y."}),
        ("flying", {"b1: forces": f"b1 is acted on by its weight. x, y and z {OWN}"}),
        (
            "wheel",
            {
                "b1: forces": (
                    "The bodies hub and axle have no mass, and nothing else acts on them: the "
                    "joints rail_x, rail_z and pin_theta together join b1 to the ground. Cut free, "
                    "b1 is acted on by the reaction in the pin theta, its weight and the contact."
                ),
            },
        ),
        (
            "turned steadily",
            {
                "b1: forces": (
                    "The body frame has no mass, and nothing else acts on it: the joints pin_q and "
                    "pin_theta together join b1 to the ground."
                ),
                "b1: moments": CENTER,
            },
        ),
        (
            "loads",
            {
                "p1: forces": (
                    "rail_x, its weight, the band, the well, the drag, the wind and the opposite "
                    "of the reaction in rail_z. x, y and z are the axes of the world."
                ),
                "p2: forces": "in rail_z, its weight, the damper, the band and the drag.",
            },
        ),
    ],
)
def test_free_bodies_are_told_with_all_that_acts_on_them(name: str, said: dict[str, str]) -> None:
    """And along which axes, and about which point, their momenta are balanced."""
    steps = {step.title: step for step in mq.derive(SAMPLES[name], "newton_euler").steps}
    for title, words in said.items():
        assert words in steps[f"Free body {title}"].explanation


@pytest.mark.parametrize(
    ("name", "method", "law"),
    [
        ("cart and arm", "lagrange", "are d/dt ∂T/∂q' - ∂T/∂q + ∂V/∂q + ∂D/∂q' = Q for every"),
        (
            "in space",
            "lagrange",
            "are d/dt ∂T/∂q' - ∂T/∂q + ∂V/∂q = 0 for every coordinate q. Each",
        ),
        ("rod", "lagrange", "+ ∂D/∂q' = Σ λ ∂Φ/∂q for every coordinate q. The loops add their"),
        ("wheel", "lagrange", "+ ∂V/∂q = Σ λ ∂Φ/∂q + Σ λ ∂ψ/∂q' for every coordinate q."),
        ("blade", "lagrange", "= Σ λ ∂ψ/∂q' for every coordinate q. The constraints add their own"),
        ("ball", "lagrange", "= Q for every coordinate q; for a velocity that is not the rate of"),
        (
            "in space",
            "newton_euler",
            "joints leave one equation for each velocity, without unknown",
        ),
        ("guided", "newton_euler", "joints, and the sums for the guided coordinates, leave one"),
        (
            "slider",
            "newton_euler",
            "The forces λ of the loops remain as unknowns; the loops add as",
        ),
        (
            "wheel",
            "newton_euler",
            "The forces λ of the contacts remain as unknowns; the conditions",
        ),
        (
            "flying",
            "newton_euler",
            "The balances along and about the free directions of the joints are",
        ),
    ],
)
def test_equations_of_motion_are_told_by_their_law(name: str, method: str, law: str) -> None:
    text = " ".join(mq.derive(SAMPLES[name], method).text(steps=True).split())
    assert law in text.partition(". Equations of motion ")[2]


@pytest.mark.parametrize(
    ("name", "held"),
    [
        ("conical pendulum", ["R_swing_z"]),  # along the rod alone
        ("ball", ["R_socket_x", "R_socket_y", "R_socket_z"]),
        ("plate", ["R_pin_psi_x", "R_pin_psi_z", "M_floor_x", "M_floor_z"]),
        ("flying", []),
    ],
)
def test_joints_transmit_what_a_motion_needs(name: str, held: list[str]) -> None:
    """A particle needs no moment about itself, and nothing where its joint is free."""
    reactions = mq.derive(SAMPLES[name], "newton_euler").derivation.reactions
    assert sorted(reactions) == sorted(held)

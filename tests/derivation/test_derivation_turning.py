"""Angular velocities and rates are stated in axes in which a reader can do the step by hand."""

from __future__ import annotations

from itertools import combinations_with_replacement

import numpy as np
import pytest
from systems import derive_system

import mecanique as mq
from mecanique.derivation.scalars.elementary import cos, sin
from mecanique.derivation.scalars.evaluation import Evaluation
from mecanique.derivation.scalars.series import Series
from mecanique.derivation.symbolic.derivation import Left, Stage
from mecanique.derivation.symbolic.kinematics import Kinematics, geometry_stages
from mecanique.derivation.symbolic.symbols import Algebra
from mecanique.derivation.symbolic.vectors import Vector, cross

NEWTON_EULER = "newton_euler"
SPATIAL = (
    "furuta_pendulum",
    "gyroscope",
    "heavy_top",
    "free_rigid_body",
    "rolling_coin",
    "rotating_plate",
    "tennis_racket",
    "two_wheeled_cart",
)


def listed(stage: Stage) -> dict[str, Series]:
    """The quantities that a step lists, by name."""
    return {x.left.symbol: x.right for x in stage.results if isinstance(x.left, Left)}


def stages_of(equations: mq.Equations) -> dict[str, Stage]:
    """The steps of a derivation by title."""
    return {stage.title: stage for stage in equations.steps}


def vector_of(name: str, known: dict[str, Series], zero: Series) -> Vector:
    """Components x, y and z of a vector; those that are not listed are zero."""
    return Vector(*(known.get(f"{name}_{axis}", zero) for axis in "xyz"))


def check_kinetic_energy(equations: mq.Equations) -> None:
    """T = Σ ½ m v² + ½ Σ I ω², each component of ω about the axis of its moment of inertia."""
    stages, algebra = stages_of(equations), equations.derivation.algebra
    speeds = np.random.default_rng(5).uniform(0.5, 2.0, len(algebra.velocities))
    state = {**algebra.generic, **dict(zip(algebra.velocities, speeds, strict=True))}
    value = Evaluation(algebra.ring, state)
    known = listed(stages["Moments of inertia"])
    known |= listed(stages["Positions and velocities"])
    numbers = {symbol: float(value(series)) for symbol, series in known.items()}
    total, turning = 0.0, 0
    for body, mass in [(body.name, body.mass) for body in algebra.mechanism.bodies]:
        v = [numbers.get(f"v_{body}_{axis}", 0.0) for axis in "xyz"]
        total += float(value(algebra.series(mass))) * np.dot(v, v) / 2
        for i, k in combinations_with_replacement("xyz", 2):
            product = numbers.get(f"omega_{body}_{i}", 0.0) * numbers.get(f"omega_{body}_{k}", 0.0)
            moment = numbers.get(f"I_{body}_{i}{k}", 0.0)
            turning += bool(moment * product)
            total += moment * product / (2 if i == k else 1)
    T = listed(stages["Kinetic energy"])["T"]
    assert turning > 0
    np.testing.assert_allclose(total, float(value(T)), rtol=1e-10, atol=0.0)


@pytest.mark.parametrize("name", SPATIAL)
def test_the_listed_values_add_up_to_the_kinetic_energy(name: str) -> None:
    check_kinetic_energy(derive_system(name))


def tilted() -> mq.Mechanism:
    """Return a plate with products of inertia on an arm that turns about z."""
    shape = mq.Shape(2.0, (0.0, 0.2, 0.0), (0.3, 0.4, 0.5, 0.1, 0.05, 0.02), ())
    bodies = (mq.Body("ground"), mq.Body("arm"), mq.Body("plate", shape))
    hinges = (
        mq.Revolute("a", "ground", "arm", axis=(0.0, 0.0, 1.0), coordinate="a"),
        mq.Revolute("b", "arm", "plate", axis=(1.0, 0.0, 0.0), coordinate="b"),
    )
    return mq.Mechanism("tilted", bodies, hinges)


TILTED = tilted()


def test_products_of_inertia_add_to_the_kinetic_energy() -> None:
    equations = mq.derive(TILTED)
    check_kinetic_energy(equations)
    said = stages_of(equations)["Kinetic energy"].explanation
    assert "plus its products of inertia, each times the angular velocities about both" in said


@pytest.mark.parametrize(
    ("name", "axes"),
    [
        ("heavy_top", "for the top along axes that do not spin with the top."),
        (
            "gyroscope",
            "for the inner along the body's own; for the rotor along those of the inner, which do "
            "not spin with the rotor.",
        ),
        ("rotating_plate", ""),
        ("double_pendulum", ""),
    ],
)
def test_axes_of_angular_velocities_are_named_unless_they_are_the_worlds(
    name: str, axes: str
) -> None:
    said = stages_of(derive_system(name))["Positions and velocities"].explanation
    assert ("The components of omega are along axes" in said) is bool(axes)
    assert said.endswith(axes)


def test_the_kinetic_energy_is_said_to_be_of_what_there_is() -> None:
    said = stages_of(derive_system("kepler_orbit"))
    assert "inertia" not in said["Kinetic energy"].explanation
    assert "omega" not in said["Positions and velocities"].explanation
    assert "squares of its angular velocities about their axes;" in (
        stages_of(derive_system("heavy_top"))["Kinetic energy"].explanation
    )


def test_axes_that_turn_by_themselves_are_listed_with_their_rate() -> None:
    """Of a plate on an arm that turns about z: Ω = b' along x, a' sin b and a' cos b across it."""
    equations = mq.derive(TILTED, NEWTON_EULER)
    known = listed(stages_of(equations)["Free body plate: forces"])
    ring = equations.derivation.algebra.ring
    rates = {axis: str(known[f"Omega_plate_{axis}"]) for axis in "xyz"}
    turn = {"x": ring["b'"], "y": sin(ring["b"]) * ring["a'"], "z": cos(ring["b"]) * ring["a'"]}
    assert rates == {axis: str(rate) for axis, rate in turn.items()}
    check_rate_of_momentum(equations, "plate", "plate")


@pytest.mark.parametrize(
    ("name", "body", "axes"),
    [
        ("heavy_top", "top", "tilted"),
        ("gyroscope", "inner", "inner"),
        ("gyroscope", "rotor", "inner"),
        ("rolling_coin", "coin", "fork"),
    ],
)
def test_the_rate_of_the_angular_momentum_follows_from_what_is_listed(
    name: str, body: str, axes: str
) -> None:
    check_rate_of_momentum(derive_system(name, NEWTON_EULER), body, axes)


def check_rate_of_momentum(equations: mq.Equations, body: str, axes: str) -> None:
    """In axes that turn the rate of a vector is that of its components and Ω × the vector."""
    stages, zero = stages_of(equations), equations.derivation.algebra.ring.number(0)
    stage = stages[f"Free body {body}: moments"]
    assert stage.explanation.endswith("components plus the cross product of Ω and the vector.")
    known = listed(stages[f"Free body {body}: forces"]) | listed(stage)
    turning, H = (vector_of(of, known, zero) for of in (f"Omega_{axes}", f"H_{body}"))
    rate = Vector(*(part.ddt() for part in H)) + cross(turning, H)
    lines = [line.left for line in stage.results if isinstance(line.left, Series)]
    for left, component in zip(lines, rate, strict=True):
        assert (left - component).vanishes()


@pytest.mark.parametrize(("name", "body"), [("heavy_top", "top"), ("kepler_orbit", "planet")])
def test_the_acceleration_follows_from_what_is_listed(name: str, body: str) -> None:
    """In a plane Ω is along the normal, z."""
    equations = derive_system(name, NEWTON_EULER)
    stage = stages_of(equations)[f"Free body {body}: forces"]
    zero = equations.derivation.algebra.ring.number(0)
    assert "plus the cross product of Ω and the vector. Listed are Ω," in stage.explanation
    known = listed(stage)
    owner = "tilted" if body == "top" else body
    turning = vector_of(f"Omega_{owner}", known, zero)
    if f"Omega_{owner}" in known:
        turning = Vector(zero, zero, known[f"Omega_{owner}"])
    r, v, a = (vector_of(f"{letter}_{body}", known, zero) for letter in "rva")
    for vector, rate in ((r, v), (v, a)):
        components = Vector(*(x.ddt() for x in vector)) + cross(turning, vector)
        for left, right in zip(rate, components, strict=True):
            assert (left - right).vanishes()


@pytest.mark.parametrize("name", ["cart_pole", "double_pendulum", "atwood_machine"])
def test_axes_that_do_not_turn_have_no_angular_velocity(name: str) -> None:
    text = derive_system(name, NEWTON_EULER).text(steps=True)
    assert "Omega" not in text
    assert "Ω" not in text


def test_a_body_without_angular_momentum_is_in_balance() -> None:
    said = stages_of(derive_system("cart_pole", NEWTON_EULER))["Free body pole: moments"]
    assert said.explanation == "The moments are in balance, all about its center of mass."
    said = stages_of(derive_system("cart_pole", "virtual_work"))["Inertia forces of pole"]
    assert said.explanation.startswith(
        "Without moments of inertia, the pole has the inertia force F_inertia_pole of a particle, "
        "minus its mass times the acceleration of its center of mass."
    )
    assert "Reduced" not in said.explanation
    said = stages_of(derive_system("heavy_top", NEWTON_EULER))["Free body top: moments"]
    assert "both about the joint psi, a fixed point." in said.explanation


def test_reactions_are_inserted_only_where_there_are_any() -> None:
    closing = "the balances along and about the free directions of the joints"
    kepler = derive_system("kepler_orbit", NEWTON_EULER).derivation.closing
    assert kepler == f"T{closing[1:]} are one equation for each velocity, without unknown forces."
    top = derive_system("heavy_top", NEWTON_EULER).derivation.closing
    assert top.startswith(f"With the reactions inserted, {closing} leave one equation")


def test_forces_of_elements_are_said_to_be_theirs() -> None:
    said = stages_of(derive_system("atwood_machine", NEWTON_EULER))["Forces of the elements"]
    assert said.explanation == (
        "Along and about the directions in which their joints are free, bodies receive no "
        "reaction: there their balances give the forces of the cord."
    )


@pytest.mark.parametrize(
    ("fork", "axes"),
    [([mq.ball(1.0, 0.1)], "those of the fork, which do not"), ([], "axes that do not")],
    ids=["heavy", "massless"],
)
def test_a_wheel_turns_about_axes_of_a_fork_that_is_named_if_it_has_mass(
    fork: list[mq.Shape], axes: str
) -> None:
    bodies = (
        mq.Body("ground"),
        mq.Body("fork", *fork),
        mq.Body("wheel", mq.disk(1.3, 0.4).at(rpy=(np.pi / 2, 0.0, 0.0))),
    )
    hinges = (
        mq.Revolute("head", "ground", "fork", axis=(0.0, 0.0, 1.0), coordinate="a"),
        mq.Revolute("hub", "fork", "wheel", axis=(0.0, 1.0, 0.0), coordinate="b"),
    )
    steps = geometry_stages(Kinematics(Algebra(mq.Mechanism("fork", bodies, hinges))))
    (said,) = (step.explanation for step in steps)
    assert said.endswith(f"are those listed: for the wheel along {axes} spin with the wheel.")

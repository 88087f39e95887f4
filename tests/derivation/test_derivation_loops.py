"""Closed mechanisms: by multipliers, in independent coordinates, against closed forms."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from derivation_reading import residual
from systems import CLOSED, derive_system

from mecanique import assemble, textbook
from mecanique.derivation import derive
from mecanique.derivation.equations import Equations
from mecanique.derivation.numeric.constraints.independent import Reduced
from mecanique.derivation.numeric.constraints.multipliers import Constrained, _second_order
from mecanique.derivation.numeric.constraints.rows import Constraints, Held
from mecanique.derivation.numeric.lagrange import LagrangeOnJets
from mecanique.derivation.numeric.recursion import Recursion
from mecanique.derivation.scalars.evaluation import Evaluation
from mecanique.derivation.scalars.jets import Jet
from mecanique.derivation.symbolic.constraints import bonds_of
from mecanique.derivation.symbolic.kinematics import Kinematics
from mecanique.derivation.symbolic.symbols import Algebra
from mecanique.derivation.tolerances import ON_LOOPS
from mecanique.errors import DerivationError
from mecanique.model import (
    Body,
    Coordinates,
    Floating,
    Input,
    JointDamper,
    Loop,
    Mechanism,
    Placement,
    Planar,
    Prismatic,
    Revolute,
    Spherical,
    Spring,
    Universal,
    bar,
    box,
    coordinate,
    rod,
    time,
)
from mecanique.model.states import States
from mecanique.verification.states import random_states

BOXES = (
    Body("ground"),
    *(Body(name, box(mass, (0.1, 0.2, 0.3))) for name, mass in zip("abc", (1, 2, 3), strict=True)),
)


def tied_where_it_stands(
    tree: Mechanism, q: np.ndarray, kind: str, end: tuple[float, float, float] = (0, 0, 0)
) -> Loop:
    """A loop from the ground to a point of the last body, closed in this position."""
    pose = Recursion(tree).poses(States.of(tree, q))[-1][0]
    pose[:3, 3] += pose[:3, :3] @ end
    roll = np.arctan2(pose[2, 1], pose[2, 2])
    pitch = np.arcsin(-pose[2, 0])
    yaw = np.arctan2(pose[1, 0], pose[0, 0])
    there = Placement(tuple(pose[:3, 3]), (roll, pitch, yaw))
    if kind == "distance":
        there = Placement(tuple(pose[:3, 3] + [0.3, 0.4, 0.0]))
    length = 0.5 if kind == "distance" else 0.0
    return Loop("tie", kind, "ground", there, "c", Placement(end), length)  # type: ignore[arg-type]  # parametrized


def roots(equations: Equations, values: dict[str, float]) -> dict[str, float]:
    """Values of the roots that the printed equations name."""
    ring = equations.derivation.algebra.ring
    value = Evaluation(ring, values)
    names = [ring.generators[index].name for index, atom in ring.atoms.items() if atom.named]
    return {name: float(value(ring[name])) for name in names}


def slider_crank(theta: np.ndarray, rate: float) -> States:
    """States of the catalogue's slider-crank on its branch x > 0, by closed form."""
    r, length = 0.5, 1.2
    rod_angle = np.arcsin(-r * np.sin(theta) / length)
    x = r * np.cos(theta) + length * np.cos(rod_angle)
    swing = -r * np.cos(theta) * rate / (length * np.cos(rod_angle))
    speed = -r * np.sin(theta) * rate - length * np.sin(rod_angle) * swing
    q = np.stack([theta, rod_angle - theta, x], axis=-1)
    v = np.stack([np.full_like(theta, rate), swing - rate, speed], axis=-1)
    return States.of(textbook.load("slider_crank"), q, v)


ROWS = {
    "ball": ("x", "y", "z"),
    "hinge": ("x", "y", "z", "rx", "ry"),
    "weld": ("x", "y", "z", "rx", "ry", "rz"),
    "pin": ("x", "y"),
    "plate": ("x", "y", "rz"),
}


@pytest.mark.parametrize("kind", ROWS)
def test_rows_of_a_loop_grow_with_the_motions_that_they_are_named_after(kind: str) -> None:
    """Of body b relative to a, along and about the axes of frame a, as forces on b count."""
    axes = {"x": (1, 0, 0), "y": (0, 1, 0), "z": (0, 0, 1)}
    bodies, joints = [Body("ground")], list[Prismatic | Revolute]()
    for prefix, joint in (("", Prismatic), ("r", Revolute)):
        for name, axis in axes.items():
            child = f"to {prefix}{name}"
            joints.append(joint(f"{prefix}{name}", bodies[-1].name, child, axis=axis))
            bodies.append(Body(child))
    bodies[-1] = Body("to rz", box(1.0, (0.1, 0.2, 0.3)))
    loop = Loop("tie", kind, "ground", Placement(), "to rz", Placement())  # type: ignore[arg-type]
    mechanism = Mechanism("free", tuple(bodies), tuple(joints), loops=(loop,))
    rows = [mechanism.coordinates.index(row) for row in ROWS[kind]]
    here = States.of(mechanism, np.zeros((1, 6)))
    np.testing.assert_array_equal(Held(mechanism).at(here).jacobian[0], np.eye(6)[rows])
    kinematics = Kinematics(Algebra(mechanism))
    (bond,) = bonds_of(kinematics)
    ring = kinematics.algebra.ring
    value = Evaluation(ring, dict.fromkeys(mechanism.coordinates, 0.0))
    slopes = [[float(value(slope)) for slope in tie.slopes(ring)] for tie in bond.ties]
    np.testing.assert_array_equal(slopes, np.eye(6)[rows])
    pushes = [[float(value(x)) for x in (*unit.force, *unit.moment)] for unit in bond.units]
    np.testing.assert_array_equal(pushes, np.eye(6)[rows])


def close_loops(reduced: Reduced, states: States, group: Any) -> tuple[np.ndarray, list[Jet]]:
    """Return the coefficients of the coordinates' jets and the poses, at unit accelerations."""
    paths = reduced._start(states, group)
    free = np.setdiff1d(np.arange(len(paths)), group.dependent)
    paths[free, 2, 0] = 0.5
    return paths, reduced._close(states, paths, 2, group)[1]


def test_coordinates_that_follow_close_the_loops_to_rounding_at_every_order() -> None:
    """From a position that is a hundredth off, with all derivatives by the independent ones."""
    states = slider_crank(np.linspace(0.2, 2.8, 5), 1.7)
    mechanism = states.mechanism
    reduced, held = Reduced(mechanism), Held(mechanism)
    (group,) = reduced._groups(states)
    off = replace(states, q=states.q + 0.01)
    _, poses = close_loops(reduced, off, group)
    for gap in held.gaps(poses):
        np.testing.assert_allclose(gap.c[:, 0], 0, rtol=0, atol=ON_LOOPS)
        np.testing.assert_allclose(gap.c[:, 1:], 0, rtol=0, atol=2e-15)


def test_a_state_on_its_loops_up_to_rounding_is_taken_as_it_is() -> None:
    """Only derivatives by the independent coordinates, and accelerations, follow from the loops."""
    states = slider_crank(np.linspace(0.2, 2.8, 5), 1.7)
    reduced, held = Reduced(states.mechanism), Held(states.mechanism)
    (group,) = reduced._groups(states)
    near = replace(states, q=states.q + 1e-13, v=states.v - 1e-13)
    paths, poses = close_loops(reduced, near, group)
    np.testing.assert_array_equal(paths[:, 0, 0], near.q.T)
    np.testing.assert_array_equal(paths[:, 1, 0], near.v.T)
    for gap in held.gaps(poses):
        np.testing.assert_allclose(gap.c[2], 0, rtol=0, atol=2e-15)
        assert np.abs(gap.c[:2, 0]).max() > 1e-14


@pytest.mark.parametrize("name", ["four_bar_linkage", "slider_crank"])
def test_newtons_iterations_end_at_rounding(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """About seven for each order of the series; without an end at rounding there are 40."""
    states = random_states(textbook.load(name), 5, 0)
    reduced, evaluations = Reduced(states.mechanism), list[int]()
    evaluate = Reduced._evaluate_poses

    def count(*arguments: Any) -> Any:
        evaluations.append(1)
        return evaluate(*arguments)

    monkeypatch.setattr(Reduced, "_evaluate_poses", count)
    reduced.acceleration(states)
    assert 3 < len(evaluations) < 30


def test_the_constraints_of_a_slider_crank_are_those_of_its_closed_form() -> None:
    states = slider_crank(np.linspace(-3, 3, 7), 1.7)
    found = Held(states.mechanism).at(states)
    np.testing.assert_allclose(found.residual, 0, rtol=0, atol=1e-15)
    np.testing.assert_allclose(
        np.einsum("nmv,nv->nm", found.jacobian, states.v), 0, rtol=0, atol=1e-14
    )


def test_multipliers_and_independent_coordinates_agree() -> None:
    states = slider_crank(np.linspace(-3, 3, 41), 1.7)
    mechanism = states.mechanism
    reduced = Reduced(mechanism).acceleration(states)
    for tree in (LagrangeOnJets(mechanism), Recursion(mechanism)):
        found = Constrained(mechanism, tree).motion(states)
        np.testing.assert_allclose(found.acceleration, reduced, rtol=1e-12, atol=1e-12)
        assert found.determined.all()


def test_the_loop_carries_what_newton_asks_of_the_slider() -> None:
    """The pin's force along the line is the slider's m a; the rod pulls along itself."""
    states = slider_crank(np.linspace(0.2, 2.8, 9), 2.5)
    mechanism = states.mechanism
    equations = derive(mechanism)
    a = equations.acceleration(states.q, states.v)
    names = tuple(equations.multipliers(states.q, states.v))
    assert names == ("B: x", "B: y")
    found = Constrained(mechanism, Recursion(mechanism)).motion(states).multipliers
    # body a is the rod; frame a's x-y plane is the plane of motion, turned with the rod
    size = np.linalg.norm(found, axis=1)
    rod_angle = states.q[:, 0] + states.q[:, 1]
    np.testing.assert_allclose(
        size * abs(np.cos(rod_angle)), abs(mechanism.values["m2"] * a[:, 2]), rtol=1e-11, atol=0
    )


@pytest.mark.parametrize("kind", ["hinge", "weld", "plate", "pin", "ball", "distance"])
def test_every_kind_of_loop_agrees_in_both_ways(kind: str) -> None:
    """A chain of planar and universal joints, tied where it stands, with any fitting velocity."""
    joints = (
        Planar("j", "ground", "a", axis=(0, 1, 0), origin=Placement((0.1, 0.2, 0.3))),
        Universal("u", "a", "b", origin=Placement((0.3, 0, 0), (0.1, 0.2, 0.3))),
        Planar("p", "b", "c", origin=Placement((0.3, 0.1, 0), (0.1, 0.2, 0.3))),
    )
    spring = Spring("k", "ground", (1, 1, 1), "c", (0.1, 0.1, 0.1), 7.0, 0.3)
    tree = Mechanism("chain", BOXES, joints, forces=(spring,))
    random = np.random.default_rng(5)
    q = random.uniform(-0.6, 0.6, tree.nq)
    loop = tied_where_it_stands(tree, q, kind)
    mechanism = replace(tree, loops=(loop,))
    here = Held(mechanism).at(States.of(mechanism, q))
    np.testing.assert_allclose(here.residual, 0, rtol=0, atol=1e-14)
    v = random.normal(size=tree.nv)
    v -= np.linalg.pinv(here.jacobian[0]) @ (here.jacobian[0] @ v)
    states = States.of(mechanism, q[None], v[None])
    found = Constrained(mechanism, LagrangeOnJets(mechanism)).motion(states)
    np.testing.assert_allclose(
        Reduced(mechanism).acceleration(states), found.acceleration, rtol=1e-10, atol=1e-10
    )
    after = Held(mechanism).at(states)
    np.testing.assert_allclose(
        after.jacobian[0] @ found.acceleration[0] + after.gamma[0], 0, rtol=0, atol=1e-13
    )


@pytest.mark.parametrize("kind", ["hinge", "weld", "plate", "pin", "ball", "distance"])
def test_joints_with_quaternions_have_independent_coordinates_too(kind: str) -> None:
    joints = (
        Revolute("j", "ground", "a", axis=(0, 1, 0), origin=Placement((0.1, 0.2, 0.3))),
        Floating("f", "a", "b", origin=Placement((0.3, 0, 0), (0.1, 0.2, 0.3))),
        Spherical("s", "b", "c", origin=Placement((0.3, 0.1, 0), (0.1, 0.2, 0.3))),
    )
    a, b = Placement((0.1, 0.2, 0.3)), Placement((0.3, -0.2, 0.3))
    loop = Loop("tie", kind, "ground", a, "c", b, 0.4 if kind == "distance" else 0.0)  # type: ignore[arg-type]  # parametrized
    mechanism = Mechanism(
        "spatial", BOXES, joints, loops=(loop,), forces=(JointDamper("d", "j", 0.3),)
    )
    given = random_states(mechanism, 6, 1, lot=8)
    states = States.of(mechanism, given.q, given.v)
    found = Constrained(mechanism, Recursion(mechanism)).motion(states)
    np.testing.assert_allclose(
        Reduced(mechanism).acceleration(states), found.acceleration, rtol=1e-9, atol=1e-9
    )


@pytest.mark.parametrize("name", CLOSED)
def test_closed_systems_of_the_catalogue_have_accelerations_that_keep_the_loops(name: str) -> None:
    mechanism = textbook.load(name)
    # the starts of the catalogue are rounded
    states = States.of(mechanism, assemble(mechanism, textbook.entry(name).start))
    closed = Held(mechanism).at(states)
    assert abs(closed.residual).max() < 1e-10
    a = derive(mechanism).acceleration(states.q, states.v)
    np.testing.assert_allclose(
        np.einsum("nmv,nv->nm", closed.jacobian, a) + closed.gamma,
        0,
        rtol=0,
        atol=1e-13 * abs(a).max(),
    )
    np.testing.assert_allclose(
        Reduced(mechanism).acceleration(states), a, rtol=1e-10, atol=1e-10 * abs(a).max()
    )


def test_the_published_start_of_the_squeezer() -> None:
    """Hairer & Wanner, Solving ODEs II, sect. VII.7: accelerations and multipliers at the start."""
    mechanism = textbook.load("squeezer")
    a = derive(mechanism).acceleration(textbook.entry("squeezer").start, None)
    at = dict(zip(mechanism.coordinates, a, strict=True))
    assert at["beta"] == pytest.approx(14222.4439199541138705911625887, rel=1e-12)
    assert at["theta"] == pytest.approx(-10666.8329399655854029433719415, rel=1e-12)
    assert [at[name] for name in ("gamma", "phi", "delta", "omega", "epsilon")] == pytest.approx(
        [0] * 5, abs=1e-6
    )


def test_a_doubled_loop_moves_the_same_and_says_what_is_undetermined() -> None:
    states = slider_crank(np.array([0.7]), 1.0)
    mechanism = states.mechanism
    twice = replace(
        mechanism, loops=(mechanism.loops[0], replace(mechanism.loops[0], name="again"))
    )
    found = Constrained(twice, Recursion(twice)).motion(States.of(twice, states.q, states.v))
    once = Constrained(mechanism, Recursion(mechanism)).motion(states)
    np.testing.assert_allclose(found.acceleration, once.acceleration, rtol=1e-12, atol=0)
    np.testing.assert_allclose(
        found.multipliers, np.tile(once.multipliers / 2, 2), rtol=1e-10, atol=1e-12
    )
    assert not found.determined.any()
    np.testing.assert_allclose(
        Reduced(twice).acceleration(States.of(twice, states.q, states.v)),
        once.acceleration,
        rtol=1e-14,
        atol=0,
    )


def test_forms_of_second_order_give_gamma_along_free_directions() -> None:
    mechanism, rng = textbook.load("squeezer"), np.random.default_rng(4)
    state = random_states(mechanism, 1, 0)
    free, w = rng.normal(size=(mechanism.nv, 3)), rng.normal(size=3)
    forms = _second_order(state, free, Held(mechanism).at)
    moving = replace(state, v=(free @ w)[None])
    expected = Held(mechanism).at(moving).gamma[0]
    found = np.einsum("mkl,k,l->m", forms, w, w)
    np.testing.assert_allclose(found, expected, rtol=1e-10, atol=1e-12)


def test_what_prescribed_motions_add_is_in_no_form_of_second_order() -> None:
    """γ = vᵀ S v + L v + γ₀: the forms are those of S, whatever moves with time."""
    mechanism, rng = textbook.load("squeezer"), np.random.default_rng(7)
    nv, state = mechanism.nv, random_states(mechanism, 1, 0)
    S, L, rest = rng.normal(size=(2, nv, nv)), rng.normal(size=(2, nv)), rng.normal(size=2)

    def at(states: States) -> Constraints:
        gamma = np.einsum("mij,ni,nj->nm", S, states.v, states.v) + states.v @ L.T + rest
        return Constraints(gamma, np.zeros((len(gamma), 2, nv)), gamma, gamma, [])

    free = rng.normal(size=(nv, 3))
    expected = free.T @ ((S + S.swapaxes(1, 2)) / 2) @ free
    np.testing.assert_allclose(_second_order(state, free, at), expected, rtol=1e-10, atol=1e-10)


def test_a_driven_crank_is_rheonomic() -> None:
    """With θ = 0.7 + 2 t by an input, the slider moves as that of a crank at constant speed."""
    mechanism = textbook.load("slider_crank")
    signal = Input("turn", 2.0 * time() + 0.7)
    driven = replace(
        mechanism, coordinates=Coordinates((), {"theta": coordinate("turn")}), inputs=(signal,)
    )
    t = 0.3
    free = slider_crank(np.array([0.7 + 2 * t]), 2.0)
    theta, r, length = free.q[0, 0], 0.5, 1.2
    root = np.sqrt(length**2 - (r * np.sin(theta)) ** 2)
    second = -4 * (
        r * np.cos(theta)
        + r**2 * np.cos(2 * theta) / root
        + (r**2 * np.sin(2 * theta) / 2) ** 2 / root**3
    )
    states = States.of(driven, free.q[:, 1:], free.v[:, 1:], np.array([t]))
    for found in (
        Constrained(driven, Recursion(driven)).motion(states).acceleration,
        Reduced(driven).acceleration(states),
    ):
        assert found[0, 1] == pytest.approx(second, rel=1e-12)


@pytest.mark.parametrize("name", [name for name in CLOSED if name != "bricard_linkage"])
def test_printed_equations_with_multipliers_hold_on_the_loops(name: str) -> None:
    """Some multipliers satisfy all printed lines, with accelerations in independent coordinates."""
    mechanism = textbook.load(name)
    equations = derive(mechanism)
    given = random_states(mechanism, 3, 2, equations.derivation.assumptions, lot=8)
    unknown = [f"lambda_{tie.name}" for tie in equations.derivation.ties]
    for k in range(3):
        states = States.of(mechanism, given.q[k], given.v[k])
        a = Reduced(mechanism).acceleration(states)[0]
        known: dict[str, float] = {**{n: float(np.ravel(x)[0]) for n, x in states.values.items()}}
        known |= {f"{n}'": float(x) for n, x in zip(mechanism.velocities, a, strict=True)}
        known |= roots(equations, known)
        lines = equations.text().splitlines()

        def at(
            multipliers: np.ndarray, lines: list[str] = lines, known: dict[str, float] = known
        ) -> np.ndarray:
            return np.array(
                [
                    residual(line, known | dict(zip(unknown, multipliers, strict=True)))
                    for line in lines
                ]
            )

        rest = at(np.zeros(len(unknown)))
        columns = np.stack([at(one) - rest for one in np.eye(len(unknown))], axis=1)
        found = np.linalg.lstsq(columns, -rest, rcond=None)[0]
        size = np.abs(columns * found).sum(axis=1) + np.abs(rest)
        np.testing.assert_allclose(at(found) / np.maximum(size, 1.0), 0.0, rtol=0, atol=1e-11)


def test_the_printed_multipliers_are_the_force_of_the_loop() -> None:
    lines = derive_system("slider_crank").text().splitlines()
    assert lines[2:] == [
        "m2 x'' - lambda_B_x = 0",
        "x - r cos(theta) - l cos(theta + beta) = 0",
        "r sin(theta) + l sin(theta + beta) = 0",
    ]
    steps = derive_system("slider_crank").text(steps=True)
    assert steps.startswith("Slider crank: Lagrange's equations with multipliers")
    said = (
        "force of the rod on the slider in the loop B, x and z components in the axes of the world"
    )
    assert f"  lambda_B_x, lambda_B_z\n    {said} [N]\n" in steps
    assert "∂V/∂q = Σ λ ∂Φ/∂q for every" in steps
    assert "     cos(theta + beta) lambda_B_z = sin(theta + beta) lambda_B_x\n" in steps
    # the force is along the rod: in closed form its components differ by sine for cosine alone
    *_, along, across, _ = (line.strip() for line in steps.splitlines())
    along = along.replace("lambda_B_x", "lambda_B_z").replace(
        ") cos(theta + beta)/", ") sin(theta + beta)/"
    )
    assert across == along
    assert across.startswith("lambda_B_z = -m1 m2 (2 l (theta' + beta')^2 + 3 g sin(beta)")


def test_the_axes_of_a_pin_in_the_vertical_plane_are_those_of_the_world() -> None:
    frame = Loop.pin("p", "a", (1, 0, 0), "b", (0, 0, 1)).frame_a
    assert np.array(frame.rotation, dtype=float) == pytest.approx(
        np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]]), abs=1e-15
    )
    for normal in ((0.0, 0.0, 1.0), (0.6, 0.0, -0.8), (0.48, -0.6, 0.64)):
        tilted = Loop.plate("p", "a", (1, 0, 0), "b", (0, 0, 1), normal).frame_b
        z = [row[2] for row in tilted.rotation]
        assert z == pytest.approx(normal, abs=1e-15)
    text = derive_system("bars_and_springs", "newton_euler").text(steps=True)
    said = "force that CF exerts on DEF in F, along x and z of the world [N]"
    assert f"  R_F_x, R_F_z\n    {said}\n" in text


@pytest.mark.parametrize("kind", ["hinge", "weld", "plate", "pin", "ball", "distance"])
def test_loops_of_every_kind_have_closed_forms_that_close_the_same_directions(kind: str) -> None:
    joints = (
        Revolute("j", "ground", "a", axis=(0, -1, 0)),
        Prismatic("s", "a", "b", axis=(1, 0, 0), origin=Placement((0.3, 0.2, 0))),
        Universal("u", "b", "c", origin=Placement((0.3, 0.1, 0))),
    )
    q = np.array([0.4, 0.1, -0.3, 0.5])
    there = tied_where_it_stands(Mechanism("out", BOXES, joints), q, kind, (0.1, 0.2, -0.3))
    mechanism = replace(Mechanism("out", BOXES, joints), loops=(there,))
    equations = derive(mechanism)
    assert equations.symbolic, equations.why_not
    states = States.of(mechanism, q)
    algebra, ties = equations.derivation.algebra, equations.derivation.ties
    value = Evaluation(algebra.ring, states.values)
    np.testing.assert_allclose([value(tie.demand) for tie in ties], 0.0, rtol=0, atol=1e-14)
    ours = np.array(
        [[float(np.ravel(value(x))[0]) for x in algebra.ring.along(tie.demand)] for tie in ties]
    )
    theirs = Held(mechanism).at(states).jacobian[0]
    assert len(ours) <= len(theirs)  # what holds identically is left out
    for one, other in ((ours, theirs), (theirs, ours)):
        reached = one.T @ np.linalg.lstsq(one.T, other.T, rcond=1e-12)[0]
        np.testing.assert_allclose(reached, other.T, rtol=0, atol=1e-13)


def test_what_cannot_be_done_is_said() -> None:
    mechanism = textbook.load("slider_crank")
    blind = replace(mechanism, inputs=(Input("F", lambda t: t),))
    with pytest.raises(
        DerivationError, match="input 'F' is a function, which has no exact derivatives"
    ):
        Reduced(blind)
    loose = Mechanism(
        "loose",
        (
            Body("ground"),
            Body("a", bar(1.0, (1, 0, 0))),
            Body("b", bar(1.0, (1, 0, 0))),
            Body("c", rod(1.0, 1.0)),
        ),
        (
            Revolute("A", "ground", "a", axis=(0, -1, 0)),
            Revolute("B", "a", "b", axis=(0, -1, 0), origin=Placement((1, 0, 0))),
            Revolute("D", "ground", "c", axis=(0, -1, 0)),
        ),
        loops=(Loop.distance("tie", "ground", (1, 0, 1), "b", (1, 0, 0), 1.0),),
    )
    with pytest.raises(
        DerivationError, match=r"loops allow a motion of .*[AB]'.* without inertia; give a body"
    ):
        derive(loose).acceleration([0.0, np.pi / 2 - 0.5, 0.0], [0.0, 0.0, 0.0])

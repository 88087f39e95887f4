"""Signs, factors and choices that agreement between derivations does not show."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
import pytest
import sympy
from scipy.spatial.transform import Rotation
from systems import derive_system

from mecanique import textbook
from mecanique.derivation import derive
from mecanique.derivation.laws import Elastic, Viscous
from mecanique.derivation.methods import METHODS
from mecanique.derivation.numeric.lagrange import LagrangeOnJets
from mecanique.derivation.numeric.newton_euler import Balances
from mecanique.derivation.numeric.recursion import Recursion
from mecanique.derivation.numeric.virtual_work import NumericVirtualWork
from mecanique.derivation.scalars.elementary import cos, sin
from mecanique.derivation.scalars.evaluation import Evaluation
from mecanique.derivation.scalars.polynomials import REACH, exponent, exponents, power
from mecanique.derivation.symbolic.balances import FreeBodies
from mecanique.derivation.symbolic.cutting import Cuts, axes_of, find_swing, normal_of
from mecanique.derivation.symbolic.kinematics import Kinematics
from mecanique.derivation.symbolic.newton_euler import NewtonEuler
from mecanique.derivation.symbolic.symbols import Algebra
from mecanique.errors import DerivationError
from mecanique.model import (
    Body,
    Coordinates,
    Fixed,
    Floating,
    Gear,
    Joint,
    JointForce,
    Loop,
    Mechanism,
    Parameter,
    Placement,
    Prismatic,
    Rack,
    Revolute,
    Shape,
    Spherical,
    Torque,
    ball,
    box,
    coordinate,
    disk,
    particle,
)
from mecanique.model.states import States
from mecanique.reference import Reference
from mecanique.verification import verify
from mecanique.verification.states import random_states


def test_moments_are_taken_about_the_center_of_mass_of_a_body_that_moves_freely() -> None:
    """The second bar of the double pendulum: Ḣ_C = −m l²/12 q₂'' about y, R with the arm l/2."""
    by_hand = NewtonEuler(textbook.load("double_pendulum"))
    cut = by_hand.cuts.bodies[1]
    ring = by_hand.algebra.ring
    m, length, q, a, x, z = (ring[n] for n in ("m2", "l2", "q2", "q2''", "R_pin2_x", "R_pin2_z"))
    assert not cut.fixed
    assert cut.about_reference(cut.push).moment[1] == -m * length**2 * a / 12
    assert by_hand.balances.acting(cut).moment[1] == length * (z * sin(q) + x * cos(q)) / 2


def test_inertia_forces_of_a_rod_act_at_two_thirds_and_leave_no_couple() -> None:
    text = derive_system("rigid_bar_pendulum", "virtual_work").text(steps=True)
    assert "δr_inertia_rod_t = 2 l δq/3" in text
    assert "δW_inertia_rod = -m l^2 q'' δq/3" in text
    assert "δW_couple" not in text
    assert "\n     δW_q = " in text
    assert "the inertia forces where their resultant acts, at the distance s_rod" in " ".join(
        text.split()
    )


def test_a_rotor_takes_its_part_of_the_moment_about_its_joint() -> None:
    """Moment less Ḣ is −((m l²/3 + I) q'' + m g l/2 sin q) for a rod on a geared motor's shaft."""
    pendulum = textbook.load("rigid_bar_pendulum")
    inertia = Parameter("I", 0.3, "kg*m^2")
    (joint,) = pendulum.joints
    assert isinstance(joint, Revolute)
    driven = replace(
        pendulum,
        joints=(replace(joint, armature=inertia),),
        parameters=(*pendulum.parameters, inertia),
    )
    by_hand = NewtonEuler(driven)
    (cut,) = by_hand.cuts.bodies
    m, length, g, rotor, q, a = (
        by_hand.algebra.ring[name] for name in ("m", "l", "g", "I", "q", "q''")
    )
    about_k = by_hand.balances.acting_along(cut).moment[2]
    rate = m * length**2 * a / 3
    assert about_k == -rotor * a - m * g * length * sin(q) / 2
    assert by_hand.derivation().rows == (rate - about_k,)


@pytest.mark.parametrize("method", [LagrangeOnJets, Recursion, Balances, NumericVirtualWork])
def test_a_rotor_behind_a_gear_of_varying_ratio(
    method: Callable[[Mechanism], LagrangeOnJets | Recursion | Balances | NumericVirtualWork],
) -> None:
    """φ = x² turns I + J: T = ½ (I + J) (2 x x')², so M = 4 (I + J) x², bias = 4 (I + J) x x'²."""
    flywheel = disk(2.0, 0.5)
    J = 0.5 * 2.0 * 0.5**2
    mechanism = Mechanism(
        "flywheel",
        bodies=(Body("ground"), Body("wheel", flywheel)),
        joints=(
            Revolute("shaft", "ground", "wheel", axis=(0, 0, 1), coordinate="phi", armature=0.3),
        ),
        coordinates=Coordinates(("x",), {"phi": coordinate("x") ** 2}),
    )
    x, v = np.array([0.7, -1.3]), np.array([1.1, 2.0])
    states = States.of(mechanism, x[:, None], v[:, None], np.zeros(2))
    ours = method(mechanism)
    np.testing.assert_allclose(
        ours.mass_matrix(states)[:, 0, 0], 4 * (J + 0.3) * x**2, rtol=1e-14, atol=0
    )
    np.testing.assert_allclose(
        ours.bias(states)[:, 0], 4 * (J + 0.3) * x * v**2, rtol=1e-14, atol=0
    )
    np.testing.assert_allclose(
        ours.energy(states)[0], 2 * (J + 0.3) * (x * v) ** 2, rtol=1e-14, atol=0
    )


def test_floats_that_stand_for_roots_are_recognized_by_their_relative_distance() -> None:
    algebra = Algebra(textbook.load("rigid_bar_pendulum"))
    assert algebra.number(30 * 2**0.5) ** 2 == algebra.number(1800)
    assert algebra.number(0.05 * 2**0.5) ** 2 == algebra.number(0.005)
    assert algebra.number(0.05 * 2**0.5 * (1 + 1e-13)) ** 2 != algebra.number(0.005)


TURN = Revolute("turn", "ground", "one", axis=(0, 1, 0))
TURN_ON = Revolute("on", "one", "two", axis=(0, 1, 0))
BODIES = (Body("ground"), Body("one", ball(1.0, 0.1)), Body("two", ball(1.0, 0.1)))


@pytest.mark.parametrize(
    ("joints", "normal"),
    [
        ((TURN, Prismatic("slide", "one", "two", axis=(1, 0, 0))), (0, 1, 0)),
        ((TURN, Prismatic("slide", "one", "two", axis=(0, 1, 0))), None),
        ((TURN, Revolute("other", "one", "two", axis=(0, -1, 0))), (0, 1, 0)),
        ((TURN, Revolute("other", "one", "two", axis=(1, 0, 0))), None),
        ((Spherical("ball", "ground", "one"), TURN_ON), None),
        ((Prismatic("in", "ground", "one"), Prismatic("out", "one", "two")), (0, 0, 1)),
        ((TURN, replace(TURN_ON, origin=Placement(rpy=(np.pi / 2, 0, 0)))), None),
        ((TURN, replace(TURN_ON, origin=Placement(rpy=(0, np.pi / 2, 0)))), (0, 1, 0)),
    ],
)
def test_a_plane_of_motion_has_all_turns_along_its_normal_and_all_slides_across(
    joints: tuple[Joint, ...], normal: tuple[int, int, int] | None
) -> None:
    found = normal_of(Kinematics(Algebra(Mechanism("two", BODIES, joints))))
    assert (found is None) == (normal is None)
    if found is not None and normal is not None:
        np.testing.assert_allclose(found, normal, rtol=0, atol=1e-15)


@pytest.mark.parametrize(("name", "planar"), [("rigid_bar_pendulum", True), ("two_blocks", False)])
def test_what_only_slides_has_no_plane_whose_normal_angles_are_about(
    name: str, planar: bool
) -> None:
    assert Cuts(Kinematics(Algebra(textbook.load(name)))).planar is planar


@pytest.mark.parametrize(
    ("axis", "center"),
    [((0.6, 0.8, 0.0), (0.0, 0.0, -1.0)), ((0.0, 1.0, 0.0), (0.6, 0.0, -0.8))],
    ids=["slanted axis", "slanted arm"],
)
def test_a_pendulum_off_its_own_axes_has_no_normal_and_tangent_along_them(
    axis: tuple[float, float, float], center: tuple[float, float, float]
) -> None:
    pin = Revolute("pin", "ground", "bob", axis=axis)

    def swing(pin: Revolute, center: tuple[float, float, float]) -> object:
        bodies = (Body("ground"), Body("bob", particle(1.0).at(xyz=center)))
        return find_swing(Mechanism("pendulum", bodies, (pin,)), "bob")

    assert swing(pin, center) is None
    upright = replace(pin, axis=(0.0, 1.0, 0.0))
    # where along its axis the pin stands does not matter
    for aside in (0.0, 0.4, -0.9):
        assert swing(upright, (0.0, aside, -1.3)) == (upright, (0.0, 0.0, -1.0), (-1.0, 0.0, 0.0))


def test_a_particle_has_no_angular_velocity_to_be_listed() -> None:
    text = derive_system("simple_pendulum").text(steps=True)
    assert "v_bob_x" in text
    assert "omega_bob" not in text


def test_axes_of_a_body_that_never_turns_are_the_worlds_unless_it_stands_turned() -> None:
    """In space; in the plane all bodies share the axes of the world."""
    bodies = (*(Body(name) for name in ("ground", "sled", "ramp")), Body("arm", ball(1.0, 0.1)))
    joints = (
        Prismatic("slide", "ground", "sled", axis=(1, 0, 0)),
        Fixed("weld", "sled", "ramp", origin=Placement(rpy=(0, 0, np.pi / 2))),
        Revolute("pin", "ramp", "arm", axis=(0, 1, 0)),
    )
    kinematics = Kinematics(Algebra(Mechanism("in space", bodies, joints)))
    named = {body: axes_of(kinematics, body, None) for body in ("sled", "ramp", "arm")}
    assert {body: set(axes.whose.values()) for body, axes in named.items()} == {
        "sled": {"the world"},
        "ramp": {"ramp"},
        "arm": {"ramp"},  # a ball about its center
    }
    assert named["sled"].sentence.startswith("x, y and z are the axes of the world; moments")
    assert named["arm"].sentence.startswith(
        "x, y and z are the axes of the ramp, which do not spin"
    )
    plane = axes_of(kinematics, "ramp", np.array([0.0, -1.0, 0.0]))
    assert plane.sentence == (
        "x and z are the axes of the world; forces are positive along them, moments about -y."
    )


def test_a_torque_on_the_ground_does_no_work() -> None:
    pendulum = textbook.load("rigid_bar_pendulum")
    pushed = replace(pendulum, forces=(Torque("idle", "ground", (1.0, 2.0, 3.0)),))
    for method in ("lagrange", "newton_euler", "virtual_work"):
        assert derive(pushed, method).text() == derive(pendulum, method).text()


def geared_arm() -> Mechanism:
    """The two-link arm with a rotor in its elbow."""
    arm, inertia = textbook.load("two_link_arm"), Parameter("I", 0.3, "kg*m^2")
    shoulder, elbow = arm.joints
    assert isinstance(elbow, Revolute)
    joints = (shoulder, replace(elbow, armature=inertia))
    return replace(arm, joints=joints, parameters=(*arm.parameters, inertia))


@pytest.mark.parametrize(
    "name", ["rigid_bar_pendulum", "double_pendulum", "cart_pole", "gyroscope", "geared arm"]
)
def test_the_balances_of_every_body_hold_as_they_are_written(name: str) -> None:
    """Forces and moments with all reactions equal the rates of momentum, axis by axis."""
    mechanism = geared_arm() if name == "geared arm" else textbook.load(name)
    by_hand, some = NewtonEuler(mechanism), random_states(mechanism, 3, 0)
    states = States.of(mechanism, some.q, some.v, some.t)
    algebra, a = by_hand.algebra, Balances(mechanism).acceleration(states)
    values = states.values | dict(zip(algebra.accelerations, a.T, strict=True))
    reactions = dict(by_hand.derivation().reactions)
    evaluated = Evaluation(algebra.ring, values)
    values |= {reaction: evaluated(series) for reaction, series in reactions.items()}
    evaluated = Evaluation(algebra.ring, values)
    balances = by_hand.balances
    for cut in by_hand.cuts.bodies:
        acting = balances.acting_along(cut)
        changing = cut.axes.along(cut.about_reference(cut.push))
        pairs = (acting.force, changing.force), (acting.moment, changing.moment)
        for one, other in (sides for pair in pairs for sides in zip(*pair, strict=True)):
            np.testing.assert_allclose(evaluated(one), evaluated(other), rtol=0, atol=1e-12)


def test_roots_and_products_of_constants_are_numbers_of_the_ring() -> None:
    algebra = Algebra(textbook.load("rigid_bar_pendulum"))
    assert algebra.number(sympy.sqrt(2)) ** 2 == algebra.number(2)
    assert algebra.number(sympy.sqrt(3) * sympy.pi) == (
        algebra.number(sympy.pi) * algebra.number(sympy.sqrt(3))
    )
    assert algebra.number(1 / sympy.pi) * algebra.number(sympy.pi) == algebra.number(1)


def test_a_series_knows_whether_it_is_a_number() -> None:
    ring = Algebra(textbook.load("rigid_bar_pendulum")).ring
    assert ring.number(0).is_number
    assert ring.number(1.5).is_number
    assert not ring["m"].is_number
    assert not (ring["m"] + 1).is_number
    assert not cos(ring["q"]).is_number


def test_monomials_keep_exponents_apart_up_to_the_reach() -> None:
    for k in (1, -1, REACH, -REACH):
        assert list(exponents(power(0, k) + power(2, -k))) == [(0, k), (2, -k)]
        assert [exponent(power(0, k) + power(2, -k), i) for i in range(3)] == [k, 0, -k]
    ring = Algebra(textbook.load("rigid_bar_pendulum")).ring
    assert (ring["m"] ** REACH).diff("m") == REACH * ring["m"] ** (REACH - 1)
    with pytest.raises(DerivationError, match=f"beyond ±{REACH}"):
        ring["m"] ** (REACH + 1)


@dataclass
class Stretched:
    """A distance x that grows at a rate, as what a force acts along."""

    x: float
    rate: float = 0.0
    name: str = "distance"

    @property
    def values(self) -> dict[str, float]:
        return {self.name: self.x}

    @property
    def square(self) -> float:
        return self.x**2

    def direct(self, slope: float | None, size: float | None) -> float:
        return (slope or 0.0) * self.x + (size or 0.0)


@pytest.mark.parametrize("rest", [0.0, 0.7])
def test_a_spring_pulls_as_its_potential_rises(rest: float) -> None:
    law, h = Elastic(50.0, rest), 1e-4
    assert law.scalar(Stretched(0.9)) == pytest.approx(25.0 * (0.9 - rest) ** 2, rel=1e-14)
    slope = (law.scalar(Stretched(0.9 + h)) - law.scalar(Stretched(0.9 - h))) / (2 * h)
    assert law.pull(Stretched(0.9)) == pytest.approx(slope, rel=1e-9)


def test_a_damper_pulls_as_rayleighs_function_rises_with_the_rate() -> None:
    law, h = Viscous(3.0), 1e-4
    assert law.scalar(Stretched(0.9, -2.0)) == 6.0
    slope = (law.scalar(Stretched(0.9, -2 + h)) - law.scalar(Stretched(0.9, -2 - h))) / (2 * h)
    assert law.pull(Stretched(0.9, -2.0)) == pytest.approx(slope, rel=1e-9) == -6.0


def test_energies_of_bodies_are_written_where_there_is_more_than_one() -> None:
    assert "T_rod = " not in derive_system("rigid_bar_pendulum").text(steps=True)
    assert "T_rod1 = " in derive_system("double_pendulum").text(steps=True)


def test_a_rod_drawn_aslant_is_no_rod_along_an_axis() -> None:
    """What is drawn decides where along a rod its inertia forces lie."""
    pendulum = textbook.load("rigid_bar_pendulum")
    ground, rod = pendulum.bodies
    assert "s_rod" in derive(pendulum, "virtual_work").text(steps=True)
    (visual,) = rod.visuals
    slanted = replace(visual, placement=Placement(visual.placement.xyz, (0.0, 0.3, 0.0)))
    drawn = Body("rod", Shape(rod.mass, rod.center, rod.inertia, (slanted,)))
    text = derive(replace(pendulum, bodies=(ground, drawn)), "virtual_work").text(steps=True)
    assert "s_rod" not in text


def on_a_stand(joint: Fixed | Revolute) -> Mechanism:
    height = Parameter("h", 2.0, "m")
    return Mechanism(
        "stand",
        (Body("ground"), Body("stand"), Body("top", ball(1.0, 0.1).at((0, 0, 1)))),
        (joint, Spherical("socket", "stand", "top", origin=Placement((0, 0, height)))),
        parameters=(height,),
    )


def test_a_ball_joint_may_stand_on_what_is_at_rest_only() -> None:
    Kinematics(Algebra(on_a_stand(Fixed("weld", "ground", "stand"))))
    hinged = on_a_stand(Revolute("hinge", "ground", "stand", axis=(0, 1, 0)))
    with pytest.raises(DerivationError, match="'socket' turns by a quaternion on a body th"):
        Kinematics(Algebra(hinged))


@pytest.mark.parametrize("method", METHODS)
def test_a_rotor_turns_as_its_joint_does_where_the_coordinate_is_another(method: str) -> None:
    """With theta = 2 s the rotor's energy is 2 J s'^2 and 4 J s'' in s; the equation is halved."""
    pendulum = textbook.load("rigid_bar_pendulum")
    (pin,) = pendulum.joints
    assert isinstance(pin, Revolute)
    rotor = Parameter("J", 0.7, "kg·m²")
    half = replace(
        pendulum,
        joints=(replace(pin, coordinate="theta", armature=rotor),),
        coordinates=Coordinates(("s",), {"theta": 2 * coordinate("s")}),
        parameters=(*pendulum.parameters, rotor),
    )
    assert str(derive(half, method)) == "2 (m l^2 + 3 J) s'' + 3 m g l sin(s) cos(s) = 0"


@pytest.mark.parametrize("method", METHODS)
def test_a_free_body_is_carried_by_a_slide(method: str) -> None:
    """A Floating joint moves relative to its parent: the parent's velocity adds to its own."""
    cart = Body("cart", box(2.0, (0.3, 0.2, 0.1)))
    dice = Body("dice", box(0.7, (0.1, 0.2, 0.4)).at((0.1, 0.0, 0.2)))
    slide = Prismatic("slide", "ground", "cart", axis=(0.6, 0.0, 0.8), coordinate="x")
    joint = Floating("root", "cart", "dice", origin=Placement((0.1, 0.2, 0.3), (0.4, 0.1, 0.0)))
    bodies = (Body("ground"), cart, dice)
    mechanism = Mechanism("carried", bodies, (slide, joint), gravity=(0, 0, -9.81))
    derivation = derive(mechanism, method).derivation
    reference = Reference(mechanism)
    random = np.random.default_rng(4)
    q, v, a = mechanism.neutral(), *random.normal(size=(2, mechanism.nv))
    turn = random.normal(size=4)
    q[:4], q[4:] = random.normal(size=4), turn / np.linalg.norm(turn)
    names = (*mechanism.coordinates, *mechanism.velocities, *derivation.algebra.accelerations)
    values = dict(zip(names, np.concatenate([q, v, a]).tolist(), strict=True))
    evaluate = Evaluation(derivation.algebra.ring, values)
    needed = [
        sum(evaluate(m) * x for m, x in zip(row, a, strict=True)) + evaluate(h) - evaluate(Q)
        for row, h, Q in zip(derivation.M, derivation.h, derivation.Q, strict=True)
    ]
    np.testing.assert_allclose(needed, reference.inverse_dynamics(q, v, a), rtol=0, atol=1e-12)
    assert verify(mechanism, 5).agrees
    text = " ".join(derive(mechanism, method).text(steps=True).split())
    assert (
        "x component of the velocity of the dice relative to the cart, in its own axes [m/s]"
        in text
    )
    assert "z coordinate of the dice relative to the cart [m]" in text
    assert "axes of the world. Both are relative to the cart, which carries the dice." in text


def test_a_length_is_positive_where_all_coordinates_are_zero() -> None:
    """As a series √((a − b)²) is a − b or b − a, by the numbers of a and b."""
    for a, b in ((0.3, 0.5), (0.5, 0.3)):
        lengths = Parameter("a", a, "m"), Parameter("b", b, "m")
        pendulum = textbook.load("rigid_bar_pendulum")
        longer = replace(pendulum, parameters=(*pendulum.parameters, *lengths))
        algebra = Algebra(longer)
        apart = algebra.ring["a"] - algebra.ring["b"]
        assert algebra.root(apart**2) == (apart if a > b else -apart)
        assert algebra.at_rest(algebra.root(apart**2 * 4 + 0)) == pytest.approx(0.4, rel=1e-14)


@pytest.mark.parametrize("scale", [1e-5, 1.0, 1e5])
def test_forces_of_teeth_do_not_depend_on_the_unit_of_length(scale: float) -> None:
    """Both driven shafts turn at 25 rad/s²: 2.5 N and 10 N across the radii, over cos 20°."""
    r, R, far, about = 0.1 * scale, 0.2 * scale, Placement((scale, 0, 0)), (0, -1, 0)

    def wheel(name: str, mass: float, radius: float) -> Body:
        return Body(name, disk(mass, radius).at(rpy=(np.pi / 2, 0, 0)))

    rail = Placement((scale, 0, -R))
    mechanism = Mechanism(
        "teeth",
        (
            *(Body("ground"), Body("rack", particle(2.0))),
            *(wheel("a", 3.0, R), wheel("b", 1.0, r), wheel("pinion", 2.0, R)),
        ),
        (
            Revolute("A", "ground", "a", axis=about),
            Revolute("B", "ground", "b", axis=about, origin=Placement((r + R, 0, 0))),
            Revolute("P", "ground", "pinion", axis=about, origin=far),
            Prismatic("S", "ground", "rack", axis=(1, 0, 0), origin=rail),
        ),
        forces=(
            JointForce("drive", "A", 2.0 * scale**2),
            JointForce("other drive", "P", 3.0 * scale**2),
        ),
        coordinates=Coordinates((), {"B": -2 * coordinate("A"), "S": R * coordinate("P")}),
        elements=(Gear("mesh", "A", "B", R, other_radius=r), Rack("teeth", "P", "S", R)),
    )
    size = scale / np.cos(np.radians(20))
    expected = pytest.approx({"mesh": 2.5 * size, "teeth": 10.0 * size}, rel=1e-12)
    assert derive(mechanism, "newton_euler").guide_forces([0.3, 0.2]) == expected
    assert Reference(mechanism).guide_forces([0.3, 0.2]) == expected


TURNS = {
    str(turn.as_matrix().round().astype(int).T.tolist()): (x, y, z)
    for x, y, z in product((0.0, np.pi / 2, np.pi, -np.pi / 2), repeat=3)
    for turn in [Rotation.from_euler("xyz", (x, y, z))]
}
"""Angles of the 24 turns that lead axes into axes, by the turned axes."""


@pytest.mark.parametrize("turned", TURNS)
def test_forces_of_a_loop_are_named_by_the_axes_of_the_world_where_all_lie_along_them(
    turned: str,
) -> None:
    rows, frame = np.array(json.loads(turned)), Placement(rpy=TURNS[turned])
    ground, bodies = "ground", (Body("bob", ball(1.0, 0.1)), Body("cart", ball(1.0, 0.1)))
    mechanism = Mechanism(
        "tied",
        (Body(ground), *bodies),
        tuple(
            Prismatic(name, ground, body.name, axis=(1, 0, 0))
            for name, body in zip("xu", bodies, strict=True)
        ),
        coordinates=Coordinates(("u",), {"x": sympy.Integer(0)}),
        elements=(Loop("tie", "ball", ground, frame, "bob", Placement()),),
    )
    named = FreeBodies(mechanism, Algebra(mechanism)).guiding.meanings
    along = ["-" * int(row.min() < 0) + "xyz"[np.abs(row).argmax()] for row in rows]
    names = along if (rows >= 0).all() else [*"xyz"]
    said = "force that the ground exerts on the bob in the tie, along"
    assert named == {
        f"R_tie_{name}": f"{said} {axis} of the world [N]"
        for name, axis in zip(names, along, strict=True)
    }

"""Potentials of joints and of distances: both sides of the wall, motions, files and refusals."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import mecanique as mq
from mecanique.derivation.printing.equations import expression
from mecanique.derivation.symbolic.forces import stored_in_loads
from mecanique.motion.inertial import on_turning_earth

M = mq.Parameter("m", 2.0, "kg")
K = mq.Parameter("k", 3.0, "N/m")
B = mq.Parameter("b", 5.0, "N/m³")
D = mq.Parameter("D", 3.0, "J", "depth of the well")
A = mq.Parameter("a", 0.8, "m")
G = mq.Parameter("G", 0.7, "N·m²/kg²")
X = mq.coordinate("x")


def duffing(*forces: mq.AnyForce) -> mq.Mechanism:
    """A block on a slide; by default in Duffing's potential."""
    well = mq.Potential("well", "slide", K * X**2 / 2 + B * X**4 / 4)
    return mq.Mechanism(
        "duffing",
        (mq.Body("ground"), mq.Body("block", mq.particle(M))),
        (mq.Prismatic("slide", "ground", "block", axis=(1, 0, 0), coordinate="x"),),
        forces=forces or (well,),
        parameters=(M, K, B),
        gravity=(0, 0, 0),
    )


def slides(letters: str, body: str) -> tuple[mq.Prismatic, ...]:
    """Three slides that carry a body along x, y and z."""
    stations = ("ground", f"{body}_x", f"{body}_y", body)
    axes = ((1, 0, 0), (0, 1, 0), (0, 0, 1))
    return tuple(
        mq.Prismatic(
            f"slide_{letter}", stations[k], stations[k + 1], axis=axes[k], coordinate=letter
        )
        for k, letter in enumerate(letters)
    )


def pair(potential: object) -> mq.Mechanism:
    """Two particles free in space that attract each other."""
    bodies = [mq.Body("ground")]
    for body in ("one", "two"):
        bodies += [mq.Body(f"{body}_x"), mq.Body(f"{body}_y"), mq.Body(body, mq.particle(M))]
    bond = mq.CentralForce("bond", "one", (0, 0, 0), "two", (0, 0, 0), potential)
    joints = (*slides("xyz", "one"), *slides("uvw", "two"))
    return mq.Mechanism(
        "pair", (*bodies,), joints, forces=(bond,), parameters=(M, K, G, D, A), gravity=(0, 0, 0)
    )


Y = mq.coordinate("y")
C = mq.Parameter("c", 2.0, "N/m²")
W = mq.Parameter("W", 2.0, "rad/s")
HENON_HEILES = K * (X**2 + Y**2) / 2 + C * (X**2 * Y - Y**3 / 3)
TRAP = K * mq.cos(W * mq.time()) * (X**2 - Y**2) / 2


def plane(potential: object) -> mq.Mechanism:
    """A particle on two slides, in a potential of both coordinates."""
    return mq.Mechanism(
        "plane",
        (mq.Body("ground"), mq.Body("led"), mq.Body("ball", mq.particle(M))),
        (
            mq.Prismatic("along", "ground", "led", axis=(1, 0, 0), coordinate="x"),
            mq.Prismatic("across", "led", "ball", axis=(0, 1, 0), coordinate="y"),
        ),
        forces=(mq.Potential("field", ("along", "across"), potential),),
        parameters=(M, K, C, W),
        gravity=(0, 0, 0),
    )


def field(potential: object) -> mq.Mechanism:
    """A rod on a pin that slides, with a field at a point beside the rod's axis."""
    return mq.Mechanism(
        "field",
        (mq.Body("ground"), mq.Body("slider", mq.particle(M)), mq.Body("rod", mq.rod(M, A))),
        (
            mq.Prismatic("slide", "ground", "slider", axis=(1, 0, 0), coordinate="x"),
            mq.Revolute("pin", "slider", "rod", axis=(0, -1, 0), coordinate="y"),
        ),
        forces=(mq.PotentialField("trap", "rod", (0.1, 0, -A), potential),),
        parameters=(M, A, K, C, W),
        gravity=(0, 0, 0),
    )


PX, PY, PZ = mq.position()
SADDLE = K * (PX**2 - PZ**2) / 2 + C * PX**2 * PZ / 3
WAVE = K * A * mq.cos(W * mq.time()) * mq.sqrt(PX**2 + PZ**2 + A**2)

GRAVITATION = -G * M * M / mq.distance()
HOOKE = K * mq.distance() ** 2 / 2
MORSE = D * (1 - mq.exp(-mq.distance() / A)) ** 2


def test_duffing_by_its_potential() -> None:
    equations = mq.derive(duffing())
    assert str(equations) == "x'' + k x/m + b x^3/m = 0"
    text = equations.text(steps=True)
    assert "The potential V of the well is given." in text
    assert "V = k x^2/2 + b x^4/4" in text
    assert "E = m x'^2/2 + k x^2/2 + b x^4/4" in text


@pytest.mark.parametrize(
    "mechanism",
    [
        duffing(),
        pair(GRAVITATION),
        pair(HOOKE),
        pair(MORSE),
        plane(HENON_HEILES),
        plane(TRAP),
        field(SADDLE),
        field(WAVE),
    ],
    ids=["duffing", "gravitation", "hooke", "morse", "henon_heiles", "trap", "saddle", "wave"],
)
def test_all_derivations_agree_with_the_engine(mechanism: mq.Mechanism) -> None:
    verdict = mq.verify(mechanism, samples=30)
    assert verdict.agrees
    assert verdict.worst < 1e-12


def test_potentials_of_joints_and_distances_by_hand() -> None:
    at, rate = {"x": 0.7}, {"x": 0.2}
    reference = mq.Reference(duffing())
    assert reference.energy(at, rate).potential == pytest.approx(
        1.5 * 0.49 + 1.25 * 0.7**4, rel=1e-14
    )
    assert reference.acceleration(at, rate) == pytest.approx(-(3 * 0.7 + 5 * 0.343) / 2, rel=1e-14)
    q = np.array([0.3, -0.2, 0.5, 1.3, 1.8, 2.5])  # the distance is 3
    attracted = mq.Reference(pair(GRAVITATION))
    assert attracted.energy(q).potential == pytest.approx(-0.7 * 4 / 3, rel=1e-14)
    pull = 0.7 * 2 / 27 * (q[3:] - q[:3])
    np.testing.assert_allclose(
        attracted.acceleration(q, 0 * q), [*pull, *-pull], rtol=1e-14, atol=0
    )


def test_two_bodies_keep_kepler_s_third_law_and_their_energy() -> None:
    """A circle of two equal masses about their middle: omega² = 2 G m/d³."""
    d, omega = 1.0, (2 * 0.7 * 2.0) ** 0.5
    v = omega * d / 2
    period = 2 * np.pi / omega
    motion = mq.simulate(
        pair(GRAVITATION), q={"x": -d / 2, "u": d / 2}, v={"y": -v, "v": v}, duration=period
    )
    np.testing.assert_allclose(motion.q[-1], motion.q[0], rtol=0, atol=1e-7)
    assert motion.audit().ok


def test_hooke_s_force_is_smooth_where_the_ends_meet() -> None:
    q = np.zeros(6)
    for method in ("lagrange", "newton_euler", "virtual_work"):
        np.testing.assert_array_equal(mq.derive(pair(HOOKE), method).acceleration(q, q), q)
    np.testing.assert_array_equal(mq.Reference(pair(HOOKE)).acceleration(q, q), q)
    with pytest.raises(mq.EngineError, match="central force 'bond' has no direction"):
        mq.Reference(pair(GRAVITATION)).acceleration(q, q)


def test_a_potential_of_two_coordinates_by_hand() -> None:
    """Hénon & Heiles, Astron. J. 69 (1964) 73, with a mass and a stiffness."""
    equations = mq.derive(plane(HENON_HEILES))
    assert str(equations).splitlines() == [
        "m x'' + k x + 2 c x y = 0",
        "m y'' + k y + c x^2 - c y^2 = 0",
    ]
    E = "E = m (x'^2 + y'^2)/2 + k (x^2 + y^2)/2 + c x^2 y - c y^3/3"
    assert E in equations.text(steps=True)
    reference, (x, y) = mq.Reference(plane(HENON_HEILES)), (0.3, -0.2)
    np.testing.assert_allclose(
        reference.acceleration([x, y], [0, 0]),
        [-(3 * x + 4 * x * y) / 2, -(3 * y + 2 * (x * x - y * y)) / 2],
        rtol=1e-14,
        atol=0,
    )
    effects = {(effect.body, effect.other) for effect in reference.applied([x, y])}
    assert effects == {("led", "ground"), ("ground", "led"), ("ball", "led"), ("led", "ball")}
    motion = mq.simulate(plane(HENON_HEILES), q={"x": 0.1, "y": 0.2}, duration=5.0)
    assert motion.audit().ok
    assert np.ptp(motion.energy().total) < 1e-9


def test_a_potential_that_depends_on_time_has_no_energy_integral() -> None:
    """A saddle that changes sides, as in a trap of Paul: dE/dt = ∂V/∂t."""
    text = mq.derive(plane(TRAP)).text(steps=True)
    assert "V depends on time, so that the total energy is no integral" in text.replace(
        "\n   ", " "
    )
    assert "Energy integral" not in text
    assert "m x'' + k x cos(W t) = 0" in text
    motion = mq.simulate(plane(TRAP), q={"x": 0.1, "y": 0.2}, duration=4.0)
    assert motion.audit().ok
    energy = motion.energy()
    x, y = motion.q.T
    V = 1.5 * np.cos(2 * motion.t) * (x**2 - y**2)
    np.testing.assert_allclose(energy.potential, V, rtol=0, atol=1e-14)
    assert np.ptp(energy.total) > 0.01
    assert np.abs(energy.balance).max() < 1e-8 * energy.scale


@pytest.mark.parametrize(
    "mechanism",
    [
        duffing(),
        pair(GRAVITATION),
        pair(MORSE),
        plane(HENON_HEILES),
        plane(TRAP),
        field(SADDLE),
    ],
)
def test_potentials_go_through_urdf(mechanism: mq.Mechanism) -> None:
    text = mq.write_urdf(mechanism)
    assert not [f for f in mq.lint(text) if f.severity == "error"]
    back = mq.read_urdf(text, gravity=(0, 0, 0))
    assert [type(force) for force in back.forces] == [type(force) for force in mechanism.forces]
    q = np.linspace(0.3, 1.4, mechanism.nq) ** 2
    before, after = (mq.Reference(m) for m in (mechanism, back))
    np.testing.assert_allclose(
        after.acceleration(q, 0 * q, 0.7), before.acceleration(q, 0 * q, 0.7), rtol=1e-15, atol=0
    )
    assert after.energy(q).potential == pytest.approx(before.energy(q).potential, rel=1e-15)


@pytest.mark.parametrize(
    ("tag", "said"),
    [
        ('potential name="a" joint="nowhere" potential="q"', "'nowhere' is no joint"),
        ('potential name="a" joint="slide nowhere" potential="q1"', "'nowhere' is no joint"),
        ('potential name="a" joint="slide" potential="q +"', "expression in the letters q and t"),
        (
            'central_force name="a" link_a="block" point_a="0 0 0" link_b="block" point_b="0 0 0" '
            'potential="distance"',
            "both of its ends are on link 'block'",
        ),
    ],
)
def test_faulty_tags_are_reported(tag: str, said: str) -> None:
    text = mq.write_urdf(duffing())
    text = text.replace("</robot>", f"  <mecanique:{tag}/>\n</robot>")
    with pytest.raises(mq.UrdfError, match=said):
        mq.read_urdf(text)


@pytest.mark.parametrize(
    ("potential", "said"),
    [
        (
            K * X**2 * mq.velocity("x"),
            'time and parameters alone, got "x\'"; what varies otherwise is a load',
        ),
        (K * mq.coordinate("y") ** 2, "depends on 'y', which is not declared"),
        (K * X, "potential"),
        (K * X**2 * mq.sign(X), r"'well': its potential holds sign\(x\), whose slope at zero"),
    ],
)
def test_what_is_no_potential_is_refused(potential: object, said: str) -> None:
    with pytest.raises(mq.MechanismError, match=said):
        duffing(mq.Potential("well", "slide", potential))


def test_a_field_pushes_a_point_down_its_slope() -> None:
    """Q = −grad V · ∂r/∂q at r = (x + c cos y + a sin y, 0, c sin y − a cos y)."""
    mechanism = field(SADDLE)
    reference = mq.Reference(mechanism)
    x, y, a, c, k, b = 0.4, 0.7, 0.8, 0.1, 3.0, 2.0
    px, pz = x + c * np.cos(y) + a * np.sin(y), c * np.sin(y) - a * np.cos(y)
    slope = np.array([k * px + 2 * b * px * pz / 3, -k * pz + b * px**2 / 3])
    turned = np.array([-c * np.sin(y) + a * np.cos(y), c * np.cos(y) + a * np.sin(y)])
    empty = mq.Reference(replace(mechanism, forces=()))
    q, still = [x, y], [0.0, 0.0]
    np.testing.assert_allclose(
        reference.bias(q, still) - reference.forces(q, still),
        empty.bias(q, still) + np.array([slope[0], slope @ turned]),
        rtol=1e-14,
        atol=0,
    )
    V = k * (px**2 - pz**2) / 2 + b * px**2 * pz / 3
    gained = reference.energy(q).potential - empty.energy(q).potential
    assert gained == pytest.approx(V, rel=1e-13)
    (effect,) = reference.applied(q)
    assert (effect.body, effect.other) == ("rod", None)
    np.testing.assert_allclose(effect.point, [px, 0, pz], rtol=0, atol=1e-15)


def test_a_motion_in_a_field_keeps_its_energy_or_gains_the_field_s() -> None:
    assert "E = " in mq.derive(field(SADDLE)).text(steps=True)
    motion = mq.simulate(field(SADDLE), q={"x": 0.1, "y": 0.5}, duration=1.5)
    assert motion.audit().ok
    assert np.ptp(motion.energy().total) < 1e-8
    driven = mq.simulate(field(WAVE), q={"x": 0.1, "y": 0.5}, duration=2.0)
    assert driven.audit().ok
    assert np.ptp(driven.energy().total) > 0.1
    assert "trap" in mq.picture(driven.mechanism).svg


def test_a_field_of_the_world_does_not_turn_with_the_earth() -> None:
    with pytest.raises(mq.InputError, match="'trap' is a function of places in the world"):
        on_turning_earth(field(SADDLE), 0.5)


def test_where_a_point_is_has_letters_of_its_own() -> None:
    with pytest.raises(mq.MechanismError, match=r"is to depend on position\(\), time and"):
        field(X * SADDLE)
    letter = mq.Parameter("position_x", 1.0)
    with pytest.raises(mq.MechanismError, match="'position_x' is where its point is; rename"):
        replace(field(SADDLE), parameters=(M, A, K, C, W, letter))


def test_a_distance_is_a_letter_of_its_own() -> None:
    with pytest.raises(
        mq.MechanismError, match=r"is to depend on distance\(\), time and parameters"
    ):
        pair(X * HOOKE)


def test_the_arrow_of_an_attraction_points_to_the_other_end() -> None:
    drawn = mq.picture(mq.textbook.load("kepler_orbit")).svg
    assert "attraction" in drawn


@pytest.mark.parametrize(
    ("force", "slope"),
    [
        (mq.Potential("v", "slide", 3 * abs(X)), 3.0),
        (mq.Potential("v", "slide", ((X - 0.1 + abs(X - 0.1)) / 2) ** 2), 2 * 0.6),
        (
            mq.CentralForce(
                "v",
                "ground",
                (0, 0, 0),
                "block",
                (0, 0, 0),
                ((mq.distance() - 0.2 + abs(mq.distance() - 0.2)) / 2) ** 2,
            ),
            2 * 0.5,
        ),
    ],
)
def test_potentials_may_have_corners(force: mq.AnyForce, slope: float) -> None:
    mechanism = duffing(force)
    reference = mq.Reference(mechanism)
    assert reference.inverse_dynamics([0.7], [0.0], [0.0]) == pytest.approx([slope], rel=1e-14)
    assert mq.verify(mechanism, samples=5).agrees


def test_written_code_has_the_potential_of_any_parameters() -> None:
    """Where cos(W t) is near zero, a frequency rounded to 15 digits would show."""
    made = mq.generate(mq.derive(plane(TRAP)), "python", "acceleration,energy")
    assert made.verdict is not None
    assert max(made.verdict.worst.values()) < 1e-14


def loaded(along: object, across: object) -> mq.Mechanism:
    """A particle on two slides under a load with components along x and y."""
    return mq.Mechanism(
        "loaded",
        (mq.Body("ground"), mq.Body("led"), mq.Body("ball", mq.particle(M))),
        (
            mq.Prismatic("along", "ground", "led", axis=(1, 0, 0), coordinate="x"),
            mq.Prismatic("across", "led", "ball", axis=(0, 1, 0), coordinate="y"),
        ),
        forces=(mq.Force("load", "ball", (0, 0, 0), (along, across, 0)),),
        parameters=(M, K, C, W),
        gravity=(0, 0, 0),
    )


@pytest.mark.parametrize(
    ("potential", "along", "across"),
    [
        ("k x^2/2", -K * X, 0),
        ("k x y", -K * Y, -K * X),
        ("c x^2 y - c y^3/3", -2 * C * X * Y, C * (Y**2 - X**2)),
        ("-2 sin(x) cos(y)", 2 * mq.cos(X) * mq.cos(Y), -2 * mq.sin(X) * mq.sin(Y)),
    ],
)
def test_a_load_that_derives_from_a_potential_has_it(
    potential: str, along: object, across: object
) -> None:
    (V,) = stored_in_loads(loaded(along, across)).values()
    assert expression(V).text() == potential


@pytest.mark.parametrize(
    "components",
    [
        (-K * Y, K * X),  # it turns around the origin
        (Y, 0),
        (-K * X * mq.cos(W * mq.time()), 0),
        (-mq.velocity("y"), mq.velocity("x")),
        (3.0, 0),  # a constant load, as a motor's, is told as a load
        (0, 0),
    ],
)
def test_a_load_without_a_potential_has_none(components: tuple[object, object]) -> None:
    assert not stored_in_loads(loaded(*components))


def test_a_potential_that_is_not_even_pushes_at_zero_too() -> None:
    """V = sin x has the slope 1 there, where (∂V/∂x)/x, which pulls along lines, has no value."""
    slide = mq.Prismatic("slide", "ground", "block", axis=(1.0, 0.0, 0.0), coordinate="x")
    block = mq.Body("block", mq.particle(2.0))
    wave = mq.Potential("wave", "slide", mq.sin(mq.coordinate("x")))
    mechanism = mq.Mechanism("on a wave", (mq.Body("ground"), block), (slide,), (wave,))
    assert mq.Reference(mechanism).acceleration([0.0]) == pytest.approx([-0.5], rel=1e-14)
    assert mq.verify(mechanism).agrees
    assert mq.simulate(mechanism, duration=1.0).audit().ok


def push(factor: float) -> mq.Mechanism:
    """A force in each slide of a particle, by the difference of both coordinates."""
    drives = (
        mq.JointForce("ahead", "along", -K * (mq.coordinate("x") - Y)),
        mq.JointForce("back", "across", -factor * K * (Y - mq.coordinate("x"))),
    )
    return replace(plane(0.5 * K * Y**2), forces=drives)


def test_loads_that_have_a_potential_together_are_recognised() -> None:
    """Neither has one by itself: each depends on the coordinate of the other."""
    text = mq.derive(push(1.0)).text(steps=True)
    assert "ahead and back depend on the position alone" in text
    assert "V = k (x^2 + y^2)/2 - k x y" in text
    assert "V_back" not in text
    motion = mq.simulate(push(1.0), q={"x": 0.3, "y": -0.1}, duration=1.0)
    assert motion.audit().ok
    assert np.ptp(motion.energy().total) < 1e-9
    assert "depend on the position" not in mq.derive(push(2.0)).text(steps=True)

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import simpson

import mecanique as mq
from mecanique.motion import Audit, Event
from mecanique.motion.analysis.forces import Actions
from mecanique.motion.motion import Motion

BALANCES = (
    "energy",
    "linear momentum",
    "angular momentum about the origin",
    "angular momentum about the center of mass",
)


def oscillator(damping: float) -> mq.Mechanism:
    """A particle of 2 kg on a spring of 50 N/m, with a damper to the ground."""
    return mq.Mechanism(
        "oscillator",
        (mq.Body("ground"), mq.Body("block", mq.particle(2.0))),
        (mq.Prismatic("slide", "ground", "block", axis=(1, 0, 0), coordinate="x"),),
        forces=(
            mq.Spring(
                "spring", "ground", (-1, 0, 0), "block", (0, 0, 0), stiffness=50.0, free_length=1.0
            ),
            mq.Damper("damper", "block", (0, 0, 0), "ground", (3, 0, 0), damping=damping),
        ),
    )


def test_the_work_of_a_damper_is_the_energy_lost() -> None:
    c = 0.8
    motion = mq.simulate(oscillator(c), q={"x": 0.5}, duration=8.0)
    decay, omega = c / 4, np.sqrt(25 - (c / 4) ** 2)
    t = motion.t
    x = 0.5 * np.exp(-decay * t) * (np.cos(omega * t) + decay / omega * np.sin(omega * t))
    v = -0.5 * np.exp(-decay * t) * (25 / omega) * np.sin(omega * t)
    energy = motion.energy()
    np.testing.assert_allclose(energy.kinetic, v**2, rtol=0, atol=1e-9)
    np.testing.assert_allclose(energy.springs, 25 * x**2, rtol=0, atol=1e-9)
    np.testing.assert_allclose(energy.work, v**2 + 25 * x**2 - 6.25, rtol=0, atol=2e-9)
    assert np.abs(energy.balance).max() / energy.scale < 1e-9
    assert (np.diff(energy.work) <= 1e-12).all()
    later = motion.energy([1.0, 2.0])
    assert later.total[0] == pytest.approx(energy.total[60], rel=1e-12)
    assert later.work[0] == pytest.approx(energy.work[60], rel=1e-9)


@pytest.mark.parametrize("stated", [True, False])
def test_what_attracts_has_a_potential(stated: bool) -> None:
    """E = m v²/2 - m mu/r of Kepler's orbit, e = 0.6; nothing else does work."""
    orbit = mq.textbook.load("kepler_orbit")
    m, mu = orbit.values["m"], orbit.values["mu"]
    if not stated:
        pull = -m * mu / mq.coordinate("r") ** 2
        load = mq.Force("load", "planet", (0, 0, 0), (pull, 0, 0), axes="radius")
        orbit = replace(orbit, forces=(load,))
    motion = mq.simulate(orbit, q={"r": 1.0}, v={"phi": (1.6 * mu) ** 0.5}, duration=20.0)
    energy = motion.energy()
    stored = energy.springs if stated else energy.loads
    np.testing.assert_allclose(stored, -m * mu / motion["r"], rtol=1e-13, atol=0)
    np.testing.assert_allclose(energy.total, -0.2 * m * mu, rtol=1e-9, atol=0)
    assert not energy.work.any()
    assert f"energy: {-0.2 * m * mu:.6g} J at the start, 0 J of work since" in motion.summary()


def test_loads_of_one_body_are_told_apart() -> None:
    """A steady push has a potential, -F l sin(q) here; a motor's power is work, by quadrature."""
    pendulum = replace(
        mq.textbook.load("rigid_bar_pendulum"),
        forces=(
            mq.Force("wind", "rod", (0, 0, -1.0), (3.0, 0, 0)),
            mq.JointForce("motor", "pin", 0.4 * mq.coordinate("t")),
        ),
    )
    motion = mq.simulate(pendulum, q={"q": 0.3}, duration=4.0, samples=4001)
    energy = motion.energy()
    np.testing.assert_allclose(energy.loads, -3.0 * np.sin(motion["q"]), rtol=0, atol=1e-12)
    power = 0.4 * motion.t * motion["q'"]
    assert energy.work[-1] == pytest.approx(simpson(power, x=motion.t), rel=1e-8)
    assert np.abs(energy.balance).max() < 1e-9 * energy.scale


def test_without_losses_energy_stays() -> None:
    motion = mq.simulate(
        mq.textbook.load("double_pendulum"), q=[0.9, 1.4], duration=5.0, rtol=1e-12
    )
    energy = motion.energy()
    assert (energy.work == 0).all()
    assert np.ptp(energy.total) < 1e-10 * energy.scale


def tied(amplitude: float) -> mq.Mechanism:
    """A bob that a rod of 1 m ties to a cart, which goes to and fro."""
    drive = amplitude * mq.sin(5 * mq.time())
    return mq.Mechanism(
        "tied",
        (mq.Body("ground"), mq.Body("cart"), mq.Body("bob", mq.ball(1.0, 0.1))),
        (
            mq.Prismatic("rail", "ground", "cart", axis=(1, 0, 0), coordinate="s"),
            mq.Planar("free", "ground", "bob", names=("x", "z", "a"), axis=(0, -1, 0)),
        ),
        loops=(mq.Loop.distance("rod", "cart", (0, 0, 0), "bob", (0, 0, 0), 1.0),),
        coordinates=mq.Coordinates((), {"s": drive}),
    )


def test_rounding_of_a_weights_work_breaks_no_balance() -> None:
    """Swings of 1e-6 rad change m g l = 10 J by 5e-12 J, of which rounding leaves three digits."""
    small = mq.simulate(mq.textbook.load("simple_pendulum"), q=[1e-6], duration=2.0, rtol=1e-12)
    energy = small.audit()["energy"]
    assert energy.ok
    assert energy.relative > 1e-8


def test_what_rests_against_rough_surfaces_is_in_balance() -> None:
    """A ladder that sticks has momenta of rounding alone, beside the impulse of its weight."""
    ladder = mq.textbook.load("ladder")
    contacts = [part for part in ladder.switching if isinstance(part, mq.Contact)]
    rough = tuple(replace(contact, mu=0.4, mu_static=0.4) for contact in contacts)
    start = mq.textbook.entry("ladder").start
    motion = mq.simulate(replace(ladder, switching=rough), q=start, duration=0.5)
    assert {*motion.modes[0].states.values()} == {"sticks"}
    assert all(row.ok for row in motion.audit().rows)


def test_the_work_of_a_rod_from_a_driven_cart_is_in_the_balance() -> None:
    motion = mq.simulate(tied(0.3), q={"x": 1.0}, duration=1.0, fps=400)
    force = motion.reactions("rod").force[:, 0]
    power = force * 1.5 * np.cos(5 * motion.t)
    energy = motion.energy()
    assert energy.work[-1] == pytest.approx(simpson(power, x=motion.t), rel=1e-6, abs=0)
    assert np.abs(energy.balance).max() < 1e-9 * energy.scale
    still = mq.simulate(tied(0.0), q={"x": 1.0}, duration=0.5).energy()
    assert not still.work.any()


def test_the_work_of_a_condition_with_a_rate_of_its_own_is_in_the_balance() -> None:
    """A x' = b does the work ∫ λ b dt, here with λ = J a''/0.3, J of the ball."""
    b, a = 0.5, mq.coordinate("a")
    row = {"x": -mq.sin(a), "y": mq.cos(a), "a": 0.3}
    driven = mq.Mechanism(
        "driven",
        (mq.Body("ground"), mq.Body("bob", mq.ball(1.0, 0.1))),
        (mq.Planar("free", "ground", "bob", names=("x", "y", "a")),),
        velocity_constraints=(mq.VelocityConstraint("row", row, b),),
    )
    motion = mq.simulate(driven, v={"x'": 1.0}, duration=1.0, fps=400)
    multiplier = 0.004 * motion.a[:, 2] / 0.3
    energy = motion.energy()
    assert energy.work[-1] == pytest.approx(b * simpson(multiplier, x=motion.t), rel=1e-6, abs=0)
    assert motion.audit().ok


@pytest.mark.parametrize("name", ["base_excited_mass", "kapitza_pendulum", "bead_on_hoop"])
def test_the_work_of_prescribed_motion_is_in_the_balance(name: str) -> None:
    system = mq.textbook.entry(name)
    motion = mq.simulate(
        mq.textbook.load(name), q=system.start, v=system.start_velocity, duration=0.5
    )
    energy = motion.energy()
    assert (
        np.abs(energy.total - energy.total[0]).max() > 1e-4 * energy.scale
    )  # there is something to balance
    assert np.abs(energy.balance).max() < 3e-9 * energy.scale


@pytest.mark.parametrize(
    "name",
    [
        "double_pendulum",
        "cart_pole",
        "two_blocks",
        "free_rigid_body",
        "heavy_top",
        "furuta_pendulum",
        "shear_building",
    ],
)
def test_energy_and_momentum_balance_along_textbook_motions(name: str) -> None:
    system = mq.textbook.entry(name)
    motion = mq.simulate(
        mq.textbook.load(name), q=system.start, v=system.start_velocity, duration=1.0
    )
    audit = motion.audit()
    assert tuple(row.name for row in audit.rows) == BALANCES
    assert audit.ok, audit
    assert max(row.relative for row in audit.rows) < 3e-9
    assert 0 <= audit.speed_of_light_fraction < 1e-6


def loaded() -> mq.Mechanism:
    """A cart on a rail with every kind of force, and an arm on it."""
    F = mq.Input("F", lambda t: 3 * np.sin(5 * t), "N")
    q, rate = mq.coordinate("q"), mq.velocity("q")
    return mq.Mechanism(
        "loaded",
        (
            mq.Body("ground"),
            mq.Body("cart", mq.box(3.0, (0.4, 0.3, 0.2))),
            mq.Body("arm", mq.rod(1.0, 0.7), mq.ball(0.2, 0.1)),
        ),
        (
            mq.Prismatic(
                "slide",
                "ground",
                "cart",
                axis=(1, 0, 0.2),
                coordinate="x",
                origin=mq.Placement((0.1, 0.2, 0.3)),
            ),
            mq.Revolute(
                "pin",
                "cart",
                "arm",
                axis=(0.1, -1, 0.3),
                coordinate="q",
                origin=mq.Placement((0, 0.1, 0.1)),
            ),
        ),
        forces=(
            mq.JointSpring("s1", "slide", 30.0, 0.2),
            mq.JointDamper("d1", "slide", 0.7),
            mq.JointForce("f1", "slide", F),
            mq.JointSpring("s2", "pin", 2.0),
            mq.JointDamper("d2", "pin", 0.05),
            mq.Spring("s3", "arm", (0, 0, -0.5), "ground", (1, 1, 0), 15.0, 0.4),
            mq.Spring("s4", "ground", (-1, 0, 0), "cart", (0.1, 0, 0), 10.0, 0.3),
            mq.Spring("s5", "cart", (0, 0, 0.5), "arm", (0, 0, -0.5), 5.0, 0.1),
            mq.Damper("d3", "ground", (0, 1, 0), "arm", (0, 0.1, -0.5), 0.4),
            mq.Force("f2", "arm", (0, 0.1, -0.2), (q, -rate, 1.0)),
            mq.Force("f3", "arm", (0, 0, -0.7), (0.5, F, 0), axes="arm"),
            mq.Torque("t1", "arm", (0.3, 0.2, q), axes="cart"),
            mq.Torque("t2", "cart", (1.0, 2.0, 3.0)),
        ),
        inputs=(F,),
    )


def test_every_kind_of_force_is_in_the_balances() -> None:
    motion = mq.simulate(loaded(), q={"q": 0.8, "x": 0.1}, v={"x": 0.5}, duration=1.0)
    audit = motion.audit()
    assert max(row.relative for row in audit.rows) < 1e-9, audit


def test_dampers_in_driven_ground_joints_are_in_the_balances() -> None:
    q = mq.coordinate("q")
    mechanism = mq.Mechanism(
        "geared",
        (
            mq.Body("ground"),
            mq.Body("wheel", mq.disk(2.0, 0.5)),
            mq.Body("rack", mq.box(1.0, (0.1, 0.1, 0.1))),
        ),
        (
            mq.Revolute("axle", "ground", "wheel", axis=(0, 1, 0), coordinate="a"),
            mq.Prismatic("rail", "ground", "rack", axis=(1, 0, 0), coordinate="b"),
        ),
        coordinates=mq.Coordinates(("q",), {"a": 2 * q, "b": 0.5 * q + 0.1 * mq.time()}),
        forces=(
            mq.JointDamper("d1", "axle", 0.3),
            mq.JointSpring("s1", "axle", 4.0),
            mq.JointDamper("d2", "rail", 1.0),
            mq.JointSpring("s2", "rail", 20.0, 0.1),
        ),
    )
    audit = mq.simulate(mechanism, q=[0.7], duration=2.0).audit()
    assert max(row.relative for row in audit.rows) < 1e-9, audit


def test_a_falsified_motion_breaks_the_balances() -> None:
    mechanism = mq.textbook.load("double_pendulum")
    motion = mq.simulate(mechanism, q=[0.9, 1.4], duration=1.0)
    other = mechanism.replace(m2=1.001)
    false = Motion(
        other, motion.t, motion.q, motion.v, motion.curve, motion.method, motion.statistics
    )
    audit = false.audit()
    assert not audit.ok
    assert not audit["linear momentum"].ok
    assert "BROKEN" in str(audit)


def test_an_audit_reads_as_a_table() -> None:
    audit = mq.simulate(mq.textbook.load("cart_pole"), q={"q": 2.0}, duration=1.0).audit()
    assert isinstance(audit, Audit)
    text = str(audit)
    for name in BALANCES:
        assert name in text
    assert "of the speed of light" in text
    assert audit["energy"].unit == "J"
    with pytest.raises(
        mq.UnknownNameError, match="unknown balance 'energi'; did you mean 'energy'"
    ):
        audit["energi"]


@pytest.mark.slow
def test_a_chaotic_motion_is_trusted_only_so_far() -> None:
    motion = mq.simulate(
        mq.textbook.load("double_pendulum"), q=[2.0, 1.5], duration=12.0, rtol=1e-8
    )
    audit = motion.audit(refine=True)
    trust = audit.trust
    assert trust is not None
    assert trust.lyapunov > 0.5
    assert 1 < trust.until < 12
    # the same verdict from a much more accurate motion
    fine = mq.simulate(motion.mechanism, q=[2.0, 1.5], duration=12.0, rtol=1e-13)
    size = np.abs(motion.q).max(axis=0)
    error = np.abs((fine.q - motion.q) / size).max(axis=1)
    assert error[motion.t < trust.until].max() < 3e-6
    assert error[motion.t > trust.until].max() > 1e-6
    assert f"trustworthy to t = {trust.until:.4g} s" in str(audit)


def test_a_regular_motion_is_trusted_to_its_end() -> None:
    motion = mq.simulate(mq.textbook.load("rigid_bar_pendulum"), q=[1.0], duration=5.0)
    trust = motion.audit(refine=True).trust
    assert trust is not None
    assert trust.until == 5.0
    assert trust.error < 1e-8
    assert trust.lyapunov < 1.0
    assert "trustworthy to its end" in str(trust)
    with pytest.raises(mq.InputError, match="expected a positive accuracy, got 0"):
        motion.audit(refine=True, accuracy=0)


def test_an_audit_stays_right_across_events() -> None:
    mechanism = mq.textbook.load("cart_pole")
    events = [
        Event("wall", mq.coordinate("x") - 0.3, direction=1, restitution=0.5),
        Event("low", "q"),
    ]
    motion = mq.simulate(mechanism, q={"q": 2.0}, duration=3.0, events=events)
    assert len(motion.times("wall")) >= 1
    assert len(motion.times("low")) >= 1
    audit = motion.audit(refine=True)
    assert audit.ok, audit
    assert audit.trust is not None
    assert audit.trust.error < 1e-6


@pytest.mark.parametrize(
    "name", ["cart_pole", "slider_crank", "rolling_coin", "double_atwood_machine"]
)
def test_the_resultant_is_that_of_all_that_crosses_from_the_ground(name: str) -> None:
    """Action by action: weights, loads, springs to the ground, joints, loops and contacts."""
    mechanism = mq.textbook.load(name)
    motion = mq.simulate(mechanism, duration=0.3)
    t, q, v = motion.t, motion.q, motion.v
    actions = Actions(mechanism, motion.reference)
    force, moment = np.zeros((len(t), 3)), np.zeros((len(t), 3))
    for action in (*actions.applied(t, q, v), *actions.reactions(t, q, v)):
        if action.body != mechanism.ground and action.other in (None, mechanism.ground):
            force += action.force
            moment += action.moment + np.cross(action.origin, action.force)
    found = motion.reference.resultant(q, v, t)
    size = 1 + np.abs(force).max()
    assert np.allclose(found.force, force, rtol=0, atol=1e-9 * size)
    assert np.allclose(found.moment, moment, rtol=0, atol=1e-9 * (size + np.abs(moment).max()))
    assert np.allclose(
        found.center, motion.reference.center_of_mass(q, t=t).position, rtol=1e-13, atol=0
    )


def test_the_largest_speed_is_that_of_the_fastest_center_of_mass() -> None:
    motion = mq.simulate(mq.textbook.load("cart_pole"), duration=0.5)
    centers = [
        motion.reference.point(
            body.name, motion.mechanism.evaluate_all(body.center), motion.q, motion.v, None
        ).velocity
        for body in motion.mechanism.bodies
    ]
    fastest = np.linalg.norm(centers, axis=2)
    assert motion.audit().speed == pytest.approx(fastest.max(), rel=1e-12)

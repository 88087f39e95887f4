"""A screw joint: closed form, in-house derivation, engine and URDF round trip agree."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import mecanique as mq

AXIS = np.array([2.0, -1.0, 2.0]) / 3
PITCH = 0.3


def screw_on_an_arm(**options: object) -> mq.Mechanism:
    """Return a screw with an oblique axis on a swinging arm, and a ball joint behind it."""
    h = mq.Parameter("h", PITCH, "m/rad", "pitch")
    return mq.Mechanism(
        "screw_on_an_arm",
        (
            mq.Body("ground"),
            mq.Body("arm", mq.rod(1.5, 0.8)),
            mq.Body("nut", mq.box(2.0, (0.2, 0.3, 0.4)).at((0.1, 0.2, -0.1))),
            mq.Body("tip", mq.box(0.5, (0.1, 0.2, 0.1)).at((0.0, 0.3, 0.0))),
        ),
        (
            mq.Revolute("hinge", "ground", "arm", axis=(0, -1, 0), coordinate="q"),
            mq.Helical(
                "screw",
                "arm",
                "nut",
                axis=tuple(AXIS),
                pitch=h,
                origin=mq.Placement((0.1, 0.0, -0.8), (0.2, 0.1, 0.3)),
                coordinate="s",
                armature=0.02,
            ),
            mq.Spherical("ball", "nut", "tip", origin=mq.Placement((0.2, 0.0, 0.1))),
        ),
        forces=(
            mq.JointForce("drive", "screw", 0.7),
            mq.JointDamper("grease", "screw", 0.2),
        ),
        parameters=(h,),
    )


def test_a_screw_says_what_it_is() -> None:
    screw = mq.Helical("screw", "a", "b", pitch=0.1, coordinate="s")
    assert screw.coordinates == ("s_travel", "s")
    assert screw.kinds == ("linear", "angular")
    assert (screw.nq, screw.nv, screw.quaternion) == (2, 2, ())
    mechanism = screw_on_an_arm()
    assert mechanism.coordinates[:2] == ("q", "s")
    assert str(mechanism.coordinates.driven["s_travel"]) == "h*s"


def test_the_derivations_agree_with_the_engine() -> None:
    verdict = mq.verify(screw_on_an_arm(), samples=20)
    assert verdict.agrees
    assert verdict.worst < 1e-12


def test_a_free_screw_moves_as_in_closed_form() -> None:
    """(I + m p²) θ'' = D + m g p for a body on its axis of symmetry."""
    p, m, r, moment = 0.2, 3.0, 0.5, 1.1
    mechanism = mq.Mechanism(
        "screw",
        (mq.Body("ground"), mq.Body("disk", mq.disk(m, r))),
        (mq.Helical("screw", "ground", "disk", axis=(0, 0, -1), pitch=p),),
        forces=(mq.JointForce("drive", "screw", moment),),
    )
    expected = (moment + m * 9.81 * p) / (m * r**2 / 2 + m * p**2)
    for method in ("lagrange", "newton_euler", "virtual_work"):
        found = mq.derive(mechanism, method=method).acceleration([0.4], [1.3])
        assert found == pytest.approx([expected], rel=1e-13)
    reference = mq.Reference(mechanism)
    assert reference.acceleration([0.4], [1.3]) == pytest.approx([expected], rel=1e-13)
    wrench = reference.reactions([0.4], [1.3])["screw"]
    np.testing.assert_allclose(wrench.force, [0, 0, m * (9.81 - p * expected)], rtol=0, atol=1e-13)
    # what the thread takes of the weight drives it: M = −p F
    np.testing.assert_allclose(wrench.moment, -p * wrench.force, rtol=0, atol=1e-13)
    assert -wrench.moment[2] == pytest.approx(m * r**2 / 2 * expected - moment, rel=1e-12)


def test_the_thread_couples_force_and_moment() -> None:
    """The thread does no work, but what the drive's rotor takes: M·n + p F·n = −armature θ''."""
    mechanism = screw_on_an_arm()
    reference = mq.Reference(mechanism)
    rng = np.random.default_rng(4)
    for _ in range(5):
        q = mechanism.position(rng.normal(size=mechanism.nq))
        v = rng.normal(size=mechanism.nv)
        at = mechanism.velocities.index("s'")
        a = reference.acceleration(q, v)[at]
        wrench = reference.reactions(q, v)["screw"]
        poses = dict(zip((b.name for b in mechanism.bodies), reference.poses(q), strict=True))
        n = poses["nut"][:3, :3] @ AXIS
        along = wrench.moment @ n + PITCH * (wrench.force @ n)
        assert along == pytest.approx(-0.02 * a, rel=1e-9, abs=1e-9)


def test_the_pitch_is_a_parameter() -> None:
    mechanism = screw_on_an_arm().replace(h=-0.1)
    assert mq.verify(mechanism, samples=5).agrees
    finer, coarser = (mq.Reference(screw_on_an_arm().replace(h=h)) for h in (0.01, 0.5))
    q = mechanism.neutral()
    assert finer.mass_matrix(q)[1, 1] < coarser.mass_matrix(q)[1, 1]


def test_a_screw_may_follow_another_coordinate() -> None:
    mechanism = mq.Mechanism(
        "geared",
        (mq.Body("ground"), mq.Body("wheel", mq.disk(1.0, 0.3)), mq.Body("nut", mq.disk(2.0, 0.2))),
        (
            mq.Revolute("axle", "ground", "wheel", coordinate="phi"),
            mq.Helical("screw", "ground", "nut", pitch=0.1, coordinate="s"),
        ),
        coordinates=mq.Coordinates(("phi",), {"s": -3 * mq.coordinate("phi")}),
    )
    assert mechanism.coordinates.names == ("phi",)
    found = mq.derive(mechanism).mass_matrix([0.2])
    np.testing.assert_allclose(found, [[0.045 + 9 * (0.04 + 2.0 * 0.01)]], rtol=1e-13, atol=0)
    assert mq.verify(mechanism, samples=5).agrees


def test_urdf_keeps_a_screw() -> None:
    mechanism = screw_on_an_arm()
    text = mq.write_urdf(mechanism)
    again = mq.read_urdf(text)
    screw = again.joint("screw")
    assert isinstance(screw, mq.Helical)
    assert (screw.pitch, screw.armature) == (PITCH, 0.02)
    assert {body.name for body in mechanism.bodies} <= {body.name for body in again.bodies}
    assert "nut_travel" not in {body.name for body in again.bodies}
    q = mechanism.position(np.random.default_rng(0).normal(size=mechanism.nq))
    np.testing.assert_allclose(
        mq.Reference(again).mass_matrix(q),
        mq.Reference(mechanism).mass_matrix(q),
        rtol=1e-13,
        atol=0,
    )
    assert mq.write_urdf(again).count("<mecanique:screw/>") == 1
    # what other programs see is told: a mimic joint
    assert "M404" in {finding.code for finding in mq.lint(text)}
    assert not [finding for finding in mq.lint(text) if finding.severity == "error"]


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('<mimic joint="screw"', '<mimic joint="hinge"'),
        ('offset="0"', 'offset="0.1"'),
        ('multiplier="0.3"', 'multiplier="0"'),
        (
            '<link name="nut_travel"/>',
            '<link name="nut_travel"><inertial><mass value="1"/><inertia '
            'ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>',
        ),
    ],
)
def test_what_is_no_screw_is_refused(old: str, new: str) -> None:
    text = mq.write_urdf(screw_on_an_arm())
    assert old in text
    with pytest.raises(mq.UrdfError, match="expects a slide that mimics the hinge behind it"):
        mq.read_urdf(text.replace(old, new))


@pytest.mark.parametrize("pitch", [0, float("nan"), float("inf")])
def test_a_pitch_is_finite_and_not_zero(pitch: float) -> None:
    with pytest.raises(mq.InputError, match="expected a finite pitch other than zero"):
        mq.Helical("screw", "a", "b", pitch=pitch)


def test_an_undeclared_pitch_is_refused() -> None:
    h = mq.Parameter("h", 0.1)
    bodies = (mq.Body("ground"), mq.Body("nut", mq.disk(1.0, 0.1)))
    screw = mq.Helical("screw", "ground", "nut", pitch=h)
    with pytest.raises(mq.MechanismError, match="depends on 'h', which is not declared"):
        mq.Mechanism("m", bodies, (screw,))


def sprung_screw() -> mq.Mechanism:
    """The same with a torsion spring in the screw, from 0.4 rad on."""
    k = mq.Parameter("k", 2.0, "N·m/rad", "stiffness")
    screw = screw_on_an_arm()
    spring = mq.JointSpring("thread", "screw", k, 0.4)
    return replace(screw, forces=(*screw.forces, spring), parameters=(*screw.parameters, k))


def test_a_spring_in_a_screw_is_about_its_angle() -> None:
    mechanism = sprung_screw()
    reference = mq.Reference(mechanism)
    q = {"q": 0.3, "s": 0.7}
    assert reference.energy(q).springs == pytest.approx(2.0 * 0.3**2 / 2, rel=1e-14)
    without = mq.Reference(screw_on_an_arm()).forces(q)
    expected = np.zeros(mechanism.nv)
    expected[1] = -2.0 * 0.3
    np.testing.assert_allclose(reference.forces(q) - without, expected, rtol=0, atol=1e-14)
    verdict = mq.verify(mechanism, samples=20)
    assert verdict.agrees
    assert verdict.worst < 1e-12


def test_a_spring_in_a_screw_survives_urdf() -> None:
    mechanism = sprung_screw()
    back = mq.read_urdf(mq.write_urdf(mechanism))
    (spring,) = (force for force in back.forces if isinstance(force, mq.JointSpring))
    assert (spring.joint, float(spring.stiffness)) == ("screw", 2.0)
    assert float(spring.reference) == pytest.approx(0.4, abs=1e-15)
    q = mechanism.position({"q": 0.3, "s": 0.7})
    forces = mq.Reference(mechanism).forces(q) - mq.Reference(screw_on_an_arm()).forces(q)
    unsprung = mq.read_urdf(mq.write_urdf(screw_on_an_arm()))
    found = mq.Reference(back).forces(q) - mq.Reference(unsprung).forces(q)
    np.testing.assert_allclose(found, forces, rtol=0, atol=1e-14)


def test_the_travel_of_a_screw_has_no_entry_of_its_own_in_the_map() -> None:
    own = mq.Coordinates((), {"s_travel": 0.2 * mq.coordinate("s")})
    with pytest.raises(mq.MechanismError, match=r"within joint 'screw' it follows as s_travel"):
        replace(screw_on_an_arm(), coordinates=own)
    # what a copy is made of holds the screw's own law
    again = replace(screw_on_an_arm(), name="again").replace(h=0.5)
    assert str(again.coordinates.driven["s_travel"]) == "h*s"

"""Verdicts on mechanisms with elements that switch: every mode, against the engine."""

from __future__ import annotations

from dataclasses import replace

import pytest

import mecanique as mq
from mecanique.derivation import switching

m, g, mu, alpha, r = (
    mq.Parameter("m", 1.3, "kg"),
    mq.Parameter("g", 9.81, "m/s²"),
    mq.Parameter("mu", 0.2),
    mq.Parameter("alpha", 0.3, "rad"),
    mq.Parameter("r", 0.1, "m"),
)
INCLINED = (g * mq.sin(alpha), 0, -g * mq.cos(alpha))


def slider(*elements: mq.Friction | mq.Stop) -> mq.Mechanism:
    """Return a block on an incline, with a spring to its origin."""
    return mq.Mechanism(
        "slider",
        (mq.Body("ground"), mq.Body("block", mq.box(m, (0.1, 0.1, 0.1)))),
        (mq.Prismatic("slide", "ground", "block", axis=(1, 0, 0), coordinate="x"),),
        parameters=(m, g, mu, alpha, r),
        gravity=INCLINED,
        forces=(mq.JointSpring("spring", "slide", 100.0),),
        switching=elements,
    )


def flat(shape: mq.Shape, **contact: object) -> mq.Mechanism:
    """Return a body in the plane x, z on an incline."""
    return mq.Mechanism(
        "flat",
        (mq.Body("ground"), mq.Body("body", shape)),
        (mq.Planar("plane", "ground", "body", axis=(0, -1, 0), names=("x", "z", "th")),),
        parameters=(m, g, mu, alpha, r),
        gravity=INCLINED,
        switching=(mq.Contact("floor", "body", **contact),),  # type: ignore[arg-type]
    )


def shaken() -> mq.Mechanism:
    """Return a mass on a base that time moves, with friction in both slides."""
    smooth = mq.textbook.load("base_excited_mass")
    names = [joint.name for joint in smooth.joints]
    dry = tuple(mq.Friction(f"dry in {name}", name, 0.1, 2.0) for name in names)
    return replace(smooth, switching=dry)


SYSTEMS = {
    "block": slider(mq.Friction("dry", "slide", mu, m * g * mq.cos(alpha))),
    "belt": slider(mq.Friction("belt", "slide", mu, m * g, speed=0.4)),
    "stop": slider(mq.Stop("stop", "slide", 1.0)),
    "elastic stop": slider(mq.Stop("stop", "slide", 1.0, stiffness=50.0)),
    "stop and friction": slider(
        mq.Friction("dry", "slide", mu, 3.0), mq.Stop("stop", "slide", 1.0)
    ),
    "ball": flat(mq.ball(m, r), radius=r, mu=mu),
    "rod": flat(mq.rod(m, 2.0), mu=mu),
    "smooth corner": flat(mq.box(m, (0.1, 0.1, 0.4)), center=(0.05, 0.0, 0.2)),
    "shaken": shaken(),
}


@pytest.mark.parametrize("system", SYSTEMS)
def test_every_mode_agrees_with_the_engine(system: str) -> None:
    verdict = mq.verify(SYSTEMS[system], samples=20)
    assert verdict.agrees, str(verdict)
    assert {row.quantity for row in verdict.rows} == {"acceleration", "forces of elements"}
    left_out = sum("rigid bodies do not determine" in note for note in verdict.notes)
    assert len(verdict.rows) == 2 * (len(mq.derive_modes(SYSTEMS[system]).modes) - left_out)


def test_a_law_of_friction_that_is_wrong_is_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    right = switching._find_load
    monkeypatch.setattr(switching, "_find_load", lambda forces: 1.01 * right(forces))
    verdict = mq.verify(SYSTEMS["ball"], samples=5)
    assert not verdict.agrees
    wrong = {row.sources[0] for row in verdict.rows if not row.agrees}
    assert wrong == {"slips +", "slips -"}


def test_a_mode_that_rigid_bodies_do_not_determine_is_told() -> None:
    verdict = mq.verify(SYSTEMS["stop and friction"], samples=5)
    assert "dry sticks, stop closed: not compared, rigid bodies do not determine" in str(verdict)


def test_what_no_verdict_treats_is_refused() -> None:
    block = SYSTEMS["block"]
    with pytest.raises(mq.InputError, match="'dry': its modes are compared with Pinocchio"):
        mq.verify(block, against=block)

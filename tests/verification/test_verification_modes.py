"""Verdicts on mechanisms with elements that switch: every mode, against the engine."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import pytest

import mecanique as mq
from mecanique.derivation import switching
from mecanique.derivation.mechanics.switching import Terms
from mecanique.verification import modes

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


def rolling() -> mq.Mechanism:
    """Return a ball with resistance to rolling: a couple of r/10 times the normal force."""
    bodies = (
        *(mq.Body(name, mq.massless()) for name in ("carriage", "lift")),
        mq.Body("body", mq.ball(m, r)),
    )
    joints = (
        mq.Prismatic("along", "ground", "carriage", axis=(1, 0, 0), coordinate="x"),
        mq.Prismatic("up", "carriage", "lift", axis=(0, 0, 1), coordinate="z"),
        mq.Revolute("spin", "lift", "body", axis=(0, -1, 0), coordinate="th"),
    )
    return mq.Mechanism(
        "wheel",
        (mq.Body("ground"), *bodies),
        joints,
        parameters=(m, g, mu, alpha, r),
        gravity=INCLINED,
        switching=(
            mq.Contact("floor", "body", radius=r, mu=mu),
            mq.Friction("rolls", "spin", r / 10, load="floor"),
        ),
    )


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
    "capstan": mq.textbook.load("capstan"),
    "rolling resistance": rolling(),
    "latch": slider(mq.Stop("latch", "slide", 1.0, holds=2.0)),
}


@pytest.mark.parametrize("system", SYSTEMS)
def test_every_mode_agrees_with_the_engine(system: str) -> None:
    verdict = mq.verify(SYSTEMS[system], samples=20)
    assert verdict.agrees, str(verdict)
    of_modes = [row for row in verdict.rows if "impact" not in row.sources[0]]
    assert {row.quantity for row in of_modes} == {"acceleration", "forces of elements"}
    left_out = sum("rigid bodies do not determine" in note for note in verdict.notes)
    assert len(of_modes) == 2 * (len(mq.derive_modes(SYSTEMS[system]).modes) - left_out)
    struck = [
        element.name
        for element in SYSTEMS[system].switching
        if "open" in element.states and getattr(element, "stiffness", None) is None
    ]
    assert {row.sources[0] for row in verdict.rows if row not in of_modes} == {
        f"impact of {name}" for name in struck
    }


def table() -> mq.Mechanism:
    """Return a ball in space on a rough floor."""
    bodies = mq.Body("ground"), mq.Body("ball", mq.ball(m, r))
    cloth = mq.Contact("cloth", "ball", radius=r, mu=mu, restitution=0.3)
    joint = mq.Floating("free", "ground", "ball")
    return mq.Mechanism("table", bodies, (joint,), parameters=(m, r, mu), switching=(cloth,))


def test_slip_along_two_directions_is_compared_in_numbers() -> None:
    verdict = mq.verify(table(), samples=10)
    assert verdict.agrees, str(verdict)
    assert {row.sources[0] for row in verdict.rows} == {"3 modes", "impact of cloth"}
    assert {row.quantity for row in verdict.rows if "impact" in row.sources[0]} == {
        "acceleration",
        "forces of elements",
        "momentum about contacts",
    }


def test_a_row_of_contact_that_is_wrong_is_seen_in_modes_and_impacts(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    right: Callable[[modes._Bench], Terms] = vars(modes._Bench)["ours"].func

    def tilt(bench: modes._Bench) -> Terms:
        terms = right(bench)
        (cloth,) = bench.elements
        terms.jacobian[:, cloth.normal] *= 1.001
        return terms

    monkeypatch.setattr(modes._Bench, "ours", property(tilt))
    verdict = mq.verify(table(), samples=5)
    assert {row.sources[0] for row in verdict.rows if not row.agrees} == {
        "3 modes",
        "impact of cloth",
    }


def test_an_impact_that_changes_momentum_about_the_contact_is_seen(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    right: Callable[[modes._Bench], Terms] = vars(modes._Bench)["ours"].func

    def shift(bench: modes._Bench) -> Terms:
        terms = right(bench)
        (cloth,) = bench.elements
        terms.jacobian[:, cloth.tangents[0], 5] += 0.01
        return terms

    monkeypatch.setattr(modes._Bench, "ours", property(shift))
    verdict = mq.verify(table(), samples=5)
    wrong = {row.quantity for row in verdict.rows if not row.agrees}
    assert "momentum about contacts" in wrong


def test_too_many_modes_are_refused() -> None:
    dry = tuple(mq.Friction(f"f{k}", "slide", mu, 1.0) for k in range(8))
    with pytest.raises(mq.DerivationError, match="has 6561 modes, more than 4096; expected fewer"):
        mq.verify(slider(*dry), samples=1)


def test_a_law_of_friction_that_is_wrong_is_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    right = switching._find_load
    monkeypatch.setattr(switching, "_find_load", lambda element: 1.01 * right(element))
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

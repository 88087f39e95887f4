"""The sentences about free bodies, their balances and the reactions on them."""

from __future__ import annotations

from collections.abc import Sequence

from mecanique.derivation.symbolic.free_bodies.axes import Direction
from mecanique.derivation.symbolic.free_bodies.bodies import Cut
from mecanique.model.guides.guide import Guide

__all__ = [
    "describe_reaction",
    "enumerate_words",
    "explain_guides",
    "state_moment_balance",
    "state_momentum_balance",
]


def state_momentum_balance(cut: Cut, moving: bool) -> str:
    """Return the sentence above the balance of forces of a body.

    Args:
        cut: the body, cut free.
        moving: whether its center of mass moves.
    """
    if moving:
        return (
            "Mass times the acceleration a of the center of mass equals the resultant force; "
            "below are the position r of that center in the axes of the world, the components of "
            "its velocity v and acceleration a, and then both sides in components."
        )
    if cut.mass:
        return "Its center of mass stays where it is, so the forces on it are in balance."
    return "It has no mass, so the forces on it are in balance."


def state_moment_balance(cut: Cut) -> str:
    """Return the sentence above the balance of moments of a body, cut free."""
    what = "Moments balance"
    if cut.mass:
        what = "The rate of the angular momentum equals the resultant moment"
    if cut.fixed:
        point = f"{cut.joint.name}, a fixed point"
    elif cut.mass:
        point = "its center of mass"
    else:
        point = f"{cut.joint.name}; without mass any point serves"
    return f"{what}, both about {point}."


def explain_guides(guides: Sequence[Guide]) -> str:
    """Return what guides leave undetermined, and what they do not."""
    reasons = "; ".join(guide.reason for guide in guides)
    return (
        f"{reasons[0].upper()}{reasons[1:]}. There the reactions by themselves are undetermined. S "
        "and C are force and moment of all that acts across the joint, reaction and guides "
        "together, on what hangs on it."
    )


def describe_reaction(cut: Cut, d: Direction, *, guided: bool) -> str:
    """Return what a component of a reaction is, with its unit.

    Args:
        cut: the body that it acts on, cut free.
        d: its direction.
        guided: whether guides act across the joint as well.
    """
    exerted = f"that {cut.joint.parent} exerts on {cut.body} in {cut.joint.name}"
    if guided:
        exerted = f"of reaction and guide together across {cut.joint.name} on {cut.body}"
    if d.kind == "moment":
        about = "in the sense in which moments count positive"
        if d.label:
            about = f"about {d.label}{_whose(cut, d.label)}"
        return f"moment {exerted}, {about} [N·m]"
    where = f"along {d.label}{_whose(cut, d.label)}"
    if d.sign < 0:
        where = f"towards {cut.joint.name}"
    return f"force {exerted}, {where} [N]"


def _whose(cut: Cut, label: str) -> str:
    """Whose axis a label means, where the sentence about the axes does not say so."""
    return f" of {cut.axes.whose}" if label in ("x", "y", "z") else ""


def enumerate_words(words: Sequence[str]) -> str:
    """Return words as an enumeration, the last after "and".

    Args:
        words: at least one.
    """
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}"

"""Write the sentences about free bodies, their balances and the reactions on them."""

from __future__ import annotations

from collections.abc import Sequence

from mecanique.derivation.symbolic.free_bodies.axes import Direction
from mecanique.derivation.symbolic.free_bodies.bodies import Cut
from mecanique.model.guides.guide import Guide


def state_momentum_balance(cut: Cut, moving: bool) -> str:
    """Return the sentence that introduces the balance of forces of a body.

    Args:
        cut: the body, cut free.
        moving: whether its center of mass moves.
    """
    if moving:
        return (
            "Mass times the acceleration a of the center of mass equals the resultant force. "
            "Listed are the position r of that center in the axes of the world, the components of "
            "its velocity v and acceleration a, and then both sides in components."
        )
    if cut.mass:
        return "Its center of mass does not move, so the forces on it are in balance."
    return "It has no mass, so the forces on it are in balance."


def state_moment_balance(cut: Cut) -> str:
    """Return the sentence that introduces the balance of moments of a body."""
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
    """Explain which reactions the guides leave undetermined, and what S and C are."""
    reasons = "; ".join(guide.reason for guide in guides)
    return (
        f"{reasons[0].upper()}{reasons[1:]}. There the reactions by themselves are undetermined. S "
        "and C are the total force and moment across the joint, of reaction and guides together, "
        "on the child."
    )


def describe_reaction(cut: Cut, d: Direction, *, guided: bool) -> str:
    """Describe a component of a reaction, with its unit.

    Args:
        cut: the body on which it acts.
        d: its direction.
        guided: whether guides act across the joint as well.
    """
    exerted = f"that {cut.joint.parent} exerts on {cut.body} in {cut.joint.name}"
    if guided:
        exerted = f"of reaction and guides together across {cut.joint.name} on {cut.body}"
    if d.kind == "moment":
        about = "in the positive sense of moments"
        if d.label:
            about = f"about {d.label}{_say_whose(cut, d.label)}"
        return f"moment {exerted}, {about} [N·m]"
    where = f"along {d.label}{_say_whose(cut, d.label)}"
    if d.sign < 0:
        where = f"towards {cut.joint.name}"
    return f"force {exerted}, {where} [N]"


def _say_whose(cut: Cut, label: str) -> str:
    """Say whose axes x, y and z are, where the sentence about the axes does not."""
    return f" of {cut.axes.whose}" if label in ("x", "y", "z") else ""


def enumerate_words(words: Sequence[str]) -> str:
    """Join words into an enumeration, the last after "and".

    Args:
        words: at least one.
    """
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}"

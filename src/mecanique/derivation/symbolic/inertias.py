"""List masses, centers of mass and moments of inertia, and say where the moments come from."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence

from mecanique.derivation.scalars.cancel import tidy
from mecanique.derivation.symbolic.derivation import Left, Result, Stage, list_components
from mecanique.derivation.symbolic.kinematics import MOST_LISTED, Kinematics
from mecanique.derivation.tree.poses import combination
from mecanique.model.bodies import Body
from mecanique.model.bodies.shapes import HOMOGENEOUS
from mecanique.wording import enumerate_words


def inertia_stages(kinematics: Kinematics) -> list[Stage]:
    """Return the step that lists masses, centers of mass and moments of inertia about them."""
    algebra, results, turning = kinematics.algebra, list[Result](), list[Body]()
    for name in kinematics.bodies:
        body = algebra.mechanism.body(name)
        mass = algebra.series(body.mass)
        if mass:
            results.append(Result(Left(f"m_{name}"), mass))
            center = [tidy(algebra.series(part)) for part in body.center]
            results += list_components(f"c_{name}", "xyz", center)
        moments = [*list_moments(kinematics, name)]
        results += moments
        if moments:
            turning.append(body)
    if not results or sum(len(result.right) for result in results) > MOST_LISTED:
        return []
    told = " ".join(_say_forms(turning))
    if "(H" in told:
        told += (
            " H1 to H9 are the rows of the table of homogeneous bodies, whose letters stand for "
            "each body's own mass and dimensions."
        )
    what = "its mass m, the position c of its center of mass in its own frame"
    if told:
        what += ", and the moments of inertia I about that center, along the axes of that frame "
        what += "that it turns about"
    title = "Masses and moments of inertia" if told else "Masses"
    return [Stage(title, f"Of each body: {what}. {told}".rstrip(), (*results,))]


def list_moments(kinematics: Kinematics, name: str) -> Iterator[Result]:
    """Yield the moments of inertia of a body about the axes of its frame that it turns about."""
    algebra = kinematics.algebra
    turn = kinematics.turn(kinematics.place[name])
    spin = kinematics.spin(name)
    about = [combination(column, spin) for column in zip(*turn, strict=True)]
    turns = [bool(tidy(algebra.lift(rate))) for rate in about]
    entries = algebra.mechanism.body(name).inertia
    for (i, k), entry in zip(_ENTRIES, entries, strict=True):
        moment = tidy(algebra.series(entry))
        if turns[i] and turns[k] and moment:
            yield Result(Left(f"I_{name}_{'xyz'[i]}{'xyz'[k]}"), moment)


_ENTRIES = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
"""Rows and columns of ixx, iyy, izz, ixy, ixz, iyz."""


def _say_forms(bodies: Sequence[Body]) -> Iterator[str]:
    """Say where moments of inertia come from: the table, a sum over parts, or the description."""
    alike: dict[str, list[str]] = {}
    for body in bodies:
        parts = [shape.form for shape in body.shapes if {shape.mass, *shape.inertia} != {0.0}]
        if len(parts) > 1:
            counted = Counter(form or "part with given moments" for form in parts)
            made = enumerate_words([_count_forms(form, n) for form, n in counted.items()])
            yield (
                f"{body.name} is made of {made}: its moments are the sums over these parts, each "
                "with m d² for the distance d of its center from the common one (Steiner)."
            )
        else:
            alike.setdefault("".join(parts), []).append(body.name)
    for form, names in alike.items():
        who = enumerate_words(names)
        if form in HOMOGENEOUS:
            be = "is" if len(names) == 1 else "are"
            yield f"{who} {be} {_count_forms(form, len(names), '')}: {HOMOGENEOUS[form]}."
        else:
            yield f"The moments of {who} are given."


def _count_forms(form: str, count: int, number: str = "{} ") -> str:
    """Return a form with its number in the table, e.g. "a thin disk (H4)", "2 particles"."""
    row = f" (H{[*HOMOGENEOUS].index(form) + 1})" if form in HOMOGENEOUS else ""
    if count == 1:
        return f"a {form}{row}"
    head, joint, rest = form.partition(" with")
    plural = f"{head}{'es' if head.endswith('x') else 's'}{joint}{rest}"
    return f"{number.format(count)}{plural}{row}"

"""List centers of mass and moments of inertia, and say where the moments come from."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from functools import partial

from mecanique.derivation.printing.equations import expression, join, shorter
from mecanique.derivation.printing.writers import Expression
from mecanique.derivation.scalars.cancel import tidy
from mecanique.derivation.scalars.series import Series
from mecanique.derivation.symbolic.derivation import (
    Left,
    Result,
    Stage,
    lefts_of,
    list_components,
)
from mecanique.derivation.symbolic.kinematics import MOST_LISTED, Kinematics
from mecanique.derivation.tree.poses import combination
from mecanique.model.bodies import Body
from mecanique.model.bodies.shapes import HOMOGENEOUS
from mecanique.model.mechanism.letters import call
from mecanique.wording import enumerate_words


def inertia_stages(kinematics: Kinematics, spread: Sequence[str] = ()) -> list[Stage]:
    """Return the step that lists centers of mass and moments of inertia about them."""
    # but not of bodies over which the inertia forces are spread, and integrated
    algebra, results, turning = kinematics.algebra, list[Result](), list[Body]()
    for name in (name for name in kinematics.bodies if name not in spread):
        body = algebra.mechanism.body(name)
        mass = algebra.series(body.mass)
        moments = [*list_moments(kinematics, name)]
        if mass and moments and not _is_letter(mass):
            results.append(Result(Left(f"m_{name}"), mass))
        if mass and moments:
            center = [tidy(algebra.series(part)) for part in body.center]
            results += list_components(f"c_{name}", "xyz", center)
        results += moments
        if moments:
            turning.append(body)
    if not turning or sum(len(result.right) for result in results) > MOST_LISTED:
        return []
    names = [left.symbol.removesuffix("_x") for left in lefts_of(results)]
    letters: dict[str, list[str]] = {}
    for name in names:
        letters.setdefault(name[0], []).append(name)
    at = "; in that frame the center is at [c]" if "c" in letters else ""
    said = [
        "The moments of inertia [I] of a body are those about its center of mass, along the axes "
        f"of its own frame that it turns about{at}.",
        *_say_forms(turning),
    ]
    said += ["A mass [m] that is no single letter is listed, too."] if "m" in letters else []
    return [Stage("Moments of inertia", algebra.say(" ".join(said), **letters), (*results,))]


def _is_letter(series: Series) -> bool:
    """Return whether a series is one letter or number, which a name would only repeat."""
    ring, names = series.ring, [generator.name for generator in series.generators()]
    return series.is_number or (len(names) == 1 and series == ring[names[0]])


def list_moments(kinematics: Kinematics, name: str) -> Iterator[Result]:
    """Yield the moments of inertia of a body about the axes of its frame that it turns about."""
    algebra = kinematics.algebra
    turn = kinematics.turn(kinematics.place[name])
    spin = kinematics.spin(name)
    about = [combination(column, spin) for column in zip(*turn, strict=True)]
    turns = [bool(tidy(algebra.lift(rate))) for rate in about]
    body = algebra.mechanism.body(name)
    parts = zip(*(shape.inertia for shape in body.shapes), strict=True)
    for (i, k), entry, entries in zip(_ENTRIES, body.inertia, parts, strict=True):
        moment = tidy(algebra.series(entry))
        if turns[i] and turns[k] and moment:
            shown = partial(_write_sum, moment, [tidy(algebra.series(part)) for part in entries])
            yield Result(Left(f"I_{name}_{'xyz'[i]}{'xyz'[k]}"), moment, shown)


def _write_sum(moment: Series, own: Sequence[Series]) -> Expression:
    """Return the moment of a body as those of its parts and what Steiner's theorem adds."""
    apart = (*own, tidy(moment - moment.ring.sum(own)))
    return shorter(expression(moment), join(expression(part) for part in apart if part))


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
                f"{_begin(call(body.name))} is made of {made}: its moments are the sums over these "
                "parts, each with its mass times the square of the distance of its center from the "
                "common one (Steiner)."
            )
        else:
            alike.setdefault("".join(parts), []).append(body.name)
    for form, names in alike.items():
        who = enumerate_words([*map(call, names)])
        if form in HOMOGENEOUS:
            be = "is" if len(names) == 1 else "are"
            forms = _count_forms(form, len(names), "")
            yield f"{_begin(who)} {be} {forms}: {HOMOGENEOUS[form]}."
        else:
            yield f"The moments of {who} are given."


def _begin(words: str) -> str:
    """Return the beginning of a sentence; a name that is no word stays as it is."""
    return words[0].upper() + words[1:] if words.startswith("the ") else words


def _count_forms(form: str, count: int, number: str = "{} ") -> str:
    """Return a form with its article or number, e.g. "a thin disk", "2 particles"."""
    if count == 1:
        return f"a {form}"
    head, joint, rest = form.partition(" with")
    plural = f"{head}{'es' if head.endswith('x') else 's'}{joint}{rest}"
    return f"{number.format(count)}{plural}"

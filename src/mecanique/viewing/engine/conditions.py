"""What the numbers set on a page keep to: the rules of a sound mechanism, on the tape."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from mecanique.derivation.mechanics.letters import Letters
from mecanique.model.expression import Scalar, evaluate, symbols_in
from mecanique.model.mechanism import Mechanism
from mecanique.model.mechanism.rules import MASS, MOMENT, TRIANGLE, rules_of
from mecanique.viewing.scene.engine import Condition


def conditions_of(letters: Letters) -> list[tuple[Condition, list[Any]]]:
    """Return the conditions that depend on what is set, with their numbers on the tape."""
    mechanism = letters.mechanism
    values, known = mechanism.values, {*mechanism.values, *letters.open}
    open_letters = {*letters.open}

    def is_judged(scalar: Scalar) -> bool:
        return symbols_in(scalar) <= known and (
            not symbols_in(scalar) <= values.keys()
            or math.isfinite(float(evaluate(scalar, values)))
        )

    found = []
    for condition, scalars in (*_of_bodies(mechanism), *_of_rules(mechanism)):
        depends = any(symbols_in(scalar) & open_letters for scalar in scalars)
        if depends and all(map(is_judged, scalars)):
            numbers = [letters.arithmetic(scalar, letters.values) for scalar in scalars]
            found.append((condition, numbers))
    return found


def _of_bodies(mechanism: Mechanism) -> Iterator[tuple[Condition, tuple[Scalar, ...]]]:
    for body in mechanism.bodies:
        where = f"body {body.name!r}: "
        yield Condition("gap", where, (MASS,), 2), (body.mass, body.mass)
        if not body.as_given:
            words = MOMENT, TRIANGLE
            yield Condition("inertia", where, words, 7, follows=True), (body.mass, *body.inertia)


def _of_rules(mechanism: Mechanism) -> Iterator[tuple[Condition, tuple[Scalar, ...]]]:
    for rule in rules_of(mechanism):
        scalars = rule.scalars
        kind: Any = "finite" if rule.gap is None else "gap"
        words, strict, follows = (rule.words,), rule.strict, rule.follows
        yield Condition(kind, rule.where, words, len(scalars), strict, follows), scalars

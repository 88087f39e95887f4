"""What ends a motion in a page as in `simulate`: limits, and events that stop it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from math import isfinite
from typing import Any

from mecanique.derivation.mechanics.letters import Letters
from mecanique.errors import DerivationError
from mecanique.model.expression import Scalar, evaluate, symbols_in
from mecanique.model.mechanism import Mechanism
from mecanique.model.mechanism.rules import MASS, MOMENT, TRIANGLE, rules_of
from mecanique.motion.motion import Motion
from mecanique.motion.simulation.watching.limits import MARGIN
from mecanique.viewing.scene.scene import Bound, Condition


def bounds_of(motion: Motion, letters: Letters) -> list[tuple[Bound, tuple[Any, Any]]]:
    """Return what ends a motion, with its distance and how near counts as reached, on the tape."""
    if motion.watched is None and any(event.impact for event in motion.events):
        raise DerivationError("what its impacts depend on is not known")
    return [*_limits(motion, letters), *_stops(motion, letters)]


def gradients_of(motion: Motion, letters: Letters) -> list[Any]:
    """Return the slopes of what passes zero at each impact: over t, then over each coordinate."""
    from sympy import Symbol, diff

    names = ("t", *motion.mechanism.coordinates)
    return [
        letters.arithmetic(diff(event.expression(motion.mechanism), Symbol(name)), letters.values)
        for event in motion.watched or ()
        if event.restitution is not None
        for name in names
    ]


def is_cut_short(motion: Motion) -> bool:
    """Return whether a limit or an event ended a motion."""
    stopping = {f"end of chart {name}" for name in motion.mechanism.limits}
    stopping |= {event.name for event in motion.watched or () if event.stop}
    last = motion.events[-1] if motion.events else None
    return last is not None and last.name in stopping and last.t >= float(motion.t[-1])


def options_of(motion: Motion) -> Iterator[str]:
    """Yield the arguments of `simulate` that bounded a motion, as Python."""
    bounding = [
        event for event in motion.watched or () if event.stop or event.restitution is not None
    ]
    limits = _limited_joints(motion)
    for event in bounding:
        if event.name in limits:
            yield 'limits="stop"' if event.stop else f"limits={event.restitution}"
            break
    texts = []
    for event in bounding:
        if event.name not in limits:
            what = "stop=True" if event.stop else f"restitution={event.restitution}"
            when = _write_quantity(event.expression(motion.mechanism))
            texts.append(f"mq.Event({event.name!r}, {when}, {event.direction}, {what})")
    if texts:
        yield f"events=[{', '.join(texts)}]"


def _write_quantity(expression: Scalar) -> str:
    from sympy import Symbol, srepr

    if isinstance(expression, Symbol):
        return repr(expression.name)
    primed = any("'" in symbol.name for symbol in expression.free_symbols)
    return f"sympy.sympify({(srepr(expression) if primed else str(expression))!r})"


def _limited_joints(motion: Motion) -> dict[str, str]:
    """Name of each joint by the names of the events at its limits."""
    return {
        f"{which} limit of {joint.name}": joint.name
        for joint in motion.mechanism.joints
        for which in ("lower", "upper")
    }


def _limits(motion: Motion, letters: Letters) -> Iterator[tuple[Bound, tuple[Any, Any]]]:
    from sympy import sympify

    mechanism = motion.mechanism
    for name, interval in mechanism.coordinates.intervals.items():
        bounds = [sympify(bound) for bound in interval]
        texts = [f"{float(bound):g}" if bound.is_number else str(bound) for bound in bounds]
        known = zip(interval, texts, mechanism.limits[name], (1.0, -1.0), strict=True)
        ends = [
            (letters.arithmetic(bound, letters.values), side, text)
            for bound, text, value, side in known
            if isfinite(value)
        ]
        margin: Any = MARGIN
        if len(ends) == 2:
            margin = (ends[1][0] - ends[0][0]) * MARGIN
        reason = mechanism.explain_chart(name)
        must = f"{name} must stay within ({', '.join(texts)}): {reason}"
        for bound, side, text in ends:
            distance = (letters.values[name] - bound) * side
            words = f"where {name} comes to its limit {text}: {reason}"
            yield Bound(words, -1, must), (distance, margin)


def _stops(motion: Motion, letters: Letters) -> Iterator[tuple[Bound, tuple[Any, Any]]]:
    joints = _limited_joints(motion)
    for event in motion.watched or ():
        if not event.stop and event.restitution is None:
            continue
        expression = event.expression(motion.mechanism)
        if expression is None:
            raise DerivationError(f"event {event.name!r} is a function of Python")
        quantity = letters.arithmetic(expression, letters.values)
        joint = joints.get(event.name)
        where = f"at the {event.name}" if joint else f"at its event {event.name!r}"
        must = f"joint {joint!r} must start within its limits" if joint else ""
        yield Bound(where, event.direction, must, event.restitution), (quantity, 0.0)


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

    judged = []
    for condition, scalars in (*_of_bodies(mechanism), *_of_rules(mechanism)):
        depends = any(symbols_in(scalar) & open_letters for scalar in scalars)
        if depends and all(map(is_judged, scalars)):
            numbers = [letters.arithmetic(scalar, letters.values) for scalar in scalars]
            judged.append((condition, numbers))
    return judged


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

"""Distribute d'Alembert's inertia forces over a slender rod, and locate their resultant."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, final

import numpy as np

from mecanique.derivation.scalars.cancel import tidy
from mecanique.derivation.scalars.generators import Kind
from mecanique.derivation.scalars.series import Series
from mecanique.derivation.symbolic.free_bodies.bodies import Cut, Cuts
from mecanique.derivation.symbolic.vectors import Vector, along, lift
from mecanique.derivation.tree.poses import combination
from mecanique.model.bodies.shape import Shape
from mecanique.model.bodies.visuals import Cylinder

_NAMES = ("s", "xi", "sigma", "eta")


@final
@dataclass(frozen=True)
class Distribution:
    """Inertia forces per length along a homogeneous slender rod.

    Args:
        coordinate: name of the distance from the rod's end.
        length: length of the rod [m].
        direction: direction along the rod from that end, in the axes of the body's carrier.
        density: force per length at that distance, along the axes of the body [N/m].
        resultant: its integral over the rod [N].
        point: distance at which the resultant of each component acts; None if it is not the
            same in all states.
    """

    coordinate: str
    length: Series
    direction: Vector
    density: Vector
    resultant: tuple[Series, ...]
    point: tuple[Series | None, ...]


def distribution_of(cuts: Cuts, cut: Cut) -> Distribution | None:
    """Return the distribution of a body's inertia forces if it is a homogeneous slender rod.

    With the acceleration a(s) of the rod's points the density is −(m/L) a(s), a polynomial in s;
    its resultant and its moment about the end are integrated term by term.
    """
    algebra, kinematics = cuts.algebra, cuts.kinematics
    shapes = algebra.mechanism.body(cut.body).shapes
    if len(shapes) != 1 or (rod := _find_rod(cuts, shapes[0])) is None:
        return None
    length, direction, center = rod
    taken = {*algebra.values, *algebra.mechanism.coordinates}
    name = next((name for name in _NAMES if name not in taken), None)
    if name is None:
        return None
    s = algebra.ring.unknown(name, Kind.PARAMETER)
    point = [c + (s - length / 2) * d for c, d in zip(center, direction, strict=True)]
    rate = [combination(row, [*point, 1]) for row in kinematics.rate(cut.body)]
    a = kinematics.change(lift(algebra.ring, rate), cut.carrier)
    density = (along(cut.axes.rows, a) * -(cut.mass / length)).tidy()
    resultants, points = [], []
    for component in density:
        force, moment = (_integrate(component, name, length, order) for order in (0, 1))
        resultants.append(force)
        points.append(_divide(moment, force))
    turn = kinematics.turn(kinematics.place[cut.body])
    away = lift(algebra.ring, [combination(row, direction) for row in turn]).tidy()
    return Distribution(
        coordinate=name,
        length=length,
        direction=away,
        density=density,
        resultant=tuple(resultants),
        point=tuple(points),
    )


def _find_rod(cuts: Cuts, shape: Shape) -> tuple[Series, list[int], list[Series]] | None:
    """Return length, direction away from the joint and center of a slender rod, None for others."""
    algebra = cuts.algebra
    if len(shape.visuals) != 1 or not isinstance(cylinder := shape.visuals[0].geometry, Cylinder):
        return None
    rotation = shape.visuals[0].placement.rotation
    axis = np.array([algebra.mechanism.evaluate(row[2]) for row in rotation])
    if np.abs(axis).max() < 1 - 1e-12:
        return None
    at = algebra.mechanism.evaluate_all(shape.center)
    sign = -1 if axis @ np.array(at) < 0 else 1
    direction = [sign * round(component) for component in axis.tolist()]
    length = algebra.series(cylinder.length)
    across = algebra.series(shape.mass) * length**2 / 12
    squares = [1 - d * d for d in direction]
    wanted = [across * square for square in squares] + [algebra.ring.number(0)] * 3
    given = [algebra.series(entry) for entry in shape.inertia]
    fits = all((a - b).vanishes() for a, b in zip(wanted, given, strict=True))
    if not length or not across or not fits:
        return None
    return length, direction, [algebra.series(component) for component in shape.center]


def _integrate(density: Series, name: str, length: Series, order: int) -> Series:
    """Return ∫ s^order f(s) ds from 0 to the length, for a polynomial f."""
    ring = density.ring
    terms: Sequence[Any] = [
        coefficient * length ** (power + order + 1) / (power + order + 1)
        for (power,), coefficient in density.coefficients([name]).items()
    ]
    return tidy(ring.sum(list(terms)))


def _divide(moment: Series, force: Series) -> Series | None:
    """Return moment/force if it is the same in any state, a product of parameters; else None."""
    if not force or not moment:
        return None
    # the ratio of the first terms, if it is the ratio of all
    (trig, monomial, c) = next(iter(force.terms()))
    for other_trig, other, d in moment.terms():
        if other_trig == trig:
            ratio = Series(
                force.ring, {0: {other - monomial: 1}}, 1, force.reach + moment.reach
            ) * (d / c)
            kinds = {generator.kind for generator in ratio.generators()}
            if kinds <= {Kind.PARAMETER, Kind.CONSTANT} and (moment - ratio * force).vanishes():
                return ratio
    return None

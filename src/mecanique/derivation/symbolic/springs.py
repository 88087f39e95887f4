"""Lengths of springs and dampers as series: a polynomial where the distance is a square, a named root elsewhere."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, final

from mecanique.derivation.scalars.evaluation import evaluate
from mecanique.derivation.scalars.ring import Ring
from mecanique.derivation.scalars.series import Kind, Series
from mecanique.derivation.symbolic.kinematics import Kinematics
from mecanique.model.forces import Damper, Spring

__all__ = ["Assumption", "Length", "length_names", "length_of"]


@final
@dataclass(frozen=True)
class Assumption:
    """What a closed form takes for granted.

    Args:
        subject: what it is about, e.g. "the length of spring1".
        positive: the series that must be positive.
    """

    subject: str
    positive: Series

    def holds(self, values: Mapping[str, Any]) -> bool:
        """Return whether it holds.

        Args:
            values: value of each coordinate, parameter and t, by name.
        """
        return bool(evaluate(self.positive, values) > 0)


@final
@dataclass(frozen=True)
class Length:
    """The distance between the ends of a spring or damper.

    Args:
        series: the distance ρ.
        square: its square.
        assumption: what ρ takes for granted, if anything.
    """

    series: Series
    square: Series
    assumption: Assumption | None


def length_of(kinematics: Kinematics, force: Spring | Damper) -> Length:
    """Return the distance between the ends of a spring or damper.

    A distance whose square is the square of a polynomial is that polynomial, with the sign it has
    where all coordinates are zero; any other is adjoined as a root of its own.

    Args:
        kinematics: of the mechanism.
        force: the spring or damper.
    """
    algebra = kinematics.algebra
    a, b = (
        kinematics.point(*end)
        for end in ((force.body_a, force.point_a), (force.body_b, force.point_b))
    )
    reach = [end - start for start, end in zip(a, b, strict=True)]
    square = algebra.ring.sum([component * component for component in reach])
    root = algebra.root(square)
    generators = root.generators()
    moving = any(g.kind in (Kind.COORDINATE, Kind.TIME, Kind.INPUT) for g in generators)
    rational = all(
        algebra.ring.atoms[g.index].argument.is_number
        for g in generators
        if g.index in algebra.ring.atoms
    )
    assumption = Assumption(f"the length of {force.name}", root) if moving and rational else None
    return Length(root, square, assumption)


def length_names(ring: Ring, lengths: Iterable[tuple[str, Series]]) -> dict[str, str]:
    """Return what each root in the length of a spring or damper is, by its name.

    Args:
        ring: the ring.
        lengths: name and length of each spring and damper.
    """
    found: dict[str, list[str]] = {}
    whole: dict[str, bool] = {}
    for name, length in lengths:
        for g in length.generators():
            if g.index in ring.atoms and ring.atoms[g.index].named:
                found.setdefault(g.name, []).append(name)
                whole[g.name] = length == ring[g.name]
    return {
        name: f"{'length' if whole[name] else 'root in the length'} of {' and '.join(owners)}"
        + (" [m]" if whole[name] else "")
        for name, owners in found.items()
    }

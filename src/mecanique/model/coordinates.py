"""Generalized coordinates and the map from them, and time, to the joint coordinates."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import final, overload

from mecanique.errors import InputError
from mecanique.model.expression import Scalar, plain


@final
@dataclass(frozen=True)
class Coordinates(Sequence[str]):
    """The independent generalized coordinates and how joints follow them; a sequence of names.

    A joint coordinate that the map does not mention is a generalized coordinate itself. One map
    covers a textbook coordinate that is no joint angle, mimic joints, prescribed (rheonomic) motion
    and reduced loops.

    Args:
        names: generalized coordinates, in order.
        map: joint coordinate -> expression in generalized coordinates, parameters, inputs and t,
            for the joints that do not move freely; only joints with one coordinate, `Planar` and
            `Universal` can be driven.
        limits: generalized coordinate -> (lower, upper), numbers or expressions in parameters, for
            coordinates that locate the mechanism within an open interval only, e.g. the abscissa of
            a point on a circle.

    Example:
        >>> two = mq.Coordinates(("x",), {"follower": mq.coordinate("x") / 2})
        >>> list(two), dict(two.map)
        (['x'], {'follower': x/2})
    """

    names: tuple[str, ...]
    map: Mapping[str, Scalar] | tuple[tuple[str, Scalar], ...] = ()
    limits: Mapping[str, tuple[Scalar, Scalar]] | tuple[tuple[str, tuple[Scalar, Scalar]], ...] = ()

    def __post_init__(self) -> None:
        pairs = self.map.items() if isinstance(self.map, Mapping) else self.map
        object.__setattr__(self, "names", tuple(self.names))
        object.__setattr__(
            self, "map", tuple((name, plain(expression)) for name, expression in pairs)
        )
        bounds = self.limits.items() if isinstance(self.limits, Mapping) else self.limits
        try:
            intervals = tuple(
                (name, (plain(lower), plain(upper))) for name, (lower, upper) in bounds
            )
        except (TypeError, ValueError) as error:
            if isinstance(error, InputError):
                raise
            raise InputError(
                f"expected (lower, upper) for each coordinate in limits, got {self.limits!r}"
            ) from None
        object.__setattr__(self, "limits", intervals)

    @property
    def driven(self) -> dict[str, Scalar]:
        """Joint coordinate -> expression, for the joints that follow the map."""
        return dict(self.map)

    @property
    def intervals(self) -> dict[str, tuple[Scalar, Scalar]]:
        """Generalized coordinate -> (lower, upper), for those that are limited."""
        return dict(self.limits)

    @overload
    def __getitem__(self, index: int) -> str: ...
    @overload
    def __getitem__(self, index: slice) -> tuple[str, ...]: ...
    def __getitem__(self, index: int | slice) -> str | tuple[str, ...]:
        return self.names[index]

    def __len__(self) -> int:
        return len(self.names)

    def __iter__(self) -> Iterator[str]:
        return iter(self.names)

"""Generalized coordinates and the map from them, and time, to the joint coordinates."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import final, overload

from mecanique.model.expression import Scalar, plain

__all__ = ["Coordinates"]


@final
@dataclass(frozen=True)
class Coordinates(Sequence[str]):
    """Names of the independent generalized coordinates and how the joints follow them; a sequence of the names.

    A joint coordinate that the map does not mention is a generalized coordinate itself. One map covers a textbook
    coordinate that is no joint angle, mimic joints, prescribed (rheonomic) motion and reduced loops.

    Args:
        names: generalized coordinates, in order.
        map: joint coordinate -> expression in generalized coordinates, parameters, inputs and t, for the joints that
            do not move freely; only joints with one coordinate, `Planar` and `Universal` can be driven.
    """

    names: tuple[str, ...]
    map: Mapping[str, Scalar] | tuple[tuple[str, Scalar], ...] = ()

    def __post_init__(self) -> None:
        pairs = self.map.items() if isinstance(self.map, Mapping) else self.map
        object.__setattr__(self, "names", tuple(self.names))
        object.__setattr__(self, "map", tuple((name, plain(expression)) for name, expression in pairs))

    @property
    def driven(self) -> dict[str, Scalar]:
        """Joint coordinate -> expression, for the joints that follow the map."""
        return dict(self.map)

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
